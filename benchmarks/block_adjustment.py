"""The simultaneous adjustment of 10 000 models on a grid, and how it grows.

The peers solve the full normal equations, points included, which is what one would
write with scipy. Ours finds its order of elimination in every round as well.
"""

import subprocess
import sys
from functools import partial
from statistics import median
from time import perf_counter, process_time

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import spsolve

from benchmarks.block_generator import generate_block
from benchmarks.racing import (
    Contender,
    Outcome,
    at_least,
    at_most,
    exponent,
    in_unit,
    one_core,
    peak_gib,
    peer,
    race,
    ratio_of,
    report,
)
from einschalt.theory.block_adjustment import solver as parts
from einschalt.theory.block_adjustment.block_solution import adjust

SIDE = 100
ROUNDS = 3
SIZES = ((32, 32), (100, 100), (316, 316), (1000, 1000))  # 1e3 to 1e6 models
MOST_EXPONENT = 1.3  # from 1e4 models on
AGREEMENT_M = 1e-6
MOST_SECONDS = {(316, 316): at_most(10.0, 1.5), (1000, 1000): at_most(200.0, 25.0)}
MOST_GIB = {(316, 316): at_most(4.0), (1000, 1000): at_most(12.0, 6.0)}


def run():
    """Run the race, the shares of the steps, and the growth.

    Returns
    -------
    list of Race
    """
    with one_core():
        races = _on_one_core(generate_block(SIDE, SIDE))
    return [*races, _growth()]


def _on_one_core(block):
    """The race and the shares of the steps."""
    solved = adjust(block)
    spsolve_bound = at_least(25, 30)
    peers = [("scipy spsolve, full normals", _by_scipy, spsolve_bound)]
    peers += _installed_peers()
    for name, solve, _ in peers:
        apart = np.abs(solve(block) - solved.points).max()
        assert apart < AGREEMENT_M, f"{name}: {apart} m"
    raced = race(
        "Simultaneous adjustment, helmert, 10 000 models",
        "block",
        Contender("einschalt, points and residuals", lambda: adjust(block), 1),
        [
            Contender(name, lambda solve=solve: solve(block), 1, bound)
            for name, solve, bound in peers
        ],
        rounds=ROUNDS,
    )
    return [raced, _shares(block)]


def _installed_peers():
    """Solvers that cannot be installed everywhere."""
    peers, bound = [], at_least(5)
    pardiso = peer("pypardiso")
    if pardiso:
        solve = partial(_solved, solve=partial(_fresh, pardiso.spsolve))
        peers.append(("pypardiso, full normals", solve, bound))
    cholmod = peer("sksparse.cholmod")
    if cholmod:
        solve = partial(_solved, solve=lambda a, b: cholmod.cholesky(a)(b))
        peers.append(("CHOLMOD, full normals", solve, bound))
    return peers


def _fresh(by_pardiso, matrix, right):
    # pypardiso keeps the factor of a matrix that it has seen
    from pypardiso.scipy_aliases import pypardiso_solver  # noqa: PLC0415 - optional

    pypardiso_solver.free_memory(everything=True)
    return by_pardiso(matrix, right)


def _by_scipy(block):
    return _solved(block, spsolve)


def _solved(block, solve):
    """Points from the full normal equations."""
    normals, right = normal_equations(block)
    return solve(normals, right)[4 * block.n_models :].reshape(-1, 2)


def normal_equations(block):
    """Full normal equations of helmert models and points, real numbers."""
    n_rows, n_models, n_points = len(block.model), block.n_models, block.n_points
    count = np.bincount(block.model, minlength=n_models)
    mean = [np.bincount(block.model, c, n_models) / count for c in block.xy.T]
    x, y = (block.xy - np.column_stack(mean)[block.model]).T / 60.0
    one, nil = np.ones(n_rows), np.zeros(n_rows)
    east = np.column_stack([one, nil, x, -y, -one, nil])
    north = np.column_stack([nil, one, y, x, nil, -one])
    columns = np.column_stack(
        [
            *(4 * block.model + k for k in range(4)),
            *(4 * n_models + 2 * block.point + k for k in range(2)),
        ]
    )
    known = np.flatnonzero(block.is_control)
    at = 4 * n_models + 2 * known[:, None] + np.arange(2)
    size = 4 * n_models + 2 * n_points
    index = np.arange(n_rows).repeat(6)
    design = sparse.vstack(
        [
            sparse.csr_array((e.ravel(), (index, columns.ravel())), (n_rows, size))
            for e in (east, north)
        ]
        + [
            sparse.csr_array(
                (np.ones(at.size), (np.arange(at.size), at.ravel())), (at.size, size)
            )
        ],
        format="csr",
    )
    error = np.concatenate(
        [
            np.tile(block.standard_error, 2),
            np.sqrt(block.control_covariance[known][:, [0, 1], [0, 1]]).ravel(),
        ]
    )
    whitened = sparse.diags_array(1.0 / error) @ design
    right = np.concatenate([np.zeros(2 * n_rows), block.control[known].ravel()]) / error
    return (whitened.T @ whitened).tocsc(), whitened.T @ right


def _shares(block):
    """Assembly and variances against the factorization."""
    seconds = {"assembly": [], "factorization": [], "variances": []}
    task = adjust(block)
    ordering, system = task.ordering, task.solver.system
    for _ in range(ROUNDS):
        begin = perf_counter()
        blocks = parts.assemble(system, ordering.pattern)
        seconds["assembly"].append(perf_counter() - begin)
        begin = perf_counter()
        factor = parts.factorize(blocks, ordering.pattern, ordering.fronts)
        seconds["factorization"].append(perf_counter() - begin)
        begin = perf_counter()
        inverse = factor.selected_inverse()
        parts.point_cofactors(system, ordering.pattern, inverse)
        seconds["variances"].append(perf_counter() - begin)
    base = seconds["factorization"]

    def outcome(name, bound=None):
        of_step = seconds[name]
        return Outcome(name, in_unit(median(of_step)), ratio_of(of_step, base), bound)

    return report(
        "Steps against the factorization, 10 000 helmert models",
        [
            outcome("factorization"),
            outcome("assembly", at_most(0.25)),
            outcome("variances", at_most(2.5)),
        ],
    )


def _growth():
    """Time and memory of larger blocks, each in a process of its own.

    Judged by the clock, on all cores; the exponent is that of the seconds of the CPU:
    others who use the machine do not count there.
    """
    found = {size: _in_a_process(*size) for size in SIZES}
    outcomes = []
    for size, (_, elapsed, gib) in found.items():
        name = f"{np.prod(size)} models"
        figure = f"{elapsed:.2f} s"
        outcomes.append(
            Outcome(f"{name}: seconds", figure, elapsed, MOST_SECONDS.get(size))
        )
        if size in MOST_GIB:
            figure = f"{gib:.2f} GiB"
            outcomes.append(Outcome(f"{name}: memory", figure, gib, MOST_GIB[size]))
    _, small, *_, large = SIZES
    spent = [found[size][0] for size in (small, large)]
    growth = exponent(spent, [np.prod(size) for size in (small, large)])
    outcomes.append(
        Outcome(
            "exponent of the CPU's seconds, from the second",
            f"{spent[0]:.2f}, {spent[1]:.1f} s",
            growth,
            at_most(MOST_EXPONENT),
        )
    )
    return report(
        "Simultaneous adjustment with all variances: growth",
        outcomes,
        {int(np.prod(size)): elapsed for size, (_, elapsed, _) in found.items()},
    )


def _in_a_process(n_across, n_along):
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks.block_adjustment", f"{n_across}x{n_along}"],
        capture_output=True,
        text=True,
        check=True,
    )
    return tuple(map(float, done.stdout.split()))


def _alone(text):
    """Adjust a block with all variances; print seconds of CPU and clock, and GiB."""
    assert np.isfinite(adjust(generate_block(10, 10)).point_cofactors).all()
    block = generate_block(*map(int, text.split("x")))
    begin, began = process_time(), perf_counter()
    solution = adjust(block)
    variances = solution.point_cofactors
    seconds, elapsed = process_time() - begin, perf_counter() - began
    assert np.isfinite(variances).all()
    print(f"{seconds} {elapsed} {peak_gib()}")


if __name__ == "__main__":
    _alone(sys.argv[1])
