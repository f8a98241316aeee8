"""Whether a claim stands, falls, or was never tested."""

from types import SimpleNamespace

import pytest

from einschalt.pipeline.assessment.assess import _is_supported


@pytest.mark.parametrize(
    ("tests", "n_check", "is_refuted", "expected"),
    [
        ((), 0, False, None),
        ((), 3, False, True),
        (("residuals",), 0, False, True),
        ((), 0, True, False),
    ],
)
def test_what_nothing_tests_is_not_supported(tests, n_check, is_refuted, expected):
    examined = SimpleNamespace(
        credible=SimpleNamespace(is_lower_bound=is_refuted),
        claim=SimpleNamespace(tests=tests),
        known_check=SimpleNamespace(count=n_check),
    )
    assert _is_supported(examined, is_grave=False) is expected
