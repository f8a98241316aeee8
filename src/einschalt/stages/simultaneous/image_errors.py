"""Points of models from images, or of control that shares errors: their covariances.

Models that share a photograph share the errors of its points, and each model bends and
tilts with the errors of its relative orientation. The adjustment takes model points for
independent; so what it makes of the errors behind them is drawn: those of image points,
as large as the errors of their flight in plan, of control, and of other flights with
what all points of a model share there, put through the linearised adjustment. So are
errors that control points share.
"""

from dataclasses import dataclass

import numpy as np

from einschalt.stages.error_propagation.measurement_errors import image_chain
from einschalt.stages.relative_orientation.image_errors import ImageErrors
from einschalt.theory.adjustment.monte_carlo import draws_in_parts

# standard errors from so many draws are known to 2.5 per cent
N_DRAWS = 800
NUMBERS_AT_ONCE = 4_000_000


@dataclass(frozen=True, eq=False)
class MeasuredImages:
    """Image points behind the model points of a flight."""

    errors: ImageErrors
    # (n_sources,): of each image coordinate, on the ground at the scale number [m]
    standard_error: np.ndarray
    scale_number: float
    # (n_centres, 2): pair and side (0 left, 1 right) of the projection centres that
    # follow the model points, if they do
    centres: np.ndarray | None = None


def centres_behind(errors, centres):
    """Pair and side of the rows of a table of projection centres, (n_centres, 2)."""
    names = ["coverage", "model_id"]
    numbered = errors.pairs.assign(pair=np.arange(errors.n_models))
    found = centres[[*names, "image_id"]].merge(numbered, on=names, how="left")
    is_right = found["image_id"] == found["right_image"]
    return np.column_stack([found["pair"], is_right]).astype(np.int64)


def point_covariances(tables, weighed, solution):
    """Covariances of the adjusted points, (n_points, d, d) [m²].

    Those of the adjustment where no model was formed from images, and control shares no
    errors; NaN where it shares shifts of unknown size.
    """
    observations = solution.observations
    if tables.has_unknown_groups:
        return np.full(solution.point_cofactors.shape, np.nan)
    if not has_images(tables) and observations.shared_control is None:
        return solution.point_cofactors
    draw = _drawing(tables, weighed, solution)
    n_axes = observations.control.shape[1]
    n_numbers = n_axes * len(observations.model)
    rng = np.random.default_rng(1971)
    total = np.zeros((observations.n_points, n_axes, n_axes))
    for n_draws in draws_in_parts(N_DRAWS, n_numbers, NUMBERS_AT_ONCE):
        control = observations.drawn_control(rng, n_draws)
        points, _ = solution.answer_to(draw(rng, n_draws), control)
        total += points @ np.swapaxes(points, 1, 2)
    return total / N_DRAWS


def has_images(tables):
    """Whether any model was formed from images."""
    return any(images is not None for images in tables.images)


def _drawing(tables, weighed, solution):
    """Function that draws errors of all measured points of a part on the ground."""
    observations = solution.observations
    row = tables.row[weighed.part.rows]
    # groups of a flight follow each other, that of its points in plan first
    n_groups = (len(weighed.factors) - 1) // len(tables.flights)
    chains = []
    for k, start, images, chain in image_chains(tables, weighed.part, solution):
        rows = np.flatnonzero((row >= start) & (row < start + chain.n_points))
        error = images.standard_error * weighed.factors[k * n_groups]
        chains.append((rows, row[rows] - start, error, chain))

    def draw(rng, n_draws):
        every = observations.drawn_errors(rng, n_draws, solution.linear)
        for rows, of_chain, error, chain in chains:
            moved = chain.apply(chain.axes.draw(rng, error, n_draws))
            every[rows] = moved.reshape(chain.n_points, -1, n_draws)[of_chain]
        return every

    return draw


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
