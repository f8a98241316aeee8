"""How large the errors of image points are, by the residuals of the block.

The points of a model from images are worse than its image points, by base and rays:
what their residuals show is the size of the errors of model points, with which they are
weighed, and no size of an image error. So errors of image points as large as given are
drawn, and put through the adjustment; with the sums of squares

    S_k = B_k + Σ f_i² A_ki

of the residuals of flight k, of which control and other models make B, and the image
errors of flight i make A_ki, the factors f are those that make the sums that are there.
"""

from dataclasses import replace

import numpy as np
import pandas as pd

from einschalt.foundations.language import mark
from einschalt.stages.simultaneous.image_drawings import (
    ImageSizes,
    drawings_of_images,
)
from einschalt.theory.block_adjustment.group_components import LEAST_REDUNDANCY

IMAGE_POINTS = mark("image points")
# sums over all points of a flight, known to two per cent with a redundancy of 25
N_DRAWS = 200
MOST_STEPS = 200
SETTLED = 1e-6
LEAST_SQUARE = 1e-6  # of a factor


def with_image_sizes(tables, weighed):
    """Give the image points of a weighed part the errors that its residuals show.

    The Weighed has the factors in ``image_sizes``, and a row of its table for each
    flight that has images: the median of the errors of an image coordinate on the
    ground, as it is.
    """
    solution, part = weighed.block.solution, weighed.part
    flight = part.observations.flight[part.observations.model]
    n_flights = len(tables.flights)
    is_ground = ~tables.is_centre[part.points][part.observations.point]
    counted = np.asarray(~weighed.block.is_out & is_ground)[:, None]
    error = part.observations.standard_error.reshape(len(flight), -1)
    weights = counted / error**2

    def sums(values):
        return np.bincount(flight, np.sum(weights * values, axis=1), n_flights)

    free = counted * (1.0 - solution.leverage)
    redundancy = np.bincount(flight, free.sum(axis=1), n_flights)
    own, rest = _made_by_errors(tables, part, solution, sums)
    is_free = np.diagonal(own) > 0.0
    is_free &= redundancy > LEAST_REDUNDANCY
    factors = np.sqrt(_squares(own, rest, sums(solution.residuals**2), is_free))
    table = _with_rows(tables, weighed.table, factors, is_free, redundancy)
    sizes = replace(weighed.image_sizes, factors=factors)
    return replace(weighed, image_sizes=sizes, table=table)


def _made_by_errors(tables, part, solution, sums):
    """Mean sums of squares by flight: of image errors as given, and of all others.

    (n_flights, n_flights), those that the image errors of flight i make of flight k in
    row k; and (n_flights,).
    """
    observations, n_flights = solution.observations, len(tables.flights)
    of_images = drawings_of_images(
        tables, part, ImageSizes.as_given(n_flights), solution
    )
    own, rest = np.zeros((n_flights, n_flights)), np.zeros(n_flights)
    for rng, n_draws, control in observations.control_in_parts(N_DRAWS):
        others = observations.drawn_errors(rng, n_draws, solution.linear)
        for k, rows, draw in of_images:
            others[rows] = 0.0
            alone = np.zeros_like(others)
            alone[rows] = draw(rng, n_draws)
            _, residuals = solution.answer_to(alone, np.zeros_like(control))
            own[:, k] += sums(np.sum(residuals**2, axis=2))
        _, residuals = solution.answer_to(others, control)
        rest += sums(np.sum(residuals**2, axis=2))
    return own / N_DRAWS, rest / N_DRAWS


def _squares(own, rest, shown, is_free):
    """Squares of the factors that make the sums that are ``shown``.

    Each is moved by the ratio of its sum to the one that it makes, which keeps it
    positive; those that are not free are 1.
    """
    squares = np.ones(len(rest))
    for _ in range(MOST_STEPS):
        made = rest + own @ squares
        step = np.where(is_free, shown / np.where(made > 0.0, made, 1.0), 1.0)
        before, squares = squares, np.maximum(squares * step, LEAST_SQUARE)
        if (np.abs(squares - before) < SETTLED * before).all():
            break
    return squares


def _with_rows(tables, table, factors, is_free, redundancy):
    """Table of the groups, with the image points of each flight before its models."""
    parts, rest = [], table
    for k, (name, images) in enumerate(zip(tables.flights, tables.images, strict=True)):
        is_it = rest["group"].str.partition(", ")[0] == name
        if images is not None and is_it.any():
            known = is_free[k]
            error = factors[k] / np.sqrt(2.0 * redundancy[k]) if known else np.nan
            row = {
                "group": f"{name}, {IMAGE_POINTS}",
                "standard_error_m": factors[k] * np.median(images.standard_error),
                "factor": factors[k] if known else np.nan,
                "factor_standard_error": error,
                "redundancy": redundancy[k],
                "is_estimated": known,
            }
            parts.append(pd.DataFrame([row]).astype({"is_estimated": bool}))
        parts.append(rest[is_it])
        rest = rest[~is_it]
    return pd.concat([*parts, rest], ignore_index=True)
