"""True errors of points by draws of the measurements, the block factored once.

The check of the selected inverse: new errors for every measurement, the points that
follow, their squares summed. The peers solve the full normal equations of the block,
factored anew for every draw, or once; both get their errors drawn for nothing.
"""

import numpy as np
from scipy.sparse.linalg import splu, spsolve

from benchmarks.block_adjustment import normal_equations
from benchmarks.block_generator import generate_block
from benchmarks.racing import Contender, at_least, one_core, race
from einschalt.theory.block_adjustment.block_solution import adjust

N_DRAWS, N_SOLVED = 256, 4
# models of a block, and how many times longer spsolve must take for each draw
BLOCKS = {(10, 10): at_least(20, 50), (32, 32): at_least(45, 100)}
ONCE = at_least(1, 5)  # the same, of a factorization that is kept
N_CHECKED = 4000
WITHIN = 0.12  # largest difference of variances by draws and by the selected inverse


def run():
    """Race scipy on a small and on a larger block.

    Returns
    -------
    list of Race
    """
    with one_core():
        return [_race(*size, bound) for size, bound in BLOCKS.items()]


def _race(n_across, n_along, bound):
    block = generate_block(n_across, n_along)
    solution = adjust(block)
    errors, of_control = _drawn(block, N_DRAWS)
    _assert_right(block, solution)
    system, _ = normal_equations(block)
    rights = np.random.default_rng(3).standard_normal((system.shape[0], N_SOLVED))
    factor = splu(system)

    def each():
        return [spsolve(system, right) for right in rights.T]

    def once():
        return [factor.solve(right) for right in rights.T]

    def noise():
        return _drawn(block, N_DRAWS)

    return race(
        f"Draws of a block of {block.n_models} models, {len(block.model)} measurements",
        "draw",
        Contender(
            f"einschalt, {N_DRAWS} at once",
            lambda: solution.answer_to(errors, of_control, is_rough=True),
            N_DRAWS,
        ),
        [
            Contender("scipy spsolve, full normals", each, N_SOLVED, bound),
            Contender("scipy splu, factored once", once, N_SOLVED, ONCE),
            Contender("drawing the errors alone", noise, N_DRAWS),
        ],
        rounds=3,
    )


def _drawn(block, n_draws):
    rng = np.random.default_rng(2)
    errors = rng.standard_normal((len(block.model), 2, n_draws))
    errors *= block.standard_error[:, None, None]
    of_control = rng.standard_normal((block.n_points, 2, n_draws))
    variances = block.control_covariance[:, [0, 1], [0, 1]]
    of_control *= np.sqrt(variances)[:, :, None]
    return errors, of_control


def _assert_right(block, solution):
    """Draws scatter as the selected inverse says, point by point."""
    points, _ = solution.answer_to(*_drawn(block, N_CHECKED), is_rough=True)
    drawn = np.mean(np.square(points), axis=(1, 2))
    claimed = np.trace(solution.point_cofactors, axis1=1, axis2=2) / 2.0
    assert np.abs(drawn / claimed - 1.0).max() < WITHIN
