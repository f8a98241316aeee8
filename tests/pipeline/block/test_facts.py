"""Facts of a block that scripts give: numbers, words, and what belongs together."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from einschalt.foundations.errors import EinschaltError
from einschalt.pipeline.block.block import Block, Flight
from einschalt.pipeline.block.facts import (
    check_facts,
)
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block


def changed(block, flight="low_flight", **facts):
    return replace(block, **{flight: replace(getattr(block, flight), **facts)})


@pytest.mark.parametrize(
    ("facts", "said"),
    [
        (
            {"m_g_um": 5e-6},
            r"\[low_flight\] m_g_um = 5e-06; expected 0\.1 to 1000 \(mic",
        ),
        ({"m_g_um": 5e-6}, r"Did you give metres\?$"),
        ({"m_g_um": 0.0075}, r"Did you give millimetres\?$"),
        ({"m_g_um": np.nan}, r"m_g_um = nan; expected 0\.1 to 1000"),
        ({"m_g_um": True}, "m_g_um = True; expected"),
        ({"m_g_um": "5"}, "m_g_um = '5'; expected"),
        ({"m_g_um": None}, "m_g_um = None; expected"),
        (
            {"scale_number": 1 / 8000},
            r"scale_number = 0\.000125; .*Give 8000 for 1:8000",
        ),
        (
            {"scale_number": -8000},
            r"scale_number = -8000; expected 100 to 200000 \(the",
        ),
        (
            {"principal_distance_mm": 0.153},
            r"expected 1 to 5000 .*Did you give metres\?",
        ),
        ({"principal_distance_mm": 153e3}, r"Did you give micrometres\?$"),
        (
            {"transformation": "Afine"},
            r"transformation = 'Afine' is unknown; expected affine or .*Write 'affine'",
        ),
        (
            {"model_unit": "inch"},
            "model_unit = 'inch' is unknown; expected um or mm or .*Convert the models",
        ),
        ({"model_unit": "km"}, "'km' is unknown; .*Convert the models to one of these"),
        ({"model_unit": "µm"}, "'µm' is unknown; .*Write 'um'"),
        ({"model_unit": "Meter"}, "'Meter' is unknown; .*Write 'm'"),
        (
            {"base": -90.0},
            r"\[low_flight\] base = -90\.0; expected a positive number in",
        ),
        ({"base": np.inf}, "base = inf; expected a positive number"),
        ({"model_points": None}, "model_points and image_points are both missing"),
        (
            {"orientation_case": "dependent"},
            r"orientation_case = 'dependent' is unknown; .*Write '(in)?dependent",
        ),
        (
            {"orientation_method": "gruber"},
            r"y_parallaxes is missing; expected y_parallaxes beside orientation_method",
        ),
    ],
)
def test_wrong_fact_of_a_flight(demo_block, facts, said):
    with pytest.raises(EinschaltError, match=said):
        changed(demo_block, **facts)


def test_parallaxes_need_a_base(demo_block):
    points = demo_block.low_flight.model_points
    parallaxes = points.assign(z=0.0, y_parallax=0.0)
    with pytest.raises(EinschaltError, match=r"base is missing; expected base beside"):
        changed(demo_block, y_parallaxes=parallaxes)


def test_images_need_models_and_principal_distance(demo_block):
    images = pd.DataFrame({"image_id": ["1"], "point_id": ["A"], "x": 1.0, "y": 1.0})
    with pytest.raises(EinschaltError) as caught:
        changed(demo_block, model_points=None, image_points=images)
    assert [problem.found for problem in caught.value.problems] == [
        "[low_flight] models is missing",
        "[low_flight] principal_distance_mm is missing",
    ]


def test_two_sources_of_one_flight(demo_block):
    images = pd.DataFrame({"image_id": ["1"], "point_id": ["A"], "x": 1.0, "y": 1.0})
    with pytest.raises(
        EinschaltError, match="image_points are both given; expected one"
    ):
        changed(demo_block, image_points=images)


def test_neither_and_both_sources_of_approximations(demo_block):
    with pytest.raises(EinschaltError, match="neither a high flight nor approximate"):
        replace(demo_block, high_flight=None)
    with pytest.raises(EinschaltError, match="and approximate points are both given"):
        replace(demo_block, approximate_points=demo_block.truth)


def test_high_flight_needs_control_points(demo_block):
    with pytest.raises(EinschaltError, match="a high flight is given without control"):
        replace(demo_block, control_points=None)


def test_low_flight_is_needed(demo_block):
    with pytest.raises(
        EinschaltError, match=r"no low flight is given; expected \[low_"
    ):
        replace(demo_block, low_flight=None)


def test_error_of_approximations_in_millimetres(demo_block):
    with pytest.raises(EinschaltError, match=r"m_0_m = 1000; .*Did you give millimet"):
        replace(
            demo_block,
            high_flight=None,
            approximate_points=demo_block.truth,
            approximate_m_0_m=1000,
        )


def test_unknown_system(demo_block):
    with pytest.raises(EinschaltError, match="crs = 'EPSG:99999' is unknown"):
        replace(demo_block, crs="EPSG:99999")


def test_what_was_said_is_not_said_again(demo_block):
    low = Flight(scale_number=None, m_g_um=None, base=True, transformation=7)
    draft = type("Draft", (), vars(demo_block) | {"low_flight": low, "crs": 7})()
    keys = ("scale_number", "m_g_um", "base", "transformation", "model_points")
    said = {("low_flight", key) for key in keys} | {("block", "crs")}
    assert check_facts(draft, said) == []
    assert len(check_facts(draft, said - {("low_flight", "m_g_um")})) == 1


def test_facts_of_a_file_name_it(demo_block):
    with pytest.raises(EinschaltError, match=r"^block\.toml: \[low_flight\] m_g_um"):
        changed(replace(demo_block, sources={"block": "block.toml"}), m_g_um=0)


def test_sound_block_has_no_problem(demo_block):
    assert check_facts(demo_block) == []
    assert isinstance(demo_block, Block)


def test_models_and_coverages_are_counted_as_they_were_measured(demo_block):
    points = demo_block.low_flight.model_points
    assert demo_block.low_flight.n_models == 23
    assert demo_block.low_flight.n_coverages == 2
    one = replace(demo_block.low_flight, model_points=points[points["coverage"] == "1"])
    assert one.n_models < 23
    assert one.n_coverages == 1


def test_models_of_images_are_those_of_their_list():
    geometry = replace(PRESETS["demo"].geometry, measurement="images")
    low = simulate_block("demo", seed=1, geometry=geometry).low_flight
    assert low.model_points is None
    assert low.n_models == len(low.models)
    assert low.n_coverages == 2
