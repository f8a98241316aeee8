"""What to say of a block that drifts while it is repeated on its own coordinates."""

import numpy as np

from einschalt.foundations.typesetting import count, length
from einschalt.pipeline.summary.suggestion import Suggestion

ONE_PASS = "Set iterations = 1"
# where fewer models have control of their own, the others hang on their neighbours
LEAST_SHARE_HELD = 0.5


def drift(result):
    """Iterations that nothing, or too little, holds."""
    iteration = result.iteration
    if iteration is None:
        return None
    moved = length(iteration.moves["move_rms"].sum())
    once, now = total_of_one_pass(result), result.figures.mean_total
    if iteration.n_held == 0:
        figures = f"; propagated {length(once)} after one pass, {length(now)} now"
        return Suggestion(
            "The low flight was repeated on its own coordinates, and no control point "
            f"holds it: the block drifts, so far by up to {moved} (RMS)"
            f"{figures if np.isfinite(now) else ''}",
            f"{ONE_PASS}, or measure control in the low flight",
        )
    if now > once:
        return Suggestion(
            f"The iterations make the points worse, {length(now)} instead of "
            f"{length(once)} after one pass (propagated): {_held(iteration)}",
            f"{ONE_PASS}, or give the low flight more control",
        )
    is_thin = iteration.n_models_held < LEAST_SHARE_HELD * iteration.n_models
    if np.isfinite(once) or not is_thin:
        return None
    return Suggestion(
        f"{_held(iteration)}: the others may have drifted by up to {moved} (RMS), and "
        "no propagated figure tells",
        f"{ONE_PASS}, or give the low flight more control",
    )


def _held(iteration):
    models = count(iteration.n_models, "model")
    return f"{iteration.n_models_held} of {models} of the low flight hold control"


def total_of_one_pass(result):
    """Propagated error of the new points after the first pass, TOTAL, RMS [m].

    Parameters
    ----------
    result : DensificationResult

    Returns
    -------
    float
        NaN where the errors were not propagated.
    """
    errors = result.errors_of_one_pass
    if errors is None:
        return np.nan
    new = result.points.loc[result.points["role"] == "new", "point_id"]
    is_new = np.isin(errors.point_ids, new.to_numpy(dtype=object))
    variance = np.trace(errors.covariance[:, :2, :2], axis1=1, axis2=2)[is_new]
    return float(np.sqrt(np.mean(variance))) if len(variance) else np.nan
