"""What the page knows of points: places, standard errors, vectors, ellipses."""

import numpy as np

from einschalt.interfaces.reports.packed_data import quantum_of
from einschalt.interfaces.reports.page_plots import residual_bins

MANY = 30_000  # from here on bytes count more than the third digit
VERY_MANY = 200_000
MOST_SIGNS = 25_000  # vectors or ellipses that anybody looks at
GOLDEN_SECTION = (np.sqrt(5.0) - 1.0) / 2.0
ERRORS = {
    "standard_error_paper": "paper",
    "standard_error_internal": "internal",
    "spread_total": "spread",
}
COUNTS = {"n_models": "models", "n_coverages": "coverages"}


def pack_points(packed, result, claim):
    """Put the points into the page's data: each column that there is."""
    points = result.points
    n_points = len(points)
    is_many, is_very_many = n_points > MANY, n_points > VERY_MANY
    place_quantum = 0.01 if is_very_many else 0.001
    parts = 40.0 if is_many else 200.0
    found = {
        "n": n_points,
        "share": min(MOST_SIGNS / max(n_points, 1), 1.0),
        "names": packed.names(points["point_id"]),
        "role": packed.codes(points["role"]),
        "east": packed.numbers(points["easting"], place_quantum),
        "north": packed.numbers(points["northing"], place_quantum),
        "error": _errors(packed, points[claim], parts),
    }
    if "height" in points and not is_very_many:
        found["height"] = packed.numbers(points["height"], place_quantum)
    shown = list(ERRORS.items())[: 1 if is_very_many else 2 if is_many else 3]
    for column, name in shown:
        if column != claim and column in points and points[column].notna().any():
            found[name] = _errors(packed, points[column], parts)
    for column, name in COUNTS.items():
        found[name] = packed.numbers(points[column], 1.0)
    if "is_suspect" in points and points["is_suspect"].any():
        found["suspect"] = packed.numbers(points["is_suspect"].astype(float), 1.0)
    found |= _vectors(packed, result, parts / 4.0)
    found |= _ellipses(packed, result)
    found |= _worst_residuals(packed, result)
    if not is_many:
        masks = residual_bins(result.residuals, points["point_id"])
        for name, mask in zip(("bins_low", "bins_high"), masks.T, strict=True):
            found[name] = packed.numbers(mask, 1.0)
    packed.head["points"] = found


def _errors(packed, values, parts):
    return packed.numbers(values, quantum_of(values, parts))


def _vectors(packed, result, parts):
    """Densified − given at known points; first − second coverage at all."""
    points = result.points
    found = {}
    sides = ("difference_easting", "difference_northing")
    known = points[list(sides)].where(points["role"] != "new")
    if known[sides[0]].notna().any():
        quantum = quantum_of(np.hypot(*known.to_numpy().T), 100.0)
        found["known_east"] = packed.numbers(known[sides[0]], quantum)
        found["known_north"] = packed.numbers(known[sides[1]], quantum)
    apart, names = coverage_differences(result)
    if apart is not None:
        quantum = quantum_of(np.hypot(*apart.T), parts)
        apart[~evenly_chosen(len(apart))] = np.nan
        found["apart_east"] = packed.numbers(apart[:, 0], quantum)
        found["apart_north"] = packed.numbers(apart[:, 1], quantum)
        packed.head["coverages"] = names
    return found


def coverage_differences(result):
    """Difference of the first two coverages at each point (n_points, 2) [m], or None.

    With the names of the two.
    """
    values = result.single_values
    if not len(values):
        return None, []
    coverages = sorted(values["coverage"].unique())[:2]
    if len(coverages) < 2:
        return None, []
    order = result.points["point_id"]
    first, second = (
        values[values["coverage"] == coverage]
        .groupby("point_id")[["easting", "northing"]]
        .mean()
        .reindex(order)
        .to_numpy()
        for coverage in coverages
    )
    return first - second, [str(name) for name in coverages]


def evenly_chosen(n_points):
    """Which of many points have vectors and ellipses in the page: evenly, (n_points,).

    Multiples of the golden section fill an interval evenly, and beat with no pattern of
    rows in which points may stand.
    """
    if n_points <= MOST_SIGNS:
        return np.ones(n_points, dtype=bool)
    return (np.arange(n_points) * GOLDEN_SECTION) % 1.0 < MOST_SIGNS / n_points


def _ellipses(packed, result):
    """Semi axes and azimuth, in the order of the points."""
    ellipses = result.ellipses
    if ellipses is None or not len(ellipses):
        return {}
    columns = ["semi_major", "semi_minor", "azimuth_gon"]
    rows = ellipses.drop_duplicates("point_id").set_index("point_id")[columns]
    rows = rows.reindex(result.points["point_id"]).to_numpy(dtype=float)
    rows[~evenly_chosen(len(rows))] = np.nan
    major, minor, azimuth = rows.T
    flat = minor / np.where(major > 0.0, major, np.nan)
    return {
        "semi_major": _errors(packed, major, 40.0),
        "flattened": packed.numbers(flat, 0.02),
        "azimuth": packed.numbers(azimuth, 2.0),
    }


def _worst_residuals(packed, result):
    """Largest standardised residual of each point, whatever model it lies in."""
    residuals = result.residuals
    if not len(residuals) or "w" not in residuals:
        return {}
    size = residuals["w"].astype(float).abs()
    worst = size.groupby(residuals["point_id"]).max()
    found = worst.reindex(result.points["point_id"]).to_numpy()
    return {"w": packed.numbers(found, 0.05)} if np.isfinite(found).any() else {}
