"""Suggestions on what the propagated standard errors show."""

import numpy as np

from einschalt.foundations.typesetting import count, length, names
from einschalt.pipeline.suggestion import Suggestion

LARGE = 3.0
MOSTLY = 0.5
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


def _models_of(result, new, weak):
    """Names of the low-flight models most of whose new points are weak; or ""."""
    table = result.block.low_flight.model_table()
    table = table[table["point_id"].isin(new)]
    is_weak = table["point_id"].isin(weak)
    share = is_weak.groupby([table[name] for name in MODEL], sort=False).mean()
    found = share.index.get_level_values("model_id")[share > MOSTLY]
    return f"model{'s' * (len(found) > 1)} {names(found)}" if len(found) else ""
