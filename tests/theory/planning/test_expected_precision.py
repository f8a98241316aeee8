"""The closed estimate of expected precision: its geometry and its limits."""

import numpy as np
import pytest

from einschalt.theory.planning.expected_precision import (
    FlightsToExpect,
    control_leverage,
    expected_parts,
    models_per_point,
)
from einschalt.theory.planning.kovarik_precision import PlannedModel, planned_precision

FILM = PlannedModel()
CORNERS = np.array([[-1, -1], [1, -1], [-1, 1], [1, 1], [0, 0]]) / 2
NINE = np.stack(np.meshgrid([-0.5, 0, 0.5], [-0.5, 0, 0.5]), -1).reshape(-1, 2)


def flights(**change):
    given = {
        "scale_number": 8000.0,
        "high_scale_number": 15000.0,
        "spacing": 300.0,
        "m_g": 5e-6,
        "high_m_g": 7.5e-6,
        "n_coverages": 2,
        "control_error": 0.03,
    }
    return FlightsToExpect(**{**given, **change})


@pytest.mark.parametrize(("n_points", "places"), [(5, CORNERS), (9, NINE)])
@pytest.mark.parametrize(("kind", "u"), [("affine", 3), ("helmert", 2)])
def test_control_leverage_is_the_mean_over_the_neat_model(n_points, places, kind, u):
    line = (np.arange(200) + 0.5) / 200 - 0.5
    x, y = np.meshgrid(line, line)
    moments = (places**2).mean(axis=0)
    if u == 3:
        h = 1 + x**2 / moments[0] + y**2 / moments[1]
    else:
        h = 1 + (x**2 + y**2) / moments.sum()
    expected = h.mean() / n_points
    assert control_leverage(kind, n_points) == pytest.approx(expected, rel=1e-4)


def test_models_per_point_counts_overlaps():
    # footprints over the area that each model adds
    model = PlannedModel(image_format=(0.1, 0.2), forward_overlap=0.8, side_overlap=0.6)
    added = (0.2 * 0.1) * (0.4 * 0.2)
    assert models_per_point(model) == pytest.approx((0.8 * 0.1) * 0.2 / added)


def test_parts_make_the_mean():
    parts = expected_parts(flights(), FILM)
    total = parts.measuring + parts.noise + parts.transformation + parts.control
    assert parts.mean**2 == pytest.approx(total)
    assert parts.centre < parts.edge


def test_perfect_approximations_leave_the_measurement():
    parts = expected_parts(flights(high_m_g=1e-12, control_error=0.0), FILM)
    assert parts.approximate == pytest.approx(0.0, abs=1e-6)
    assert float(parts.centre) < 0.04
    with_paper = planned_precision(8000.0, 300.0, 0.0, 5e-6, FILM)
    assert float(parts.centre) == pytest.approx(float(with_paper.M_centre), rel=0.05)


@pytest.mark.parametrize(
    ("change", "better"),
    [
        ({"m_g": 2.5e-6}, True),
        ({"high_m_g": 5e-6}, True),
        ({"high_scale_number": 12000.0}, True),
        ({"n_coverages": 3}, True),
        ({"control_error": 0.01}, True),
        ({"control_per_model": 9}, True),
        ({"spacing": 400.0}, False),
    ],
)
def test_more_work_is_better(change, better):
    assert (
        expected_parts(flights(**change), FILM).mean
        < expected_parts(flights(), FILM).mean
    ) == better


def test_arrays_are_as_one_by_one():
    scales = np.array([6000.0, 8000.0, 12000.0])
    many = expected_parts(
        flights(scale_number=scales, high_scale_number=2 * scales), FILM
    )
    for i, scale in enumerate(scales):
        one = expected_parts(
            flights(scale_number=scale, high_scale_number=2 * scale), FILM
        )
        for name in ("mean", "edge", "centre", "approximate", "control"):
            assert getattr(many, name)[i] == pytest.approx(float(getattr(one, name)))


def test_few_points_take_the_lattice():
    few, many = (
        expected_parts(flights(spacing=spacing), FILM).edge
        for spacing in (800.0, 300.0)
    )
    assert few > many
