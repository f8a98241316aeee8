"""What the page's plots show: residuals, correlogram, sources, parallaxes."""

import numpy as np
import pandas as pd
from scipy.special import ndtri

from einschalt.foundations.frame_columns import values_of
from einschalt.foundations.units import METRES_PER_MM, METRES_PER_UNIT
from einschalt.pipeline.summary.sections.error_sources import source_name

N_QUANTILES = 199
N_BINS = 40
N_CLASSES = 10
LEAST_POINTS = 20
SPREAD = 2.0  # standard deviations of the draws to either side
FARTHEST = 5.0  # standard errors at which a histogram ends
EDGES = np.linspace(-FARTHEST, FARTHEST, N_BINS + 1)


def plots(result) -> dict:
    """Numbers of the plots by name, as JSON has them; those that there are."""
    found = {
        "residuals": standardised_residuals(result.residuals),
        "correlogram": correlogram(result.claim.residuals),
        "sources": sources_of_error(result),
        "parallaxes": residual_parallaxes(result),
    }
    return {name: one for name, one in found.items() if one is not None}


def standardised_residuals(residuals):
    """Histogram and quantiles of residuals in units of their own standard errors."""
    rows, values = _in_own_scale(residuals)
    return _distribution(values.ravel()) if len(rows) >= LEAST_POINTS else None


def residual_bins(residuals, point_ids):
    """Which bins of the histogram hold a residual of a point: two masks of 20 bins.

    Whole numbers (n_points, 2), the lower bins first; bit k is bin k of its half.
    """
    rows, values = _in_own_scale(residuals)
    place = pd.Series(np.arange(len(point_ids)), point_ids)
    place = place[~place.index.duplicated()].reindex(rows["point_id"]).to_numpy()
    is_known = np.isfinite(place)
    held = np.zeros((len(point_ids), N_BINS), dtype=bool)
    for side in (0, 1):
        held[place[is_known].astype(int), _bins(values[is_known, side])] = True
    bits = 2 ** np.arange(N_BINS // 2)
    return np.stack([held[:, : N_BINS // 2] @ bits, held[:, N_BINS // 2 :] @ bits], 1)


def _in_own_scale(residuals):
    """Rows with redundancy, and their residuals in their own standard errors (n, 2)."""
    sides = ("residual_easting", "residual_northing")
    part = residuals["redundancy_number"].to_numpy(dtype=float)
    both = values_of(residuals, sides)
    is_known = np.isfinite(both).all(axis=1) & (part > 1e-6)
    free = both[is_known] / np.sqrt(part[is_known])[:, np.newaxis]
    rows = residuals[is_known]
    return rows, free / _own_scale(rows, free)[:, np.newaxis]


def _own_scale(rows, free):
    """Pooled standard error of one coordinate in the flight of each row."""
    scale = np.empty(len(rows))
    for flight in rows["flight"].unique():
        is_own = (rows["flight"] == flight).to_numpy()
        size = np.sqrt(np.mean(free[is_own] ** 2))
        scale[is_own] = size if size > 0.0 else 1.0
    return scale


def _bins(values):
    """Bin of each value; what is farther out is in the outermost."""
    inner = EDGES[1:-1]
    return np.searchsorted(inner, values, side="right")


def _distribution(values):
    """Counts of bins, and quantiles beside those of the normal distribution."""
    counts = np.bincount(_bins(values), minlength=N_BINS)
    part = (np.arange(N_QUANTILES) + 0.5) / N_QUANTILES
    rarest = 0.5 / len(values)  # the outermost values themselves
    part = np.concatenate([[rarest], part[(part > rarest) & (part < 1 - rarest)]])
    part = np.append(part, 1.0 - rarest)
    return {
        "n": len(values),
        "edges": _listed(EDGES, 3),
        "counts": counts.tolist(),
        "expected": _listed(ndtri(part), 4),
        "observed": _listed(np.quantile(values, part), 4),
        "n_far": int((np.abs(values) > FARTHEST).sum()),
    }


def correlogram(field):
    """Correlation of residuals by distance, and its band where the claim holds."""
    if field is None or not len(field.correlogram.distance):
        return None
    observed, expected = field.correlogram, field.expected
    mean = expected.correlation.mean(axis=1)
    spread = SPREAD * expected.correlation.std(axis=1, ddof=1)
    return {
        "distance": _listed(observed.distance, 2),
        "measured": _listed(observed.correlation, 4),
        "claimed_distance": _listed(expected.distance, 2),
        "low": _listed(mean - spread, 4),
        "high": _listed(mean + spread, 4),
    }


def sources_of_error(result):
    """Shares of the block, and variances from good points to bad [m²]."""
    block = result.block_error_sources
    if block.empty or not block["share"].sum() > 0.0:
        return None
    table = result.error_sources
    new = result.points.loc[result.points["role"] == "new", "point_id"]
    is_new = table["point_id"].isin(new)
    table = table[is_new] if is_new.any() else table
    table = table.sort_values("standard_error_total", kind="stable")
    n_classes = N_CLASSES if len(table) >= LEAST_POINTS else 1
    parts = np.array_split(np.arange(len(table)), n_classes)
    columns = [f"standard_error_{source}" for source in block["source"]]
    variances = values_of(table, columns) ** 2
    means = np.array([variances[part].mean(axis=0) for part in parts])
    return {
        "codes": list(block["source"]),
        "names": [source_name(source) for source in block["source"]],
        "shares": _listed(block["share"], 6),  # rounded as in the table
        "classes": [_significant(row, 4) for row in means],
    }


def residual_parallaxes(result):
    """Residual parallaxes of relative orientations; their RMS in the image [m]."""
    rows, parts = result.orientation_residuals, []
    if "residual_y_left" in rows:
        of_images = rows["residual_y_left"] - rows["residual_y_right"]
        parts.append(of_images.to_numpy(dtype=float) * METRES_PER_MM)
    if "residual" in rows:
        flights = result.block.flights.items()
        metres = {name: METRES_PER_UNIT[one.model_unit] for name, one in flights}
        of_models = rows["residual"] * rows["flight"].map(metres)
        parts.append(of_models.to_numpy(dtype=float))
    values = np.concatenate([np.empty(0), *parts])
    values = values[np.isfinite(values)]
    if len(values) < LEAST_POINTS:
        return None
    rms = float(np.sqrt(np.mean(values**2)))
    return (
        {**_distribution(values / rms), "scale": float(f"{rms:.4g}")} if rms else None
    )


def _significant(values, digits):
    """Numbers for JSON, each to its own digits: however small, it is not 0."""
    listed = np.asarray(values, dtype=float).tolist()
    return [
        float(f"{value:.{digits}g}") if np.isfinite(value) else None for value in listed
    ]


def _listed(values, decimals):
    """Numbers for JSON, which knows no NaN."""
    rounded = np.round(np.asarray(values, dtype=float), decimals) + 0.0
    return [value if np.isfinite(value) else None for value in rounded.tolist()]
