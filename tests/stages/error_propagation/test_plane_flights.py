from dataclasses import replace

import numpy as np
import pytest

from einschalt.stages.error_propagation import covariances
from einschalt.stages.error_propagation.plane_flights import (
    GivenControl,
    PlaneFlight,
    UnusableModelError,
    propagate_flights,
)

SIDE = 1000.0
# two models of nine points each, which share a column of them
PLACES = np.stack(np.meshgrid(np.arange(5.0), np.arange(3.0)), -1).reshape(-1, 2)
ROWS = [np.flatnonzero(PLACES[:, 0] <= 2), np.flatnonzero(PLACES[:, 0] >= 2)]


@pytest.fixture
def flight():
    point = np.concatenate(ROWS)
    model = np.repeat([0, 1], [len(rows) for rows in ROWS])
    return PlaneFlight("affine", 10_000.0, 10.0, model, point, PLACES[point] * 0.1)


@pytest.fixture
def control():
    return GivenControl(np.arange(len(PLACES)), SIDE * PLACES, 0.03, None)


def test_points_of_both_models_gain_by_the_mean(flight, control):
    found = propagate_flights(flight, flight, control)
    total = found.errors.covariance.trace(axis1=1, axis2=2)
    middle = PLACES[found.point, 0] == 2
    assert found.n_models.tolist() == np.where(middle, 2, 1).tolist()
    assert total[middle].mean() < total[~middle].mean()


def _total_of_shared(flight, control, weighting):
    """TOTAL variances of the points that both models hold."""
    found = propagate_flights(flight, flight, control, weighting)
    total = found.errors.covariance.trace(axis1=1, axis2=2)
    return total[PLACES[found.point, 0] == 2]


def test_weights_of_least_variance_spare_the_weaker_model(flight, control):
    # alike models have equal weights
    plain, best = (
        _total_of_shared(flight, control, weighting)
        for weighting in ("plain", "rigorous")
    )
    assert best == pytest.approx(plain, rel=1e-9)
    weaker = replace(flight, **_without_a_side(flight))
    plain, best = (
        _total_of_shared(weaker, control, weighting)
        for weighting in ("plain", "rigorous")
    )
    assert best.sum() < 0.998 * plain.sum()


def _without_a_side(flight):
    is_kept = np.ones(len(flight.model), dtype=bool)
    is_kept[[-1, -4]] = False
    names = ("model", "point", "xy")
    return {name: getattr(flight, name)[is_kept] for name in names}


def test_without_measuring_errors_control_alone_remains(flight, control):
    rows = flight.model == 0
    model, point, xy = (part[rows] for part in (flight.model, flight.point, flight.xy))
    exact = replace(flight, m_g_um=0.0, model=model, point=point, xy=xy)
    given = replace(control, point=ROWS[0], plane=control.plane[ROWS[0]])
    found = propagate_flights(exact, exact, given)
    # an affine model of nine points on a lattice: 1/9 + 1/6 + 1/6 in its corner
    variance = found.errors.covariance[0].trace()
    assert variance == pytest.approx((1 / 9 + 2 / 6) * 0.03**2)
    assert found.m_0 == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("kind", ["affine", "helmert"])
@pytest.mark.parametrize("n", [2, 4])
def test_points_that_stand_for_others_have_the_errors_of_each(flight, control, kind, n):
    """As if so many lay at its place, one of them control where control lies."""
    corners = np.flatnonzero((PLACES[:, 0] % 2 == 0) & (PLACES[:, 1] != 1))
    given = replace(control, point=corners, plane=control.plane[corners])
    flight = replace(flight, kind=kind)
    few = replace(flight, stands_for=float(n))
    # points of the same place stand beside each other
    many = replace(
        flight,
        model=np.repeat(flight.model, n),
        point=(n * flight.point[:, None] + np.arange(n)).ravel(),
        xy=np.repeat(flight.xy, n, axis=0),
    )
    of_few = propagate_flights(few, few, given)
    of_many = propagate_flights(many, many, replace(given, point=n * corners))
    is_new = ~np.isin(of_many.point, n * corners)
    place = np.argsort(of_few.point)[of_many.point[is_new] // n]
    for source, found in of_many.parts.items():
        expected = of_few.parts[source][place]
        assert found[is_new] == pytest.approx(expected, rel=1e-9, abs=1e-15)


def test_a_model_on_a_line_is_refused(flight, control):
    on_a_line = replace(flight, xy=flight.xy * [1.0, 0.0])
    with pytest.raises(UnusableModelError):
        propagate_flights(on_a_line, flight, control)


def test_errors_through_models_are_those_of_every_point(flight, control, monkeypatch):
    """As through each measured point of the high flight."""
    few = replace(flight, kind="helmert", stands_for=4.0)
    joint_through_models, taken = covariances.joint_through_models, []

    def counted(*arguments):
        taken.append(joint_through_models(*arguments))
        return taken[-1]

    monkeypatch.setattr(covariances, "joint_through_models", counted)
    found = propagate_flights(few, few, control, "rigorous").parts
    assert any(joint is not None for joint in taken)
    monkeypatch.setattr(covariances, "joint_through_models", lambda *_: None)
    expected = propagate_flights(few, few, control, "rigorous").parts
    assert found.keys() == expected.keys()
    for name, part in expected.items():
        assert found[name] == pytest.approx(part, rel=1e-9, abs=1e-15)
