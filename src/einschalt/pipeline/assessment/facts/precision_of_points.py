"""How the errors of the new points are spread, where they come from, what is shared."""

from dataclasses import dataclass

import numpy as np

DOMINATED = 1.5
"""Root mean square over median from which on a few points make the figure: more than
half of the sum of squares (1 - 1/1.5² = 56 %) is then beyond what it would be if all
points were as good as the median. Where all are alike the ratio is 1; of errors spread
as Rayleigh has them it is 1.2."""
FEWEST_SPREAD = 20
"""Points of which a 95 % quantile can be told: one is worse."""


@dataclass(frozen=True)
class SpreadFacts:
    """Standard errors of the new points where a few of them make the figure."""

    rms: float  # TOTAL [m], as are the others
    median: float
    most: float  # 95 % of the points are better


@dataclass(frozen=True)
class SourceFacts:
    """One source of the error of the new points."""

    source: str
    total: float  # root mean square over the new points, TOTAL [m]
    share: float  # of the variance


@dataclass(frozen=True)
class ErrorSourceFacts:
    """All sources of the error of the new points."""

    sources: tuple[SourceFacts, ...]  # the largest first
    total: float  # all together, TOTAL [m]
    # what better measurements would bring, TOTAL [m]
    total_with_half_the_largest: float


@dataclass(frozen=True)
class NeighbourFacts:
    """Coordinate differences between neighbouring points."""

    n_pairs: int
    median_distance: float  # [m]
    # propagated, and if points shared no error; TOTAL, RMS [m]
    total: float
    total_if_independent: float


def spread_facts(points) -> SpreadFacts | None:
    """Tell how errors are spread where a few points dominate; None elsewhere.

    ``points`` are judged: the errors to believe.
    """
    if "standard_error_checked" not in points:
        return None
    is_new = points["role"] == "new"
    errors = points.loc[is_new, "standard_error_checked"].to_numpy(dtype=float)
    errors = errors[np.isfinite(errors)]
    if len(errors) < FEWEST_SPREAD:
        return None
    median, most = np.quantile(errors, [0.5, 0.95])
    rms = float(np.sqrt(np.mean(errors**2)))
    if not rms > DOMINATED * median:
        return None
    return SpreadFacts(rms, float(median), float(most))


def error_source_facts(examined) -> ErrorSourceFacts | None:
    """Collect the sources of error; None where nothing was propagated."""
    table = examined.block_error_sources
    if table.empty or not table["share"].sum() > 0.0:
        return None
    sizes = table["standard_error_total"].to_numpy(dtype=float)
    whole = float(np.sqrt(np.sum(sizes**2)))
    # all of the largest but half of it
    better = float(np.sqrt(whole**2 - 0.75 * sizes[0] ** 2))
    rows = zip(table["source"], sizes, table["share"], strict=True)
    sources = tuple(SourceFacts(n, float(size), float(s)) for n, size, s in rows)
    return ErrorSourceFacts(sources, whole, better)


def neighbour_facts(examined) -> NeighbourFacts | None:
    """How precise differences of neighbours are; None where nothing was propagated."""
    table = examined.neighbours
    if table.empty:
        return None
    columns = ("standard_error_total", "standard_error_if_independent")
    totals = [float(np.sqrt(np.mean(table[name].to_numpy() ** 2))) for name in columns]
    return NeighbourFacts(len(table), float(table["distance"].median()), *totals)
