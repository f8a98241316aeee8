"""The words for causes."""

import math

import pytest

from einschalt.pipeline.assessment.finding import Finding, Gravity, Subject
from einschalt.pipeline.summary.suggestions.catalogue import suggestion_of


@pytest.mark.parametrize(
    ("images", "sigma_0", "says"),
    [
        (("7",), 0.5e-3, "5 and 6 in photograph 7 of the low flight: with the names "),
        (("7", "8"), 0.5e-3, "in photograph 7 or 8 of the low flight"),
        (("7",), 0.5e-3, "sigma_0 of model 7/8 is 4.0 µm instead of 0.50 mm"),
        (("7",), math.inf, "is 4.0 µm; as measured its relative orientation does not"),
    ],
)
def test_names_exchanged_in_a_photograph_are_named(images, sigma_0, says):
    exchange = {
        "flight": "low_flight",
        "points": ("5", "6"),
        "images": images,
        "models": (("1", "7/8"),),
        "sigma_0": sigma_0,
        "sigma_0_exchanged": 4e-6,
        "takes_part": True,
    }
    found = Finding(
        "exchanged_image_names",
        Subject.MEASUREMENT,
        Gravity.GRAVE,
        remedy="put_the_names_right",
        facts={
            "n_exchanges": 1,
            "exchanges": (exchange,),
            "takes_part": True,
            "explains": ("failed_models",),
        },
    )
    said = suggestion_of(found)
    assert says in said.problem
    assert said.remedy == "Correct the names and compute again"
    assert "failed models" in said.details[0]
