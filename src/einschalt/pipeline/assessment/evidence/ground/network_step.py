"""A control network that is broken in two, and no strain of it.

A part of the network that lies apart looks like a smooth strain to a test that looks
for one, and a smooth strain looks like a step to a test of steps. Each is tested beside
the other: a step is one where it is the clearer of both, and where, once its amplitude
is free, no strain is left. A strain leaves most of itself beside any step.

See docs/theory/claim.md.
"""

import numpy as np

from einschalt.foundations.frame_columns import values_of
from einschalt.foundations.names import is_among
from einschalt.pipeline.assessment.evidence.control.signatures import Kind
from einschalt.pipeline.assessment.evidence.ground.displaced_control import (
    check_points_beside,
    moved_with,
)
from einschalt.pipeline.assessment.evidence.ground.given_region import (
    GivenRegion,
    told_region,
)
from einschalt.pipeline.assessment.evidence.systematic_errors import strain_beside
from einschalt.stages.error_propagation.given_points import PLAN
from einschalt.theory.adjustment.displaced_regions import DisplacedRegion


def network_step(examined):
    """The step that breaks the control network in two: FoundPattern or None.

    Of an adjustment that of the two steps, if there is one: what was set aside may be
    the part that lies apart.
    """
    two_step = examined.two_step
    own = _broken(examined)
    if two_step is examined or not two_step.is_possible:
        return own
    is_other = own is None and examined.control_patterns.plan is not None
    return own if is_other else two_step.network_step or own


def smooth_strain(examined):
    """The strain that neighbouring control shares: NetworkStrain or None.

    None where a step explains it.
    """
    strain = examined.strain
    if strain is None or not (strain.is_significant and strain.is_smooth):
        return None
    return strain if examined.network_step is None else None


def _broken(examined):
    step, strain = examined.control_patterns.plan, examined.strain
    if step is None or step.kind is not Kind.STEP:
        return None
    if strain is None or not (strain.is_significant and strain.is_smooth):
        return step
    left = strain_beside(strain, step.point_ids, examined.block.control_points)
    is_left = left is not None and left.is_significant
    return None if is_left or step.p_value > strain.p_value else step


def region_of_step(two_step, step) -> GivenRegion:
    """The smaller part of the network as a region, with the check points like it."""
    control = two_step.block.control_points
    control = control[(control["role"] != "check").to_numpy()]
    xy = values_of(control, PLAN)
    rows = np.flatnonzero(is_among(control["point_id"], list(step.point_ids)))
    part = DisplacedRegion(rows, np.array(step.amplitude), np.nan, step.p_value)
    check = moved_with(part, check_points_beside(two_step, xy, part))
    return told_region(
        control,
        part,
        step.n_control - len(rows),
        check,
        is_of_control=True,
        is_decided=False,
    )
