"""What is said of displacements that the claim's tests would not notice."""

import numpy as np
import pytest

from einschalt.pipeline.assessment.evidence.claim import Claim
from einschalt.pipeline.summary.sections.claim import section
from einschalt.theory.adjustment.detectable_shift import DetectableShift


@pytest.mark.parametrize(
    ("median", "largest", "said"),
    [
        (0.17, 0.23, "from 17 cm on, at the least favourable place from 23 cm on"),
        (
            0.17,
            np.inf,
            "from 17 cm on; parts of the block that hardly",
        ),
        (np.inf, np.inf, "would not be noticed: hardly anything connects the models"),
    ],
)
def test_what_would_not_be_noticed_is_said(median, largest, said):
    claim = Claim((), None, detectable_shift=DetectableShift(median, largest))
    assert any(said in remark for remark in section(claim).remarks)


def test_nothing_is_said_where_nothing_was_looked_for():
    assert not any("noticed" in remark for remark in section(Claim((), None)).remarks)
