"""Templates of the pages: names in them are escaped, what is missing is an error."""

import jinja2

from einschalt.foundations.typesetting import number

TEMPLATES = jinja2.Environment(
    loader=jinja2.PackageLoader("einschalt.interfaces.reports"),
    autoescape=True,
    undefined=jinja2.StrictUndefined,
    trim_blocks=True,
    lstrip_blocks=True,
)
TEMPLATES.filters["number"] = number
