"""Whether a claim stands, falls, or was never tested."""

import math
from types import SimpleNamespace

import pytest

from einschalt.pipeline.assessment.assess import _is_supported


@pytest.mark.parametrize(
    ("tests", "n_check", "is_refuted", "value", "expected"),
    [
        ((), 0, False, 0.05, None),
        ((), 3, False, 0.05, True),
        (("residuals",), 0, False, 0.05, True),
        ((), 0, True, 0.05, False),
        # no figure, no claim
        (("residuals",), 3, False, math.nan, None),
    ],
)
def test_what_nothing_tests_is_not_supported(
    tests, n_check, is_refuted, value, expected
):
    examined = SimpleNamespace(
        credible=SimpleNamespace(is_lower_bound=is_refuted, value=value),
        claim=SimpleNamespace(tests=tests),
        known_check=SimpleNamespace(count=n_check),
    )
    assert _is_supported(examined, is_grave=False) is expected
