"""Errors of image points, drawn and put through orientations to the model points.

Those of single points, of the size that was given or that residuals show; and bends of
single photographs, each of which displaces its points by

    Σ_k τ f_k(x, y) c_pk,   c_pk ~ N(0, 1) for each axis,

f_k the products of powers of second and third degree of the position in the photograph
(1 at the edge). Models that share a photograph share its part.
"""

from dataclasses import dataclass
from functools import partial

import numpy as np

from einschalt.stages.error_propagation.measurement_errors import image_chain
from einschalt.theory.block_adjustment.common_parameters import (
    DEGREE,
    powers_of,
)

# of all image coordinates: what is farther out may be wrong
WITHIN = (0.005, 0.995)


@dataclass(frozen=True, eq=False)
class ImageSizes:
    """How large the errors behind image points are, of each flight."""

    factors: np.ndarray  # (n_flights,): of single points, over those that were given
    # (n_flights,): τ of the bends of photographs, on the ground [m]; 0 without
    bends: np.ndarray

    @classmethod
    def as_given(cls, n_flights: int) -> "ImageSizes":
        """Errors of single points as they were stated, and nothing else."""
        return cls(np.ones(n_flights), np.zeros(n_flights))


def has_images(tables):
    """Whether any model was formed from images."""
    return any(images is not None for images in tables.images)


def drawing(tables, part, sizes, solution, *, with_tails=False):
    """Function that draws errors of all measured points of a part on the ground.

    Normal ones, or (``with_tails``) those of image points with a share of worse ones.
    """
    observations = solution.observations
    flights = drawings_of_images(tables, part, sizes, solution, with_tails=with_tails)
    bends = drawings_of_bends(tables, part, sizes, solution)

    def draw(rng, n_draws):
        every = observations.drawn_errors(rng, n_draws, solution.linear)
        for _, rows, of_images in flights:
            every[rows] = of_images(rng, n_draws)
        for _, rows, of_bends in bends:
            every[rows] += of_bends(rng, n_draws)
        return every

    return draw


def drawings_of_images(tables, part, sizes, solution, *, with_tails=False):
    """Functions that draw what image errors make of the points of each flight.

    List of the number of the flight, the rows of the part, and the function.
    """
    found = []
    for k, rows, of_chain, images, chain in _flights(tables, part, solution):
        error = images.standard_error * sizes.factors[k]
        tails = images.tails if with_tails else (0.0, 1.0)
        draw = partial(_drawn_through, chain, of_chain, error, images.rank, tails)
        found.append((k, rows, draw))
    return found


def drawings_of_bends(tables, part, sizes, solution):
    """Functions that draw what bends of photographs make of the points of each flight.

    As of :func:`drawings_of_images`, of flights that have any.
    """
    found = []
    for k, rows, of_chain, images, chain in _flights(tables, part, solution):
        if sizes.bends[k] > 0.0:
            xy = images.sources[["x", "y"]].to_numpy(dtype=float)
            names = images.sources["image_id"].astype(str)
            photographs, photograph = np.unique(names, return_inverse=True)
            position = _positions(xy)
            terms = np.hstack([powers_of(family, position) for family in DEGREE])
            columns = sizes.bends[k] * terms
            draw = partial(
                _drawn_bends, chain, of_chain, columns, photograph, len(photographs)
            )
            found.append((k, rows, draw))
    return found


def _flights(tables, part, solution):
    """Of flights with images: number, rows of the part, and these of the operator.

    With the MeasuredImages and the operator itself.
    """
    row = tables.row[part.rows]
    for k, start, images, chain in image_chains(tables, part, solution):
        rows = np.flatnonzero((row >= start) & (row < start + chain.n_points))
        yield k, rows, row[rows] - start, images, chain


def _positions(xy):
    """Positions in photographs of one camera, about 1 at their edge.

    Those at the border of a block are filled in part, but as large as the others.
    """
    low, high = np.quantile(xy, WITHIN, axis=0)
    return (xy - (low + high) / 2.0) / (float(np.max(high - low)) / 2.0 or 1.0)


def _drawn_bends(chain, of_chain, columns, photograph, n_photographs, rng, n_draws):
    coefficients = rng.standard_normal((n_photographs, columns.shape[1], 2, n_draws))
    by_point = np.zeros((len(photograph), chain.axes.value, n_draws))
    for k, column in enumerate(columns.T):  # all at once would take much memory
        by_point[:, :2] += column[:, None, None] * coefficients[photograph, k]
    moved = chain.apply(by_point.reshape(-1, n_draws))
    return moved.reshape(chain.n_points, -1, n_draws)[of_chain]


def _drawn_through(chain, of_chain, error, rank, tails, rng, n_draws):
    drawn = chain.axes.draw(rng, error[rank.argsort()], n_draws)
    if tails[0] > 0.0:
        drawn *= _worse(rng, tails, drawn.shape, len(error))
    by_point = drawn.reshape(len(rank), -1, n_draws)
    moved = chain.apply(by_point[rank].reshape(drawn.shape))
    return moved.reshape(chain.n_points, -1, n_draws)[of_chain]


def _worse(rng, tails, shape, n_points):
    """Sizes of the errors of points with tails, of mean square 1."""
    share, factor = tails
    is_worse = rng.random((n_points, shape[1])) < share
    size = np.where(is_worse, factor, 1.0)
    size /= np.sqrt(1.0 - share + share * factor**2)
    return np.repeat(size, shape[0] // n_points, axis=0)


def image_chains(tables, part, solution):
    """Operators from image points to model points, of the flights that have images.

    List of the number of the flight, its first row among those of all flights, one
    table after the other, its MeasuredImages, and the operator, see
    :func:`image_chain`.
    """
    linear = solution.linear
    model = np.full(len(tables.row), len(linear))
    model[tables.row[part.rows]] = solution.observations.model
    # models that could not be determined move nothing
    linear = np.append(linear, np.zeros((1, *linear.shape[1:])), axis=0)[model]
    ends = np.cumsum(tables.n_rows)
    found = []
    for k, images in enumerate(tables.images):
        if images is not None:
            start = ends[k] - tables.n_rows[k]
            of_rows, scale = linear[start : ends[k]], images.scale_number
            chain = image_chain(images.errors, of_rows, scale, images.centres)
            found.append((k, start, images, chain))
    return found
