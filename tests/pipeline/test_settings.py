"""Settings: the words of an option stand once; former words keep working."""

import re
import warnings
from typing import Literal, get_args, get_origin

import numpy as np
import pytest

import einschalt as es
from einschalt.foundations.errors import SettingsError
from einschalt.pipeline.assessment.tolerance import PRESETS
from einschalt.pipeline.settings import (
    FORMER_WORDS,
    NO_TOLERANCE,
    TOLERANCES,
    Expected,
    Settings,
    with_present_words,
    words_of,
)
from einschalt.stages import coverage_screening, model_screening, stage5_double_coverage
from einschalt.stages.relative_orientation import orient_from_images
from einschalt.stages.simultaneous import adjustment
from einschalt.theory.residual_distribution import distribution_weights

FIELDS = list(Settings.model_fields)


@pytest.mark.parametrize("name", FIELDS)
def test_every_field_has_help_and_says_what_it_takes(name):
    field = Settings.model_fields[name]
    assert field.description.endswith(".")
    is_choice = get_origin(field.annotation) is Literal
    assert is_choice or any(isinstance(fact, Expected) for fact in field.metadata)


@pytest.mark.parametrize("name", [name for name in FIELDS if words_of(name)])
def test_the_docstring_lists_the_words(name):
    listed = re.search(rf"\n    {name} : {{(.*?)}}", Settings.__doc__, re.DOTALL)[1]
    assert tuple(re.findall(r'"(\w+)"', listed)) == words_of(name)


@pytest.mark.parametrize(
    ("name", "known"),
    [
        ("outliers", model_screening.OUTLIERS),
        ("outliers", orient_from_images.OUTLIERS),
        ("outliers", adjustment.OUTLIERS),
        ("screening", coverage_screening.SCREENINGS),
        ("coverage_mean", stage5_double_coverage.COVERAGE_MEANS),
        ("weighting", ("auto", *stage5_double_coverage.WEIGHTINGS)),
        ("variance_components", adjustment.COMPONENTS),
        ("model_deformation", adjustment.DEFORMATIONS),
        ("residual_distribution", ("none", *distribution_weights.DISTRIBUTIONS)),
    ],
)
def test_words_are_those_that_the_stages_know(name, known):
    assert set(words_of(name)) == set(known)


def test_tolerances_are_those_that_are_judged():
    assert (NO_TOLERANCE, *PRESETS) == TOLERANCES


def test_words_are_those_of_the_annotation():
    assert words_of("method") == get_args(Settings.model_fields["method"].annotation)
    assert words_of("iterations") == ()


@pytest.mark.parametrize("name", FORMER_WORDS)
def test_a_former_word_is_understood_with_a_warning(name):
    for former, present in FORMER_WORDS[name].items():
        with pytest.warns(DeprecationWarning, match=f'{former}" is now called') as said:
            settings = Settings(**{name: former})
        assert said[0].filename == __file__
        assert getattr(settings, name) == present in words_of(name)


def test_a_former_word_gives_the_same_result():
    block = es.simulate_block("demo", seed=4)
    with pytest.warns(DeprecationWarning, match="two_step"):
        former = es.densify(block, Settings(method="pipeline"))
    assert former.settings == es.densify(block).settings


def test_present_words_raise_no_warning():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert Settings(method="two_step") == Settings()


@pytest.mark.parametrize("value", [3, None, ["pipeline"], {"pipeline": 1}])
def test_what_is_no_word_is_refused_as_before(value):
    with pytest.raises(SettingsError, match=r"method = .* 'two_step', 'simul"):
        Settings(method=value)
    assert with_present_words({"method": value}) == {"method": value}


def test_updated_settings_are_checked():
    assert Settings(iterations=2).updated({"weighting": "weighted"}) == Settings(
        iterations=2, weighting="weighted"
    )
    with pytest.raises(SettingsError, match="weighting = 'heavy'"):
        Settings().updated({"weighting": "heavy"})


@pytest.mark.parametrize("update", [{"method": "nonsense"}, {"metod": "auto"}])
def test_copies_are_checked(update):
    """A copy of pydantic takes anything: densify ended in a KeyError."""
    with pytest.raises(SettingsError, match=r"method = 'nonsense'|Write method"):
        Settings().model_copy(update=update)
    copied = Settings(iterations=2).model_copy(update={"method": "auto"}, deep=True)
    assert copied == Settings(iterations=2, method="auto")
    assert copied.model_copy() == copied


def test_settings_that_nobody_checked_are_refused_before_the_work(demo_block):
    said = "method = 'nonsense'; expected 'two_step', 'simul"
    with pytest.raises(SettingsError, match=said):
        es.densify(demo_block, Settings.model_construct(method="nonsense"))


@pytest.mark.parametrize(
    ("given", "found", "remedy"),
    [
        (
            {"method": "auto"},
            "a dict of length 1",
            "Write Settings(**fields) of a dict of fields",
        ),
        ("auto", "'auto'", ""),
    ],
)
def test_settings_without_their_names(given, found, remedy):
    with pytest.raises(SettingsError) as caught:
        Settings(given)
    assert caught.value.found == f"Settings was given {found} without a name"
    assert caught.value.expected == "fields by name, such as method=…"
    assert (caught.value.remedy or "") == remedy


@pytest.mark.parametrize("kind", [np.int64, np.uint8, np.array])
def test_integers_of_numpy_are_integers(kind):
    settings = Settings(iterations=kind(2))
    assert settings == Settings(iterations=2)
    assert type(settings.iterations) is int


@pytest.mark.parametrize(
    "value", [True, np.True_, 2.0, np.float64(2.0), "2", np.array([2, 3]), np.int64(0)]
)
def test_what_is_no_number_of_iterations_stays_refused(value):
    said = r"iterations = .*; expected a whole number from 1 to 100"
    with pytest.raises(SettingsError, match=said):
        Settings(iterations=value)
