"""Misspelt arguments of the classes that users make."""

import inspect
from dataclasses import replace

import pytest

import einschalt as es
from einschalt.foundations.errors import SettingsError

MISSPELT = {
    es.Flight: ("scale_nunber", "scale_number"),
    es.Block: ("controll_points", "control_points"),
    es.PlanChoices: ("spacings", "spacing"),
    es.PlanFrame: ("max_hight", "max_height"),
    es.PlanCosts: ("modell", "model"),
    es.FlightDesign: ("m_g_mu", "m_g_um"),
    es.CameraPreset: ("principle_distance", "principal_distance"),
    es.BlockGeometry: ("heigth", "height"),
    es.BlockNoise: ("low_m_g", "low_m_g_um"),
}


@pytest.mark.parametrize("kind", MISSPELT, ids=lambda kind: kind.__name__)
def test_the_field_that_is_meant_is_named(kind):
    wrong, right = MISSPELT[kind]
    with pytest.raises(SettingsError) as caught:
        kind(**{wrong: 1})
    assert caught.value.found == f"{kind.__name__} has no field {wrong}"
    assert caught.value.remedy == f"Write {right}"
    assert right in caught.value.expected.split(", ")
    # help shows the fields all the same
    assert right in inspect.signature(kind).parameters


def test_what_is_like_no_field_is_to_be_taken_out():
    with pytest.raises(SettingsError, match=r"no field zzz; expected .* Take it out"):
        es.PlanCosts(zzz=1)


def test_copies_with_a_misspelt_field(demo_block):
    flight = demo_block.low_flight
    with pytest.raises(SettingsError, match=r"no field m_g_m; .*Write m_g_um"):
        replace(flight, m_g_m=4)
    assert replace(flight, m_g_um=4).m_g_um == 4
