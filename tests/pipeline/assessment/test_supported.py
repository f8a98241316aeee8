"""Whether a claim stands, falls, or was never tested."""

import math
from types import SimpleNamespace

import pytest

from einschalt.pipeline.assessment.assess import _is_supported


@pytest.mark.parametrize(
    ("tests", "n_check", "refuted", "value", "expected"),
    [
        ((), 0, "", 0.05, None),
        ((), 3, "", 0.05, True),
        (("residuals",), 0, "", 0.05, True),
        ((), 0, "plan", 0.05, False),
        (("residuals",), 0, "heights", 0.05, False),
        # no figure, no claim
        (("residuals",), 3, "", math.nan, None),
    ],
)
def test_what_nothing_tests_is_not_supported(tests, n_check, refuted, value, expected):
    examined = SimpleNamespace(
        credible=SimpleNamespace(is_lower_bound=refuted == "plan", value=value),
        credible_heights=SimpleNamespace(is_lower_bound=refuted == "heights"),
        claim=SimpleNamespace(tests=tests),
        known_check=SimpleNamespace(count=n_check),
    )
    assert _is_supported(examined, is_grave=False) is expected
