"""The stage of the simultaneous adjustment: deformations of a whole flight."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

import einschalt as es
from einschalt.foundations.errors import GeometryError, SettingsError
from einschalt.pipeline.simulation.simulate_block import PRESETS
from einschalt.stages.simultaneous.adjustment import (
    AdjustmentOptions,
    simultaneous_adjustment,
)
from einschalt.stages.simultaneous.observations import MeasuredFlight, code_block

FLIGHTS = ["high_flight", "low_flight"]


@pytest.fixture(scope="module")
def deformed_block():
    noise = replace(PRESETS["demo"].noise, low_deformation_um=18.75)
    return es.simulate_block("demo", seed=4, noise=noise)


@pytest.fixture(scope="module")
def modelled(deformed_block):
    return es.adjust_block(deformed_block, deformation="modelled")


def test_what_is_found_is_modelled(deformed_block, modelled):
    found = modelled.deformations.set_index("flight")
    assert list(found.index) == FLIGHTS
    assert list(found["is_detected"]) == [False, True]
    assert list(found["is_modelled"]) == [False, True]
    assert list(modelled.common["flight"].unique()) == ["low_flight"]
    assert len(modelled.common) == found.loc["low_flight", "n_terms"] == 14
    # the same as asking for these terms, which both flights then have
    asked = es.adjust_block(deformed_block, deformation=("quadratic", "cubic"))
    low = asked.common[asked.common["flight"] == "low_flight"].reset_index(drop=True)
    difference = low["value"] - modelled.common["value"]
    error = np.hypot(low["standard_error"], modelled.common["standard_error"])
    assert (difference.abs() < 2.0 * error).all()
    assert asked.deformations.empty


def test_the_size_that_is_said_is_the_size_that_is_taken_out(deformed_block, modelled):
    """Against the coordinates that were deformed, and those that were not."""
    plain = es.simulate_block("demo", seed=4)
    moved = (
        deformed_block.low_flight.model_points[["x", "y"]]
        - plain.low_flight.model_points[["x", "y"]]
    ).to_numpy() * 8.0  # mm at 1:8000
    length = np.sqrt(np.mean((moved**2).sum(axis=1)))
    low = modelled.deformations.set_index("flight").loc["low_flight"]
    assert low["size_middle"] < low["size"] < low["size_edge"]
    # terms of degree 4 and the affine part of these points are not in it
    assert low["size"] == pytest.approx(length, rel=0.25)
    assert modelled.s_0 < 1.1
    assert es.adjust_block(deformed_block).s_0 > 1.4


def test_a_gross_error_hides_no_deformation(deformed_block, modelled):
    low = deformed_block.low_flight
    points = low.model_points.copy()
    points.loc[points.index[40], "x"] += 20.0  # 160 m
    block = replace(deformed_block, low_flight=replace(low, model_points=points))
    hidden = es.adjust_block(block, deformation="tested").deformations
    assert not hidden["is_detected"].any()
    found = es.adjust_block(block, deformation="modelled", outliers="snoop")
    assert list(found.deformations["is_modelled"]) == [False, True]
    assert found.residuals["is_suspect"].sum() == 1
    size, expected = (
        each.deformations.set_index("flight").loc["low_flight", "size_edge"]
        for each in (found, modelled)
    )
    assert size == pytest.approx(expected, rel=0.1)


def test_a_test_changes_nothing(deformed_block):
    tested = es.adjust_block(deformed_block, deformation="tested")
    plain = es.adjust_block(deformed_block)
    assert tested.points.equals(plain.points)
    assert tested.common.empty
    assert list(tested.deformations["is_detected"]) == [False, True]
    assert not tested.deformations["is_modelled"].any()
    assert plain.deformations.empty


def test_film_affinity_is_found_by_helmert_models():
    noise = replace(PRESETS["demo"].noise, film_affinity=2e-4)
    block = es.simulate_block("demo", seed=4, noise=noise)
    found = es.adjust_block(block, kind="helmert", deformation="modelled")
    assert found.deformations["is_detected"].all()
    film = found.common[found.common["term"] == "film_affinity"]
    z = (film["value"] + 2e-4) / film["standard_error"]
    assert (z.abs() < 4.0).all()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"deformation": "found"}, "deformation = 'found' is unknown; expected ign"),
        ({"outliers": "none"}, "outliers = 'none' is unknown; expected keep or snoop"),
    ],
)
def test_unknown_words_are_said(options, message):
    with pytest.raises(SettingsError, match=message):
        AdjustmentOptions(**options)


def test_parameters_have_one_set_of_names_however_control_is_weighed():
    """Control of unequal coordinates couples easting and northing in the solution."""
    block = es.simulate_block("demo", seed=1)
    points = block.low_flight.model_points
    error = block.low_flight.ground_error_of(points)
    low = MeasuredFlight("low_flight", points, error, "helmert")
    size = 1.0 + np.array([[0.0, 0.0], [0.0, 1e-9]])
    even, uneven = (
        simultaneous_adjustment(
            code_block(
                [low],
                block.control_points.assign(
                    standard_error_easting=0.02 * e, standard_error_northing=0.02 * n
                ),
            )
        ).estimates
        for e, n in size
    )
    assert even.names == uneven.names == ("a", "b", "te", "tn")
    np.testing.assert_allclose(
        uneven.cofactors,
        even.cofactors,
        rtol=0,
        atol=1e-6 * np.abs(even.cofactors).max(axis=(0, 1, 2)),
    )


def test_models_without_control_are_counted():
    square = pd.DataFrame({"x": [0.0, 0.0, 90.0], "y": [0.0, 90.0, 0.0]})
    names = [("1", "abc"), ("2", "bcd"), ("3", "efg"), ("4", "pqr")]
    parts = [
        square.assign(coverage="1", model_id=model, point_id=list(held))
        for model, held in names
    ]
    low = MeasuredFlight("low_flight", pd.concat(parts), np.full(12, 0.03), "helmert")
    control = pd.DataFrame(
        {
            "point_id": list("aepqr"),
            "easting": [0.0, 9e3, 3e3, 3e3, 3.72e3],
            "northing": [0.0, 0.0, 9e3, 9.72e3, 9e3],
            "standard_error_m": 0.03,
        }
    )
    failures = simultaneous_adjustment(code_block([low], control)).failures
    reasons = dict(zip(failures["model_id"], failures["reason"], strict=True))
    said = "the part of the block it belongs to, {}, has 1 control point, but helmert "
    assert sorted(reasons) == ["1", "2", "3"]
    assert reasons["1"].startswith(said.format("2 models"))
    assert reasons["1"] == reasons["2"]


def test_points_that_do_not_determine_a_deformation_are_said():
    """Four corners of the same square in every model."""
    corners = np.array([[0, 0], [0, 1], [1, 0], [1, 1]])
    i, j = np.divmod(np.arange(9), 3)
    at = np.stack([i, j], -1)[:, None] + corners
    names = [f"{a}/{b}" for a, b in at.reshape(-1, 2)]
    flight = pd.DataFrame(
        {
            "coverage": "1",
            "model_id": np.repeat([str(k) for k in range(9)], 4),
            "point_id": names,
            "x": np.tile(corners[:, 0] * 100.0, 9),
            "y": np.tile(corners[:, 1] * 100.0, 9),
        }
    )
    places = np.argwhere(np.ones((4, 4))) * 800.0
    control = pd.DataFrame(
        {
            "point_id": [f"{a}/{b}" for a, b in np.argwhere(np.ones((4, 4)))],
            "easting": places[:, 0],
            "northing": places[:, 1],
            "standard_error_m": 0.03,
        }
    )
    low = es.Flight(flight, scale_number=8000, m_g_um=5)
    high = replace(low, scale_number=15000)
    block = es.Block(control_points=control, high_flight=high, low_flight=low)
    with pytest.raises(GeometryError, match="do not determine the deformation"):
        es.adjust_block(block, deformation=("cubic",))
    searched = es.adjust_block(block, deformation="modelled").deformations
    assert searched["p_value"].isna().all()
    assert not searched["is_detected"].any()
