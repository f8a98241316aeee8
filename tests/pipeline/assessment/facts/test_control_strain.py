"""Control points that disagree, from tables made by hand."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from einschalt.pipeline.assessment.evidence.systematic_errors import (
    NetworkStrain,
    SystematicPatterns,
)
from einschalt.pipeline.assessment.facts.control_strain import (
    MOST_DISPLACED,
    MOST_SUSPECTS,
    displaced_control_facts,
    suspect_control_facts,
)
from einschalt.pipeline.summary.sections.control_strain import section


def strained(*, is_smooth=True, p_value=1e-5, n=12):
    moved = pd.DataFrame(
        {
            "point_id": [f"K{k}" for k in range(n)],
            "easting": np.linspace(0.3, 0.1, n),
            "northing": -0.1,
        }
    )
    return NetworkStrain(
        size=0.2,
        reach=800.0,
        p_value=p_value,
        is_smooth=is_smooth,
        n_control=n,
        displacements=moved,
    )


def examined_with(n_suspects=0, strain=None, **columns):
    n = 30
    control = pd.DataFrame(
        {
            "point_id": [f"K{k}" for k in range(n)],
            "strain_easting": np.arange(n) / 10.0,
            "strain_northing": 0.5,
            "w": np.arange(n, dtype=float),
            # the last one is the worst
            "p_value": 10.0 ** -np.arange(n),
            "is_suspect": np.arange(n) >= n - n_suspects,
            "is_set_aside": False,
        }
    ).assign(**columns)
    return SimpleNamespace(
        adjustment=SimpleNamespace(control=control),
        patterns=SystematicPatterns((), strain),
        strain=strain,
    )


def test_suspects_come_worst_first():
    facts = suspect_control_facts(examined_with(2))
    assert [suspect.point_id for suspect in facts.suspects] == ["K29", "K28"]
    first = facts.suspects[0]
    assert (first.easting, first.northing, first.w) == (2.9, 0.5, 29.0)
    assert first.p_value == pytest.approx(1e-29)
    assert not facts.is_set_aside
    aside = examined_with(2, is_set_aside=[False] * 29 + [True])
    assert suspect_control_facts(aside).is_set_aside


def test_heights_of_spatial_models_are_told():
    assert np.isnan(suspect_control_facts(examined_with(2)).suspects[0].height)
    facts = suspect_control_facts(examined_with(2, strain_height=-0.7))
    assert facts.suspects[0].height == -0.7
    said = section(facts)
    assert said.header == ("", "easting", "northing", "height", "w", "p")
    assert said.rows[0][3] == "-70 cm"
    assert "height: error" in said.remarks[0]
    assert "height" not in section(suspect_control_facts(examined_with(2))).header


def test_all_are_counted_and_few_are_shown():
    facts = suspect_control_facts(examined_with(25))
    assert len(facts.suspects) == MOST_SUSPECTS < facts.n_suspects == 25


def test_where_no_point_is_suspect_the_whole_network_is_looked_at():
    facts = suspect_control_facts(examined_with(0, strained()))
    assert facts == displaced_control_facts(examined_with(0, strained()))
    assert facts.n_control == 12
    assert len(facts.displacements) == MOST_DISPLACED
    assert facts.displacements[0] == ("K0", 0.3, -0.1)


@pytest.mark.parametrize(
    "strain", [None, strained(is_smooth=False), strained(p_value=0.2)]
)
def test_without_a_smooth_strain_there_is_nothing_to_tell(strain):
    assert displaced_control_facts(examined_with(0, strain)) is None


def test_a_block_without_faults_has_none(good_result, simultaneous_result):
    assert displaced_control_facts(good_result.examination) is None
    assert suspect_control_facts(simultaneous_result.examination) is None
