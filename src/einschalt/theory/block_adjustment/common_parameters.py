"""Deformations that all models of a flight share, as unknowns of the adjustment.

A point of a model is displaced by D(x, y) c before it is transformed: the affinity of
the film (two terms), or polynomials of the position in the model. They are few and
border the normal equations: with the residuals C̃ that the block cannot take up of
their columns C,

    (Cᵀ W C̃) c = −Cᵀ W v,

v the residuals of the block without them. Eliminating the models first costs one solve
for each term.
"""

from dataclasses import dataclass

import numpy as np

from einschalt.foundations.batches import sum_by_group

AFFINITY = "affinity"
QUADRATIC = "quadratic"
CUBIC = "cubic"
DEGREE = {QUADRATIC: 2, CUBIC: 3}
COMPLEX = np.array([1.0, 1j])


@dataclass(frozen=True)
class CommonTerms:
    """Terms that the models of one flight share."""

    flight: int
    families: tuple[str, ...]  # of "affinity", "quadratic", "cubic"

    @property
    def names(self):
        """Names of the terms, in order."""
        return tuple(name for family in self.families for name in term_names(family))


def term_names(family):
    """Names of the terms of a family: ``dx:x2`` displaces x with the square of x."""
    if family == AFFINITY:
        return ("film_affinity", "film_shear")
    degree = DEGREE[family]
    powers = [_power(degree - k, k) for k in range(degree + 1)]
    return tuple(f"{axis}:{power}" for axis in ("dx", "dy") for power in powers)


def _power(p, q):
    parts = [(name, p if name == "x" else q) for name in "xy"]
    return "".join(f"{n}{k if k > 1 else ''}" for n, k in parts if k)


def displacement(family, position):
    """Displacement of each point by each term with the coefficient 1.

    Parameters
    ----------
    family : {"affinity", "quadratic", "cubic"}
    position : ndarray, shape (n, 2)
        In the model; about 1 at its edge for polynomials.

    Returns
    -------
    ndarray, shape (n, 2, n_terms)
        In units of ``position``. The affinity stretches x by half of its coefficient
        and shortens y by the other half.
    """
    x, y = position.T
    if family == AFFINITY:
        stretch = np.stack([x, -y], -1) / 2.0
        shear = np.stack([y, x], -1) / 2.0
        return np.stack([stretch, shear], -1)
    powers = powers_of(family, position)
    nil = np.zeros_like(powers)
    along, across = np.stack([powers, nil], 1), np.stack([nil, powers], 1)
    return np.concatenate([along, across], -1)


def powers_of(family, position):
    """Products of x and y of the degree of a family of polynomials, (n, degree + 1)."""
    x, y = position.T
    degree = DEGREE[family]
    return np.stack([x ** (degree - k) * y**k for k in range(degree + 1)], -1)


def polynomials_on_ground(xy, model, ground, size):
    """What the polynomials do on the ground, by complex coefficients.

    Parameters
    ----------
    xy : ndarray, shape (n, 2)
        Positions in the models of a flight [model units].
    model : ndarray of int, shape (n,)
        Model of each; each number has rows.
    ground : ndarray, shape (n, 2)
        Easting, northing of each by the transformation of its model [m].
    size : float
        Displacement at the edge of a model by a coefficient of 1, in the scale that the
        models have in the middle [m].

    Returns
    -------
    ndarray of complex, shape (n, 7)
        Easting + i northing of the displacements by the three quadratic and the four
        cubic terms, turned and scaled like the model [m]; models that are mirrored are
        turned as they lie.
    """
    position, _ = positions_in_model(xy, model)
    powers = np.column_stack([powers_of(family, position) for family in DEGREE])
    turn = _turn_of_models(position, model, ground)
    return (size / np.median(np.abs(turn)) * turn)[model, None] * powers


def affinity_on_ground(model, ground):
    """What an affinity of all models along the axes of the ground does there.

    As of film along the strips, whose models were turned in the machine. A complex
    coefficient p + i q is that of S = [[p, q], [q, -p]].

    Parameters
    ----------
    model : ndarray of int, shape (n,)
        Model of each point; each number has rows.
    ground : ndarray, shape (n, 2)
        Easting, northing of each by the transformation of its model [m].

    Returns
    -------
    ndarray of complex, shape (n,)
        Easting + i northing of the displacement by the coefficient 1 [m].
    """
    place = ground @ COMPLEX
    return np.conj(place - (sum_by_group(model, place) / np.bincount(model))[model])


def _turn_of_models(position, model, ground):
    """Factor from a displacement in each model to one on the ground: complex.

    That of z, or of its conjugate where a model is mirrored.
    """
    count = np.bincount(model)
    z, place = (
        part - (sum_by_group(model, part) / count)[model]
        for part in (position @ COMPLEX, ground @ COMPLEX)
    )
    upright, mirrored = (sum_by_group(model, place * part) for part in (z.conj(), z))
    square = np.bincount(model, np.abs(z) ** 2)
    turn = np.where(np.abs(upright) >= np.abs(mirrored), upright, mirrored)
    return turn / np.where(square > 0.0, square, 1.0)


@dataclass(frozen=True, eq=False)
class Deformation:
    """Displacements of all observations, each by the terms of its own flight."""

    names: tuple[str, ...]
    flight: tuple[int, ...]  # of each term
    # (n_rows, 2, n_terms): displacement of each observation by each term with the
    # coefficient 1, in model units; 0 in rows of other flights. Coefficients of an
    # affinity are ratios, those of a polynomial are model units at the edge
    columns: np.ndarray
    # half extent of the models [model units]: the median of each flight, and the
    # largest of these
    extent: float

    def displaced(self, coefficients):
        """Displacement of each observation, shape (n_rows, 2) [model units]."""
        return self.columns @ coefficients


def deformation_of(observations, terms) -> Deformation:
    """Arrange the terms of all flights."""
    flight_of_row = observations.flight[observations.model]
    names, flights, largest = [], [], 0.0
    columns = [np.zeros((len(flight_of_row), 2, 0))]
    for part in terms:
        rows = np.flatnonzero(flight_of_row == part.flight)
        position, extent = positions_in_model(
            observations.xy[rows], observations.model[rows]
        )
        largest = max(largest, extent)
        for family in part.families:
            at = position * extent if family == AFFINITY else position
            own = displacement(family, at)
            whole = np.zeros((len(flight_of_row), 2, own.shape[2]))
            whole[rows] = own
            columns.append(whole)
            names += term_names(family)
            flights += [part.flight] * own.shape[2]
    return Deformation(
        tuple(names), tuple(flights), np.concatenate(columns, axis=2), largest
    )


# models whose centres lie closer together than this share of their extent have been
# measured in one frame, that of the camera
COMMON_FRAME = 0.25


def positions_in_model(xy, model):
    """Position of all points of a flight in their models, and the model units of 1.

    About 1 at the edge.
    """
    models, model = np.unique(model, return_inverse=True)
    low = np.full((len(models), 2), np.inf)
    high = -low
    np.minimum.at(low, model, xy)
    np.maximum.at(high, model, xy)
    extent = float(np.median(np.max(high - low, axis=1)) / 2.0) or 1.0
    centre = (low + high) / 2.0
    middle = np.median(centre, axis=0)
    away = np.median(np.max(np.abs(centre - middle), axis=1))
    if away < COMMON_FRAME * extent:
        return (xy - middle) / extent, extent
    return (xy - centre[model]) / extent, extent
