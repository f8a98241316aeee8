"""Which photographs make models: pairs with many common points and a good base.

How large a base is, the angle tells at which rays from both photographs meet. The
similarity between two images of vertical photographs gives it: how far it moves the
principal point, over the principal distance. Of tilted and convergent photographs a
plane through the points that they share does, whatever the tilts are; it is asked where
it fits clearly better, since relief in a narrow overlap bends it.

Each photograph is paired with its best partners. Then those pairs follow that hold what
no pair does yet, until all points are in one that can be. All pairs are looked at
together: sums over common points are products of sparse matrices, of images by points.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy import sparse

from einschalt.theory.relative_orientation.views_of_planes import (
    OF_LEFT,
    OF_RIGHT,
    base_ratios,
    fit_homographies,
    monomials_of_left,
    monomials_of_right,
)

LEAST_COMMON = 8  # five elements of the orientation, and points that check them
LEAST_RATIO = 0.1  # a narrower base gives no heights, and many photographs have one
# from which base on a model is as good in height as it has to be: 60 % forward overlap
# of a wide-angle camera
FULL_RATIO = 0.6
# beyond it the rays meet at more than 53°, and look at the same ground from two sides
LONG_RATIO = 1.0
PAIRS_AT_ONCE = 50_000  # of which planes are fitted
# by which errors of a plane have to be smaller than those of a similarity
BETTER = 1.2
N_PARTNERS = 3  # one on either side in the strip, and one in the next
COVERAGE = "1"


@dataclass(frozen=True, eq=False)
class ModelChoice:
    """Models that photographs could make.

    Attributes
    ----------
    models : DataFrame
        coverage, model_id, left_image, right_image.
    n_common : ndarray of int, shape (n_models,)
        Points that both photographs show.
    base_ratio : ndarray, shape (n_models,)
        Base over height above ground: twice the tangent of half the angle at which the
        rays meet in the middle of the model.
    alone : list of str
        Photographs that are in no model.
    unpaired : list of str
        Points in two photographs or more that are in no model, since none could hold
        them: pairs with too few common points, or too short a base.
    n_single : int
        Points that were measured in one photograph alone.
    most_common : int
        Points that two photographs have in common, at most.
    """

    models: pd.DataFrame
    n_common: np.ndarray
    base_ratio: np.ndarray
    alone: list
    unpaired: list
    n_single: int
    most_common: int


def choose_models(
    image_points: pd.DataFrame, principal_distance_mm: float
) -> ModelChoice:
    """Choose pairs of photographs: for each the best partners it has.

    Parameters
    ----------
    image_points : DataFrame
        image_id, point_id, x, y [mm], origin in the principal point.
    principal_distance_mm : float
        [mm]
    """
    images, names = pd.factorize(image_points["image_id"], sort=True)
    points, point_names = pd.factorize(image_points["point_id"])
    places = image_points["x"].to_numpy(float) + 1j * image_points["y"].to_numpy(float)
    places /= principal_distance_mm
    left, right, n_common, *by_similarity = _bases(images, points, places)
    most_common = int(n_common.max(initial=0))
    is_possible = n_common >= LEAST_COMMON
    left, right, n_common, *by_similarity = (
        one[is_possible] for one in (left, right, n_common, *by_similarity)
    )
    ratio = _ratios(images, points, places, left, right, n_common, *by_similarity)
    is_possible = ratio >= LEAST_RATIO
    left, right, n_common, ratio = (
        one[is_possible] for one in (left, right, n_common, ratio)
    )
    weight = np.minimum(ratio, FULL_RATIO) * np.minimum(1.0, LONG_RATIO / ratio)
    shown = _shown(images, points)
    is_chosen = _are_best(left, right, n_common * weight)
    is_held = _held(shown, left[is_chosen], right[is_chosen])
    _complete(is_chosen, is_held, shown, left, right, weight)
    left, right = left[is_chosen], right[is_chosen]
    models = pd.DataFrame(
        {
            "coverage": COVERAGE,
            "model_id": _named(names[left].astype(str), names[right].astype(str)),
            "left_image": names[left],
            "right_image": names[right],
        }
    )
    is_alone = ~np.isin(np.arange(len(names)), np.concatenate([left, right]))
    n_images = np.bincount(shown.indices, minlength=shown.shape[1])
    return ModelChoice(
        models,
        n_common[is_chosen],
        ratio[is_chosen],
        [str(name) for name in names[is_alone]],
        [str(name) for name in point_names[~is_held & (n_images > 1)]],
        int(np.count_nonzero(n_images == 1)),
        most_common,
    )


def _shown(images, points):
    """Which points each image shows, (n_images, n_points) of ones."""
    shape = (images.max(initial=-1) + 1, points.max(initial=-1) + 1)
    shown = sparse.csr_array((np.ones(len(images)), (images, points)), shape=shape)
    shown.data[:] = 1.0
    return shown


def _held(shown, left, right):
    """Whether a pair shows a point in both of its images, (n_points,)."""
    is_held = np.zeros(shown.shape[1], dtype=bool)
    if len(left):  # of which scipy makes no array
        is_held[shown[left].multiply(shown[right]).indices] = True
    return is_held


def _complete(is_chosen, is_held, shown, left, right, weight):
    """Choose pairs for points that no pair holds, until none could hold more.

    In each round those that are the best for both of their images, so that they hardly
    show the same points. ``is_chosen`` (pairs) and ``is_held`` (points) are changed.
    """
    open_pairs = np.flatnonzero(~is_chosen)
    while len(open_pairs):
        missing = shown[:, np.flatnonzero(~is_held)]
        first, second = left[open_pairs], right[open_pairs]
        gain = _sums(missing, missing, first, second)
        is_of_use = gain > 0.0
        open_pairs, gain = open_pairs[is_of_use], gain[is_of_use]
        first, second = first[is_of_use], second[is_of_use]
        order = np.argsort(-gain * weight[open_pairs], kind="stable")
        rank = np.empty(len(order), dtype=int)
        rank[order] = np.arange(len(order))
        best = np.full(shown.shape[0], len(order))
        np.minimum.at(best, first, rank)
        np.minimum.at(best, second, rank)
        is_taken = (best[first] == rank) & (best[second] == rank)
        taken = open_pairs[is_taken]
        is_chosen[taken] = True
        is_held |= _held(shown, left[taken], right[taken])
        open_pairs = open_pairs[~is_taken]


def _sums(of_left, of_right, left, right):
    """Sums over the points that pairs share, (n_pairs,)."""
    if not len(left):  # of which scipy makes no array
        return np.empty(0)
    return np.asarray((of_left @ of_right.T)[left, right]).ravel()


def _ratios(images, points, places, left, right, n_common, ratio, squares):
    """Base over distance, (n_pairs,): by a plane where that fits clearly better.

    ``ratio`` and ``squares`` (sums of those of its errors) are of the similarity.
    """
    if not len(left):
        return ratio
    shape = (images.max() + 1, points.max() + 1)

    def of_images(values):
        return sparse.csr_array((values, (images, points)), shape=shape)

    x, y = places.real, places.imag
    of_left = [of_images(values) for values in monomials_of_left(x, y)]
    of_right = [of_images(values) for values in monomials_of_right(x, y)]
    sums = np.empty((len(left), OF_LEFT, OF_RIGHT))
    for i, one in enumerate(of_left):
        for k, other in enumerate(of_right):
            sums[:, i, k] = _sums(one, other, left, right)
    of_plane, by_plane = np.empty(len(left)), np.empty(len(left))
    for start in range(0, len(left), PAIRS_AT_ONCE):
        own = sums[start : start + PAIRS_AT_ONCE]
        middle = own[:, 1:3, 0] / own[:, :1, 0]
        homographies, errors = fit_homographies(own)
        by_plane[start : start + PAIRS_AT_ONCE] = errors
        found = base_ratios(homographies, middle)
        of_plane[start : start + PAIRS_AT_ONCE] = found
    # over their degrees of freedom: four unknowns, and eight
    similar, plane = squares / (2 * n_common - 4), by_plane / (2 * n_common - 8)
    return np.where(similar > BETTER**2 * plane, of_plane, ratio)


def _bases(images, points, places):
    """Pairs of images with common points, their number, and two of the similarity.

    These are base over height, and the sum of squares of its errors.
    """
    shape = (images.max(initial=-1) + 1, points.max(initial=-1) + 1)

    def of_images(values):
        return sparse.csr_array((values, (images, points)), shape=shape)

    ones, own = of_images(np.ones(len(places))), of_images(places)
    pairs = sparse.triu(ones @ ones.T, k=1).tocoo()
    order = np.lexsort((pairs.col, pairs.row))
    left, right = pairs.row[order], pairs.col[order]
    n_common = pairs.data[order].astype(int)
    if not len(left):  # of which scipy makes no array
        return left, right, n_common, np.empty(0), np.empty(0)
    sums, squares = own @ ones.T, of_images(np.abs(places) ** 2) @ ones.T
    products = own.conj() @ own.T
    squares_right = squares[right, left]
    mean_left, mean_right = sums[left, right] / n_common, sums[right, left] / n_common
    spread = squares[left, right] / n_common - np.abs(mean_left) ** 2
    shared = products[left, right] / n_common - mean_left.conj() * mean_right
    with np.errstate(divide="ignore", invalid="ignore"):
        turn = np.where(spread > 0.0, shared / spread, 0.0)
        base = np.abs(mean_right - turn * mean_left) / np.sqrt(np.abs(turn))
        spread_right = squares_right / n_common - np.abs(mean_right) ** 2
        errors = n_common * np.maximum(spread_right - np.abs(turn) ** 2 * spread, 0.0)
    return left, right, n_common, np.where(np.isfinite(base), base, 0.0), errors


def _are_best(left, right, score):
    """Whether a pair is among the best of one of its images, (n_pairs,)."""
    of_image = np.concatenate([left, right])
    pair = np.tile(np.arange(len(left)), 2)
    order = np.lexsort((pair, -score[pair], of_image))
    starts = np.searchsorted(of_image[order], of_image[order])
    is_best = np.zeros(len(left), dtype=bool)
    is_best[pair[order][np.arange(len(order)) - starts < N_PARTNERS]] = True
    return is_best


def _named(left, right):
    """Names of models by their images; numbers where these would be the same."""
    names = np.char.add(np.char.add(left.astype(str), "-"), right.astype(str))
    is_double = len(np.unique(names)) < len(names)
    return np.arange(1, len(names) + 1).astype(str) if is_double else names
