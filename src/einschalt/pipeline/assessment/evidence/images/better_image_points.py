"""Image points that are more precise than their m_g says, in all that the block shows.

Residuals of relative orientation see y-parallax only, and prove nothing alone: what is
identified wrongly in each photograph shows in x as well, and in the block.
"""

from einschalt.pipeline.assessment.evidence.claim import COVERAGES, COVERAGES_HIGH
from einschalt.pipeline.assessment.evidence.image_precision import (
    good_sigma_0,
    image_component,
)
from einschalt.pipeline.assessment.evidence.variance_components import Component
from einschalt.stages.error_propagation.error_model import HIGH, LOW
from einschalt.stages.relative_orientation.shown_errors import MODELS_OF_IMAGE
from einschalt.theory.adjustment.global_tests import ratio_limits
from einschalt.theory.adjustment.significance import (
    FINDING_SIGNIFICANCE,
    MIN_REPORTED_RATIO,
)

COVERAGES_OF = {HIGH: COVERAGES_HIGH, LOW: COVERAGES}


def better_image_points(examined) -> dict[str, Component]:
    """m_g of flights with which orientations and the block agree too well [µm].

    By the residuals of their orientations. The block shows it by the residuals of
    their models in one adjustment, in two steps by the differences of coverages.
    """
    found = {}
    for name, rows in examined.orientations.groupby("flight", sort=False):
        flight = examined.block.flights[name]
        if not flight.has_images:
            continue
        shown = image_component(rows, flight, good_sigma_0(examined, name))
        is_less = shown.given > MIN_REPORTED_RATIO * shown.estimated
        if is_less and shown.is_contradicted and _block_agrees(examined, name):
            found[name] = shown
    return found


def _block_agrees(examined, name):
    """Whether the block shows smaller errors of a flight, too."""
    if examined.two_step is examined:
        return any(
            test.name == COVERAGES_OF[name]
            and test.observed < test.predicted / MIN_REPORTED_RATIO
            for test in examined.claim.too_small
        )
    groups = examined.adjustment.components.set_index("group")
    group = f"{name}, plan" if f"{name}, plan" in groups.index else name
    factor, redundancy = groups.loc[group, ["factor", "redundancy"]].astype(float)
    # models share image points
    degrees = redundancy / MODELS_OF_IMAGE
    limits = ratio_limits(degrees, FINDING_SIGNIFICANCE, MIN_REPORTED_RATIO)
    return bool(factor < limits[0])
