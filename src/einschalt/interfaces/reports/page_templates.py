"""Templates of the pages: names in them are escaped, what is missing is an error."""

import base64
import hashlib
import re
from functools import cache
from importlib.resources import files

import jinja2
from markupsafe import Markup

from einschalt.foundations.language import ENGLISH, language, translated
from einschalt.foundations.typesetting import number

TEMPLATES = jinja2.Environment(
    loader=jinja2.PackageLoader("einschalt.interfaces.reports"),
    autoescape=True,
    undefined=jinja2.StrictUndefined,
    trim_blocks=True,
    lstrip_blocks=True,
)


def minus_sign(text):
    """A figure with a minus sign instead of a hyphen, as the scripts write it.

    >>> minus_sign("-0.14"), minus_sign("–"), minus_sign("8811-8936")
    ('−0.14', '–', '8811-8936')
    """
    return re.sub(r"^-(?=\d)", "−", str(text))


TEMPLATES.filters |= {"number": number, "minus_sign": minus_sign}
TEMPLATES.globals |= {"translated": translated, "language": language}

SCRIPTS = (
    *("words", "decode", "figures", "selection", "grid", "view", "layers", "map"),
    *("cards", "table", "plots", "page"),
)
"""Modules of the page, in the order in which they stand in it: each knows those before.

They are one script, so that the page needs nothing else.
"""


# a message of a script, without the escapes of a string
MESSAGE = re.compile(r'\btranslated\("([^"\\]*)"')


def words_of_scripts() -> dict[str, str]:
    """Messages of the scripts in the active language; none in English."""
    if language() == ENGLISH:
        return {}
    return {message: translated(message) for message in messages_of_scripts()}


@cache
def messages_of_scripts() -> tuple[str, ...]:
    """Every message that is written out in the scripts."""
    return tuple(message for text in _scripts() for message in MESSAGE.findall(text))


def _scripts():
    folder = files("einschalt.interfaces.reports") / "page"
    return [(folder / f"{name}.js").read_text(encoding="utf-8") for name in SCRIPTS]


@cache
def sealed_parts(paper="auto") -> dict:
    """Style, script, and the policy that allows these two, and nothing else."""
    folder = files("einschalt.interfaces.reports") / "page"
    style = (folder / "page.css").read_text(encoding="utf-8")
    style = style.replace("size: auto", f"size: {paper}", 1)
    script = "\n" + "\n".join(_scripts())
    style = f"\n{style}"
    policy = (
        "default-src 'none'; base-uri 'none'; form-action 'none'; "
        f"style-src '{_digest(style)}'; script-src '{_digest(script)}'"
    )
    return {"style": Markup(style), "script": Markup(script), "policy": policy}


def _digest(text):
    data = hashlib.sha256(text.encode("utf-8")).digest()
    return f"sha256-{base64.b64encode(data).decode('ascii')}"
