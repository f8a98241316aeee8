"""Is the claimed error true where models are transformed in space?

Small blocks with known truth: models formed from image coordinates, in which neighbours
share photographs, and machine coordinates x, y, z, of whose z nobody states an error.
"""

from functools import partial

import numpy as np
from tests.truth.long_form.calibration import HEAD, errors_of, figures_of, sums_of
from tests.truth.long_form.figures import Table, of_blocks, ratio

from einschalt.pipeline.densify import densify
from einschalt.pipeline.simulation.simulate_block import BlockGeometry, simulate_block

N_BLOCKS = {"images": 500, "machine": 700}
GEOMETRY = {
    "width": 2200.0,
    "height": 2200.0,
    "point_spacing": 275.0,
    "control_per_model": 9,
    "transformation": "helmert_3d",
}
# of one coordinate: the height lies within 1.96 standard errors
INSIDE_95 = 1.96**2


def tables():
    """Run the study.

    Returns
    -------
    list of Table
    """
    plan, heights = [], []
    for measurement, n_blocks in N_BLOCKS.items():
        blocks = of_blocks(partial(_study, measurement), range(n_blocks))
        of_plan = figures_of([block["plan"] for block in blocks])
        plan.append((measurement, *of_plan))
        paper = figures_of([block["paper"] for block in blocks], judged=False)
        plan.append(("paper", *paper))
        count, squares, inside = np.transpose([block["height"] for block in blocks])
        of_height = ratio(squares, count), ratio(inside, count)
        heights.append((measurement, *of_height))
    return [
        Table(
            "Precision with spatial models",
            f"{N_BLOCKS['images']} blocks from image coordinates, and "
            f"{N_BLOCKS['machine']} of machine coordinates x, y, z, of 64 points "
            "each; bounds as above.",
            ("measured", *HEAD),
            plan,
        ),
        Table(
            "Heights of spatial models",
            "Squared error over its variance, and share within 1.96 "
            "`standard_error_height`. With machine coordinates the error of z is "
            "estimated from the residuals of only a few models.",
            ("measured", "squared error", "within 95 %"),
            heights,
        ),
    ]


def _study(measurement, seed):
    geometry = BlockGeometry(measurement=measurement, **GEOMETRY)
    block = simulate_block("demo", seed=seed, geometry=geometry)
    result = densify(block)
    points, covariance = result.points, result.errors.covariance
    error = errors_of(points, block.truth)
    paper = points["standard_error_paper"].to_numpy() ** 2 / 2.0
    true = block.truth.set_index("point_id").loc[points["point_id"], "height"]
    squares = (points["height"].to_numpy() - true.to_numpy()) ** 2 / covariance[:, 2, 2]
    inside = np.count_nonzero(squares < INSIDE_95)
    return {
        "plan": sums_of(error, covariance[:, :2, :2]),
        "paper": sums_of(error, paper[:, None, None] * np.eye(2)),
        "height": np.array([len(squares), squares.sum(), inside]),
    }
