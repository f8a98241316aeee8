"""Where the error of the new points comes from, and what neighbours share of it."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class SourceFacts:
    """One source of the error of the new points.

    Attributes
    ----------
    source : str
    total : float
        Root mean square over the new points, TOTAL [m].
    share : float
        Of the variance.
    """

    source: str
    total: float
    share: float


@dataclass(frozen=True)
class ErrorSourceFacts:
    """All sources of the error of the new points.

    Attributes
    ----------
    sources : tuple of SourceFacts
        The largest first.
    total : float
        All together, TOTAL [m].
    total_with_half_the_largest : float
        What better measurements would bring, TOTAL [m].
    """

    sources: tuple[SourceFacts, ...]
    total: float
    total_with_half_the_largest: float


@dataclass(frozen=True)
class NeighbourFacts:
    """Coordinate differences between neighbouring points.

    Attributes
    ----------
    n_pairs : int
    median_distance : float
        [m]
    total, total_if_independent : float
        Propagated, and if points shared no error; TOTAL, RMS [m].
    """

    n_pairs: int
    median_distance: float
    total: float
    total_if_independent: float


def error_source_facts(examined) -> ErrorSourceFacts | None:
    """Collect the sources of error.

    Parameters
    ----------
    examined : Examination

    Returns
    -------
    ErrorSourceFacts or None
        None where the errors were not propagated, or there are none.
    """
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
    """Say how precise the coordinate differences of neighbours are.

    Parameters
    ----------
    examined : Examination

    Returns
    -------
    NeighbourFacts or None
        None where the errors were not propagated.
    """
    table = examined.neighbours
    if table.empty:
        return None
    columns = ("standard_error_total", "standard_error_if_independent")
    totals = [float(np.sqrt(np.mean(table[name].to_numpy() ** 2))) for name in columns]
    return NeighbourFacts(len(table), float(table["distance"].median()), *totals)
