"""Templates of the pages: names in them are escaped, what is missing is an error."""

import base64
import hashlib
from functools import cache
from importlib.resources import files

import jinja2
from markupsafe import Markup

from einschalt.foundations.typesetting import number

TEMPLATES = jinja2.Environment(
    loader=jinja2.PackageLoader("einschalt.interfaces.reports"),
    autoescape=True,
    undefined=jinja2.StrictUndefined,
    trim_blocks=True,
    lstrip_blocks=True,
)
TEMPLATES.filters["number"] = number

SCRIPTS = (
    *("decode", "figures", "selection", "grid", "view", "layers", "map"),
    *("table", "plots", "page"),
)
"""Modules of the page, in the order in which they stand in it: each knows those before.

They are one script, so that the page needs nothing else.
"""


@cache
def sealed_parts(paper="auto") -> dict:
    """Style, script, and the policy that allows these two, and nothing else."""
    folder = files("einschalt.interfaces.reports") / "page"
    style = (folder / "page.css").read_text(encoding="utf-8")
    style = style.replace("size: auto", f"size: {paper}", 1)
    texts = [(folder / f"{name}.js").read_text(encoding="utf-8") for name in SCRIPTS]
    script = "\n" + "\n".join(texts)
    style = f"\n{style}"
    policy = (
        "default-src 'none'; base-uri 'none'; form-action 'none'; "
        f"style-src '{_digest(style)}'; script-src '{_digest(script)}'"
    )
    return {"style": Markup(style), "script": Markup(script), "policy": policy}


def _digest(text):
    data = hashlib.sha256(text.encode("utf-8")).digest()
    return f"sha256-{base64.b64encode(data).decode('ascii')}"
