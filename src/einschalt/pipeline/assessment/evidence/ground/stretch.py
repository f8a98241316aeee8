"""One axis of the ground against the other: a stretch that all models share.

Affine models take it up, and have it in their parameters; of models that keep their
shape it is told by an affine fit onto control. Spatial models are turned as the ground
lies first: x and y of oblique photographs are shorter one way, as the cosine of their
tilt, where they stand as they were formed.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.special import fdtrc  # scipy.stats takes a second to import

from einschalt.foundations.batches import segment_centred, segment_sum
from einschalt.foundations.frame_columns import values_of
from einschalt.theory.adjustment.point_operator import GROUND_NAMES
from einschalt.theory.transformation.helmert_3d import nearest_rotations

DETERMINANT = ["a1", "a2", "b1", "b2"]
# share of an affinity beyond which the smaller axis of a model is nothing
NEARLY_FLAT = 1.0 - 1e-9
FEWEST_MODELS = 3
# of a common affinity: what models may differ from it, and how many must not
ALIKE, LEAST_ALIKE = 0.5, 0.8
# points on a line tell nothing across it: of the longer extent, squared
LEAST_WIDTH = 1e-3


@dataclass(frozen=True)
class Stretch:
    """What models have in common."""

    size: float  # of one axis against the other, 0 without
    p_value: float  # of a common stretch this large by chance
    east_by_north: float  # scale of easting by that of northing
    n_models: int


NO_STRETCH = Stretch(0.0, 1.0, 1.0, 0)


def stretch_of(affine) -> Stretch:
    """Stretch that models share, from their affine parameters and ``n_points``.

    Errors of a model turn its affinity into any direction: with its sign they cancel in
    the mean, and their scatter tells how well. An affinity that is common stands fast
    in the axes of the machine or in those of the ground; the clearer one is told.
    Exchanged names make affinities as large, which no two models have in common.
    """
    if len(affine) < FEWEST_MODELS:
        return NO_STRETCH
    a1, a2, b1, b2 = values_of(affine, DETERMINANT).T
    # ground = turned z + mirrored conj(z), z = x + i y
    turned = 0.5 * ((a1 + b2) + 1j * (b1 - a2))
    mirrored = 0.5 * ((a1 - b2) + 1j * (b1 + a2))
    is_over = np.abs(mirrored) > np.abs(turned)
    large = np.where(is_over, mirrored, turned)
    small = np.where(is_over, turned, mirrored)
    # a model that puts all of its points on a line has no axes
    is_plane = np.abs(small) < NEARLY_FLAT * np.abs(large)
    if is_plane.sum() < FEWEST_MODELS:
        return NO_STRETCH
    large, small, is_over = large[is_plane], small[is_plane], is_over[is_plane]
    of_machine = np.where(is_over, np.conj(small / large), small / large)
    weights = affine["n_points"].to_numpy(dtype=float)[is_plane]
    found = [_common(part, weights) for part in (of_machine, small / np.conj(large))]
    affinity, p_value = min(found, key=lambda pair: (pair[1], -pair[0]))
    size = np.abs(large) ** 2 - np.abs(small) ** 2
    east = np.average((a1**2 + a2**2)[is_plane] / size, weights=weights)
    north = np.average((b1**2 + b2**2)[is_plane] / size, weights=weights)
    return Stretch(
        size=2.0 * affinity / (1.0 - affinity),
        p_value=min(2.0 * p_value, 1.0),  # the clearer of two
        east_by_north=float(np.sqrt(east / north)),
        n_models=int(is_plane.sum()),
    )


def _common(affinities, weights):
    """Size of the affinity that models share, and the p-value of their weighted mean.

    Easting and northing of equal precision make their errors circular: two degrees of
    freedom each. What a wrong point makes of the models around it is not common: most
    models must have it.
    """
    mean = np.average(affinities, weights=weights)
    degrees = 2 * (len(affinities) - 1)
    scatter = np.sum(weights * np.abs(affinities - mean) ** 2) / degrees
    size = np.sum(weights) * np.abs(mean) ** 2 / 2.0
    ratio = size / scatter if scatter > 0.0 else np.inf
    middle = np.median(affinities.real) + 1j * np.median(affinities.imag)
    of_most = np.abs(middle)
    if np.mean(np.abs(affinities - middle) <= ALIKE * of_most) < LEAST_ALIKE:
        return 0.0, 1.0
    return float(min(np.abs(mean), of_most)), float(fdtrc(2, degrees, ratio))


def affinities_onto_control(model_points, control, *, is_turned=False) -> pd.DataFrame:
    """Affine parameters of models onto control, whatever they are transformed by.

    Of every model whose control points span a plane, with ``n_points``. Where
    ``is_turned``, of spatial models turned in space as their control points lie that
    have heights.
    """
    d = 3 if is_turned else 2
    used = control.loc[control["role"] != "check", ["point_id", *GROUND_NAMES[:d]]]
    both = model_points.drop(columns=list(GROUND_NAMES), errors="ignore")
    both = both.merge(used.dropna(), on="point_id")
    both = both.sort_values(["coverage", "model_id"])
    keys = both[["coverage", "model_id"]].to_numpy(dtype=object)
    is_first = np.ones(len(both), dtype=bool)
    is_first[1:] = (keys[1:] != keys[:-1]).any(axis=1)
    start = np.append(np.flatnonzero(is_first), len(both))
    n_points = np.diff(start)
    at, to = (
        segment_centred(values_of(both, names), start)
        for names in (["x", "y", "z"][:d], list(GROUND_NAMES[:d]))
    )
    if is_turned:
        at, to = _turned(at, to, start)[:, :2], to[:, :2]
    own = segment_sum(at[:, :, None] * at[:, None, :], start)
    mixed = segment_sum(to[:, :, None] * at[:, None, :], start)
    with np.errstate(invalid="ignore", divide="ignore"):
        width = np.linalg.det(own) / np.trace(own, axis1=1, axis2=2) ** 2
    is_known = (n_points > FEWEST_MODELS) & (width > LEAST_WIDTH)
    matrix = mixed[is_known] @ np.linalg.inv(own[is_known])
    table = pd.DataFrame(matrix.reshape(-1, 4), columns=DETERMINANT)
    return table.assign(n_points=n_points[is_known])


def _turned(at, to, start):
    """Centred points of each model, turned as they lie on the ground."""
    cross = segment_sum(to[:, :, None] * at[:, None, :], start)
    rotation = nearest_rotations(cross)
    return np.einsum("nab,nb->na", np.repeat(rotation, np.diff(start), axis=0), at)


def are_negative(affine):
    """Whether each of some affine models is mirrored: a negative determinant."""
    a1, a2, b1, b2 = values_of(affine, DETERMINANT).T
    return a1 * b2 - a2 * b1 < 0.0
