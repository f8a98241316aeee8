"""Whether a block drifts while it is repeated on its own coordinates."""

import numpy as np

from einschalt.pipeline.assessment.findings.kinds import finding

# where fewer models have control of their own, the others hang on their neighbours
LEAST_SHARE_HELD = 0.5


def drift(two_step):
    """Iterations that nothing, or too little, holds."""
    iteration = two_step.iteration
    if iteration is None:
        return None
    once, now = two_step.total_of_one_pass, float(two_step.figures.mean_within)
    facts = {
        "n_models": int(iteration.n_models),
        "n_models_held": int(iteration.n_models_held),
        "moved": float(iteration.moves["move_rms"].sum()),
        "propagated_once": once,
        "propagated_now": now,
    }
    if iteration.n_held == 0:
        return _found("drift_without_control", "measure_control", facts)
    if now > once:
        return _found("iterations_that_spoil", "more_control", facts)
    is_thin = iteration.n_models_held < LEAST_SHARE_HELD * iteration.n_models
    if np.isfinite(once) or not is_thin:
        return None
    return _found("drift_that_nothing_tells", "more_control", facts)


def _found(code, remedy, facts):
    return finding(
        code,
        statistic="propagated figure",
        observed=facts["propagated_now"],
        expected=facts["propagated_once"],
        remedy=f"one_pass_or_{remedy}",
        facts=facts,
    )


TWO_STEP = (drift,)
SIMULTANEOUS = ()
