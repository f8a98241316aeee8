"""The simultaneous adjustment of 10 000 models on a grid, and how it grows.

The peers solve the full normal equations, points included, which is what one would
write with scipy. Ours finds its order of elimination in every round as well.
"""

import subprocess
import sys
from functools import partial
from pathlib import Path
from statistics import median
from time import perf_counter, process_time

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import spsolve

from benchmarks.block_generator import generate_block
from benchmarks.racing import Contender, Outcome, one_core, race, report
from einschalt.theory.block_adjustment import solver as parts
from einschalt.theory.block_adjustment.block_solution import adjust

SIDE = 100
ROUNDS = 3
SIZES = ((100, 100), (316, 316), (548, 548))  # 1e4, 1e5, 3e5 models
MOST_EXPONENT = 1.3
AGREEMENT_M = 1e-6
GIB_OF_1E5 = 4.0


def run():
    """Run the race, the shares of the steps, and the growth.

    Returns
    -------
    bool
        Whether every floor is kept.
    """
    with one_core():
        kept = _on_one_core(generate_block(SIDE, SIDE))
    return all([kept, _growth()])


def _on_one_core(block):
    """The race and the shares of the steps."""
    solved = adjust(block)
    peers = [("scipy spsolve, full normals", _by_scipy, 25.0), *_installed_peers()]
    for name, solve, _ in peers:
        apart = np.abs(solve(block) - solved.points).max()
        assert apart < AGREEMENT_M, f"{name}: {apart} m"
    kept = race(
        "Simultaneous adjustment, helmert, 10 000 models",
        "block",
        Contender("einschalt, points and residuals", lambda: adjust(block), 1),
        [
            Contender(name, lambda solve=solve: solve(block), 1, floor=floor)
            for name, solve, floor in peers
        ],
        rounds=ROUNDS,
    )
    return all([kept, _shares(block)])


def _installed_peers():
    """Solvers that cannot be installed everywhere."""
    peers = []
    try:
        from pypardiso import spsolve as by_pardiso  # noqa: PLC0415 - optional
    except ImportError:
        print("pypardiso is not installed: that race is left out")
    else:
        solve = partial(_solved, solve=partial(_fresh, by_pardiso))
        peers.append(("pypardiso, full normals", solve, 5.0))
    try:
        from sksparse.cholmod import cholesky  # noqa: PLC0415 - optional
    except ImportError:
        print("scikit-sparse is not installed: the race against CHOLMOD is left out")
    else:
        solve = partial(_solved, solve=lambda matrix, right: cholesky(matrix)(right))
        peers.append(("CHOLMOD, full normals", solve, 5.0))
    return peers


def _fresh(by_pardiso, matrix, right):
    # pypardiso keeps the factor of a matrix that it has seen
    from pypardiso.scipy_aliases import pypardiso_solver  # noqa: PLC0415 - optional

    pypardiso_solver.free_memory(everything=True)
    return by_pardiso(matrix, right)


def _by_scipy(block):
    return _solved(block, spsolve)


def _solved(block, solve):
    """Points from the full normal equations of helmert models, real numbers."""
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
    solution = solve((whitened.T @ whitened).tocsc(), whitened.T @ right)
    return solution[4 * n_models :].reshape(-1, 2)


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

    def outcome(name, most):
        ratio = median(a / b for a, b in zip(seconds[name], base, strict=True))
        return Outcome(
            name,
            f"{1e3 * median(seconds[name]):.0f} ms",
            ratio,
            "" if most is None else f"<= {most:g}",
            most is None or ratio <= most,
        )

    return report(
        "Steps against the factorization, 10 000 helmert models",
        [
            outcome("factorization", None),
            outcome("assembly", 0.25),
            outcome("variances", 2.5),
        ],
    )


def _growth():
    """Time and memory of larger blocks, each in a process of its own.

    Judged are the seconds of the CPU: others who use the machine do not count. Those
    of the clock are shown beside them, on all cores.
    """
    found = [_in_a_process(*size) for size in SIZES]
    outcomes = []
    for seconds, elapsed, gib, n_models in found:
        exponent = np.log(seconds / found[0][0]) / np.log(
            max(n_models / found[0][-1], 1.0 + 1e-9)
        )
        is_last = n_models == found[-1][-1]
        outcomes.append(
            Outcome(
                f"{n_models} models, {gib:.2f} GiB, {elapsed:.2f} s elapsed",
                f"{seconds:.2f} s",
                exponent if n_models > found[0][-1] else np.nan,
                f"<= {MOST_EXPONENT:g}" if is_last else "",
                not is_last or exponent <= MOST_EXPONENT,
            )
        )
    memory = found[1][2]
    outcomes.append(
        Outcome(
            "memory of 1e5 models [GiB]",
            "",
            memory,
            f"<= {GIB_OF_1E5:g}",
            memory <= GIB_OF_1E5,
        )
    )
    return report("Growth with all variances: exponent of time", outcomes)


def _in_a_process(n_across, n_along):
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks.block_adjustment", f"{n_across}x{n_along}"],
        capture_output=True,
        text=True,
        check=True,
    )
    seconds, elapsed, gib = map(float, done.stdout.split())
    return seconds, elapsed, gib, n_across * n_along


def _alone(text):
    """Adjust a block with all variances; print seconds of CPU and clock, and GiB."""
    adjust(generate_block(10, 10)).point_cofactors.sum()
    block = generate_block(*map(int, text.split("x")))
    begin, began = process_time(), perf_counter()
    solution = adjust(block)
    variances = solution.point_cofactors
    seconds, elapsed = process_time() - begin, perf_counter() - began
    assert np.isfinite(variances).all()
    print(f"{seconds} {elapsed} {_peak_gib()}")


def _peak_gib():
    # getrusage would begin with the memory of the process that started this one
    status = Path("/proc/self/status").read_text()
    return int(status.split("VmHWM:")[1].split()[0]) / 2**20


if __name__ == "__main__":
    _alone(sys.argv[1])
