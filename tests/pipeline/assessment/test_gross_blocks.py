"""Errors of a whole block: one figure everywhere, no cause that is not there."""

from dataclasses import replace

import numpy as np
import pytest

from einschalt.pipeline.assessment.evidence.ground.frame import Doubt
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings


def with_names_of_each_other(block, share):
    """Some rows of the low flight under the name of another one's point."""
    points = block.low_flight.model_points.reset_index(drop=True)
    rng = np.random.default_rng(4)
    rows = rng.choice(len(points), int(share * len(points)), replace=False)
    names = points["point_id"].to_numpy(dtype=object)
    names[rows] = np.roll(names[rows], 1)
    points = points.assign(point_id=names)
    once = ~points.duplicated(["coverage", "model_id", "point_id"])
    low = replace(block.low_flight, model_points=points[once].reset_index(drop=True))
    return replace(block, low_flight=low)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["two_step", "simultaneous"])
def test_exchanged_names_have_one_figure_and_are_no_stretch(demo_block, method):
    block = with_names_of_each_other(demo_block, 0.01)
    result = densify(block, Settings(method=method))
    new = result.points[result.points["role"] == "new"]
    credible = result.examination.credible
    assert credible.is_lower_bound
    assert credible.value > 1.0
    checked = new["standard_error_checked"]
    assert np.sqrt(np.mean(checked**2)) == pytest.approx(credible.value, rel=0.01)
    assert Doubt.STRETCHED not in result.examination.frame.doubts
    # 10 times the claim and more is no matter of single points
    assert new["is_suspect"].all()
    truth = block.truth.set_index("point_id").loc[new["point_id"]]
    errors = np.hypot(
        *(new[n].to_numpy() - truth[n].to_numpy() for n in ("easting", "northing"))
    )
    assert credible.value > 0.5 * np.sqrt(np.mean(errors**2))


def test_an_axis_in_another_unit_is_still_a_stretch(demo_block):
    control = demo_block.control_points
    control = control.assign(northing=control["northing"] * 1.05)
    result = densify(replace(demo_block, control_points=control))
    assert Doubt.STRETCHED in result.examination.frame.doubts
