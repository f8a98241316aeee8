"""What differences at known points share, as the propagation knows it.

Densified coordinates of neighbours have the errors of their high-flight models in
common, and those of control. So their differences to given coordinates tell less than
as many independent ones: of their size, and of their mean.

See docs/theory/claim.md.
"""

from dataclasses import dataclass

import numpy as np

from einschalt.foundations.names import encode
from einschalt.pipeline.assessment.evidence.control.signatures import (
    PLAN,
    covariance_of,
)
from einschalt.stages.error_propagation.given_points import (
    CONTROL_POINTS,
    GROUPS,
    errors_of_control,
)
from einschalt.theory.adjustment.least_squares import SQRT2
from einschalt.theory.adjustment.point_operator import selection

MOST_POINTS = 300
"""Of which the covariances are computed; of more points these tell of all."""


@dataclass(frozen=True, eq=False)
class SharedDifferences:
    """How alike the errors of the differences at known points are."""

    degrees: float  # of freedom of the sum of their squares, by Satterthwaite
    # of the mean difference, shape (2, 2), where the mean square is 1, TOTAL
    covariance_of_mean: np.ndarray


def shared_differences(examined, point_ids) -> SharedDifferences | None:
    """Tell how alike the differences at known points are, by the model of errors.

    That of the two steps: of one adjustment covariances between points are not kept.
    None where sizes of errors are not known, or nothing is left of the differences.
    """
    two_step = examined.two_step
    n = len(point_ids)
    if not two_step.is_possible or two_step.error_model is None or n < 2:
        return None
    few = np.unique(np.linspace(0, n - 1, min(n, MOST_POINTS)).astype(int))
    covariance = covariance_in_plan(two_step, np.asarray(point_ids)[few])
    if covariance is None:
        return None
    total = np.trace(covariance)
    if not (np.isfinite(covariance).all() and total > 0.0):
        return None
    return _of_all(covariance / (total / len(few)), n)


def _of_all(covariance, n):
    """Of ``n`` points, by the covariance of some; their mean square is 1, TOTAL."""
    m = len(covariance) // 2
    of_pairs = covariance.reshape(2, m, 2, m).transpose(1, 3, 0, 2)  # (m, m, 2, 2)
    is_own = np.eye(m, dtype=bool)
    own, between = of_pairs[is_own], of_pairs[~is_own]
    n_pairs = n * (n - 1.0) / (m * (m - 1.0))
    squares = n / m * np.sum(own**2) + n_pairs * np.sum(between**2)
    of_sum = n / m * own.sum(axis=0) + n_pairs * between.sum(axis=0)
    return SharedDifferences(float(n**2 / squares), of_sum / n**2)


def covariance_in_plan(two_step, point_ids):
    """Covariance of densified minus given coordinates in two steps.

    (2 n_points, 2 n_points), all eastings first [m²]. None where a point is one of
    another solution, or sizes are not known.
    """
    model, means = two_step.error_model, two_step.means.points["point_id"]
    places = encode(means).locate(encode(point_ids))
    if places.min() < 0:
        return None
    pick = selection(places, len(means), model.axes)
    chains = {name: pick @ chain for name, chain in model.chains.items()}
    densified = Densified(chains, model.standard_errors, two_step.group_error)
    return covariance_of_differences(
        two_step.block, point_ids, model.axes, PLAN, densified
    )


@dataclass(frozen=True, eq=False)
class Densified:
    """What the errors of densified points come from; nothing of it where left out."""

    chains: dict  # from each source to the points
    standard_errors: dict  # of each source, per coordinate [m]
    group_error: float  # shift that given points of a group share, TOTAL [m]
    # whether it holds of these axes where no size was stated: it is estimated in plan
    is_group_error_known: bool = True


def covariance_of_differences(block, point_ids, axes, in_axes, densified):
    """Covariance of densified minus given coordinates of control and check points.

    What both have in common, as errors of control and shifts of groups, is in the
    difference only once.

    Parameters
    ----------
    block : Block
    point_ids : array_like of str
        Points with given coordinates.
    axes : Axes
        Of the operators.
    in_axes : tuple of int
        Axes that are wanted: PLAN or HEIGHT.
    densified : Densified

    Returns
    -------
    ndarray, shape (n_axes · n_points, n_axes · n_points)
        All of one axis first [m²]. None where a point has no given coordinates, and
        where shifts of groups have no known size.
    """
    names = encode(block.control_points["point_id"])
    places = names.locate(encode(point_ids))
    if places.min() < 0:
        return None
    given = errors_of_control(block, axes)
    unknown = given.to_be_estimated
    is_known = densified.is_group_error_known or unknown in densified.standard_errors
    if unknown and not is_known:
        return None
    given = given.picked(selection(places, len(block.control_points), axes))
    sizes = {**given.sizes, **densified.standard_errors}
    groups = GROUPS[CONTROL_POINTS]
    if groups in given.sizes and groups not in densified.standard_errors:
        size = densified.group_error / SQRT2
        sizes[groups] = np.full_like(given.sizes[groups], size)
    chains = {**densified.chains}
    for name, chain in given.chains.items():
        chains[name] = chains[name] - chain if name in chains else -chain
    return covariance_of(chains, sizes, in_axes)
