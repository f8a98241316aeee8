"""Deformations that each model has for itself, found and given to the adjustment."""

from dataclasses import replace

import numpy as np

from einschalt.stages.simultaneous.image_drawings import has_images
from einschalt.stages.simultaneous.variance_components import (
    weigh_groups,
    with_errors_as_shown,
)
from einschalt.theory.adjustment.significance import (
    FINDING_SIGNIFICANCE,
    OWN_DEFORMATION_SIGNIFICANCE,
)
from einschalt.theory.block_adjustment.common_border import UndeterminedTermsError
from einschalt.theory.block_adjustment.gross_errors import (
    OutlierFreeBlock,
    without_far_control,
)
from einschalt.theory.block_adjustment.observations import Part
from einschalt.theory.block_adjustment.own_deformation import (
    HEIGHT,
    bent_columns,
)
from einschalt.theory.block_adjustment.own_deformation_size import (
    chance_with_other_errors,
    estimate_own_deformation,
    sample_of_models,
)
from einschalt.theory.block_adjustment.spatial_solution import (
    NoConvergenceError,
    adjust_models,
)

UNTESTED = {
    "own_size_edge": np.nan,
    "own_size_edge_height": np.nan,
    "own_p_value": np.nan,
    "own_is_modelled": False,
}


def find_own_deformation(tables, weighed, solution, deformation):
    """Estimate how much models are bent, each in its own way; None where it cannot be.

    ``solution`` is one without own deformations, ``weighed`` the part with the errors
    that its groups have.
    """
    # photographs that models share bend them together
    if deformation == "ignored" or has_images(tables):
        return None
    sample = sampled_part(weighed.part, solution.points)
    if len(sample.models) == len(weighed.part.models):
        return _estimated(tables, sample, solution.readjusted, sample.observations)
    terms = getattr(solution, "terms", ())
    return _estimated(tables, sample, adjust_models, sample.observations, terms)


def sampled_part(part, places):
    """As :func:`sample_of_models`, of a part of a block."""
    sample = sample_of_models(part.observations, places)
    return Part(
        sample.observations,
        part.rows[sample.rows],
        part.models[sample.models],
        part.points[sample.points],
    )


def estimate_for(tables, sample, terms=()):
    """As :func:`estimate_own_deformation`; None where the models are too weak.

    What larger errors of a whole flight explain as well is no deformation.
    """
    return _estimated(tables, sample, adjust_models, sample.observations, terms)


def estimate_beside_control(tables, sample, terms):
    """As :func:`estimate_for`, where control takes no part in what is computed.

    What bends models is no control then that is far off.
    """
    own = estimate_for(tables, sample, terms)
    if not is_detected(own):
        return own
    plain = adjust_models(sample.observations, terms, is_rough=True)
    left = without_far_control(plain, FINDING_SIGNIFICANCE)
    if np.array_equal(left.is_control, sample.observations.is_control):
        return own
    return estimate_for(tables, replace(sample, observations=left), terms)


def _estimated(tables, sample, adjust, *observed):
    try:
        plain = adjust(*observed, is_rough=True)
        own = estimate_own_deformation(plain)
        if not is_detected(own):
            return own
        shown = with_errors_as_shown(tables, sample, OutlierFreeBlock.whole(plain))
        again = plain.readjusted(shown.observations, is_rough=True)
        p_value = chance_with_other_errors(again, own, OWN_DEFORMATION_SIGNIFICANCE)
    except (UndeterminedTermsError, NoConvergenceError):
        return None
    if p_value < OWN_DEFORMATION_SIGNIFICANCE:
        return own
    return replace(own, size=np.zeros(len(own.size)), p_value=p_value)


def bent_part(part, weighed, own):
    """Part of a block whose models are bent, by sizes beside the errors of ``weighed``.

    The errors of the part are those that were given.
    """
    given, used = part.observations, weighed.part.observations
    bent = bent_columns(given, own)
    share = (given.standard_error / used.standard_error)[..., None]
    return replace(part, observations=replace(given, bent=bent * share))


def with_errors_that_show(tables, sample):
    """Sample of a spatial block: its heights have errors that nobody has given."""
    block = OutlierFreeBlock.whole(adjust_models(sample.observations))
    return weigh_groups(tables, sample, block, all_of_them=False).part


def is_detected(own):
    """Whether chance does not explain the deformations that show."""
    if own is None or not own.kinds:
        return False
    return bool(own.p_value < OWN_DEFORMATION_SIGNIFICANCE)


def own_columns(own, flight, *, is_modelled):
    """Columns of ``deformations`` for one flight, dict.

    ``is_modelled``: what is detected is in the standard errors.
    """
    if own is None:
        return UNTESTED
    sizes = own.edge(flight), own.edge(flight, HEIGHT)
    return {
        "own_size_edge": sizes[0],
        "own_size_edge_height": sizes[1],
        "own_p_value": own.p_value,
        "own_is_modelled": bool(max(sizes) > 0.0 and is_modelled),
    }
