"""Many blocks: a table that fills up while they are computed."""

from urllib.parse import urlencode

from einschalt.foundations.display_names import printable
from einschalt.foundations.kept_texts import retold
from einschalt.foundations.language import (
    figure,
    language,
    mark,
    mark_each,
    translated,
)
from einschalt.foundations.typesetting import MISSING, length, seconds
from einschalt.interfaces.batch.block_search import find_blocks, name_blocks
from einschalt.interfaces.local_page.pages import (
    form_of,
    messages_of,
    page,
    redirect,
    with_refusals,
    worked,
)
from einschalt.interfaces.local_page.refusals import OutsideError
from einschalt.interfaces.local_page.rooted_paths import is_name
from einschalt.interfaces.local_page.session import RESULTS, Place

COLUMNS = (
    *(mark("block"), mark("outcome"), mark("points"), mark("to believe")),
    *(mark("stated precision"), mark("suspects"), mark("time")),
)
WAITING = mark("waiting")
OUTCOMES = mark_each({"done": "done", "skipped": "skipped", "failed": "failed"})
CLAIMS = mark_each({True: "supported", False: "not supported", None: "not tested"})


@with_refusals
async def batch_page(request):
    """The blocks below a folder, and where their results are to go."""
    session = request.app.state.session
    place = session.place(request.query_params)
    blocks, left_out = await worked(_blocks, place, None)
    output = f"{session.root.name(place.folder)}/{RESULTS}".lstrip("/")
    facts = {"place": place, "names": list(blocks), "output": f"{output}_of_all"}
    facts["left_out"] = [(name, messages_of(error)) for name, error in left_out.items()]
    return page("batch", session=session, **facts)


def _blocks(place, output):
    """Blocks below a folder by name, and why others are left out.

    A block that names a file elsewhere is none of the page's; the error of the first
    one where all are such.
    """
    found, left_out = [], {}
    for folder in find_blocks(place.folder, output):
        try:
            place.root.require_inside(folder)
            Place(place.root, folder).require_own_files()
            found.append(folder)
        except OutsideError as error:
            left_out[folder.name] = error
    if not found:
        raise next(iter(left_out.values()))
    blocks = name_blocks(found)
    return {name: one for name, one in blocks.items() if is_name(name)}, left_out


@with_refusals
async def start_batch(request):
    """Start the computation of all blocks below a folder."""
    session = request.app.state.session
    form = await form_of(request)
    place = session.place(form)
    folder = session.root.find(form.get("output") or RESULTS, is_new=True)
    blocks, _ = await worked(_blocks, place, folder)
    folders = [str(one) for one in blocks.values()]
    question = {"kind": "batch", "blocks": folders, "output": str(folder)}
    question["language"] = language()
    path = session.root.name(folder)
    links = {"back": f"/batch?{place.query}", "output": path, "names": list(blocks)}
    return redirect(f"/run/{session.runs.start(question, place.title, links).number}")


def rows_of(run):
    """Rows of the table as text, with the address of each result."""
    names = dict.fromkeys([*run.links["names"], *run.rows])
    return [_row(run, name) for name in names]


def _row(run, name):
    row = run.rows.get(name)
    if row is None:
        text = translated(WAITING) if run.state == "running" else MISSING
        return {"cells": [printable(name), text], "link": "", "said": ""}
    is_failed = row["outcome"] == "failed"
    claim = row.get("claim_is_supported")
    took = row.get("seconds")
    cells = [
        printable(name),
        translated(OUTCOMES[row["outcome"]]),
        _whole(row.get("n_points")),
        length(row.get("standard_error_credible")),
        MISSING if is_failed else translated(CLAIMS[claim]),
        _whole(row.get("n_suspects")),
        MISSING if took is None else seconds(took),
    ]
    address = urlencode({"path": f"{run.links['output']}/{name}"})
    said = [row.get("reason"), row.get("remedy")] if is_failed else []
    return {
        "cells": cells,
        "link": "" if is_failed else f"/result?{address}",
        "said": " ".join(
            f"{printable(retold(text)).rstrip('.')}." for text in said if text
        ),
    }


def _whole(value):
    return MISSING if value is None else figure(value, ".0f")
