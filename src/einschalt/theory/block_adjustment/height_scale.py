"""Heights of spatial models that are out of scale, beside bends that they share.

A wrong principal distance scales the heights of the models of a flight. What a model
has for itself, position, size and tilt, takes up none of it where the ground has
relief, and the residuals of an adjustment of all models show it in many more points
than control has. A bend looks in part like it: scales and bends of all flights are
determined together, as in :mod:`~einschalt.theory.block_adjustment.shared_bend`.

See docs/theory/block_adjustment.md.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.special import ndtri

from einschalt.theory.adjustment.monte_carlo import draws_in_parts
from einschalt.theory.block_adjustment.shared_bend import border_of

# orientations of few points are not linear: of what 3.9 standard errors seem to be too
SIGNIFICANCE = 1e-5
HEIGHT = 2
# relief that the block leaves of the heights of models, in their standard errors: of
# less they are errors themselves, and seem to be out of scale by 1 / (1 + relief²)
LEAST_RELIEF = 10.0
BEYOND_ERRORS = 3.0  # times that
MEDIAN_OF_SQUARES = float(ndtri(0.75) ** 2)  # of errors of variance 1
# of sums that errors of control heights make
N_DRAWS = 400


@dataclass(frozen=True, eq=False)
class HeightScale:
    """Heights of the models of a flight, as far as they are out of scale."""

    flight: int
    ratio: float  # what heights are too large by; 0.01 is one per cent
    p_value: float  # of all flights together
    # what all flights that are out of scale do together to the heights of points on the
    # ground without a given one, RMS [m]
    moved: float
    # whether errors of control heights that are all larger do not explain it as well
    is_told_apart: bool


def examine_scales(solution, terms, answer, made, held):
    """Flights whose heights are out of scale, the clearest first.

    Parameters
    ----------
    solution : SpatialSolution
        Without any of the terms.
    terms : BendTerms
        With the scales of heights.
    answer : AnswerToBends
    made : MadeByErrors
    held : SpatialSolution
        The block as it is adjusted, with control that ``solution`` has refused.

    Returns
    -------
    list of HeightScale
        None that chance explains, and none of ground that has no relief.
    """
    observations = solution.observations
    every = np.ones(len(terms.flight), dtype=bool)
    border = border_of(solution, answer, made, every)
    if border is None:
        return []
    relief = np.where(terms.is_scale, _relief(observations, terms, answer), 0.0)
    is_large = np.abs(border.found) * (1.0 + relief**2) > BEYOND_ERRORS
    places = np.flatnonzero((relief > LEAST_RELIEF) & is_large)
    if not _shown(border, places):
        return []
    made = _with_larger_errors(solution, answer, made, border.found, held)
    beside = border_of(solution, answer, made, every)
    told_apart = [place for place, _ in _shown(beside, places)]
    shown = _shown(border, places)
    some = [place for place, _ in shown]
    errors = answer.on_ground[:, :, some] @ border.found[some]
    none = np.zeros((*observations.control.shape, 1))
    heights = held.answer_to(errors[:, :, None], none)[0][:, HEIGHT, 0]
    is_asked = _has_no_height(observations, terms)
    moved = float(np.sqrt(np.mean(heights[is_asked] ** 2)))
    scales = [
        HeightScale(
            flight=int(terms.flight[place]),
            ratio=-float(border.found[place]),
            p_value=p_value,
            moved=moved,
            is_told_apart=place in told_apart,
        )
        for place, p_value in shown
    ]
    return sorted(scales, key=lambda scale: scale.p_value)


def _shown(border, places):
    """Terms that chance does not explain, with the probability of all together."""
    shown = []
    for place in places.tolist():
        p_value = border.p_value(np.arange(len(border.used)) == place)
        p_value = min(1.0, len(places) * p_value)
        if p_value < SIGNIFICANCE:
            shown.append((place, p_value))
    return shown


def _relief(observations, terms, answer):
    """RMS of what models leave of each term by a coefficient of 1, in their errors."""
    of_row = observations.flight[observations.model]
    is_ground = np.isfinite(terms.position[:, 0])
    n_points = [np.count_nonzero(is_ground & (of_row == k)) for k in terms.flight]
    return np.sqrt(np.maximum(np.diag(answer.normals), 0.0) / np.array(n_points))


def _with_larger_errors(solution, answer, made, found, held):
    """Sums of errors, those of control heights as large as models show at most.

    By what most of them miss their models, beside the terms that were ``found``: much
    of an error of control is no correction of it, but one of the models.
    """
    given = solution.observations
    variances = held.observations.control_covariance[:, HEIGHT, HEIGHT]
    missed = solution.residuals[:, HEIGHT] + answer.residuals[:, HEIGHT] @ found
    n_points = len(given.control)
    n_models = np.bincount(given.point, minlength=n_points)
    missed = np.bincount(given.point, missed, n_points) / np.maximum(n_models, 1)
    missed += solution.control_residuals[:, HEIGHT] + answer.heights @ found
    is_known = np.isfinite(missed) & (variances > 0.0) & (n_models > 0)
    if not is_known.any():
        return made
    variance = variances[is_known]
    times = np.median(missed[is_known] ** 2 / variance) / MEDIAN_OF_SQUARES
    if times <= 1.0:
        return made
    spread = np.sqrt(variance)[:, None]
    rng, more = np.random.default_rng(1971), np.zeros_like(made.sums)
    for n_draws in draws_in_parts(N_DRAWS, given.xyz.size):
        errors = np.zeros((*given.control.shape, n_draws))
        random = rng.standard_normal((len(variance), n_draws))
        errors[is_known, HEIGHT] = spread * random
        none = np.zeros((*given.xyz.shape, n_draws))
        sums = answer.sums(solution.answer_to(none, errors)[1])
        more += sums @ sums.T / N_DRAWS
    return replace(made, sums=made.sums + (times - 1.0) * more)


def _has_no_height(observations, terms):
    """Whether a point lies on the ground, and its height is not given, (n_points,).

    Of a block of which all heights are given all points on the ground.
    """
    is_on_ground = np.zeros(len(observations.control), dtype=bool)
    is_on_ground[observations.point[np.isfinite(terms.position[:, 0])]] = True
    is_asked = is_on_ground & np.isnan(observations.control[:, HEIGHT])
    return is_asked if is_asked.any() else is_on_ground
