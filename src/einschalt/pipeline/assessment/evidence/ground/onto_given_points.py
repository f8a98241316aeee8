"""Models of the low flight, and the given points that they are fitted onto."""

import numpy as np
import pandas as pd

from einschalt.foundations.frame_columns import values_of
from einschalt.foundations.names import encode
from einschalt.foundations.units import ground_from_image_um
from einschalt.pipeline.assessment.evidence.image_precision import (
    error_of_orientations,
)
from einschalt.pipeline.assessment.evidence.systematic_errors import FlightValues
from einschalt.stages.error_propagation.error_model import (
    LOW,
    errors_are_stated,
    model_of_block,
)
from einschalt.stages.error_propagation.given_points import PLAN
from einschalt.theory.adjustment.least_squares import SQRT2
from einschalt.theory.block_adjustment.common_parameters import COMPLEX
from einschalt.theory.block_adjustment.control_information import ControlValues

# of the error of measurements: given points that are better weigh no more than that
LEAST_GIVEN_ERROR = 0.1


def says_what_is_shared(two_step):
    """Whether there is a high flight, or it is said what given points share."""
    block = two_step.block
    is_said = errors_are_stated(block) and not two_step.has_untold_groups
    return block.high_flight is not None or is_said


def first_pass(two_step):
    """The low flight as it was transformed onto the given points."""
    iteration = two_step.iteration
    return two_step.low if iteration is None else iteration.passes[0].low


def observations(two_step, is_out):
    """Given points that were fitted onto, errors, the low flight, these as control.

    Without the model points that ``is_out`` names, (n_model_points,).
    """
    block, points = two_step.block, two_step.model_points[LOW]
    known, low = block.approximate_points, first_pass(two_step)
    model = two_step.error_model
    if two_step.iteration is not None:
        what = two_step.orientation_errors, two_step.own_deformation
        model = model_of_block(block, two_step.model_points, None, low, *what)
    names = encode(pd.concat([known["point_id"], points["point_id"]]))
    codes, places = names.codes, model.places
    measured = _measured(two_step, model)
    origin = values_of(known, PLAN).mean(axis=0)
    values = FlightValues.of(low, points, codes[len(known) :], measured, is_out)
    bent = values.displaced(two_step.own_deformation, 0)
    flight = values.about(origin, bent, is_affine=low.kind == "affine")
    errors = _given_errors(model)
    error = np.maximum(errors, LEAST_GIVEN_ERROR * np.median(measured))
    xy = values_of(known, PLAN)[places] - origin
    given = ControlValues(codes[places], xy @ COMPLEX, error[places] ** -2.0)
    return places, errors, flight, given


def _measured(two_step, model):
    """Errors of one coordinate in plan of the model points, (n_model_points,) [m].

    Where models have errors of their orientation as well, with these by their RMS.
    """
    low, n_points = two_step.block.low_flight, len(two_step.model_points[LOW])
    if not low.is_oriented_numerically:
        sizes = model.standard_errors[LOW]
        # heights may have others
        return sizes if sizes.ndim == 1 else sizes[:, 0]
    of_models = error_of_orientations(two_step.orientations, LOW)
    error = np.hypot(low.m_g_counted_um, of_models)
    return np.full(n_points, ground_from_image_um(error, low.scale_number) / SQRT2)


def _given_errors(model):
    """Errors of one coordinate of the given points in plan, (n_points,) [m]."""
    sizes = model.standard_errors
    each = [c.covariances(sizes[source]) for source, c in model.ground.items()]
    return np.sqrt(sum(each)[:, 0, 0])
