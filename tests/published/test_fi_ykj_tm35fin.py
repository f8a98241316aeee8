"""Finland, YKJ to ETRS-TM35FIN: 767 points, 1450 triangles (data_examples).

Source: National Land Survey of Finland, as distributed in PROJ-data. PROJ prints
(3210000, 6700000) -> (209948.3217, 6697187.0009) for its own evaluation of the
triangles; tolerance half a unit of the last printed digit. The figures of the single
transformations were computed independently, and are stated to 1 mm and 1e-8.
"""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import einschalt as es

FOLDER = Path(__file__).parents[2] / "data_examples" / "fi_ykj_tm35fin"
RESIDUALS = ["residual_easting", "residual_northing"]
HALF_MM = 0.0005
RADIANS_PER_ARCSECOND = np.pi / 648_000


@pytest.fixture(scope="module")
def ground_points():
    return pd.read_csv(FOLDER / "ground_points.csv")


@pytest.fixture(scope="module")
def corners():
    return pd.read_csv(FOLDER / "triangles_model_points.csv")


def fit_all(ground_points, kind):
    model_points = pd.read_csv(FOLDER / "model_points.csv")
    return es.transform_models(model_points, ground_points, kind=kind)


@pytest.mark.parametrize(
    ("kind", "rms", "largest"),
    [
        ("helmert", (0.890, 0.683), (2.88, 2.91)),
        ("affine", (0.804, 0.651), (2.77, 2.80)),
    ],
)
def test_one_transformation_over_all(ground_points, kind, rms, largest):
    residuals = fit_all(ground_points, kind).residuals[RESIDUALS].to_numpy()
    assert len(residuals) == 767
    found = np.sqrt(np.mean(residuals**2, axis=0))
    np.testing.assert_allclose(found, rms, rtol=0, atol=HALF_MM)
    np.testing.assert_allclose(np.abs(residuals).max(axis=0), largest, atol=0.005)


def test_scale_and_rotation_of_the_helmert_transformation(ground_points):
    a, b = fit_all(ground_points, "helmert").parameters.loc["all", ["a", "b"]]
    assert np.hypot(a, b) == pytest.approx(0.99959798, abs=5e-9)
    rotation = np.arctan2(b, a) / RADIANS_PER_ARCSECOND
    assert rotation == pytest.approx(0.644, abs=HALF_MM)


def test_a_triangle_reproduces_its_corners_and_knows_no_precision(
    ground_points, corners
):
    fit = es.transform_models(corners, ground_points, kind="affine")
    assert len(fit.models) == 1450
    assert fit.models["is_usable"].all()
    assert (fit.models["redundancy"] == 0).all()
    assert fit.models["m_0"].isna().all()
    # coordinates of 7e6 m have 1e-9 m of rounding
    assert fit.residuals[RESIDUALS].abs().to_numpy().max() < 5e-9


def test_the_point_that_proj_prints(ground_points, corners):
    x, y = 3_210_000.0, 6_700_000.0
    triangle = triangle_around(corners, x, y)
    assert triangle == "T0001"
    fit = es.transform_models(corners, ground_points, kind="affine")
    point = pd.DataFrame({"model_id": [triangle], "point_id": "P", "x": x, "y": y})
    found = fit.transform(point)[["easting", "northing"]].to_numpy()[0]
    expected = (209_948.3217, 6_697_187.0009)
    np.testing.assert_allclose(found, expected, rtol=0, atol=0.00005)


def triangle_around(corners, x, y):
    xy = corners[["x", "y"]].to_numpy().reshape(-1, 3, 2) - (x, y)
    turned = np.roll(xy, -1, axis=1)
    area = xy[..., 0] * turned[..., 1] - xy[..., 1] * turned[..., 0]
    holds = np.flatnonzero((area >= 0).all(axis=1) | (area <= 0).all(axis=1))
    assert len(holds) == 1
    return corners["model_id"].iloc[3 * holds[0]]
