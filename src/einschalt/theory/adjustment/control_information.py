"""What the models of all flights, adjusted together, know of the control points.

Every value of a point in a model is D θ, with the parameters θ of the model; the point
itself stands between its values. Eliminating the points leaves the normal equations of
the models, and these tell how far every control point is from where the rest has it.
Everything is linear about the values that are there already; one complex number stands
for easting and northing where the transformations allow it.

Source: partitioned normal equations of an adjustment of independent models; see
docs/theory/systematic_patterns.md.
"""

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

# weight of "no correction" for each parameter of a model, against its diagonal: models
# that hang on nothing stay where they are
RIDGE = 1e-9


@dataclass(frozen=True, eq=False)
class ModelValues:
    """Values of points in models.

    Attributes
    ----------
    design : ndarray, shape (n_values, n_parameters)
        D of each value, with columns of about unit size; complex where it must be.
    model, point : ndarray of int, shape (n_values,)
    value : ndarray of complex, shape (n_values,)
        Easting + i northing, from any place near all points [m].
    weight : ndarray, shape (n_values,)
        1 / σ² of one coordinate [1/m²].
    """

    design: np.ndarray
    model: np.ndarray
    point: np.ndarray
    value: np.ndarray
    weight: np.ndarray


@dataclass(frozen=True, eq=False)
class ControlValues:
    """Given coordinates of control points.

    Attributes
    ----------
    point : ndarray of int, shape (n,)
        Which point each is; none twice.
    value : ndarray of complex, shape (n,)
        As in :class:`ModelValues` [m].
    weight : ndarray, shape (n,)
        1 / σ² of one coordinate [1/m²].
    """

    point: np.ndarray
    value: np.ndarray
    weight: np.ndarray


def control_information(flights, control):
    """Scores of control points, and the information that checks them.

    Parameters
    ----------
    flights : sequence of ModelValues
        Their models are counted apart, their points together.
    control : ControlValues

    Returns
    -------
    scores : ndarray of complex, shape (n_control,)
        Weight times correction of each control point in the adjustment of everything
        [1/m]. Without gross or systematic errors their covariance is the information,
        for either coordinate.
    information : ndarray, shape (n_control, n_control)
        W = P - P Q P [1/m²], Q being the cofactors of the adjusted control points. The
        real part where transformations are complex.
    """
    n_points = 1 + int(max(part.point.max() for part in (*flights, control)))
    weights = sum(np.bincount(f.point, f.weight, n_points) for f in flights)
    # about the mean of its values a point asks nothing of the models
    sums = sum(_sums(flight, n_points) for flight in flights)
    centre = sums / np.where(weights > 0.0, weights, 1.0)
    total = weights + np.bincount(control.point, control.weight, n_points)
    own, onto, right = _normal_equations(flights, n_points, centre)
    shares = sparse.diags_array(1.0 / np.where(total > 0.0, total, 1.0))
    ridge = sparse.diags_array(RIDGE * own.diagonal().real)
    normal = own + ridge - onto.conj().T @ shares @ onto
    part = control.weight / total[control.point]
    pull = (onto[control.point].conj().T @ sparse.diags_array(part)).toarray()
    factor = splu(sparse.csc_array(normal, dtype=complex))
    moved = factor.solve(np.column_stack([right, pull]))
    information = np.diag(control.weight * (1.0 - part)) - pull.conj().T @ moved[:, 1:]
    closed = control.value - centre[control.point]
    scores = information @ closed + pull.conj().T @ moved[:, 0]
    is_checked = weights[control.point] > 0.0  # no model holds the others
    return np.where(is_checked, scores, 0.0), np.real(information)


def _sums(flight, n_points):
    """Weighted sum of the values of each point."""
    east, north = (
        np.bincount(flight.point, flight.weight * part, n_points)
        for part in (flight.value.real, flight.value.imag)
    )
    return east + 1j * north


def _normal_equations(flights, n_points, centre):
    """Own normal equations of all models, their sums by points, and right sides."""
    own, onto, right = [], [], []
    for flight in flights:
        n_values, n_each = flight.design.shape
        n_models = 1 + int(flight.model.max())
        columns = flight.model[:, None] * n_each + np.arange(n_each)
        pointer = np.arange(n_values + 1) * n_each
        shape = (n_values, n_models * n_each)
        entries = (flight.design.ravel(), columns.ravel(), pointer)
        design = sparse.csr_array(entries, shape=shape)
        weighted = sparse.diags_array(flight.weight) @ design
        by_point = sparse.csr_array(
            (np.ones(n_values), (flight.point, np.arange(n_values))),
            shape=(n_points, n_values),
        )
        own.append(design.conj().T @ weighted)
        onto.append(by_point @ weighted)
        right.append(weighted.conj().T @ (flight.value - centre[flight.point]))
    return (
        sparse.block_diag(own, format="csr"),
        sparse.hstack(onto, format="csr"),
        np.concatenate(right),
    )
