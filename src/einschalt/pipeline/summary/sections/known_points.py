"""Densified minus given coordinates of control and check points."""

from einschalt.foundations.typesetting import fixed, length, lengths, names, number
from einschalt.pipeline.assessment.claim import LEFT_OUT
from einschalt.pipeline.summary.sections.section import Section

MOST_NAMED = 3
WRONG = 10.0  # mean squares that no longer need decimals


def section(result) -> Section:
    """Densified minus given coordinates at the known points."""
    figures, left_out = result.figures, result.control_left_out
    known = [
        ("control points", figures.n_control, figures.control_rms),
        (LEFT_OUT, len(left_out), _rms(left_out)),
        ("check points", figures.n_check, figures.check_rms),
    ]
    known = [row for row in known if row[1]]
    total = lengths([row[2] for row in known])
    rows = [
        (name, f"{n_points:d}", rms)
        for (name, n_points, _), rms in zip(known, total, strict=True)
    ]
    return Section(
        "Differences densified - given (total, RMS)",
        ("", "points", "difference"),
        tuple(rows),
        left_out_remarks(result),
    )


def left_out_remarks(result) -> tuple[str, ...]:
    """Say how control points, predicted from the others, agree with their errors."""
    table = result.control_left_out
    if table.empty:
        return ()
    square = result.left_out_control.normalized_square
    square = fixed(square, 2) if square < WRONG else number(square)
    worst = table.sort_values("p_value", kind="stable").head(MOST_NAMED)
    most = f"{names(worst['point_id'])} ({length(_total(worst).iloc[0])} at the first)"
    said = (
        f"Left out: predicted without the point. Squares are {square} of what the "
        f"standard errors of the differences let expect; worst at {most}."
    )
    return (said,)


def _total(table):
    return (table["difference_easting"] ** 2 + table["difference_northing"] ** 2) ** 0.5


def _rms(table):
    return float((_total(table) ** 2).mean() ** 0.5) if len(table) else 0.0
