"""Given points that share errors: what their covariances are, and their sizes."""

from dataclasses import replace

import numpy as np
import pytest
from tests.given_approximations import onto_given_approximations
from tests.truth.disturbed_blocks import onto_grouped_approximations

import einschalt as es
from einschalt.pipeline.block.block import Block
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.stages.error_propagation.error_model import model_of_block
from einschalt.stages.error_propagation.given_points import (
    control_shares_errors,
    errors_of_control,
    errors_of_table,
)
from einschalt.theory.adjustment.point_operator import Axes

PLANE = ["easting", "northing"]
LENGTH = 1500.0


@pytest.fixture(scope="module")
def control_sizes(demo_block):
    rng = np.random.default_rng(3)
    n = len(demo_block.control_points)
    return {
        "standard_error_m": rng.uniform(0.02, 0.08, n),
        "standard_error_height": rng.uniform(0.01, 0.2, n),
    }


def _covariance(given, axes):
    """Of all coordinates, axis after axis."""
    found = 0.0
    for name, chain in given.chains.items():
        rows = chain.matrix.toarray() * axes.each(given.sizes[name]).ravel()
        found = found + rows @ rows.T
    places = [np.arange(a, len(found), axes.value) for a in range(axes.value)]
    return found[np.ix_(np.concatenate(places), np.concatenate(places))]


@pytest.mark.parametrize("axes", [Axes.PLANE, Axes.SPACE])
def test_errors_alike_over_a_distance(demo_block, control_sizes, axes):
    control = demo_block.control_points.assign(**control_sizes)
    lengths = {"control_points": LENGTH}
    block = replace(demo_block, control_points=control, correlation_lengths_m=lengths)
    found = _covariance(errors_of_control(block, axes), axes)
    xy = control[PLANE].to_numpy()
    alike = np.exp(-np.linalg.norm(xy[:, None] - xy[None], axis=2) / LENGTH)
    plan = control_sizes["standard_error_m"] / np.sqrt(2.0)
    of_axes = [plan, plan, control_sizes["standard_error_height"]][: axes.value]
    for k, size in enumerate(of_axes):
        place = slice(k * len(xy), (k + 1) * len(xy))
        np.testing.assert_allclose(
            found[place, place], np.outer(size, size) * alike, atol=1e-15
        )
    assert np.abs(found[: len(xy), len(xy) :][:, : len(xy)]).max() < 1e-15


@pytest.mark.parametrize("without", [[0, 3, 4], [-1], slice(None)])
def test_points_without_errors_have_none_and_take_none_from_others(demo_block, without):
    control = demo_block.control_points
    size = np.full(len(control), 0.05)
    size[without] = 0.0
    lengths = {"control_points": LENGTH}
    block = replace(demo_block, correlation_lengths_m=lengths)
    given = errors_of_table(block, "control_points", "control", size, Axes.PLANE)
    found = _covariance(given, Axes.PLANE)[: len(size), : len(size)]
    xy = control[PLANE].to_numpy()
    alike = np.exp(-np.linalg.norm(xy[:, None] - xy[None], axis=2) / LENGTH)
    np.testing.assert_allclose(found, np.outer(size, size) * alike, atol=1e-15)


def test_residuals_may_leave_no_error_to_points_that_are_alike(demo_block):
    """An m_g above all that residuals show: it divided by the 0 that is left."""
    block = onto_given_approximations(demo_block, own_error=0.001, is_stated=False)
    rough = replace(block.low_flight, m_g_um=200.0)
    lengths = {"approximate_points": LENGTH}
    block = replace(block, low_flight=rough, correlation_lengths_m=lengths)
    model = densify(block).examination.error_model
    assert (model.standard_errors["approximate_points"] == 0.0).all()
    assert np.isfinite(model.ground["approximate_points"].matrix.data).all()


def test_points_of_a_group_share_its_shift_and_others_nothing(demo_block):
    control = demo_block.control_points
    group = np.where(np.arange(len(control)) % 3 == 0, "a", "b").astype(object)
    group[:2] = [None, ""]
    block = replace(
        demo_block,
        control_points=control.assign(group=group),
        group_errors_m={"control_points": 0.1},
    )
    given = errors_of_control(block, Axes.COMPLEX)
    of_groups = given.chains["control_groups"].matrix.toarray()
    of_groups = of_groups * given.sizes["control_groups"]
    shared = of_groups @ of_groups.T
    is_same = (group[:, None] == group[None]) & (np.arange(len(group)) > 1)
    is_same &= (np.arange(len(group)) > 1)[:, None]
    np.testing.assert_allclose(shared, np.where(is_same, 0.1**2 / 2.0, 0.0))
    assert control_shares_errors(block)
    assert not control_shares_errors(demo_block)


def test_groups_of_one_point_each_are_errors_of_points(demo_block):
    """The same block said in two ways has the same covariances."""
    control, error = demo_block.control_points, 0.05
    plain = densify(
        replace(
            demo_block,
            control_points=control.assign(standard_error_m=np.hypot(0.03, error)),
        )
    )
    grouped = densify(
        replace(
            demo_block,
            control_points=control.assign(
                standard_error_m=0.03, group=control["point_id"]
            ),
            group_errors_m={"control_points": error},
        )
    )
    np.testing.assert_allclose(
        grouped.errors.covariance, plain.errors.covariance, rtol=1e-9, atol=1e-15
    )
    assert set(grouped.errors.parts) - set(plain.errors.parts) == {"control_groups"}


@pytest.mark.slow
def test_one_group_of_all_shifts_everything(demo_block):
    """No residual shows it, and every point has it in full."""
    control = demo_block.control_points.assign(group="all")
    plain = densify(demo_block)
    errors = {"control_points": 0.2}
    grouped = densify(
        replace(demo_block, control_points=control, group_errors_m=errors)
    )
    more = grouped.errors.covariance - plain.errors.covariance
    expected = np.broadcast_to(0.2**2 / 2.0 * np.eye(2), more.shape)
    np.testing.assert_allclose(more, expected, atol=1e-9)
    # nobody gives the size, and nothing shows it: then nothing is claimed
    silent = densify(replace(demo_block, control_points=control))
    assert silent.errors is None
    assert "standard_error_total" not in silent.points.columns or (
        silent.points["standard_error_total"].isna().all()
    )


@pytest.mark.slow
def test_operators_are_derivatives(demo_block):
    """Moving a group moves the points as its chain says."""
    control = demo_block.control_points.copy()
    control["group"] = np.where(
        control["easting"] > control["easting"].mean(), "e", "w"
    )
    block = replace(
        demo_block, control_points=control, group_errors_m={"control_points": 0.1}
    )
    result = densify(block)
    shift = np.where(control["group"] == "e", 1e-3, 0.0)
    moved = control.assign(easting=control["easting"] + shift)
    other = densify(replace(block, control_points=moved))
    found = (other.points[PLANE] - result.points[PLANE]).to_numpy()
    chain = result.errors.chains["control_groups"]
    groups = sorted(set(control["group"]))
    unit = np.zeros((len(groups), len(chain.axes.names)))
    unit[groups.index("e"), 0] = 1e-3
    np.testing.assert_allclose(chain.of_vectors(unit), found, atol=2e-8)


def test_the_model_of_a_block_says_what_it_assumes(demo_block):
    found = densify(demo_block).solution
    model = model_of_block(
        *(demo_block, found.model_points, found.high, found.low),
        *(found.orientation_errors, None),
    )
    assert list(model.high.control.chains) == ["control"]
    assert not model.is_assumed


def test_groups_of_single_points_in_each_model_are_not_told(demo_block):
    """Their means are the residuals again: nothing tells shifts from errors."""
    control = demo_block.control_points
    each = densify(
        replace(demo_block, control_points=control.assign(group=control["point_id"]))
    )
    assert each.errors is None


@pytest.mark.slow
def test_groups_that_nothing_tells_make_no_claim_smaller(demo_block):
    control = demo_block.control_points
    east = control["easting"] > control["easting"].median()
    halves = replace(
        demo_block, control_points=control.assign(group=np.where(east, "E", "W"))
    )
    plain, found = densify(demo_block), densify(halves)
    assert np.isnan(found.figures.mean_total)
    credible = found.assessment.credible
    assert credible.is_lower_bound
    assert credible.value > 0.9 * plain.assessment.credible.value
    assert found.assessment.claim_is_supported is False
    assert "or worse" in found.summary().splitlines()[0]
    adjusted = densify(halves, Settings(method="simultaneous")).assessment
    assert np.isnan(adjusted.credible.value)
    assert adjusted.claim_is_supported is None


def test_own_errors_are_what_shifts_of_stated_size_leave(demo_block):
    """Approximate points with a group_error_m, but no m_0_m of their own."""
    block = onto_grouped_approximations(demo_block, 0.1, 0.3, (600.0, 600.0), 0)
    said = replace(block, approximate_m_0_m=None)
    sizes = densify(said).examination.error_model.standard_errors
    assert np.max(sizes["approximate_points"]) < 0.12
    assert np.max(sizes["approximate_groups"]) == pytest.approx(0.3 / np.sqrt(2.0))


def test_what_is_said_of_approximate_points_that_are_control_counts(demo_block):
    control = demo_block.control_points
    block = Block(
        low_flight=demo_block.low_flight,
        approximate_points=demo_block.truth.assign(group="all"),
        approximate_m_0_m=0.05,
        group_errors_m={"approximate_points": 0.3},
        control_points=demo_block.truth.assign(standard_error_m=0.03),
        may_be_unmeasured=True,
        crs=demo_block.crs,
    )
    assert len(control) < len(block.control_points)
    parts = densify(block).errors.parts
    shift = parts["approximate_groups"][:, 0, 0]
    np.testing.assert_allclose(shift, 0.3**2 / 2.0, rtol=1e-6)


def test_held_control_has_no_shifts(demo_block):
    control = demo_block.control_points.drop(columns="standard_error_m")
    block = replace(
        demo_block,
        control_points=control.assign(group="all"),
        group_errors_m={"control_points": 0.1},
    )
    adjusted = es.adjust_block(block)
    held = adjusted.points["role"] == "control"
    assert adjusted.points.loc[held, "standard_error_total"].max() < 1e-9


def test_estimated_sizes_leave_alone_what_control_shares(demo_block):
    control = demo_block.control_points.assign(group="all")
    errors = {"control_points": 0.2}
    block = replace(demo_block, control_points=control, group_errors_m=errors)
    given = es.adjust_block(block)
    estimated = es.adjust_block(block, variance_components="estimated")
    for one in (given, estimated):
        # a shift that all points have, in full
        assert one.points["standard_error_total"].min() > 0.18
