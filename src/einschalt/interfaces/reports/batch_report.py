"""The table of a batch as one HTML page: failures first, then every block."""

from urllib.parse import quote

import numpy as np
import pandas as pd

from einschalt.foundations.display_names import printable
from einschalt.foundations.typesetting import (
    MISSING,
    count,
    length,
    length_column,
    seconds,
)
from einschalt.interfaces.reports.page_templates import TEMPLATES
from einschalt.pipeline.batch.block_table import DONE, FAILED, SKIPPED


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
    numbers = table["outcome"].value_counts()
    said = [f"{numbers[o]} {o}" for o in (DONE, SKIPPED, FAILED) if numbers.get(o)]
    return f"{count(len(table), 'block')}: {', '.join(said)}"


def _headline(table):
    n_points = int(table["n_points"].fillna(0).sum())
    shown = [(f"{n_points}", "points of all blocks")]
    for kind, what in (("total", "propagated"), ("paper", "after Kovarik’s budget")):
        errors = table[f"standard_error_{kind}"].dropna()
        if len(errors):
            shown.append((length(errors.median()), f"{what}, total: median of blocks"))
            shown.append((length(errors.max()), f"{what}, total: worst block"))
    return shown


def _moved(moved):
    order = moved.sort_values("largest_move", ascending=False, kind="stable")
    unit, texts = length_column(order["largest_move"])
    cells = zip(order["block"], order["n_moved"], texts, strict=True)
    return {
        "columns": ("block", "points", f"largest move [{unit}]"),
        "rows": [(printable(block), f"{n}", text) for block, n, text in cells],
    }


def _blocks(table):
    shown = {
        "total": "propagated",
        "paper": "paper",
        "internal": "internal",
        "credible": "to believe",
    }
    kinds = [table[f"standard_error_{kind}"] for kind in shown]
    unit, texts = length_column(np.concatenate(kinds))
    names = [f"{name} [{unit}]" for name in shown.values()]
    parts = [texts[k * len(table) : (k + 1) * len(table)] for k in range(len(shown))]
    times = [MISSING if np.isnan(time) else seconds(time) for time in table["seconds"]]
    columns = {
        "block": map(_link, table.itertuples()),
        "outcome": table["outcome"],
        "points": map(_whole, table["n_points"]),
        **dict(zip(names, parts, strict=True)),
        "claim": map(_claim, table["claim_is_supported"], table["outcome"]),
        "suspects": map(_whole, table["n_suspects"]),
        "failed models": map(_whole, table["n_failed_models"]),
        "time": times,
    }
    rows = list(zip(*columns.values(), strict=True))
    return {"columns": tuple(columns), "rows": rows}


def _link(row):
    """Name of a block, and where its report lies; nowhere, where it has none."""
    has_report = row.outcome != FAILED and not np.isnan(row.seconds)
    return printable(row.block), quote(f"{row.block}/report.html") * has_report


def _claim(is_supported, outcome):
    if pd.isna(is_supported):
        return MISSING if outcome == FAILED else "not tested"
    return "stands" if is_supported else "does not stand"


def _whole(value):
    return MISSING if pd.isna(value) else f"{value:d}"


def _failure(row):
    block, reason, remedy = map(printable, (row.block, row.reason, row.remedy))
    is_ended = not remedy or remedy.endswith(("?", "."))
    return block, _words(row.stage), reason, remedy if is_ended else f"{remedy}."


def _words(name):
    return printable(name).partition("_")[2].replace("_", " ") or printable(name)
