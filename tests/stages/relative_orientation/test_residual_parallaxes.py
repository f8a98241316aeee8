"""Residual parallaxes in plan, from parallaxes and from image coordinates."""

import numpy as np
import pandas as pd
import pytest

from einschalt.stages.relative_orientation.orient_from_images import orient_from_images
from einschalt.stages.relative_orientation.orient_from_parallaxes import (
    orient_from_parallaxes,
)
from einschalt.stages.relative_orientation.residual_parallaxes import (
    parallaxes_of_images,
    parallaxes_of_parallaxes,
)

BASE, DEPTH, DISTANCE = 92.0, 152.0, 152.0


def test_of_parallaxes():
    rng = np.random.default_rng(1)
    xyz = rng.uniform([0, -95, -165], [BASE, 95, -140], size=(24, 3))
    given = pd.DataFrame(xyz, columns=["x", "y", "z"]).assign(
        coverage=["a", "b"] * 12,
        model_id="7/8",
        point_id=np.arange(24).astype(str),
        y_parallax=rng.normal(scale=0.005, size=24),
    )
    oriented = orient_from_parallaxes(given, BASE)
    points = parallaxes_of_parallaxes(oriented, given)
    assert points["model"].tolist() == ["a: 7/8", "b: 7/8"] * 12
    np.testing.assert_array_equal(points[["x", "y"]], xyz[:, :2])
    np.testing.assert_array_equal(points["residual"], oriented.residuals["residual"])
    # the squares of the normalised residuals add up to the redundancy
    normalised = (points["residual"] / points["standard_error"]) ** 2
    numbers = oriented.residuals["redundancy_number"]
    np.testing.assert_allclose((normalised * numbers).sum(), 14.0, rtol=1e-9)


@pytest.mark.parametrize("case", ["dependent_right", "dependent_left", "independent"])
@pytest.mark.parametrize("kappa", [0.0, 1.0, np.pi])
def test_of_images(case, kappa):
    rng = np.random.default_rng(2)
    xyz = rng.uniform([0, -95, -165], [BASE, 95, -140], size=(30, 3))
    turn = np.array([[np.cos(kappa), np.sin(kappa)], [-np.sin(kappa), np.cos(kappa)]])
    image = []
    for ray in (xyz, xyz - [BASE, 0.0, 0.0]):
        measured = -DISTANCE * ray[:, :2] / ray[:, 2:]
        image.append((measured + rng.normal(scale=0.005, size=(30, 2))) @ turn.T)
    # vertical photographs without tilt: their parallax across the base is y' - y"
    columns = ["x_left", "y_left", "x_right", "y_right"]
    pairs = pd.DataFrame(np.hstack(image), columns=columns)
    pairs = pairs.assign(model_id="7/8", point_id=np.arange(30).astype(str))
    oriented = orient_from_images(pairs, DISTANCE, case=case)
    points = parallaxes_of_images(oriented, DISTANCE)
    depth = -xyz[:, 2].mean()
    expected = xyz[:, :2] * DISTANCE / depth
    # 5 µm tilt the pair by some 1e-4, which shifts its points by 0.1 mm or so
    np.testing.assert_allclose(points[["x", "y"]], expected, atol=0.5)
    np.testing.assert_allclose(points["base"], BASE * DISTANCE / depth, atol=0.5)
    # adjusting takes the whole parallax from the two coordinates across the base
    squares = np.sum(points["residual"] ** 2) / 2.0
    total = np.sum(
        oriented.residuals[[f"residual_{c}" for c in columns]].to_numpy() ** 2
    )
    np.testing.assert_allclose(squares, total, rtol=0.01)
    normalised = points["residual"] / points["standard_error"]
    assert 0.6 < normalised.std() < 1.4
    across = turn @ np.array([0.0, 1.0])
    by_hand = (
        oriented.residuals[["residual_x_left", "residual_y_left"]].to_numpy() @ across
        - oriented.residuals[["residual_x_right", "residual_y_right"]].to_numpy()
        @ across
    )
    np.testing.assert_allclose(points["residual"], by_hand, atol=2e-5)
