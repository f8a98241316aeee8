"""Points of models from images, or of control that shares errors: their covariances.

Models that share a photograph share the errors of its points, and each model bends and
tilts with the errors of its relative orientation. The adjustment takes model points for
independent; so what it makes of the errors behind them is drawn: those of image points,
of the size that was given or that residuals show (`image_sizes`), of control, and of
other flights with what all points of a model share there, put through the linearised
adjustment. So are errors that control points share. Residuals of such points have other
sizes than the adjustment expects: at the edge of a model they are larger, and good
points would look wrong there. So has their sum of squares: rays that are longer than
the scale number says, as from tilted photographs, make it larger.
"""

from dataclasses import dataclass, field, replace

import numpy as np
import pandas as pd

from einschalt.foundations.names import ranks
from einschalt.stages.relative_orientation.image_errors import ImageErrors
from einschalt.stages.simultaneous.image_drawings import drawing, has_images
from einschalt.theory.adjustment.least_squares import SQRT2
from einschalt.theory.block_adjustment.block_tests import (
    DrawnCovariance,
    judge_by_covariance,
    judge_observations,
)
from einschalt.theory.block_adjustment.control_heights import IN_HEIGHT
from einschalt.theory.block_adjustment.control_in_plan import IN_PLAN
from einschalt.theory.block_adjustment.control_scores import scores_of_control
from einschalt.theory.block_adjustment.gross_errors import OUT
from einschalt.theory.block_adjustment.neighbouring_errors import (
    judge_among_neighbours,
    neighbours_of,
)
from einschalt.theory.block_adjustment.norm_precision import variances_by_norm

# standard errors from so many draws are known to 2.5 per cent
N_DRAWS = 800
# one ratio of variances of all points: known to two per cent
N_NORM_DRAWS = 60
LEAST_REDUNDANCY = 1e-6  # less is rounding
MOST_CONTROL = 500  # heights whose covariance is drawn
# the same in plan: two numbers each, of which the draws must be many more
MOST_IN_PLAN = 200


@dataclass(frozen=True, eq=False)
class MeasuredImages:
    """Image points behind the model points of a flight."""

    errors: ImageErrors
    # (n_sources,): of each image coordinate, on the ground at the scale number [m]
    standard_error: np.ndarray
    sources: pd.DataFrame  # their table: image_id, point_id, …
    scale_number: float
    # (n_centres, 2): pair and side (0 left, 1 right) of the projection centres that
    # follow the model points, if they do
    centres: np.ndarray | None = None
    # share of image points that are much worse than the others, and how many times;
    # ``standard_error`` is the root mean square of all
    tails: tuple[float, float] = (0.0, 1.0)

    @property
    def n_rows(self) -> int:
        """Number of model points, and of the projection centres that follow them."""
        n_centres = 0 if self.centres is None else len(self.centres)
        return len(self.errors.sources) + n_centres

    @property
    def rank(self) -> np.ndarray:
        """Place of each source in the order of names, as they are drawn."""
        return ranks(self.sources["image_id"], self.sources["point_id"])


def centres_behind(errors, centres):
    """Pair and side of the rows of a table of projection centres, (n_centres, 2)."""
    names = ["coverage", "model_id"]
    numbered = errors.pairs.assign(pair=np.arange(errors.n_models))
    found = centres[[*names, "image_id"]].merge(numbered, on=names, how="left")
    is_right = found["image_id"] == found["right_image"]
    return np.column_stack([found["pair"], is_right]).astype(np.int64)


@dataclass(frozen=True)
class ExpectedFit:
    """How the models of a flight fit if all errors are as large as stated."""

    m_0: float  # of all of them in plan, TOTAL [m]
    degrees: float  # of freedom that its square has


@dataclass(frozen=True, eq=False)
class DrawnFigures:
    """What is known of an adjustment by drawn errors alone."""

    # (n_points,): which of the points of the tables each point of the solution is
    points: np.ndarray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    # of each flight that has models from images, by its name
    fits: dict[str, ExpectedFit] = field(default_factory=dict)
    # (n_control, n_control): covariance of the scores of the heights of control, see
    # :mod:`.control_heights`; None where observations are independent, where control
    # is more than ``MOST_CONTROL``, and of plane models [1/m²]
    control_heights: np.ndarray | None = None
    # (2 n_control, 2 n_control): the same in plan, also of plane models, see
    # :mod:`.control_in_plan`; of up to ``MOST_IN_PLAN`` points [1/m²]
    control_in_plan: np.ndarray | None = None


@dataclass(frozen=True, eq=False)
class Covariances:
    """What the errors behind the observations make of an adjusted block [m²]."""

    # (n_points, d, d): of the adjusted points; NaN where control shares shifts of
    # unknown size
    points: np.ndarray
    # of the residuals of all observations; None where model points are independent, as
    # the adjustment takes them to be
    residuals: DrawnCovariance | None = None
    # mean of Σ w v² of errors as large as stated, over the redundancy
    unit_variance: float = 1.0
    figures: DrawnFigures = field(default_factory=DrawnFigures)


def covariances(tables, part, sizes, solution) -> Covariances:
    """Find the covariances of the adjusted points, and of residuals of images.

    Those of the adjustment where no model was formed from images, and control shares no
    errors. ``sizes`` are the ImageSizes of a Weighed.
    """
    observations, points = solution.observations, solution.point_cofactors
    if tables.has_unknown_groups:
        points = np.full(points.shape, np.nan)
    is_from_images = has_images(tables)
    is_drawn = observations.shared_control is not None and not tables.has_unknown_groups
    if not is_from_images and not is_drawn:
        return Covariances(points, figures=DrawnFigures(part.points))
    drawn = _drawn(tables, part, sizes, solution)
    points = points if tables.has_unknown_groups else drawn.of_points
    if not is_from_images:
        figures = DrawnFigures(part.points, {}, *drawn.of_scores)
        return Covariances(points, figures=figures)
    squares = drawn.squares
    if sizes.bends.any():  # which are no part of what is stated
        straight = replace(sizes, bends=np.zeros(len(sizes.bends)))
        squares = _drawn(tables, part, straight, solution).squares
    fits = _expected_fits(tables, sizes, squares)
    return Covariances(
        points,
        DrawnCovariance(drawn.of_residuals, N_DRAWS),
        _unit_variance(part.observations, solution, drawn),
        DrawnFigures(part.points, fits, *drawn.of_scores),
    )


def _expected_fits(tables, sizes, squares):
    """What flights with images fit by, from drawn squares (n_flights, n_draws).

    Errors are drawn as they were estimated, where they were.
    """
    found = {}
    for k, (images, drawn) in enumerate(zip(tables.images, squares, strict=True)):
        mean = drawn.mean()
        if images is not None and mean > 0.0:
            m_0 = np.sqrt(mean) / sizes.factors[k]
            degrees = 2.0 * mean**2 / drawn.var(ddof=1)
            found[tables.flights[k]] = ExpectedFit(float(m_0), float(degrees))
    return found


def _is_in(given, solution):
    """Which observations take part, (n_rows,); what is out has a huge error."""
    error = given.standard_error.reshape(len(solution.residuals), -1)
    used = solution.observations.standard_error.reshape(error.shape)
    return (used / error).max(axis=1) < OUT


def _shares_in_fit(tables, part, solution):
    """Of the squares in plan of each row in that of ``m_0`` of its flight, (n_rows,).

    Models count there by their redundancy, each with its own square of ``m_0``.
    """
    used = solution.observations
    is_own = _is_in(part.observations, solution)
    is_own &= ~tables.is_centre[part.points][used.point]
    free = (1.0 - solution.leverage) * is_own[:, None]
    redundancy = np.bincount(used.model, free.sum(axis=1))
    in_plan = np.bincount(used.model, free[:, :2].sum(axis=1))
    is_free = (redundancy > LEAST_REDUNDANCY) & (in_plan > LEAST_REDUNDANCY)
    whole = np.bincount(used.flight, redundancy * is_free, len(tables.flights))
    with np.errstate(divide="ignore", invalid="ignore"):
        share = SQRT2**2 * redundancy / in_plan / whole[used.flight]
    return np.where(is_free, share, 0.0)[used.model] * is_own


def _unit_variance(given, solution, drawn):
    """Mean of Σ w v² over the redundancy, which is 1 where weights fit the errors.

    tr(W C) with the covariances C of the residuals and the weights that were given, of
    what takes part. Variances 1 where orientations have errors of their own besides.
    """
    used, redundancy = solution.observations, solution.redundancy
    if redundancy <= 0 or used.bent is not None:
        return 1.0
    error = given.standard_error.reshape(len(solution.residuals), -1)
    variances = np.diagonal(drawn.of_residuals, axis1=1, axis2=2)
    squares = np.sum((variances / error**2)[_is_in(given, solution)])
    squares += np.einsum("nab,nba->", used.control_weight, drawn.of_control)
    return float(squares / redundancy)


@dataclass(frozen=True, eq=False)
class _Drawn:
    """Mean products of what follows from drawn errors [m²]."""

    of_points: np.ndarray  # (n_points, d, d)
    of_residuals: np.ndarray  # (n_rows, d, d)
    of_control: np.ndarray  # (n_points, d, d): adjusted less given
    squares: np.ndarray  # (n_flights, n_draws): of m_0 of each flight, not their mean
    # of the scores of control in height and in plan, see DrawnFigures
    of_scores: tuple[np.ndarray | None, np.ndarray | None]


def _drawn(tables, part, sizes, solution):
    """Draw errors, and put them through the linearised adjustment."""
    observations = solution.observations
    draw = drawing(tables, part, sizes, solution)
    n_axes = observations.control.shape[1]
    of_points = np.zeros((observations.n_points, n_axes, n_axes))
    of_residuals = np.zeros((len(observations.model), n_axes, n_axes))
    of_control = np.zeros_like(of_points)
    flight, n_flights = observations.flight[observations.model], len(tables.flights)
    share, squares = _shares_in_fit(tables, part, solution)[:, None], []
    of_heights, of_plan = _no_products(observations)
    for rng, n_draws, control in observations.control_in_parts(N_DRAWS):
        points, residuals = solution.answer_to(draw(rng, n_draws), control)
        of_points += points @ np.swapaxes(points, 1, 2)
        of_residuals += residuals @ np.swapaxes(residuals, 1, 2)
        away = points - control
        of_control += away @ np.swapaxes(away, 1, 2)
        for axes, products in ((IN_HEIGHT, of_heights), (IN_PLAN, of_plan)):
            if products is not None:
                scores = scores_of_control(solution, away, axes)
                products[:] += scores @ scores.T / N_DRAWS
        in_plan = share * np.sum(residuals[:, :2] ** 2, axis=1)
        of_flight = [in_plan[flight == k].sum(axis=0) for k in range(n_flights)]
        squares.append(np.stack(of_flight))
    means = (sums / N_DRAWS for sums in (of_points, of_residuals, of_control))
    return _Drawn(*means, np.concatenate(squares, axis=1), (of_heights, of_plan))


def _no_products(observations):
    """Sums of products of scores of control before the first draw, or None."""
    n_control = np.count_nonzero(observations.is_control)
    has_heights = observations.is_in_space and n_control <= MOST_CONTROL
    has_plan = n_control <= MOST_IN_PLAN
    return (
        np.zeros((n_control, n_control)) if has_heights else None,
        np.zeros((2 * n_control, 2 * n_control)) if has_plan else None,
    )


def variance_by_norm(tables, part, sizes, block, norms):
    """Variance of the points by a robust norm over that by least squares.

    ``block`` is the OutlierFreeBlock without gross errors, ``norms`` those that were
    used one after the other. Errors of image points are drawn with their tails.
    """
    solution = block.solution
    draw = drawing(tables, part, sizes, solution, with_tails=True)
    sums = np.zeros(2)
    for rng, n_draws, control in solution.observations.control_in_parts(N_NORM_DRAWS):
        errors = draw(rng, n_draws)
        sums += variances_by_norm(solution, errors, control, norms, ~block.is_out)
    return float(sums[1] / sums[0])


def judge_of(part, drawn):
    """Test of the observations of a part: ``judge(solution, is_out, given)``.

    By the covariance of their residuals where it was drawn; alone otherwise, and among
    their neighbours in the models of space. What is out takes no part in how large the
    errors of its flight are, or of its neighbours.
    """
    flight = part.observations.flight[part.observations.model]
    known = []  # the neighbours, found once

    def judge(solution, is_out, given):
        alone = judge_observations(solution, given)
        if drawn is None:
            if not solution.observations.is_in_space:
                return alone
            if not known:
                known.append(neighbours_of(solution))
            return judge_among_neighbours(solution, alone, given, known[0], ~is_out)
        return judge_by_covariance(solution, alone, drawn, flight, ~is_out)

    return judge
