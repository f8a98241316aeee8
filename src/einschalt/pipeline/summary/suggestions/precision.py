"""Suggestions on what the propagated standard errors show."""

import numpy as np

from einschalt.foundations.display_names import printable
from einschalt.foundations.typesetting import count, factor, length, names
from einschalt.pipeline.summary.suggestion import Suggestion

LARGE = 3.0
MOSTLY = 0.5
MIN_REPORTED_RATIO = 0.5
MODEL = ["coverage", "model_id"]


def imprecise_points(result):
    """Points that spoil the figure of the block, and the models that they lie in."""
    new = result.points[result.points["role"] == "new"]
    if "standard_error_total" in new:
        new = new[np.isfinite(new["standard_error_total"])]
    if "standard_error_total" not in new or new.empty:
        return None
    error = new["standard_error_total"].to_numpy(dtype=float)
    median = np.median(error)
    is_large = error > LARGE * median
    if not is_large.any():
        return None
    rest = np.sqrt(np.mean(error[~is_large] ** 2))
    worst_first = new["point_id"].to_numpy()[np.argsort(-error, kind="stable")]
    weak = worst_first[: is_large.sum()]
    problem = (
        f"{count(len(weak), 'new point')} with standard errors of more than {LARGE:g} "
        f"times the median of {length(median)}, up to {length(error.max())} "
        f"({names(weak)}); the others have {length(rest)} (total, RMS)"
    )
    models = _models_of(result, new["point_id"], weak)
    where = f". They are most points of low-flight {models}" if models else ""
    return Suggestion(
        problem + where,
        "Measure more control there, spread over the model, or do without these points",
    )


def block_that_shrinks(result):
    """A simultaneous adjustment that control does not hold against its own pull."""
    adjusted = result.simultaneous
    if adjusted is None or adjusted.displacements is None:
        return None
    is_new = (adjusted.points["role"] == "new").to_numpy()
    points = adjusted.points[is_new]
    plan = ["easting", "northing"]
    moved = np.hypot(*adjusted.displacements.loc[is_new, plan].to_numpy().T)
    claimed = np.hypot(
        *points[[f"standard_error_{name}" for name in plan]].to_numpy().T
    )
    if not len(moved) or not _rms(moved) > MIN_REPORTED_RATIO * _rms(claimed):
        return None
    times = factor(_rms(moved) / _rms(claimed))
    worst = printable(points["point_id"].iloc[int(np.argmax(moved))])
    return Suggestion(
        "Control does not hold the block against its own pull: errors of the model "
        f"coordinates move the new points by about {length(_rms(moved))} (total, RMS), "
        f"up to {length(moved.max())} at {worst}, {times} "
        "the standard errors, which do not hold that",
        "Give control on the far side of the block too",
    )


def _rms(values):
    return float(np.sqrt(np.mean(values**2)))


def _models_of(result, new, weak):
    """Names of the low-flight models most of whose new points are weak; or ""."""
    table = result.block.low_flight.model_table()
    table = table[table["point_id"].isin(new)]
    is_weak = table["point_id"].isin(weak)
    share = is_weak.groupby([table[name] for name in MODEL], sort=False).mean()
    found = share.index.get_level_values("model_id")[share > MOSTLY]
    return f"model{'s' * (len(found) > 1)} {names(found)}" if len(found) else ""
