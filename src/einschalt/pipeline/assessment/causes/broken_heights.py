"""Heights of control of which a part lies apart: what follows from that.

The points at the edge of the part contradict the block each by itself, and the models
between both parts are bent: without the step none of that is left.
"""

from dataclasses import replace

import numpy as np

from einschalt.foundations.errors import EinschaltError
from einschalt.foundations.names import is_among
from einschalt.pipeline.assessment.causes.kept_gross_errors import can_follow, is_small
from einschalt.pipeline.assessment.causes.ranked import with_consequences
from einschalt.pipeline.assessment.evidence.control.signatures import Kind
from einschalt.pipeline.assessment.findings.catalogue import findings_of
from einschalt.theory.adjustment.significance import FINDING_SIGNIFICANCE

BROKEN = "broken_heights"


def with_broken_heights(examined, judges, findings):
    """Put what is gone where both parts have the same heights under what parts them.

    Only where chance surely does not, and larger errors of all heights do not either;
    the other part may be off instead, but one of them is.
    """
    cause = next((found for found in findings if found.code == BROKEN), None)
    pattern = examined.control_patterns.height
    may_follow = [f.code for f in findings if can_follow(f) and f.code != BROKEN]
    if cause is None or cause.explained_by or not may_follow:
        return findings
    is_surely_parted = pattern.is_told_apart and pattern.kind is not Kind.BEND
    if not (pattern.is_of_adjustment and is_surely_parted):
        return findings
    if pattern.p_value > FINDING_SIGNIFICANCE or not is_small(examined.two_step):
        return findings
    try:
        again = examined.computed_again(_with_heights_back(examined.block, pattern))
        remaining = {found.code for found in findings_of(again, judges)}
    except EinschaltError:  # the rest does not hold together
        return findings
    if BROKEN in remaining:
        return findings
    explained = tuple(code for code in may_follow if code not in remaining)
    return with_consequences(cause, findings, explained)


def _with_heights_back(block, pattern):
    """The block with the heights of a part of its control put back to the others."""
    control = block.control_points
    is_off = is_among(control["point_id"], list(pattern.point_ids))
    height = control["height"] - np.where(is_off, pattern.amplitude[0], 0.0)
    return replace(block, control_points=control.assign(height=height))
