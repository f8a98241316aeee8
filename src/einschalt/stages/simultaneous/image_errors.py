"""Points of models from images: covariances from the errors of the image points.

Models that share a photograph share the errors of its points, and each model bends and
tilts with the errors of its relative orientation. The adjustment takes model points for
independent; so what it makes of the errors behind them is drawn: image points, control
and points that were measured otherwise, put through the linearised adjustment.
"""

from dataclasses import dataclass

import numpy as np

from einschalt.stages.error_propagation.measurement_errors import image_chain
from einschalt.stages.relative_orientation.image_errors import ImageErrors

# standard errors from so many draws are known to 2.5 per cent
N_DRAWS = 800
# numbers that are drawn at a time
MOST_DRAWN = 4_000_000


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


def point_covariances(tables, part, solution):
    """Covariances of the adjusted points, (n_points, d, d) [m²].

    Those of the adjustment where no model was formed from images.
    """
    if not any(images is not None for images in tables.images):
        return solution.point_cofactors
    observations = solution.observations
    draw = _drawing(tables, part, solution)
    n_axes = observations.control.shape[1]
    at_once = int(np.clip(MOST_DRAWN // (n_axes * len(part.rows)), 1, N_DRAWS))
    rng = np.random.default_rng(1971)
    total = np.zeros((observations.n_points, n_axes, n_axes))
    for n_draws in np.diff([*range(0, N_DRAWS, at_once), N_DRAWS]):
        control = observations.drawn_control(rng, n_draws)
        points, _ = solution.answer_to(draw(rng, n_draws), control)
        total += points @ np.swapaxes(points, 1, 2)
    return total / N_DRAWS


def _drawing(tables, part, solution):
    """Function that draws errors of all measured points of a part on the ground."""
    n_axes = solution.observations.control.shape[1]
    rows = tables.row[part.rows]
    chains = image_chains(tables, part, solution)
    error = np.zeros((len(tables.row), n_axes, 1))
    error[rows] = solution.observations.standard_error.reshape(len(rows), -1, 1)
    for start, _, chain in chains:  # here image points are measured
        error[start : start + chain.n_points] = 0.0

    def draw(rng, n_draws):
        every = error * rng.standard_normal((len(error), n_axes, n_draws))
        for start, images, chain in chains:
            drawn = chain.axes.draw(rng, images.standard_error, n_draws)
            moved = chain.apply(drawn).reshape(-1, n_axes, n_draws)
            every[start : start + len(moved)] = moved
        return every[rows]

    return draw


def image_chains(tables, part, solution):
    """Operators from image points to model points, of the flights that have images.

    List of the first row of the flight among those of all flights, one table after the
    other, its MeasuredImages, and the operator, see :func:`image_chain`.
    """
    linear = solution.linear
    model = np.full(len(tables.row), len(linear))
    model[tables.row[part.rows]] = solution.observations.model
    # models that could not be determined move nothing
    linear = np.append(linear, np.zeros((1, *linear.shape[1:])), axis=0)[model]
    ends = np.cumsum(tables.n_rows)
    found = []
    for end, n_rows, images in zip(ends, tables.n_rows, tables.images, strict=True):
        if images is not None:
            scale, start = images.scale_number, end - n_rows
            of_rows = linear[start:end]
            chain = image_chain(images.errors, of_rows, scale, images.centres)
            found.append((start, images, chain))
    return found
