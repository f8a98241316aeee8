"""Deformations of models, shared or of each alone, and which way to believe."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from einschalt.stages.simultaneous.image_drawings import has_images
from einschalt.theory.adjustment.significance import OWN_DEFORMATION_SIGNIFICANCE

LEAST_CHECK = 8
CLEARLY = 1.25


class Belief(StrEnum):
    """Which of the two ways to believe, and why."""

    CHECK_POINTS_SIMULTANEOUS = "check points agree with the simultaneous adjustment"
    CHECK_POINTS_TWO_STEPS = "check points agree with the two steps"
    DEFORMATION_LEFT = "a deformation was found and is not modelled"
    MODELS_DIFFER = "models are deformed each in its own way"
    DEFORMATION_MODELLED = "a deformation is modelled and nothing is left"
    OWN_DEFORMATIONS_MODELLED = "what each model is deformed by for itself is modelled"
    PHOTOGRAPHS_BENT = "photographs are bent for themselves, and errors include it"
    UNTESTED = "too little redundancy to test for deformation"
    NO_DEFORMATION = "no deformation shows"


FOR_TWO_STEPS = (
    Belief.CHECK_POINTS_TWO_STEPS,
    Belief.DEFORMATION_LEFT,
    Belief.MODELS_DIFFER,
)


@dataclass(frozen=True)
class FlightDeformation:
    """The deformation that the models of one flight share."""

    flight: str
    p_value: float
    # TOTAL, of spatial models of their heights; RMS [m]
    size_middle: float
    size_edge: float
    is_modelled: bool
    # of residuals of neighbouring points in a model, after what was modelled
    neighbour_correlation: float
    # of the deformations that each model has for itself, at the edge of the models: in
    # plan TOTAL, in height; both RMS [m]
    own_edge: float
    own_edge_height: float


@dataclass(frozen=True)
class DeformationFacts:
    """What was tested and modelled."""

    flights: tuple[FlightDeformation, ...]
    belief: Belief
    # that chance makes what single models are deformed by; NaN without a test
    own_p_value: float
    is_spatial: bool  # deformations that spatial models share are those of heights
    is_shared_tested: bool
    is_own_detected: bool
    is_own_modelled: bool
    # own deformations are those of photographs, and not of models
    are_photographs: bool
    # differences at the check points that both ways have, TOTAL [m]; NaN with too few
    # of them
    check_rms_simultaneous: float
    check_rms_two_steps: float


def deformation_facts(examined) -> DeformationFacts | None:
    """Judge the deformations of the models, and which of the two ways to believe.

    Check points decide where there are enough of them; otherwise what the residuals
    show of deformation. None where nothing was tested.
    """
    found = examined.adjustment.deformations
    if found.empty:
        return None
    shared = ["flight", "p_value", "size_middle", "size_edge", "is_modelled"]
    own = ["neighbour_correlation", "own_size_edge", "own_size_edge_height"]
    flights = tuple(
        FlightDeformation(name, *map(float, sizes), bool(modelled), *map(float, others))
        for name, *sizes, modelled, others in zip(
            *(found[name] for name in shared),
            found[own].to_numpy(dtype=float),
            strict=True,
        )
    )
    rms = _check_rms(examined)
    return DeformationFacts(
        flights,
        _belief(examined.adjustment, *rms),
        float(found["own_p_value"].iloc[0]),
        examined.adjustment.tables.is_spatial,
        bool(found["p_value"].notna().any()),
        bool(_is_own_detected(found)),
        bool(found["own_is_modelled"].any()),
        has_images(examined.adjustment.tables),
        *rms,
    )


def _belief(adjustment, simultaneous, two_steps):
    found = adjustment.deformations
    ratio = simultaneous / two_steps
    if max(ratio, 1.0 / ratio) > CLEARLY:
        is_better = simultaneous < two_steps
        return (
            Belief.CHECK_POINTS_SIMULTANEOUS
            if is_better
            else Belief.CHECK_POINTS_TWO_STEPS
        )
    if (found["is_detected"] & ~found["is_modelled"]).any():
        return Belief.DEFORMATION_LEFT
    is_own = found["own_is_modelled"].any()
    is_left = _is_own_detected(found) and not is_own
    if is_left or found["is_alike"].any():
        return Belief.MODELS_DIFFER
    if is_own:
        is_in_errors = has_images(adjustment.tables)
        modelled = Belief.OWN_DEFORMATIONS_MODELLED
        return Belief.PHOTOGRAPHS_BENT if is_in_errors else modelled
    if found["is_modelled"].any():
        return Belief.DEFORMATION_MODELLED
    if found[["p_value", "own_size_edge"]].isna().all(axis=None):
        return Belief.UNTESTED
    return Belief.NO_DEFORMATION


def _is_own_detected(found):
    return (found["own_p_value"] < OWN_DEFORMATION_SIGNIFICANCE).any()


def _check_rms(examined):
    """RMS at the check points, simultaneous and in two steps; NaN with too few."""
    beside = examined.solution.two_step
    # check points that share errors with control are missed less where it is followed
    if not beside.is_possible or examined.shares_control_errors:
        return np.nan, np.nan
    one, two = (_squares(points) for points in (examined.points, beside.points))
    one, two = one.align(two, join="inner")
    if len(one) < LEAST_CHECK:
        return np.nan, np.nan
    return float(np.sqrt(one.mean())), float(np.sqrt(two.mean()))


def _squares(points):
    check = points[points["role"] == "check"].set_index("point_id")
    return check["difference_easting"] ** 2 + check["difference_northing"] ** 2
