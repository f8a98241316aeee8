"""Is a claim that does not stand called out, and one that stands left in peace?

Low flights onto given approximate coordinates that share one orientation error per
photograph: a model of errors that takes them for independent is wrong. Beside them
blocks whose errors are as their claim has them.
"""

from functools import partial

import numpy as np
from tests.given_approximations import onto_given_approximations
from tests.truth.long_form.calibration import errors_of
from tests.truth.long_form.figures import Figure, Table, of_blocks, root_of_ratio

from einschalt.pipeline.assessment.evidence.claim import COVERAGES, NEIGHBOURS
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.simulate_block import simulate_block
from einschalt.theory.adjustment.multiple_testing import is_rejected_by_holm
from einschalt.theory.adjustment.significance import CLAIM_SIGNIFICANCE

N_BLOCKS = 100
ERROR = 0.1
SHARED = {"photograph_error": ERROR}
INDEPENDENT = {"own_error": ERROR}
INPUTS = {
    "one error per photograph, size stated": {**SHARED, "is_stated": True},
    "one error per photograph, not stated": {**SHARED, "is_stated": False},
    "independent, size stated": {**INDEPENDENT, "is_stated": True},
    "both flights, as simulated": None,
}
WRONG = {"low": 95.0}
RIGHT = {"high": 5.0}


def tables():
    """Run the study.

    Returns
    -------
    list of Table
    """
    rows = []
    for name, approximations in INPUTS.items():
        blocks = of_blocks(partial(study, approximations), range(N_BLOCKS))
        is_wrong = approximations is not None and "photograph_error" in approximations
        bounds = WRONG if is_wrong else RIGHT
        true, paper = np.transpose([block["squares"] for block in blocks])
        rows.append(
            (
                name,
                root_of_ratio(true, paper, form=".2f"),
                *(
                    Figure(sum(block[tests] for block in blocks), **bounds, form="d")
                    for tests in ("two tests", "all tests")
                ),
            )
        )
    return [
        Table(
            f"Claims that are rejected, {N_BLOCKS} blocks of the preset neukirchen",
            "Number of blocks whose claim is rejected by the tests of the coverage "
            "differences and of the correlation of neighbouring residuals alone, "
            "and by all tests together (Holm, 0.01): at least 95 if approximate "
            f"coordinates share an orientation error of {100 * ERROR:g} cm per "
            "photograph, at most 5 if the errors are as claimed. The first column "
            "gives the true error of the final points divided by that of the paper's "
            "formula.",
            ("approximate coordinates", "true/paper", "by the two", "by all"),
            rows,
        )
    ]


def study(approximations, seed):
    """Test the claim of one block.

    Parameters
    ----------
    approximations : dict or None
        Arguments of :func:`onto_given_approximations`; None leaves the high flight.
    seed : int

    Returns
    -------
    dict
        Whether ``all tests``, and the ``two tests`` alone, call the block out;
        ``squares``: sums of true and of the paper's squared errors [m²].
    """
    simulated = simulate_block("neukirchen", seed=seed)
    block = simulated
    if approximations is not None:
        block = onto_given_approximations(simulated, seed=seed, **approximations)
    result = densify(block, Settings())
    claim = result.claim
    p_values = np.array(
        [test.p_value for test in claim.tests if test.name in {COVERAGES, NEIGHBOURS}]
    )
    paper = result.points["standard_error_paper"].to_numpy()
    return {
        "all tests": not claim.is_supported,
        "two tests": bool(is_rejected_by_holm(p_values, CLAIM_SIGNIFICANCE).any()),
        "squares": (
            np.sum(errors_of(result.points, simulated.truth) ** 2),
            np.sum(paper**2),
        ),
    }
