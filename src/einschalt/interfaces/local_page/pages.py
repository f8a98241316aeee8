"""Pages as they are answered: templates, forms, and errors in a sentence."""

import functools
from importlib.resources import files
from urllib.parse import parse_qs

import anyio
import jinja2
from starlette.responses import HTMLResponse, RedirectResponse

from einschalt.foundations.display_names import printable
from einschalt.foundations.errors import BlockError, EinschaltError
from einschalt.foundations.kept_texts import retold
from einschalt.foundations.language import DECIMAL_SIGN, language, translated
from einschalt.foundations.told_errors import told
from einschalt.foundations.typesetting import length, number
from einschalt.interfaces.local_page import words
from einschalt.interfaces.local_page.refusals import RefusedError, TooLargeError
from einschalt.interfaces.reports.page_templates import minus_sign

MOST_OF_A_FORM = 2**16  # bytes
AT_WORK = anyio.CapacityLimiter(2)  # pages that compute; others wait for their turn


def plain_value(value):
    """A value as a field of a form has it."""
    return f"{value:g}" if isinstance(value, float) else printable(value)


def shown_value(value):
    """The same for people, with the decimal sign of the language."""
    return plain_value(value).replace(".", DECIMAL_SIGN.get(language(), "."))


def capitalised(text):
    """A text that stands first, as the label of a field."""
    return text[:1].upper() + text[1:]


TEMPLATES = jinja2.Environment(
    loader=jinja2.PackageLoader("einschalt.interfaces.local_page"),
    autoescape=True,
    undefined=jinja2.StrictUndefined,
    trim_blocks=True,
    lstrip_blocks=True,
)
TEMPLATES.filters |= {
    "printable": printable,
    "metres": length,
    "number": number,
    "words_of": lambda name: translated(words.PARTS.get(name, printable(name))),
    "capitalised": capitalised,
    "minus_sign": minus_sign,
    "plain_value": plain_value,
    "shown_value": shown_value,
    "retold": retold,
}
TEMPLATES.globals |= {"translated": translated, "language": language}
OF_THE_REPORT = files("einschalt.interfaces.reports") / "page"
SHARED = {"report.css": "page.css", "cards.js": "cards.js"}  # files of the report
STATIC = files("einschalt.interfaces.local_page") / "static"


def page(template, /, status=200, **facts):
    """Answer with a template; all names in it are escaped."""
    text = TEMPLATES.get_template(f"{template}.html.j2").render(words=words, **facts)
    return HTMLResponse(text, status)


def redirect(address):
    """Lead on after a form was sent."""
    return RedirectResponse(address, 303)


async def form_of(request):
    """Fields of a form; a body that is too large is not read."""
    announced = request.headers.get("content-length", "0")
    if not announced.isdecimal() or int(announced) > MOST_OF_A_FORM:
        raise _too_large()
    body = b""
    async for chunk in request.stream():
        body += chunk
        if len(body) > MOST_OF_A_FORM:
            raise _too_large()
    fields = parse_qs(body.decode("utf-8", errors="replace"), keep_blank_values=True)
    return {name: values[0].strip() for name, values in fields.items()}


def _too_large():
    return TooLargeError(f"a form of more than {MOST_OF_A_FORM} bytes")


async def worked(function, *arguments):
    """Compute beside the server; two at a time, so that it goes on answering."""
    return await anyio.to_thread.run_sync(function, *arguments, limiter=AT_WORK)


def with_refusals(handler):
    """Answer with what is wrong where a handler raises it."""

    @functools.wraps(handler)
    async def answer(request):
        try:
            return await handler(request)
        except EinschaltError as error:
            status = error.status if isinstance(error, RefusedError) else 422
            return refused(request, messages_of(error), status)

    return answer


def refused(request, messages, status):
    """Answer with a page that says what is wrong."""
    return page("refused", status, messages=messages, session=request.app.state.session)


def messages_of(error):
    """Messages of an error, each a sentence or two."""
    problems = error.problems if isinstance(error, BlockError) else [error]
    return [one_line(told(one)) for one in problems]


def one_line(text):
    """A message that stands in a page."""
    return printable(" ".join(text.split()))


@functools.cache
def static_text(name):
    """A script or style of the page, or one of the report; None: no such file."""
    if name in SHARED:
        return (OF_THE_REPORT / SHARED[name]).read_text(encoding="utf-8")
    known = {path.name: path for path in STATIC.iterdir()}
    return known[name].read_text(encoding="utf-8") if name in known else None
