"""Points after the distribution: control as given, the others by their weights."""

import numpy as np
import pandas as pd
import pytest

from einschalt.stages.residual_distribution import distribute_residuals

METHODS = ("natural_neighbour", "inverse_distance", "multiquadric")


def table(rows):
    names = ["point_id", "easting", "northing", "role"]
    names += ["difference_easting", "difference_northing"]
    return pd.DataFrame(rows, columns=names)


@pytest.fixture
def points():
    nan = np.nan
    return table(
        [
            ("A", 0.0, 0.02, "control", 0.0, 0.02),
            ("B", 100.0, 0.02, "control", 0.0, 0.02),
            ("C", 100.04, 100.0, "control", 0.04, 0.0),
            ("D", 0.04, 100.0, "control", 0.04, 0.0),
            ("N", 50.0, 50.0, "new", nan, nan),
            ("K", 50.0, 25.0, "check", 0.01, 0.03),
        ]
    )


@pytest.fixture
def control():
    # in another order, with a point that no model holds and a check point
    return pd.DataFrame({"point_id": ["K", "D", "X", "C", "B", "A"]})


@pytest.mark.parametrize("method", METHODS)
def test_control_keeps_its_given_coordinates(points, control, method):
    found = distribute_residuals(points, control, method).points
    np.testing.assert_allclose(
        found.loc[:3, ["easting", "northing"]],
        [[0.0, 0.0], [100.0, 0.0], [100.0, 100.0], [0.0, 100.0]],
        atol=1e-9,
    )
    columns = ["difference_easting", "difference_northing"]
    pd.testing.assert_frame_equal(found.loc[:3, columns], points.loc[:3, columns])


@pytest.mark.parametrize("method", METHODS)
def test_a_point_in_the_middle_takes_the_mean(points, control, method):
    found = distribute_residuals(points, control, method).points.loc[4]
    assert found["distributed_easting"] == pytest.approx(-0.02)
    assert found["distributed_northing"] == pytest.approx(-0.01)
    assert found["easting"] == pytest.approx(50.0 - 0.02)


def test_check_points_are_moved_and_enter_nothing(points, control):
    found = distribute_residuals(points, control, "natural_neighbour")
    check = found.points.loc[5]
    assert check["difference_easting"] == pytest.approx(
        0.01 + check["distributed_easting"]
    )
    assert check["northing"] == pytest.approx(25.0 + check["distributed_northing"])
    assert found.control_places.tolist() == [0, 1, 2, 3]
    assert found.control_sources.tolist() == [5, 4, 3, 1]


def test_without_control_nothing_is_moved(points, control):
    found = distribute_residuals(points.loc[4:], control, "natural_neighbour").points
    assert (found["distributed_easting"] == 0.0).all()
    np.testing.assert_array_equal(found["easting"], points.loc[4:, "easting"])


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("apart", [0.0, 0.01])
def test_control_points_side_by_side_keep_what_each_was_given(points, method, apart):
    """Two marks that were given (almost) the same coordinates, and densified others."""
    twin = table([("B2", 100.0 + apart, 0.05, "control", 0.0, 0.05)])
    points = pd.concat([points, twin], ignore_index=True)
    found = distribute_residuals(points, points[["point_id"]], method).points
    given = points[["easting", "northing"]].to_numpy(dtype=float)
    given = given - points[["difference_easting", "difference_northing"]].to_numpy()
    is_control = (points["role"] == "control").to_numpy()
    np.testing.assert_allclose(
        found.loc[is_control, ["easting", "northing"]], given[is_control], atol=1e-9
    )
    assert found["distributed_northing"].abs().max() < 0.06
