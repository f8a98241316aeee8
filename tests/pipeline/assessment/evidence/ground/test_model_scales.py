"""Models of a flight with y-parallaxes that are in another unit than the others."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from einschalt.pipeline.assessment.evidence.ground.model_scales import (
    find_models_in_another_unit,
    scales_of_models,
)
from einschalt.pipeline.assessment.finding import Gravity
from einschalt.pipeline.densify import densify
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block

SCALES = [8.0, 8.1, 7.9, 8.2, 8.0, 7.8]


def flight_of_helmert(scales, *, has_parallaxes=True, is_usable=True):
    """An examination of a flight whose models have these scales."""
    angle = np.linspace(0.0, 3.0, len(scales))
    models = pd.DataFrame(
        {
            "flight": "low_flight",
            "model_id": [str(k) for k in range(len(scales))],
            "a": np.asarray(scales) * np.cos(angle),
            "b": np.asarray(scales) * np.sin(angle),
            "is_usable": is_usable,
        }
    )
    flight = SimpleNamespace(
        transformation="helmert", y_parallaxes="a table" if has_parallaxes else None
    )
    block = SimpleNamespace(flights={"low_flight": flight})
    return SimpleNamespace(models=models, block=block)


def test_scale_of_a_model_whatever_its_direction():
    examined = flight_of_helmert(SCALES)
    flight = examined.block.flights["low_flight"]
    np.testing.assert_allclose(scales_of_models(examined.models, flight), SCALES)


@pytest.mark.parametrize("factor", [3.28, 0.001, 1000.0])
def test_the_model_with_another_unit_is_found(factor):
    scales = [*SCALES[:2], SCALES[2] / factor, *SCALES[3:]]
    found = find_models_in_another_unit(flight_of_helmert(scales))
    assert list(found["model_id"]) == ["2"]
    assert found["scale_ratio"].iloc[0] == pytest.approx(factor, rel=0.05)


@pytest.mark.parametrize(
    "examined",
    [
        flight_of_helmert(SCALES),
        flight_of_helmert([*SCALES, 16.0]),  # a plotter set to half of the scale
        # a transformation takes them as they are
        flight_of_helmert([*SCALES, 8000.0], has_parallaxes=False),
        # one of three: nothing tells what is usual; nor where it is every second one
        flight_of_helmert([8.0, 8.0, 8000.0]),
        flight_of_helmert([*SCALES, *(1000.0 * np.array(SCALES))]),
        flight_of_helmert([*SCALES, 8000.0], is_usable=False),
    ],
)
def test_alike_few_and_undecided_models_are_not(examined):
    assert find_models_in_another_unit(examined).empty


def in_another_unit(block, factor):
    """A block of which one high model is in another unit, and the name of the model."""
    points = block.high_flight.model_points.copy()
    first = points.iloc[0]
    is_its = (points["coverage"] == first["coverage"]) & (
        points["model_id"] == first["model_id"]
    )
    points.loc[is_its, ["x", "y", "z"]] *= factor
    high = replace(block.high_flight, model_points=points)
    return replace(block, high_flight=high), first["model_id"]


@pytest.mark.slow
@pytest.mark.parametrize("factor", [1 / 0.3048, 0.001])
def test_a_model_in_another_unit_is_named_as_the_cause(factor):
    """Gross errors that take part stood there, or the sign of all y-parallaxes."""
    geometry = replace(PRESETS["demo"].geometry, measurement="parallaxes")
    block = simulate_block("demo", seed=15, geometry=geometry)
    spoilt, name = in_another_unit(block, factor)
    judged = densify(spoilt).assessment
    first, *others = judged.findings
    assert first.code == "models_in_another_unit"
    assert first.names == (name,)
    assert first.observed == pytest.approx(factor, rel=0.1)
    assert judged.causes == ("models_in_another_unit",)
    grave = [found for found in others if found.gravity is Gravity.GRAVE]
    assert {found.explained_by for found in grave} == {first.code}
    assert not judged.claim_is_supported
