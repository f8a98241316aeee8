"""Files that are dropped into the page, and the block that is made of tables."""

import re
from math import nan
from pathlib import Path
from urllib.parse import urlencode

from starlette.responses import JSONResponse, PlainTextResponse

from einschalt.foundations.display_names import printable
from einschalt.foundations.errors import (
    BlockError,
    EinschaltError,
    SettingsError,
    raise_problems,
)
from einschalt.foundations.language import mark, translated
from einschalt.foundations.number_parsing import is_number
from einschalt.foundations.projections import read_crs
from einschalt.foundations.told_errors import told
from einschalt.interfaces.files.atomic import write_text
from einschalt.interfaces.files.block_toml import BLOCK_FILE
from einschalt.interfaces.files.csv_tables import write_csv
from einschalt.interfaces.files.understood_tables import answered_elsewhere
from einschalt.interfaces.local_page.pages import (
    form_of,
    messages_of,
    page,
    redirect,
    with_refusals,
    worked,
)
from einschalt.interfaces.local_page.refusals import RefusedError
from einschalt.interfaces.local_page.session import Place
from einschalt.interfaces.local_page.words import INSTEAD_OF_OPTIONS
from einschalt.interfaces.new_block.block_text import block_text
from einschalt.interfaces.new_block.looked_at import files_below, look_at
from einschalt.interfaces.new_block.photographs import completed
from einschalt.interfaces.new_block.proposal import propose
from einschalt.interfaces.new_block.questions import answered, expected_instead
from einschalt.interfaces.new_block.said_of_tables import said_of_tables

COLUMNS = ("point_id", "easting", "northing")
OTHERS = ("crs", "points_crs", "decimal", "angles")
SAID = (*OTHERS, *COLUMNS)
MOST_MESSAGES = 10  # of files that were dropped and cannot be read
GROUPED = re.compile(r"\d{1,3}(?:[., \xa0\u2009\u202f'\u2019]\d{3})+")
ANSWERED, ASSUMED = "as you say", "assumed, since no file tells: correct it"


async def new_drop(request):
    """Make room for files that are to come."""
    try:
        drop = request.app.state.session.drops.new()
    except RefusedError as error:
        return _refused(error)
    return JSONResponse({"drop": drop.number})


async def take_file(request):
    """Store one file that was dropped."""
    drops = request.app.state.session.drops
    announced = request.headers.get("content-length")
    size = int(announced) if announced and announced.isdecimal() else None
    try:
        drop = drops.get(request.path_params["number"])
        name = request.path_params["name"]
        await drops.take(drop, name, size, request.stream())
    except RefusedError as error:
        return _refused(error)
    return JSONResponse({"name": request.path_params["name"]})


def _refused(error):
    # what is left of the body is not read
    return PlainTextResponse(told(error), error.status, {"connection": "close"})


@with_refusals
async def opened_drop(request):
    """Lead on to the block that was dropped, or to the tables of which one is made."""
    session = request.app.state.session
    drop = session.drops.get(request.path_params["number"])
    homes = sorted(drop.root.path.rglob(BLOCK_FILE), key=lambda path: len(path.parts))
    folder = homes[0].parent if homes else _only_folder(drop.root.path)
    asked = {"drop": drop.number, "path": drop.root.name(folder)}
    return redirect(f"/{'block' if homes else 'new'}?{urlencode(asked)}")


def _only_folder(folder):
    """The folder in which the files are, where they came in one."""
    entries = list(folder.iterdir())
    return entries[0] if len(entries) == 1 and entries[0].is_dir() else folder


@with_refusals
async def new_page(request):
    """What the files of a folder are, and what is still to be asked."""
    session = request.app.state.session
    place = session.place(request.query_params)
    asked = {name: request.query_params.get(name, "").strip() for name in SAID}
    facts = await worked(_proposed, place, asked)
    return page("new", session=session, place=place, asked=asked, **facts)


def _as_dropped(error):
    """The error with the remedy of those who drop files, and write no command."""
    return answered_elsewhere(error, INSTEAD_OF_OPTIONS)


def _said_to_those_who_drop(problems):
    """Messages of problems, the first of many."""
    messages = [messages_of(_as_dropped(one))[0] for one in problems[:MOST_MESSAGES]]
    if len(problems) > MOST_MESSAGES:
        more = mark("and {n:more problem|more problems}")
        messages.append(translated(more, n=len(problems) - MOST_MESSAGES))
    return messages


def _proposed(place, asked):
    """The proposal of a block, or why there is none yet."""
    try:
        proposal, left_out = _proposal(place, asked)
    except EinschaltError as error:
        problems = error.problems if isinstance(error, BlockError) else (error,)
        messages = _said_to_those_who_drop(problems)
        return {"proposal": None, "messages": messages, "left_out": []}
    return {"proposal": proposal, "messages": [], "left_out": left_out}


def _proposal(place, asked):
    """Look at the tables, as they are said to be understood."""
    columns, crs = {key: asked.get(key) for key in COLUMNS}, asked.get("crs") or None
    if crs is not None:
        read_crs(crs)
    how = said_of_tables(columns, **{name: asked.get(name) for name in OTHERS})
    found, refused = [], []
    for path in files_below(place.folder):
        place.root.require_inside(path)
        try:
            found += look_at(path, how)
        except BlockError as error:
            refused += error.problems
        except EinschaltError as error:
            refused.append(error)
    if not found:
        raise_problems(refused)
        raise SettingsError(
            "there is no table",
            expected="control points, and the measurements of the flights",
            remedy="Drop all files of the block together",
        )
    given = {} if crs is None else {("block", "crs"): crs}
    try:
        return propose(found, given), _said_to_those_who_drop(refused)
    except EinschaltError as error:  # what is missing may stand in what was refused
        raise_problems([*refused, error])
        raise


@with_refusals
async def make_block(request):
    """Write block.toml of the tables and the answers."""
    session = request.app.state.session
    form = await form_of(request)
    place = session.place(form)
    await worked(_write_block, place, form)
    return redirect(f"/block?{place.query}")


def _write_block(place: Place, form):
    proposal, _ = _proposal(place, form)
    for question in proposal.questions:
        text = form.get(f"{question.section}.{question.key}", "")
        value = _value(question, text)
        reason = ANSWERED if text else ASSUMED
        proposal = answered(proposal, question, value, reason)
    if (place.folder / BLOCK_FILE).exists():
        raise RefusedError(
            f"the folder holds {BLOCK_FILE} already", remedy="Open it as a block"
        )
    proposal, written, _ = completed(proposal, place.folder)
    _write_new(written)
    name = form.get("name") or Path(place.folder).name
    text = block_text(proposal, place.folder, printable(name))
    write_text(place.folder / BLOCK_FILE, text)


def _write_new(tables):
    """Write tables beside block.toml, over none that is there."""
    for path in tables:
        if path.exists():
            raise RefusedError(
                f"the folder holds {path.name} already", remedy="Rename that file"
            )
    for path, table in tables.items():
        write_csv(table, path)


def _value(question, text):
    """The answer to a question; None leaves it out."""
    if not text and question.has_suggestion:
        return question.suggested
    if question.key == "crs":
        read_crs(text)
        return text
    value = _number(question.key, text.strip())
    expected = expected_instead(question.key, value)
    if expected:
        raise SettingsError(
            f"{text!r} is no answer to: {question.text}",
            expected=expected,
            remedy="Go back, and correct it",
        )
    return value


def _number(key, text):
    """A number with a decimal point or comma; NaN for what is none."""
    if key == "scale_number" and GROUPED.fullmatch(text):  # 10.000 means 1:10 000
        return float(re.sub(r"\D", "", text))
    plain = text.replace(",", ".")
    return float(plain) if is_number(plain) else nan
