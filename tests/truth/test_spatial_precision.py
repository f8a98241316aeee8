"""The claimed precision is true where models are transformed in space.

Image coordinates, with photographs that models share, and machine coordinates x, y, z.
"""

from types import SimpleNamespace

import numpy as np
import pytest

from einschalt.pipeline.densify import densify
from einschalt.pipeline.simulation.simulate_block import BlockGeometry, simulate_block

GROUND = ["easting", "northing", "height"]
# so many that means are known to 0.1 of the squares, and to 0.01 of the shares
N_BLOCKS = {"images": 16, "machine": 24}


@pytest.fixture(scope="module", params=["images", "machine"])
def runs(request):
    """Figures of each block, neighbouring points being correlated."""
    geometry = BlockGeometry(
        width=2_200.0,
        height=2_200.0,
        point_spacing=275.0,
        measurement=request.param,
        transformation="helmert_3d",
        control_per_model=9,
    )
    found = []
    for seed in range(N_BLOCKS[request.param]):
        block = simulate_block("demo", seed=seed, geometry=geometry)
        result = densify(block)
        points = result.solution.points  # not judged: only their places count
        truth = block.truth.set_index("point_id").loc[points["point_id"], GROUND]
        error = points[GROUND].to_numpy() - truth.to_numpy()
        covariance = result.errors.covariance
        solved = np.linalg.solve(covariance[:, :2, :2], error[:, :2, None])[:, :, 0]
        square = np.sum(error[:, :2] * solved, axis=1)
        height = error[:, 2] ** 2 / covariance[:, 2, 2]
        size = np.trace(covariance[:, :2, :2], axis1=1, axis2=2)
        found.append(
            (
                *(square.mean() / 2.0, np.mean(square < 5.991), height.mean()),
                *(size.mean(), np.sum(error[:, :2] ** 2, axis=1).mean()),
            )
        )
    names = ("square", "inside", "height", "claimed", "true")
    return SimpleNamespace(**dict(zip(names, np.transpose(found), strict=True)))


@pytest.mark.slow
def test_normalised_squares_are_one(runs):
    for squares in (runs.square, runs.height):
        scatter = np.std(squares, ddof=1) / np.sqrt(len(squares))
        assert scatter < 0.1
        assert squares.mean() == pytest.approx(1.0, abs=3.0 * scatter)


def test_ellipses_hold_what_they_say(runs):
    scatter = np.std(runs.inside, ddof=1) / np.sqrt(len(runs.inside))
    assert runs.inside.mean() == pytest.approx(0.95, abs=3.0 * scatter)
    assert scatter < 0.01


def test_claimed_and_true_root_mean_square(runs):
    scatter = np.std(runs.true / runs.claimed, ddof=1) / np.sqrt(len(runs.true))
    ratio = runs.claimed.mean() / runs.true.mean()
    assert ratio == pytest.approx(1.0, abs=3.0 * scatter)
