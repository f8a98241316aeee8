"""A fitted transformation of one model as a linear model of named parameters.

Coordinates of both frames are reduced to the weighted centroids of the model's points:
at 5·10⁶ m a general solver would lose seven digits, and there the shifts are
uncorrelated with all other parameters. Affine and helmert are linear; rigid and
helmert_3d are linearised at their solution, which least squares of the linear model
gives back.
"""

from dataclasses import dataclass

import numpy as np

from einschalt.foundations.errors import GeometryError
from einschalt.theory.transformation.helmert_3d import parameters_from_step
from einschalt.theory.transformation.sensitivity import sensitivity

# shifts, then the others in the order of their columns in the sensitivity
NAMES = {
    "affine": ("a0", "b0", "a1", "a2", "b1", "b2"),
    "helmert": ("te", "tn", "a", "b"),
    "rigid": ("te", "tn", "theta"),
    "helmert_3d": ("te", "tn", "th", "scale", "omega", "phi", "kappa"),
}


@dataclass(frozen=True, eq=False)
class LinearModel:
    """Observation equations of one transformation, reduced to the centroids."""

    names: tuple[str, ...]  # of the parameters, in the order of the fit
    design: np.ndarray  # (n_points, n_axes, n_parameters)
    # (n_points, n_axes): ground coordinates less their centroid; of rigid and
    # helmert_3d with the constant of the linearisation [m]
    observed: np.ndarray
    # (n_parameters,): the fitted parameters about the centroids: the shifts are 0
    reference: np.ndarray
    # (n_parameters,): the same about the origins of the coordinates
    at_origin: np.ndarray
    # (n_parameters, n_parameters): derivative of the second by the first
    to_origin: np.ndarray
    centroid_model: np.ndarray  # both (n_axes,)
    centroid_ground: np.ndarray


def linear_model(fit, model, source, target):
    """Set up the observation equations of one fitted model.

    ``model`` is the number of one that is usable, ``source`` and ``target``
    (n_points, n_axes) are the model coordinates and the ground coordinates [m] of its
    points.

    Raises
    ------
    GeometryError
        φ of a spatial model is a right angle: ω and κ are not determined.

    Examples
    --------
    >>> from einschalt.theory.transformation.helmert import fit_helmert
    >>> xy = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]])
    >>> fit = fit_helmert(xy, 2.0 * xy, np.ones(4), np.array([0, 4]))
    >>> equations = linear_model(fit, 0, xy, 2.0 * xy)
    >>> equations.names, equations.design[1].tolist()
    (('a', 'b', 'te', 'tn'), [[0.5, 0.5, 1.0, 0.0], [-0.5, 0.5, 0.0, 1.0]])
    """
    centroid = fit.centroid_model[model]
    n_axes, names = source.shape[1], NAMES[fit.kind]
    order = [names.index(name) for name in fit.parameter_names]
    to_rest = _named_rest(fit, model)
    design = _with_shift(fit, model, source, to_rest)
    to_origin = np.eye(len(names))
    # the origin lies at −centroid from the centroid
    to_origin[:n_axes] = _with_shift(fit, model, np.zeros((1, n_axes)), to_rest)[0]
    at_origin = fit.parameters[model]
    reference = np.zeros(len(names))
    reference[order] = at_origin
    reference[:n_axes] = 0.0
    turned = (source - centroid) @ fit.linear[model].T
    # nothing but rounding where the transformation is linear in its parameters
    constant = design @ reference - turned
    return LinearModel(
        names=fit.parameter_names,
        design=design[:, :, order],
        observed=target - fit.centroid_ground[model] + constant,
        reference=reference[order],
        at_origin=at_origin,
        to_origin=to_origin[np.ix_(order, order)],
        centroid_model=centroid,
        centroid_ground=fit.centroid_ground[model],
    )


def _with_shift(fit, model, coordinates, to_rest):
    """Derivatives by the shift and by the named other parameters."""
    n_points, n_axes = coordinates.shape
    place = np.full(n_points, model)
    shift = np.broadcast_to(np.eye(n_axes), (n_points, n_axes, n_axes))
    rest = sensitivity(fit, place, coordinates) @ to_rest
    return np.concatenate([shift, rest], axis=2)


def _named_rest(fit, model):
    """Derivative of what the sensitivity takes as parameters by the named ones."""
    if fit.kind != "helmert_3d":
        return np.eye(len(fit.parameter_names) - 2)
    one = slice(model, model + 1)
    step = parameters_from_step(fit.scale[one], fit.rotation[one], np.zeros((1, 3)))
    if not np.isfinite(step).all():
        raise GeometryError(
            "phi is a right angle, at which omega and kappa are not determined",
            remedy="Turn the model's coordinates by 90° about x",
        )
    return np.linalg.inv(step[0])[3:, 3:]
