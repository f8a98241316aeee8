"""Open a folder, see what is wrong with a block, compute it, and read its report."""

from pathlib import Path
from urllib.parse import urlencode

from starlette.responses import FileResponse, JSONResponse

from einschalt.foundations.display_names import printable
from einschalt.foundations.kept_texts import retold
from einschalt.foundations.language import figure, language, mark_each, translated
from einschalt.foundations.typesetting import scale
from einschalt.interfaces.local_page import batch_pages, words
from einschalt.interfaces.local_page.pages import (
    form_of,
    page,
    redirect,
    with_refusals,
    worked,
)
from einschalt.interfaces.local_page.problem_rows import MOST_SHOWN, problems_by_file
from einschalt.interfaces.local_page.refusals import MissingError, RefusedError
from einschalt.interfaces.local_page.rooted_paths import REPORT, require_result
from einschalt.interfaces.programs.full_check import everything_wrong
from einschalt.interfaces.reports.problem_list import conclusion
from einschalt.interfaces.reports.title_block import system_text

# a report may come from anybody: its scripts have an origin of their own, none else's
REPORT_POLICY = (
    "sandbox allow-scripts allow-downloads; default-src 'none'; "
    "style-src 'unsafe-inline'; script-src 'unsafe-inline'; frame-ancestors 'self'"
)
FLIGHTS = mark_each({"high_flight": "High flight", "low_flight": "Low flight"})
CHOICES = {"method": words.METHODS, "outliers": words.OUTLIERS}


@with_refusals
async def folder_page(request):
    """The folder: what can be opened in it."""
    session = request.app.state.session
    place = session.place(request.query_params)
    if place.kind == "result":
        return redirect(f"/result?{place.query}")
    if place.kind == "block":
        return redirect(f"/block?{place.query}")
    entries, n_cut = await worked(session.root.entries, place.folder)
    parts = Path(session.root.name(place.folder)).parts
    above = [
        (part, urlencode({"path": "/".join(parts[: k + 1])}))
        for k, part in enumerate(parts)
    ]
    return page(
        "folder",
        session=session,
        place=place,
        above=above,
        entries=[(entry, urlencode({"path": entry.path})) for entry in entries],
        n_cut=n_cut,
        files=_tables_in(place.folder),
    )


def _tables_in(folder):
    """Whether there are files of which a block may be made."""
    # looked for when a folder is shown that holds no block
    from einschalt.interfaces.new_block.looked_at import files_below  # noqa: PLC0415

    return [path.name for path in files_below(folder)][:20]


@with_refusals
async def block_page(request):
    """What is wrong with a block; where nothing is, how it is to be computed."""
    session = request.app.state.session
    place = session.place(request.query_params)
    _require_block(place)
    return page("block", session=session, **await worked(_checked, place))


def _require_block(place):
    if place.kind != "block":
        raise MissingError(
            f"{place.title} holds no block.toml",
            expected="the folder of a block",
            remedy="Open the folder that has one, or make one of its tables",
        )


def _checked(place):
    """What the page says of a block."""
    place.require_own_files()
    found = everything_wrong(place.folder)
    n_hidden = max(len(found.problems) + len(found.model_problems) - MOST_SHOWN, 0)
    title = place.title if found.block is None else printable(found.block.name)
    return {
        "place": place,
        "title": title,
        "conclusion": conclusion(found),
        "problems": problems_by_file(found.problems, place),
        "models": problems_by_file(found.model_problems, place),
        "notes": [printable(retold(note)) for note in found.notes],
        "n_models": len(found.model_problems),
        "n_hidden": n_hidden,
        "facts": [] if found.block is None else _facts(found.block),
        "is_sound": not found.problems,
        "choices": CHOICES,
        "output": place.usual_output(title),
    }


def _facts(block):
    """What a block holds, in words."""
    facts = [(translated("System"), system_text(block.crs))]
    if block.control_points is not None:
        facts.append((translated("Control"), _control(block.control_points)))
    for name, flight in block.flights.items():
        points = flight.model_points
        said = [scale(flight.scale_number), f"m_g {figure(flight.m_g_um, 'g')} µm"]
        if points is not None:
            keys = [key for key in ("coverage", "model_id") if key in points]
            n_models = len(points[keys].drop_duplicates())
            said.append(translated("{n:model|models}", n=n_models))
        facts.append((translated(FLIGHTS[name]), ", ".join(said)))
    return [(name, printable(fact)) for name, fact in facts]


def _control(points):
    """How many there are of each role."""
    n_check = int((points["role"] == "check").sum())
    said = [translated("{n:point|points}", n=len(points) - n_check)]
    if n_check:
        said.append(translated("{n:check point|check points}", n=n_check))
    return ", ".join(said)


@with_refusals
async def start(request):
    """Start the computation of a block."""
    session = request.app.state.session
    form = await form_of(request)
    place = session.place(form)
    _require_block(place)
    await worked(place.require_own_files)
    output = form.get("output") or place.usual_output()
    folder = session.root.find(output, is_new=True)
    question = {
        "kind": "densify",
        "block": str(place.folder),
        "output": str(folder),
        "given": _given(form),
        "language": language(),
    }
    links = {
        "back": f"/block?{place.query}",
        "result": f"/result?{urlencode({'path': session.root.name(folder)})}",
        "output": session.root.name(folder),
    }
    title = form.get("title") or place.title
    return redirect(f"/run/{session.runs.start(question, title, links).number}")


def _given(form):
    given = {name: form[name] for name in CHOICES if form.get(name)}
    wrong = [name for name, word in given.items() if word not in CHOICES[name]]
    if wrong:
        raise RefusedError(f"{wrong[0]} = {given[wrong[0]]!r} is not known")
    return given


@with_refusals
async def run_page(request):
    """A computation that goes on, or how it ended."""
    session = request.app.state.session
    run = session.runs.get(request.path_params["number"])
    is_batch = run.question["kind"] == "batch"
    if run.state == "done" and not is_batch:
        return redirect(run.links["result"])
    if is_batch:
        facts = {"columns": batch_pages.COLUMNS, "rows": batch_pages.rows_of(run)}
        return page("batch_run", session=session, run=run, **facts)
    return page("run", session=session, run=run)


@with_refusals
async def run_state(request):
    """How far it is, for the script of the page."""
    run = request.app.state.session.runs.get(request.path_params["number"])
    is_batch = run.question["kind"] == "batch"
    rows = {"rows": batch_pages.rows_of(run)} if is_batch else {}
    return JSONResponse(run.to_json() | rows)


@with_refusals
async def cancel(request):
    """End a computation."""
    run = request.app.state.session.runs.get(request.path_params["number"])
    run.cancel()
    return redirect(f"/run/{run.number}")


@with_refusals
async def result_page(request):
    """A result: its report, and what can be done with it."""
    session = request.app.state.session
    place = session.place(request.query_params)
    require_result(place.folder)
    own = session.root.name(place.folder)
    others = [name for name in await worked(session.root.results) if name != own]
    return page("result", session=session, place=place, others=others)


@with_refusals
async def report(request):
    """The living report, in a frame of its own origin."""
    place = request.app.state.session.place(request.query_params)
    require_result(place.folder)
    headers = {"content-security-policy": REPORT_POLICY}
    return FileResponse(place.folder / REPORT, headers=headers, media_type="text/html")
