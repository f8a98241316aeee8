"""Which photographs make models: pairs with many common points and a good base.

A similarity between the image points that two photographs share leads from one image
into the other; how far it moves the principal point is the base in the image, and
divided by the principal distance the ratio of base and height above ground. Relief and
tilts change this little, and a choice needs no more.

All pairs are looked at together: the sums over common points are products of sparse
matrices, of images by points.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy import sparse

LEAST_COMMON = 8  # five elements of the orientation, and points that check them
LEAST_RATIO = 0.1  # a narrower base gives no heights, and many photographs have one
# from which base on a model is as good in height as it has to be: 60 % forward overlap
# of a wide-angle camera
FULL_RATIO = 0.6
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
        Base over height above ground.
    alone : list of str
        Photographs that are in no model.
    most_common : int
        Points that two photographs have in common, at most.
    """

    models: pd.DataFrame
    n_common: np.ndarray
    base_ratio: np.ndarray
    alone: list
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

    Returns
    -------
    ModelChoice
    """
    images, names = pd.factorize(image_points["image_id"], sort=True)
    points, _ = pd.factorize(image_points["point_id"])
    places = image_points["x"].to_numpy(float) + 1j * image_points["y"].to_numpy(float)
    left, right, n_common, base = _bases(images, points, places)
    ratio = base / principal_distance_mm
    most_common = int(n_common.max(initial=0))
    score = n_common * np.minimum(ratio, FULL_RATIO)
    is_possible = (n_common >= LEAST_COMMON) & (ratio >= LEAST_RATIO)
    left, right, n_common, ratio, score = (
        one[is_possible] for one in (left, right, n_common, ratio, score)
    )
    is_best = _are_best(left, right, score)
    left, right = left[is_best], right[is_best]
    models = pd.DataFrame(
        {
            "coverage": COVERAGE,
            "model_id": _named(names[left].astype(str), names[right].astype(str)),
            "left_image": names[left],
            "right_image": names[right],
        }
    )
    is_alone = ~np.isin(np.arange(len(names)), np.concatenate([left, right]))
    alone = [str(name) for name in names[is_alone]]
    n_common, ratio = n_common[is_best], ratio[is_best]
    return ModelChoice(models, n_common, ratio, alone, most_common)


def _bases(images, points, places):
    """Pairs of images with common points, their number, and the base [mm]."""
    shape = (images.max(initial=-1) + 1, points.max(initial=-1) + 1)

    def of_images(values):
        return sparse.csr_array((values, (images, points)), shape=shape)

    ones, own = of_images(np.ones(len(places))), of_images(places)
    pairs = sparse.triu(ones @ ones.T, k=1).tocoo()
    order = np.lexsort((pairs.col, pairs.row))
    left, right = pairs.row[order], pairs.col[order]
    n_common = pairs.data[order].astype(int)
    if not len(left):  # of which scipy makes no array
        return left, right, n_common, np.empty(0)
    sums, squares = own @ ones.T, of_images(np.abs(places) ** 2) @ ones.T
    products = own.conj() @ own.T
    mean_left, mean_right = sums[left, right] / n_common, sums[right, left] / n_common
    spread = squares[left, right] / n_common - np.abs(mean_left) ** 2
    shared = products[left, right] / n_common - mean_left.conj() * mean_right
    with np.errstate(divide="ignore", invalid="ignore"):
        turn = np.where(spread > 0.0, shared / spread, 0.0)
        base = np.abs(mean_right - turn * mean_left) / np.sqrt(np.abs(turn))
    return left, right, n_common, np.where(np.isfinite(base), base, 0.0)


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
