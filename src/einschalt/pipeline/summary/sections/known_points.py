"""Densified minus given coordinates of control and check points."""

from einschalt.foundations.typesetting import fixed, length, lengths, names, number
from einschalt.pipeline.summary.section import Section

WRONG = 10.0  # mean squares that no longer need decimals


def section(facts) -> Section:
    """Set the differences at the known points."""
    total = lengths([rms for *_, rms in facts.differences])
    rows = tuple(
        (name, f"{n_points:d}", rms)
        for (name, n_points, _), rms in zip(facts.differences, total, strict=True)
    )
    title = "Differences densified - given (total, RMS)"
    return Section(title, ("", "points", "difference"), rows, left_out_remarks(facts))


def left_out_remarks(facts) -> tuple[str, ...]:
    """Say how control points, predicted from the others, agree with their errors."""
    if (left_out := facts.left_out) is None:
        return ()
    square = left_out.normalized_square
    square = fixed(square, 2) if square < WRONG else number(square)
    most = f"{names(left_out.worst)} ({length(left_out.largest)} at the first)"
    said = (
        f"Left out: predicted without the point. Squares are {square} of what the "
        f"standard errors of the differences let expect; worst at {most}."
    )
    return (said,)
