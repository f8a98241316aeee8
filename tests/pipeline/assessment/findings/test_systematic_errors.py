"""Patterns made by hand; those of simulated blocks stand beside systematic_errors."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from einschalt.pipeline.assessment.evidence.control.patterns import (
    NO_PATTERNS,
    ControlPatterns,
)
from einschalt.pipeline.assessment.evidence.ground.network_step import smooth_strain
from einschalt.pipeline.assessment.evidence.systematic_errors import (
    CommonCurvature,
    FilmAffinity,
    NetworkStrain,
    SystematicPatterns,
)
from einschalt.pipeline.assessment.findings import systematic_errors as judges


def affinity(**changes):
    numbers = {"stretch": 1e-4, "shear": 2e-5, "stretch_error": 4e-6}
    facts = {"shear_error": 4e-6, "p_value": 1e-6, "is_absorbed": False, "bias": 0.02}
    return FilmAffinity("low_flight", **{**numbers, **facts, **changes})


def examined_with(*affinities, strain=None, mean_total=0.05, is_suspect=None):
    adjusted = None
    if is_suspect is not None:
        control = pd.DataFrame({"is_suspect": [is_suspect]})
        adjusted = SimpleNamespace(control=control)
    examined = SimpleNamespace(
        patterns=SystematicPatterns(affinities, strain),
        strain=strain,
        control_patterns=NO_PATTERNS,
        network_step=None,
        figures=SimpleNamespace(mean_within=mean_total),
        adjustment=adjusted,
    )
    examined.smooth_strain = smooth_strain(examined)
    return examined


def strain(**changes):
    moved = pd.DataFrame(
        {"point_id": ["A", "B"], "easting": [0.2, 0.1], "northing": [0.0, -0.1]}
    )
    facts = {"size": 0.12, "reach": 900.0, "p_value": 1e-4, "is_smooth": True}
    return NetworkStrain(
        **{**facts, "n_control": 30, "displacements": moved, **changes}
    )


def test_an_affinity_that_nothing_takes_up_is_named():
    found = judges.film_affinity(examined_with(affinity()))
    assert found.names == ("low_flight",)
    assert found.facts["flights"][0]["stretch"] == 1e-4
    assert found.observed == found.facts["flights"][0]["bias"] == 0.02


@pytest.mark.parametrize(
    "changes", [{"p_value": 0.02}, {"is_absorbed": True}, {"bias": 0.004}]
)
def test_other_affinities_are_not(changes):
    assert judges.film_affinity(examined_with(affinity(**changes))) is None


@pytest.mark.parametrize(
    ("size", "p_value", "named"),
    [(0.05, 1e-6, ["low_flight"]), (0.05, 0.02, None), (0.004, 1e-6, None)],
)
def test_models_that_are_curved_alike_are_named(size, p_value, named):
    curvatures = (
        CommonCurvature("high_flight", 0.3, 0.5),
        CommonCurvature("low_flight", size, p_value),
    )
    examined = examined_with()
    examined.patterns = SystematicPatterns((), None, curvatures)
    found = judges.curved_models(examined)
    assert (found and list(found.names)) == named


def test_smooth_strain_enlarges_the_figure():
    found = judges.strained_network(examined_with(strain=strain()))
    assert found.facts["claimed_with_strain"] == pytest.approx(0.13)
    assert found.facts["displacements"][0] == ("A", 0.2, 0.0)
    assert found.remedy == "check_network_or_adjust"
    adjusted = examined_with(strain=strain(), is_suspect=True)
    found = judges.strained_network_of_adjustment(adjusted)
    assert found.remedy == "check_network"
    assert judges.contradicting_control(examined_with(strain=strain())) is None


def test_without_a_figure_nothing_is_reckoned():
    found = judges.strained_network(examined_with(strain=strain(), mean_total=np.nan))
    assert np.isnan(found.facts["claimed_with_strain"])


def test_strain_of_single_points_is_contradicting_control():
    rough = strain(is_smooth=False)
    assert judges.strained_network(examined_with(strain=rough)) is None
    found = judges.contradicting_control(examined_with(strain=rough))
    assert found.facts == {
        "n_control": 30,
        "moved": 0.0,
        "is_beside_given": False,
    }
    # the adjustment names them itself
    for is_suspect in (True, False):
        adjusted = examined_with(strain=rough, is_suspect=is_suspect)
        found = judges.contradicting_control_of_adjustment(adjusted)
        assert (found is None) == is_suspect


@pytest.mark.parametrize("axis", ["plan", "height"])
def test_a_claim_enlarged_for_control_without_a_pattern_is_told(axis):
    examined = examined_with(strain=strain(p_value=0.02))
    shown = {f"moved_{axis}": 0.14, f"p_{axis}": 0.002, "n_control": 13}
    examined.control_patterns = ControlPatterns(None, None, **shown)
    found = judges.contradicting_control(examined)
    assert found.probability == 0.002
    moved = 0.14 * (axis == "plan")
    assert found.facts == {"n_control": 13, "moved": moved, "is_beside_given": False}


def test_chance_is_no_strain():
    weak = examined_with(strain=strain(p_value=0.02))
    assert judges.strained_network(weak) is None
    assert judges.contradicting_control(weak) is None
