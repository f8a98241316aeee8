"""What the first line says is to be mended first."""

from dataclasses import replace

import pytest

import einschalt as es
from einschalt.foundations.language import written_in
from einschalt.pipeline.simulation.simulate_block import PRESETS
from einschalt.pipeline.summary.verdict import verdict

SAID = {
    "en": "check the control network for strain first",
    "de": "zuerst das Passpunktnetz auf Spannungen prüfen",
}


@pytest.fixture(scope="module")
def strained():
    noise = replace(
        PRESETS["demo"].noise, network_strain=0.5, network_strain_wavelength=4000.0
    )
    block = es.simulate_block("demo", seed=1, noise=noise)
    return es.densify(block, es.Settings(method="simultaneous")).assessment


@pytest.mark.slow
@pytest.mark.parametrize("language", SAID)
def test_a_strained_network_is_named_where_it_leads(strained, language):
    with written_in(language):
        assert verdict(strained).endswith(SAID[language])


def test_a_shown_cause_comes_before_a_strain(strained):
    found = next(f for f in strained.findings if f.code == "strained_network")
    shown = replace(found, code="displaced_region", facts={"explains": ()})
    both = replace(strained, findings=(found, shown))
    assert verdict(both).endswith("check the displaced points first")


def test_a_strain_that_follows_from_something_is_not_named(strained):
    findings = tuple(
        replace(f, explained_by="models_upside_down")
        if f.code == "strained_network"
        else f
        for f in strained.findings
    )
    assert "strain" not in verdict(replace(strained, findings=findings))
