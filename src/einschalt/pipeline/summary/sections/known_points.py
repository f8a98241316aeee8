"""Densified minus given coordinates of control and check points."""

from einschalt.foundations.language import figure, mark, translated
from einschalt.foundations.typesetting import fixed, length, lengths, names, number
from einschalt.pipeline.summary.section import Section

WRONG = 10.0  # mean squares that no longer need decimals
LEFT_OUT = mark(
    "Left out: each point predicted without itself. Observed / expected variance "
    "{ratio}; worst at {names} ({length} at the first)."
)


def section(facts) -> Section:
    """Set the differences at the known points."""
    total = lengths([rms for *_, rms in facts.differences])
    rows = tuple(
        (translated(name), figure(n_points, "d"), rms)
        for (name, n_points, _), rms in zip(facts.differences, total, strict=True)
    )
    title = translated("Differences, densified minus given (total, RMS)")
    header = ("", translated("points"), translated("difference"))
    return Section(title, header, rows, left_out_remarks(facts))


def left_out_remarks(facts) -> tuple[str, ...]:
    """Say how control points, predicted from the others, agree with their errors."""
    if (left_out := facts.left_out) is None:
        return ()
    square = left_out.normalized_square
    square = fixed(square, 2) if square < WRONG else number(square)
    worst = {"names": names(left_out.worst), "length": length(left_out.largest)}
    return (translated(LEFT_OUT, ratio=square, **worst),)
