"""Two results beside each other: their figures, and how far their points lie apart."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from einschalt.foundations.display_names import printable
from einschalt.foundations.language import figure, mark, mark_each, translated
from einschalt.foundations.typesetting import MISSING, length, length_column
from einschalt.interfaces.files.plain_json import read_own_json
from einschalt.interfaces.files.written_files import PROVENANCE, evidence_of
from einschalt.interfaces.local_page.drawings import vectors
from einschalt.interfaces.local_page.refusals import RefusedError
from einschalt.interfaces.reports.html_report import role_text

POINTS = "points.parquet"
MOST_POINTS = 25
FIGURES = mark_each(
    {
        "n_new": "new points",
        "credible": "to believe, total",
        "mean_total": "propagated, total",
        "mean_paper": "by Kovarik’s budget, total",
        "check_rms": "RMS at check points, total",
        "control_rms": "RMS at control points, total",
        "n_suspects": "suspects",
    }
)
COUNTS = ("n_new", "n_suspects")
ALONE = (
    mark("{n:point|points} in the first result alone."),
    mark("{n:point|points} in the second result alone."),
)


@dataclass(frozen=True)
class Comparison:
    """What a page says of two results."""

    figures: list  # what it is, of the first, of the second
    verdict: str
    remarks: list
    apart: list  # what it is, and how far
    columns: tuple
    rows: list
    drawing: str


def compare(first, second) -> Comparison:
    """Compare the results in two folders; differences are second minus first.

    RefusedError where one of them is not whole, or they are of different systems.
    """
    (facts, points), (other_facts, other_points) = _read(first), _read(second)
    systems = [_system(one) for one in (facts, other_facts)]
    if systems[0] != systems[1]:
        raise RefusedError(
            f"the results are in different systems: {systems[0] or 'none'} and "
            f"{systems[1] or 'none'}",
            expected="results in the same system",
            remedy="Compute one of them with the output_crs of the other",
        )
    both = points.merge(other_points, on="point_id", suffixes=("_first", ""))
    moved = pd.DataFrame({"point_id": both["point_id"], "role": both["role"]})
    for axis in ("easting", "northing"):
        moved[axis] = both[axis]
        moved[f"d_{axis}"] = both[axis] - both[f"{axis}_first"]
    moved["total"] = np.hypot(moved["d_easting"], moved["d_northing"])
    moved = moved.sort_values("total", ascending=False, kind="stable")
    columns, rows = _largest(moved.head(MOST_POINTS))
    return Comparison(
        figures=_figures(facts["figures"], other_facts["figures"]),
        verdict=f"{_of_two_blocks(facts, other_facts)}{_verdict(moved['total'])}",
        remarks=_remarks(facts, other_facts, len(points), len(other_points), len(both)),
        apart=_apart(moved["total"]),
        columns=columns,
        rows=rows,
        drawing=vectors(moved) if len(moved) else "",
    )


def _read(folder):
    """What provenance.json says of a result, and its points."""
    evidence = evidence_of(folder)
    facts = read_own_json(folder / PROVENANCE)
    is_whole = all(map(evidence.vouches_for, (PROVENANCE, POINTS)))
    if not is_whole or "figures" not in facts:
        raise RefusedError(
            "the folder holds no result as einschalt has written it",
            expected="a folder with the results of einschalt densify",
            remedy="Compute the block again",
            file=folder.name,
        )
    names = ["point_id", "easting", "northing", "role"]
    points = pd.read_parquet(folder / POINTS, columns=names)
    return facts, points.astype({"point_id": str, "role": str})


def _system(facts):
    return (facts.get("output") or facts["block"]).get("crs")


def _figures(first, second):
    rows = []
    for name, text in FIGURES.items():
        values = [figures.get(name) for figures in (first, second)]
        if values != [None, None]:
            rows.append((translated(text), *(_figure(name, value) for value in values)))
    return rows


def _figure(name, value):
    if value is None:
        return MISSING
    return figure(value, ".0f") if name in COUNTS else length(value)


def _verdict(total):
    if not len(total):
        return translated("No point is in both results.")
    largest, n_both = float(total.max()), len(total)
    if largest == 0.0:
        same = mark("{n:point|points} in both results, at the same coordinates.")
        return translated(same, n=n_both)
    differ = mark(
        "{n:point|points} in both results: half of them differ by less than {median}, "
        "the largest difference is {largest} (total)."
    )
    median = length(float(total.median()))
    return translated(differ, n=n_both, median=median, largest=length(largest))


def _of_two_blocks(facts, other):
    """Warn of results that are not of one block: their points may share names alone."""
    first, second = (printable(one["block"]["name"]) for one in (facts, other))
    if first == second:
        return ""
    message = mark("Different blocks, {first} and {second}: ")
    return translated(message, first=first, second=second)


def _other_inputs(facts, other):
    """Say which input files are not those of the other result, by their checksums."""
    first, second = (
        {entry["table"]: entry for entry in one.get("inputs", ())}
        for one in (facts, other)
    )
    differ = sorted(
        table
        for table in {*first, *second}
        if first.get(table, {}).get("sha256") != second.get(table, {}).get("sha256")
    )
    if not (first and second and differ):  # of tables from Python nothing is known
        return []
    names = {table: (second.get(table) or first[table])["file"] for table in differ}
    message = mark("The inputs are not the same: {files} differ.")
    if {*differ} >= {*first, *second} - {"block"}:  # block.toml alone tells little
        message = mark("All inputs differ: {files}. Is it the same block?")
    return [translated(message, files=", ".join(map(printable, names.values())))]


def _remarks(facts, other, n_first, n_second, n_both):
    remarks = _other_inputs(facts, other)
    for message, n_alone in zip(
        ALONE, (n_first - n_both, n_second - n_both), strict=True
    ):
        if n_alone:
            remarks.append(translated(message, n=n_alone))
    settings, others = facts["settings"], other["settings"]
    for name in sorted({*settings, *others}):
        one, two = settings.get(name), others.get(name)
        if one != two:
            facts = {"name": name, "one": printable(one), "two": printable(two)}
            remarks.append(translated("{name}: {one}, then {two}.", **facts))
    return remarks


def _apart(total):
    if not len(total):
        return []
    values = total.to_numpy(dtype=float)
    return [
        (length(float(np.sqrt(np.mean(values**2)))), translated("RMS, total")),
        (length(float(np.median(values))), translated("median")),
        (length(float(np.quantile(values, 0.95))), translated("95 % are closer")),
        (length(float(values.max())), translated("largest")),
    ]


def _largest(moved):
    parts = [moved["d_easting"], moved["d_northing"], moved["total"]]
    unit, texts = length_column(np.concatenate(parts)) if len(moved) else ("cm", [])
    n_rows = len(moved)
    cells = [texts[k * n_rows : (k + 1) * n_rows] for k in range(3)]
    names = (f"ΔE [{unit}]", f"ΔN [{unit}]", translated("total [{unit}]", unit=unit))
    roles = map(role_text, moved["role"])
    rows = list(zip(map(printable, moved["point_id"]), roles, *cells, strict=True))
    return (translated("point"), translated("role"), *names), rows
