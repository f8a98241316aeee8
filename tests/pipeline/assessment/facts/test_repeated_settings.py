"""m_g of repeated settings, and what it makes of their means."""

import numpy as np
import pytest
from tests.pipeline.block.repeated_settings import M_G_UM, rows_of_settings, set_again

from einschalt.pipeline.assessment.facts.repeated_settings import (
    repeated_setting_facts,
)
from einschalt.pipeline.densify import densify


@pytest.fixture(scope="module")
def facts():
    (found,) = repeated_setting_facts(densify(set_again()).examination)
    return found


def test_points_and_settings_are_counted(facts):
    rows = rows_of_settings()
    assert facts.flight == "low_flight"
    assert facts.n_settings == len(rows)
    assert facts.settings_each == pytest.approx(facts.n_settings / facts.n_points)
    assert facts.settings_each == 3.0


def test_m_g_of_the_settings_is_that_of_their_scatter(facts):
    assert facts.m_g_um == M_G_UM
    off = abs(facts.m_g_settings_um - M_G_UM)
    assert off < 3.3 * facts.standard_error_um
    assert not facts.is_larger
    assert not facts.is_smaller


def test_a_mean_is_worse_where_film_and_model_have_their_part():
    block = set_again(m_g_um=1.5 * M_G_UM)
    (facts,) = repeated_setting_facts(densify(block).examination)
    assert facts.is_smaller
    assert facts.mean_as_taken_um == pytest.approx(1.5 * M_G_UM / np.sqrt(3.0))
    # what the settings explain is divided by their number, the rest is not
    settings = facts.m_g_settings_um**2
    rest = facts.m_g_um**2 - settings
    expected = np.sqrt(rest + settings / 3.0)
    assert facts.mean_if_rest_is_model_um == pytest.approx(expected)
    assert facts.m_g_that_makes_it_so_um == pytest.approx(expected * np.sqrt(3.0))


def test_settings_that_scatter_more_are_larger():
    block = set_again(m_g_um=M_G_UM / 2.0)
    (facts,) = repeated_setting_facts(densify(block).examination)
    assert facts.is_larger
    # nothing is left for film and model
    assert facts.mean_if_rest_is_model_um >= 0.0


@pytest.mark.parametrize("name", ["good", "faulty", "simultaneous"])
def test_without_repeats_there_are_none(name, request):
    result = request.getfixturevalue(f"{name}_result")
    assert repeated_setting_facts(result.examination) == ()
