"""Linear operators of the stages: errors of values from those of observations.

The paper's budget takes for independent what is not. Here every coordinate is written
as a linear function of the errors of all observations, sparsely; what covariance
follows from theirs is in ``covariances``.
"""

from dataclasses import dataclass

import numpy as np

from einschalt.foundations.batches import segment_sum, segments
from einschalt.foundations.frame_columns import values_of
from einschalt.foundations.names import encode
from einschalt.stages.error_propagation.turned_models import TurnedModels
from einschalt.theory.adjustment.point_operator import (
    Axes,
    PointOperator,
    selection,
    weighted_mean,
)
from einschalt.theory.adjustment.propagation import through_parameters
from einschalt.theory.transformation.sensitivity import (
    cofactors_of_rest,
    conformal_cofactors,
    conformal_sensitivity,
    sensitivity,
)


@dataclass(frozen=True, eq=False)
class FlightOperator:
    """How the errors of a flight's values follow from those of its observations."""

    # from the measuring errors of all points of the flight, in ground units
    measured: PointOperator
    # from the errors of the ground coordinates onto which its models were fitted
    ground: PointOperator
    # from both to the parameters of its models, as through_parameters has them
    parameters: "FlightOperator | None" = None
    turned: TurnedModels | None = None  # of models in space

    def selections(self, places, observed):
        """Pick what the flight was fitted with.

        Operators of the ground coordinates, and of the measured points. ``places`` says
        which source stands in each row of the table of ground coordinates.
        """
        ground, measured = self.ground, self.measured
        rows = observed.row_numbers
        return (
            selection(places[observed.ground_rows], ground.n_sources, ground.axes),
            selection(rows, measured.n_sources, measured.axes),
        )


@dataclass(frozen=True, eq=False)
class GroundSources:
    """Which source of error stands behind each row of a table of ground points."""

    places: np.ndarray  # (n_rows,)
    count: int  # number of sources


def flight_operator(transformation, model_points, ground, axes) -> FlightOperator:
    """Error operator of all values of a flight.

    Rows are in the order of ``model_points``; see :func:`operator_of_fit`.
    """
    observed = transformation.observed
    names = ["x", "y", "z"][: observed.source.shape[1]]
    coordinates = values_of(model_points, names)
    return operator_of_fit(transformation.fit, observed, coordinates, ground, axes)


def operator_of_fit(fit, observed, coordinates, ground, axes) -> FlightOperator:
    """Error operator of points in the models of a fit.

    A point that was fitted has the error (I − H) g + H e, one that was not g + H (e −
    g), with the measuring errors g and the errors e of the ground coordinates.
    ``coordinates`` (n_rows, n_axes) are those of all points, of which ``observed`` were
    fitted; NaN in the rows of models that are not usable.
    """
    n_rows, model, rows = len(coordinates), observed.models.codes, observed.row_numbers
    derive, cofactors = sensitivity, cofactors_of_rest
    if axes is Axes.COMPLEX:
        derive, cofactors = conformal_sensitivity, conformal_cofactors
    design = derive(fit, model, coordinates)
    weights = observed.weights, segment_sum(observed.weights, observed.start)
    values, parameters = through_parameters(
        design, cofactors(fit), *weights, model, rows
    )
    fitted = selection(rows, n_rows, axes)
    onto = selection(ground.places[observed.ground_rows], ground.count, axes)
    own = selection(np.arange(n_rows), n_rows, axes)
    of_measured = -(parameters @ fitted).formed()
    of_ground = (parameters @ onto).formed()
    is_spatial = axes is Axes.SPACE
    return FlightOperator(
        own + values @ of_measured,
        values @ of_ground,
        FlightOperator(of_measured, of_ground),
        TurnedModels(fit, model, coordinates) if is_spatial else None,
    )


def mean_operator(means, value_rows, n_values, axes) -> PointOperator:
    """Operator of the means of stage 5.

    ``value_rows`` says which row of the flight's values each value was that stage 5 was
    given.
    """
    points, used = encode(means.points["point_id"]), encode(means.used["point_id"])
    sort = segments(points.locate(used)[used.codes], len(points))
    rows = value_rows[means.row_numbers]
    return weighted_mean(
        rows[sort.order], means.weights[sort.order], sort.start, n_values, axes
    )
