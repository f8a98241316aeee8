"""Stage 4, rigorous: the errors of both flights and of the control, carried through.

The paper's budget takes for independent what is not. Here every final coordinate is
written as a linear function of the errors of all observations, sparsely, and its
covariance follows from theirs: L Σ Lᵀ.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy import sparse

from einschalt.foundations.batches import segments
from einschalt.foundations.names import encode
from einschalt.theory.adjustment.propagation import (
    PairLayout,
    hat_operator,
    point_covariances,
    selection,
    weighted_mean,
)
from einschalt.theory.transformation.sensitivity import cofactors_of_rest, sensitivity


@dataclass(frozen=True, eq=False)
class FlightOperator:
    """How the errors of a flight's values follow from those of its observations.

    Attributes
    ----------
    measured : bsr_array, shape (n_values · n_axes, n_values · n_axes)
        From the measuring errors of all points of the flight, in ground units.
    ground : bsr_array, shape (n_values · n_axes, n_ground · n_axes)
        From the errors of the ground coordinates onto which its models were fitted.
    n_axes : int
    """

    measured: sparse.bsr_array
    ground: sparse.bsr_array
    n_axes: int


def flight_operator(transformation, model_points, ground_places, n_ground):
    """Error operator of all values of a flight.

    A point that was fitted has the error (I − H) g + H e, one that was not g + H (e −
    g), with the measuring errors g and the errors e of the ground coordinates.

    Parameters
    ----------
    transformation : ModelTransformation
        Of ``model_points``.
    model_points : DataFrame
    ground_places : ndarray of int
        Which source stands behind each row of the table of ground points.
    n_ground : int
        Number of sources.

    Returns
    -------
    FlightOperator
        Its rows in the order of ``model_points``; NaN in the rows of models that are
        not usable.
    """
    observed, fit = transformation.observed, transformation.fit
    axes = ["x", "y", "z"][: observed.source.shape[1]]
    coordinates = model_points[axes].to_numpy(dtype=float)
    n_rows, n_axes = coordinates.shape
    sort = segments(observed.models.codes, len(observed.models))
    sorted_place = np.empty(n_rows, dtype=np.int64)
    sorted_place[sort.order] = np.arange(n_rows)
    layout = PairLayout(sort.start, sorted_place[observed.row_numbers])
    design = sensitivity(fit, layout.model_of_row, coordinates[sort.order])
    hat = hat_operator(
        design, cofactors_of_rest(fit), _weight_sum(fit), observed.weights, layout
    )
    in_given_order = selection(sorted_place, n_rows, n_axes)
    hat = in_given_order @ hat
    fitted = selection(observed.row_numbers, n_rows, n_axes)
    onto = selection(ground_places[observed.ground_rows], n_ground, n_axes)
    own = selection(np.arange(n_rows), n_rows, n_axes)
    return FlightOperator(own - hat @ fitted, hat @ onto, n_axes)


def mean_operator(means, value_rows, n_values, n_axes):
    """Operator of the means of stage 5.

    Parameters
    ----------
    means : CoverageMean
    value_rows : ndarray of int
        Which row of the flight's values each value was that stage 5 was given.
    n_values, n_axes : int

    Returns
    -------
    bsr_array, shape (n_points · n_axes, n_values · n_axes)
    """
    points, used = encode(means.points["point_id"]), encode(means.used["point_id"])
    sort = segments(points.locate(used)[used.codes], len(points))
    rows = value_rows[means.row_numbers]
    return weighted_mean(
        rows[sort.order], means.weights[sort.order], sort.start, (n_values, n_axes)
    )


@dataclass(frozen=True, eq=False)
class PropagatedErrors:
    """Covariances of the final points, and where they come from.

    Attributes
    ----------
    point_ids : ndarray of object, shape (n_points,)
    parts : dict of str to ndarray, shape (n_points, n_axes, n_axes)
        Covariance from each source alone [m²].
    operators : dict of str to sparse array
        Error operator of each source.
    standard_errors : dict of str to ndarray
        Of each source's observations, per coordinate [m].
    """

    point_ids: np.ndarray
    parts: dict
    operators: dict
    standard_errors: dict
    n_axes: int

    @property
    def covariance(self):
        """Covariance of each point, shape (n_points, n_axes, n_axes) [m²]."""
        return sum(self.parts.values())

    def covariance_between(self, first, second):
        """Covariance between pairs of points.

        Parameters
        ----------
        first, second : array of str, shape (n_pairs,)
            point_id of the points of each pair.

        Returns
        -------
        ndarray, shape (n_pairs, n_axes, n_axes)
            [m²].
        """
        index = pd.Index(self.point_ids)
        rows = [index.get_indexer(np.asarray(ids, dtype=object)) for ids in (first, second)]
        total = 0.0
        for source, operator in self.operators.items():
            sigma = np.repeat(self.standard_errors[source], self.n_axes)
            one, two = (
                _rows_of(operator, places, self.n_axes).multiply(sigma) for places in rows
            )
            total = total + _blockwise_products(one.tocsr(), two.tocsr(), self.n_axes)
        return total


def _rows_of(operator, places, n_axes):
    rows = (places[:, None] * n_axes + np.arange(n_axes)).ravel()
    return sparse.csr_array(operator)[rows]


def _blockwise_products(one, two, n_axes):
    n_pairs = one.shape[0] // n_axes
    result = np.empty((n_pairs, n_axes, n_axes))
    for a in range(n_axes):
        for b in range(n_axes):
            product = one[a::n_axes].multiply(two[b::n_axes])
            result[:, a, b] = product.sum(axis=1)
    return result


def _weight_sum(fit):
    return fit.moments.weight_sum if hasattr(fit, "moments") else fit.weight_sum


def propagate(point_ids, operators, standard_errors, n_axes):
    """Covariances of the final points from all sources.

    Parameters
    ----------
    point_ids : ndarray of object, shape (n_points,)
    operators : dict of str to sparse array
        Shape (n_points · n_axes, n_sources · n_axes).
    standard_errors : dict of str to ndarray, shape (n_sources,)
        Per coordinate [m].
    n_axes : int

    Returns
    -------
    PropagatedErrors
    """
    parts = {
        source: point_covariances(operator, standard_errors[source], n_axes)
        for source, operator in operators.items()
    }
    return PropagatedErrors(point_ids, parts, operators, standard_errors, n_axes)
