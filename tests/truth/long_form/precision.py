"""Is the error that is claimed the error that is so?

Normalised squared errors, ellipses and root mean squares of the propagated covariance
and of Kovarik's budget, over simulated Neukirchen with known truth.
"""

from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree
from tests.truth.long_form.calibration import (
    HEAD,
    PLANE,
    errors_of,
    figures_of,
    sums_of,
)
from tests.truth.long_form.figures import Table, of_blocks

from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block

N_BLOCKS = 200
MODES = {
    "all": Settings(coverage_mean="all", weighting="plain"),
    "all, rigorous": Settings(coverage_mean="all", weighting="rigorous"),
    "most_central": Settings(coverage_mean="most_central"),
    "all, weighted": Settings(coverage_mean="all", weighting="weighted"),
    "most_central, weighted": Settings(
        coverage_mean="most_central", weighting="weighted"
    ),
}
# weights that follow from the residuals themselves
SCREENED = {
    "all, snoop": Settings(outliers="snoop", weighting="plain"),
    "all, huber": Settings(outliers="huber", weighting="plain"),
}
MODES_OF = {"affine": {**MODES, **SCREENED}, "helmert": MODES}
PAIRED = ("all", "most_central")


def tables():
    """Run the study.

    Returns
    -------
    list of Table
    """
    points, neighbours = [], []
    for kind, study in _STUDIES.items():
        blocks = of_blocks(study, range(N_BLOCKS))
        for mode in MODES_OF[kind]:
            sums = [block[mode] for block in blocks]
            of_claim = {name: [s[name] for s in sums] for name in sums[0]}
            points.append((kind, mode, *figures_of(of_claim["total"])))
            paper = figures_of(of_claim["paper"], judged=False)
            points.append(("", "paper", *paper))
            if mode in PAIRED:
                pairs = figures_of(of_claim["pairs"])
                neighbours.append((kind, mode, *pairs))
    head = ("transformation", "mode", *HEAD)
    return [
        Table(
            f"Precision of points, {N_BLOCKS} blocks of the preset neukirchen",
            "Mean of the squared error over its covariance, divided by 2 (bounds 0.97 "
            "to 1.03); share of points in their 95 % ellipse (0.940 to 0.960); root "
            "mean square of the claimed errors divided by that of the true ones (0.98 "
            "to 1.02). The row below each mode gives the same for "
            "`standard_error_paper`.",
            head,
            points,
        ),
        Table(
            "Precision between neighbours",
            "The same for the coordinate difference of each point and its nearest "
            "neighbour, with the covariance between them.",
            head,
            neighbours,
        ),
    ]


def sums_of_block(result, truth, *, with_pairs=False):
    """What one block contributes to the figures of the propagated and paper errors.

    Parameters
    ----------
    result : DensificationResult
    truth : DataFrame
    with_pairs : bool
        Whether nearest neighbours are looked at as well.

    Returns
    -------
    dict of str to ndarray
        ``total``, ``paper`` and ``pairs``, as :func:`calibration.sums_of` has them.
    """
    error = errors_of(result.points, truth)
    covariance = result.errors.covariance
    paper = result.points["standard_error_paper"].to_numpy() ** 2 / 2.0
    of_paper = paper[:, None, None] * np.eye(2)
    sums = {"total": sums_of(error, covariance), "paper": sums_of(error, of_paper)}
    if with_pairs:
        ids = result.points["point_id"].to_numpy(dtype=object)
        places = result.points[PLANE].to_numpy()
        one, two = np.arange(len(ids)), cKDTree(places).query(places, 2)[1][:, 1]
        cross = result.errors.covariance_between(ids[one], ids[two])
        between = covariance[one] + covariance[two] - cross - np.swapaxes(cross, 1, 2)
        sums["pairs"] = sums_of(error[one] - error[two], between)
    return sums


def _study(kind, seed):
    preset = PRESETS["neukirchen"]
    geometry = replace(preset.geometry, transformation=kind)
    block = simulate_block("neukirchen", seed=seed, geometry=geometry)
    return {
        mode: sums_of_block(
            densify(block, settings), block.truth, with_pairs=mode in PAIRED
        )
        for mode, settings in MODES_OF[kind].items()
    }


def _study_affine(seed):
    return _study("affine", seed)


def _study_helmert(seed):
    return _study("helmert", seed)


# by name: processes are sent functions, not closures
_STUDIES = {"affine": _study_affine, "helmert": _study_helmert}
