"""The table of a batch as one HTML page: failures first, then every block."""

from urllib.parse import quote

import numpy as np
import pandas as pd

from einschalt.foundations.display_names import printable
from einschalt.foundations.kept_texts import retold
from einschalt.foundations.language import figure, mark, mark_each, translated
from einschalt.foundations.typesetting import (
    MISSING,
    length,
    length_column,
    seconds,
)
from einschalt.interfaces.reports.page_templates import TEMPLATES
from einschalt.pipeline.batch.block_table import (
    DONE,
    FAILED,
    SKIPPED,
    outcomes_text,
)

STATES = mark_each({DONE: "done", SKIPPED: "skipped", FAILED: "failed"})
# of the median of the blocks, and of the worst one
HEADLINES = {
    "total": (
        mark("propagated, total: median of blocks"),
        mark("propagated, total: worst block"),
    ),
    "paper": (
        mark("by Kovarik’s budget, total: median of blocks"),
        mark("by Kovarik’s budget, total: worst block"),
    ),
}


def render_batch(table) -> str:
    """Render the table of a batch: a page without external resources, names escaped."""
    failed = table[table["outcome"] == FAILED]
    moved = table[table["n_moved"].fillna(0) > 0]
    return TEMPLATES.get_template("batch.html.j2").render(
        verdict=_verdict(table),
        headline=_headline(table),
        failed=[_failure(row) for row in failed.itertuples()],
        moved=_moved(moved),
        **_blocks(table),
    )


def _verdict(table):
    facts = {"n": len(table), "outcomes": outcomes_text(table)}
    return translated("{n:block|blocks}: {outcomes}", **facts)


def _headline(table):
    n_points = int(table["n_points"].fillna(0).sum())
    shown = [(figure(n_points, "d"), translated("points of all blocks"))]
    for kind, (median, worst) in HEADLINES.items():
        errors = table[f"standard_error_{kind}"].dropna()
        if len(errors):
            shown.append((length(errors.median()), translated(median)))
            shown.append((length(errors.max()), translated(worst)))
    return shown


def _moved(moved):
    order = moved.sort_values("largest_move", ascending=False, kind="stable")
    unit, texts = length_column(order["largest_move"])
    cells = zip(order["block"], order["n_moved"], texts, strict=True)
    return {
        "columns": (
            translated("block"),
            translated("points"),
            translated("largest move [{unit}]", unit=unit),
        ),
        "rows": [(printable(block), figure(n, "d"), text) for block, n, text in cells],
    }


def _blocks(table):
    shown = {
        "total": translated("propagated"),
        "paper": translated("paper"),
        "internal": translated("internal"),
        "credible": translated("credible"),
    }
    kinds = [table[f"standard_error_{kind}"] for kind in shown]
    unit, texts = length_column(np.concatenate(kinds))
    names = [f"{name} [{unit}]" for name in shown.values()]
    parts = [texts[k * len(table) : (k + 1) * len(table)] for k in range(len(shown))]
    times = [MISSING if np.isnan(time) else seconds(time) for time in table["seconds"]]
    columns = {
        translated("block"): map(_link, table.itertuples()),
        translated("outcome"): [translated(STATES[o]) for o in table["outcome"]],
        translated("points"): map(_whole, table["n_points"]),
        **dict(zip(names, parts, strict=True)),
        translated("stated precision"): map(
            _claim, table["claim_is_supported"], table["outcome"]
        ),
        translated("suspects"): map(_whole, table["n_suspects"]),
        translated("failed models"): map(_whole, table["n_failed_models"]),
        translated("time"): times,
    }
    rows = list(zip(*columns.values(), strict=True))
    return {"columns": tuple(columns), "rows": rows}


def _link(row):
    """Name of a block, and where its report lies; nowhere, where it has none."""
    has_report = row.outcome != FAILED and not np.isnan(row.seconds)
    return printable(row.block), quote(f"{row.block}/report.html") * has_report


def _claim(is_supported, outcome):
    if pd.isna(is_supported):
        return MISSING if outcome == FAILED else translated("not tested")
    return translated("supported") if is_supported else translated("not supported")


def _whole(value):
    return MISSING if pd.isna(value) else figure(value, "d")


def _failure(row):
    block = printable(row.block)
    reason, remedy = (retold(printable(text)) for text in (row.reason, row.remedy))
    is_ended = not remedy or remedy.endswith(("?", "."))
    return (
        block,
        retold(_words(row.stage)),
        reason,
        remedy if is_ended else f"{remedy}.",
    )


def _words(name):
    return printable(name).partition("_")[2].replace("_", " ") or printable(name)
