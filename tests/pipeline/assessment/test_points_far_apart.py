"""Points whose models lie far apart, in a flight of one coverage.

No comparison of coverages is there to name them, and models that go onto control alone
have no residuals at them.
"""

from dataclasses import replace

import numpy as np
import pytest

from einschalt.pipeline.densify import densify
from einschalt.pipeline.simulation.simulate_block import simulate_block

PLAN = ["easting", "northing"]


@pytest.fixture(scope="module")
def simulated():
    """The demo block with the first coverage of its low flight alone."""
    block = simulate_block("demo", seed=2)
    low = block.low_flight
    points = low.model_points
    is_first = points["coverage"] == points["coverage"].iloc[0]
    points = points[is_first].reset_index(drop=True)
    return replace(block, low_flight=replace(low, model_points=points))


@pytest.fixture(scope="module")
def onto_control(simulated):
    """Its low flight straight onto control that is given as approximate points."""
    truth = simulated.truth
    rng = np.random.default_rng(4)
    given = truth[["point_id", *PLAN]].iloc[::2].reset_index(drop=True)
    given[PLAN] += rng.normal(0.0, 0.02, (len(given), 2))
    control = given.assign(standard_error_m=0.02 * np.sqrt(2.0), role="control")
    return replace(
        simulated,
        high_flight=None,
        control_points=control,
        approximate_points=given,
        approximate_m_0_m=0.02 * np.sqrt(2.0),
    )


@pytest.fixture(scope="module")
def exchanged(onto_control):
    """Two new points under each other's name in one of three models and more."""
    low = onto_control.low_flight
    points, control = low.model_points, onto_control.control_points["point_id"]
    n_models = points["point_id"].map(points["point_id"].value_counts())
    is_new = ~points["point_id"].isin(control) & (n_models > 2)
    by_model = points[is_new].groupby("model_id")["point_id"]
    rows = by_model.apply(lambda names: list(names.index[:2]))
    first, second = next(pair for pair in rows if len(pair) == 2)
    names = points["point_id"].copy()
    names[[first, second]] = names[[second, first]].to_numpy()
    points = points.assign(point_id=names)
    block = replace(onto_control, low_flight=replace(low, model_points=points))
    return block, set(names[[first, second]])


def computed(block, **settings):
    return densify(block, block.settings.updated(settings))


def missed(result, truth):
    """Distances of the new points from the truth, a Series by name [m]."""
    points = result.points
    new = points[points["role"] == "new"].set_index("point_id")[PLAN]
    apart = new - truth.set_index("point_id")[PLAN].reindex(new.index)
    return np.hypot(apart["easting"], apart["northing"])


def test_points_under_each_others_name_are_suspects_and_in_the_figure(exchanged):
    block, names = exchanged
    result = computed(block, outliers="keep", tolerance=0.5)
    off = missed(result, block.truth)
    assert off[list(names)].min() > 1.0
    points = result.points.set_index("point_id").loc[list(names)]
    assert points["is_suspect"].all()
    assert not points["is_within_tolerance"].any()
    credible = result.assessment.credible
    true = float(np.sqrt(np.mean(off**2)))
    assert 0.6 < credible.value / true < 1.5
    assert credible.is_lower_bound


def test_a_block_without_any_is_as_good_as_it_was(onto_control):
    result = computed(onto_control, outliers="keep")
    assert not result.examination.far_apart.any()
    off = missed(result, onto_control.truth)
    credible = result.assessment.credible
    assert not credible.is_lower_bound
    assert 0.6 < credible.value / float(np.sqrt(np.mean(off**2))) < 1.6
