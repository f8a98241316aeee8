"""Where the error of the new points comes from, and what neighbours share of it."""

from dataclasses import dataclass

import numpy as np


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
