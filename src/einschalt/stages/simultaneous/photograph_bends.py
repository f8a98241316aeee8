"""Photographs that are bent, each in its own way: film, plate, lens and atmosphere.

What all photographs of a flight share is found by itself (:mod:`.shared_bends`), and a
bend of single ones is as of :mod:`.image_drawings`. Orientations take up part of it;
the rest makes neighbours in a model wrong alike, which errors of single points do not.
With sums over the residuals v of a flight, in units of their errors,

    S = Σ v²,   N = Σ v · (mean of v of the nearest in the model),

errors of image points as large as stated, and bends of a size of 1, both drawn and put
through the linearised adjustment, make S = B + f² A + τ² D, and N likewise, of which
control and models that are not from images make B: the factor f and the size τ are
those that make both sums. That N is larger than it is without bends, as a share of S,
is tested by the same draws.

See docs/theory/own_deformation.md.
"""

from dataclasses import dataclass, replace

import numpy as np

from einschalt.stages.simultaneous.image_drawings import (
    ImageSizes,
    drawings_of_bends,
    drawings_of_images,
    has_images,
)
from einschalt.stages.simultaneous.own_deformation import is_detected
from einschalt.theory.adjustment.monte_carlo import tail_of_mean
from einschalt.theory.block_adjustment.common_parameters import DEGREE
from einschalt.theory.block_adjustment.own_deformation import PLAN, OwnDeformation

N_DRAWS = 100
N_NEAREST = 4  # points of a model that a residual is held against
# of a flight: fewer tell nothing of neighbours
LEAST_POINTS = 200
# of the errors of single points beside bends: names that are exchanged make hundreds
LARGEST_FACTOR = 2.5


def find_photograph_bends(tables, weighed, deformation) -> OwnDeformation | None:
    """Estimate how much photographs are bent, each in its own way.

    An OwnDeformation with sizes on the ground, one for both degrees [m]; None without
    images, where this is ``"ignored"``, of flights with few points, and where single
    points are so much worse than stated that something else is wrong. ``weighed`` is
    the block without gross errors, or with those that are kept.
    """
    if deformation == "ignored" or not has_images(tables):
        return None
    residuals = _Residuals(tables, weighed)
    flights = [k for k in residuals.flights if residuals.counts[k] >= LEAST_POINTS]
    if not flights:
        return None
    shown = residuals.sums(weighed.block.solution.residuals[:, :, None])[..., 0]
    drawn = _drawn_sums(tables, weighed, residuals)
    p_values = [
        tail_of_mean(shown[1, k] / shown[0, k], drawn.every[1, k] / drawn.every[0, k])
        for k in flights
    ]
    p_value = min(float(np.nanmin([*p_values, 1.0])) * len(flights), 1.0)
    factors, squares, errors = _squares(shown, drawn, flights)
    if factors.max() > LARGEST_FACTOR:
        return None
    families = tuple(DEGREE)
    n = len(families)
    with np.errstate(divide="ignore", invalid="ignore"):
        relative = np.where(squares > 0.0, errors / squares / 2.0, np.nan)
    return OwnDeformation(
        np.repeat(flights, n),
        families * len(flights),
        (PLAN,) * (n * len(flights)),
        np.repeat(np.sqrt(squares), n),
        np.repeat(relative, n),
        p_value,
    )


def with_photograph_bends(weighed, bends):
    """Give a Weighed the bends of its photographs, if chance does not explain them."""
    if not is_detected(bends):
        return weighed
    sizes = np.zeros(len(weighed.image_sizes.bends))
    sizes[bends.flight] = bends.size
    return replace(weighed, image_sizes=replace(weighed.image_sizes, bends=sizes))


class _Residuals:
    """Which residuals count, and which of them lie next to each other in a model."""

    def __init__(self, tables, weighed):
        from scipy.spatial import KDTree  # noqa: PLC0415 - loaded for photographs

        observations = weighed.block.solution.observations
        flight = observations.flight[observations.model]
        is_ground = ~tables.is_centre[weighed.part.points][observations.point]
        self.flights = [k for k, i in enumerate(tables.images) if i is not None]
        counts = is_ground & ~weighed.block.is_out & np.isin(flight, self.flights)
        self.rows = np.flatnonzero(counts)
        self.of_rows = flight[self.rows]
        self.counts = np.bincount(self.of_rows, minlength=len(tables.flights))
        error = weighed.part.observations.standard_error.reshape(len(flight), -1)
        self.error = error[self.rows][:, :, None]
        model = observations.model[self.rows]
        places = weighed.block.solution.points[observations.point[self.rows], :2]
        # models lie apart along an axis of their own
        apart = 2.0 * np.linalg.norm(np.ptp(places, axis=0)) + 1.0
        places = np.column_stack([places, apart * model])
        _, nearest = KDTree(places).query(places, N_NEAREST + 1)
        nearest = np.minimum(nearest[:, 1:], max(len(places) - 1, 0))
        self.nearest = nearest
        self.is_beside = (model[nearest] == model[:, None])[:, :, None, None]

    def sums(self, residuals):
        """S and N of each flight, (2, n_flights, n_draws)."""
        v = residuals[self.rows] / self.error
        beside = np.zeros_like(v)
        for place, is_beside in zip(
            self.nearest.T, np.moveaxis(self.is_beside, 1, 0), strict=True
        ):
            beside += v[place] * is_beside
        each = np.stack([v * v, v * beside / N_NEAREST]).sum(axis=2)
        of_flight = np.zeros((2, len(self.counts), v.shape[2]))
        np.add.at(of_flight, (slice(None), self.of_rows), each)
        return of_flight


@dataclass(frozen=True, eq=False)
class _DrawnSums:
    """S and N that drawn errors of unit size make, first axis S and N."""

    every: np.ndarray  # (2, n_flights, n_draws): of all errors but bends
    # (2, n_flights, n_flights): mean of what the errors of the flight of the last axis
    # make, and bends of its photographs
    of_images: np.ndarray
    of_bends: np.ndarray
    rest: np.ndarray  # (2, n_flights): mean of what all other errors make


def _drawn_sums(tables, weighed, residuals):
    solution, n_flights = weighed.block.solution, len(tables.flights)
    unit = replace(ImageSizes.as_given(n_flights), bends=np.ones(n_flights))
    given = tables, weighed.part, unit, solution
    of_images, of_bends = drawings_of_images(*given), drawings_of_bends(*given)
    observations, every, rest = solution.observations, [], []
    means = np.zeros((2, 2, n_flights, n_flights))  # of images, and of bends
    for rng, n_draws, control in observations.control_in_parts(N_DRAWS):
        others = observations.drawn_errors(rng, n_draws, solution.linear)
        for _, rows, _ in of_images:
            others[rows] = 0.0
        _, of_others = solution.answer_to(others, control, is_rough=True)
        rest.append(residuals.sums(of_others))
        of_all = of_others
        for place, drawings in enumerate((of_images, of_bends)):
            for k, rows, draw in drawings:
                alone = np.zeros_like(others)
                alone[rows] = draw(rng, n_draws)
                _, found = solution.answer_to(
                    alone, np.zeros_like(control), is_rough=True
                )
                means[place, :, :, k] += residuals.sums(found).sum(axis=-1) / N_DRAWS
                of_all = of_all + found if place == 0 else of_all
        every.append(residuals.sums(of_all))
    rest = np.concatenate(rest, axis=-1).mean(axis=-1)
    return _DrawnSums(np.concatenate(every, axis=-1), *means, rest)


def _squares(shown, drawn, flights):
    """Factors f of some flights, squares of τ, and their standard errors [m²]."""
    from scipy.optimize import nnls  # noqa: PLC0415 - loaded for photographs

    def rows(sums):
        return sums[:, flights].reshape(-1, *sums.shape[2:])

    scale = rows(drawn.every).std(axis=-1)
    parts = (rows(part)[:, flights] for part in (drawn.of_images, drawn.of_bends))
    design = np.hstack(list(parts)) / scale[:, None]
    found, _ = nnls(design, rows(shown - drawn.rest) / scale)
    errors = np.sqrt(np.diag(np.linalg.inv(design.T @ design)))
    n = len(flights)
    return np.sqrt(found[:n]), found[n:], errors[n:]
