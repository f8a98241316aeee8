"""Whether a block drifts while it is repeated on its own coordinates."""

import numpy as np

from einschalt.pipeline.assessment.finding import Finding, Gravity, Subject

# where fewer models have control of their own, the others hang on their neighbours
LEAST_SHARE_HELD = 0.5


def drift(two_step):
    """Iterations that nothing, or too little, holds."""
    iteration = two_step.iteration
    if iteration is None:
        return None
    once, now = total_of_one_pass(two_step), float(two_step.figures.mean_total)
    facts = {
        "n_models": int(iteration.n_models),
        "n_models_held": int(iteration.n_models_held),
        "moved": float(iteration.moves["move_rms"].sum()),
        "propagated_once": once,
        "propagated_now": now,
    }
    if iteration.n_held == 0:
        return _found("drift_without_control", Gravity.GRAVE, "measure_control", facts)
    if now > once:
        return _found("iterations_that_spoil", Gravity.WARNING, "more_control", facts)
    is_thin = iteration.n_models_held < LEAST_SHARE_HELD * iteration.n_models
    if np.isfinite(once) or not is_thin:
        return None
    return _found("drift_that_nothing_tells", Gravity.WARNING, "more_control", facts)


def _found(code, gravity, remedy, facts):
    return Finding(
        code,
        Subject.BLOCK,
        gravity,
        statistic="propagated figure",
        observed=facts["propagated_now"],
        expected=facts["propagated_once"],
        remedy=f"one_pass_or_{remedy}",
        facts=facts,
    )


def total_of_one_pass(two_step) -> float:
    """Propagated error of the new points after the first pass, TOTAL, RMS [m].

    Parameters
    ----------
    two_step : DensificationResult

    Returns
    -------
    float
        NaN where the errors were not propagated.
    """
    errors = two_step.errors_of_one_pass
    if errors is None:
        return np.nan
    new = two_step.points.loc[two_step.points["role"] == "new", "point_id"]
    is_new = np.isin(errors.point_ids, new.to_numpy(dtype=object))
    variance = np.trace(errors.covariance[:, :2, :2], axis1=1, axis2=2)[is_new]
    return float(np.sqrt(np.mean(variance))) if len(variance) else np.nan


TWO_STEP = (drift,)
SIMULTANEOUS = ()
