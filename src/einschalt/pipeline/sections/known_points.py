"""Densified minus given coordinates of control and check points."""

from einschalt.foundations.typesetting import lengths
from einschalt.pipeline.sections.section import Section


def section(result) -> Section:
    """Densified minus given coordinates at the known points."""
    figures = result.figures
    known = [
        ("control points", figures.n_control, figures.control_rms),
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
    )
