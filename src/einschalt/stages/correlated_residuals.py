"""Points of models that stand out, tested again with what their errors share.

The tests of all models take points for independent: what neighbours share, their model
takes up. That is not so where approximate coordinates come from several models of the
high flight and one of them is weak: its points lie off together, and look like gross
errors or hide them. The tests with all covariances are made where something stands out.
"""

from dataclasses import dataclass

import numpy as np

from einschalt.foundations.batches import segment_sum, segments
from einschalt.theory.adjustment.correlated_point_tests import correlated_point_tests
from einschalt.theory.adjustment.multiple_testing import is_rejected_by_holm
from einschalt.theory.adjustment.reliability import AXES_OF_A_POINT, PointTests
from einschalt.theory.transformation.point_tests import CommonPoints
from einschalt.theory.transformation.sensitivity import sensitivity

# a model is tested again if its worst point is so rare among all of them: of models in
# which nothing is wrong one in twenty is, which costs time only
STANDS_OUT = 0.05
# what more points share, each of them hardly depends on; and their covariances take
# the square of their number
MOST_POINTS = 300
PAIRS_AT_ONCE = 200_000
LEAST_EIGENVALUE = 1e-12  # of the largest one


@dataclass(frozen=True, eq=False)
class NumberedPoints(CommonPoints):
    """Common points that know which model points they are."""

    rows: np.ndarray  # (n,): rows of the table of model points

    def _taken(self, rows, start, *_):
        of_points = self.source, self.target, self.weights
        return NumberedPoints(*(a[rows] for a in of_points), start, self.rows[rows])


def tested_again(tests, fit, points, covariances) -> PointTests:
    """Test models of which a point stands out, with the covariances of all points.

    ``points`` are the NumberedPoints of ``fit``, in which ``tests`` were made.
    ``covariances`` gives those of the errors behind the residuals for pairs of rows
    (n_pairs, 2): (n_pairs, 2, 2) [m²]. Models in space, and of more than MOST_POINTS
    points, keep their tests.
    """
    w, p_value = tests.w.copy(), tests.p_value.copy()
    stands_out = is_rejected_by_holm(p_value, points.start, STANDS_OUT)
    for model, rows, block in _plane_blocks(points, stands_out, covariances):
        residuals, design = fit.residuals[rows], design_of(fit, model, points, rows)
        again = correlated_point_tests(residuals, design, block)
        w[rows], p_value[rows] = again.w, again.p_value
    return PointTests(w, p_value)


def tested_beside(tests, fit, kept, out, covariances) -> PointTests:
    """Test points that were taken out, each beside the points that ``fit`` has kept.

    As :func:`tested_again`; ``tests`` are those of the points ``out``.
    """
    w, p_value = tests.w.copy(), tests.p_value.copy()
    points, is_out, place = _merged(kept, out)
    for model, rows, block in _plane_blocks(points, is_out, covariances):
        residuals = _residuals(fit, model, points, rows)
        design = design_of(fit, model, points, rows)
        is_beside = is_out[rows]
        for one in np.flatnonzero(is_beside):
            take = np.flatnonzero(~is_beside | (np.arange(len(is_beside)) == one))
            last = np.flatnonzero(take == one)[0]
            numbers = (AXES_OF_A_POINT * take[:, None] + [0, 1]).ravel()
            again = correlated_point_tests(
                residuals[take], design[take], block[np.ix_(numbers, numbers)]
            )
            f = AXES_OF_A_POINT * len(take) - design.shape[2]
            at = place[rows][one]
            w[at], p_value[at] = _w_beside(again.w[last], f), again.p_value[last]
    return PointTests(w, p_value)


def _w_beside(w, redundancy):
    """Make w by the s_0 of the points beside it of one by the s_0 of all."""
    share = w**2 / redundancy
    with np.errstate(divide="ignore"):  # all others fit exactly
        return np.sqrt(share / (1.0 - share) * (redundancy - AXES_OF_A_POINT))


def _merged(kept, out):
    """Points of both, sorted by model; which are of the second, and of which row."""
    model = np.concatenate([kept.model, out.model])
    sort = segments(model, len(kept.start) - 1)
    arrays = (
        np.concatenate([getattr(points, name) for points in (kept, out)])[sort.order]
        for name in ("source", "target", "weights")
    )
    rows = np.concatenate([kept.rows, out.rows])[sort.order]
    place = sort.order - len(kept.rows)
    return NumberedPoints(*arrays, sort.start, rows), place >= 0, place


def _plane_blocks(points, is_asked, covariances):
    """Models in plan with points that are asked for, as :func:`model_covariances`.

    None whose covariances are hardly regular beside their rounding.
    """
    asked = segment_sum(is_asked.astype(np.int64), points.start) > 0
    is_plane = points.target.shape[1] == AXES_OF_A_POINT
    models = np.flatnonzero(asked & is_plane)
    for model, rows, block in model_covariances(points, models, covariances):
        eigenvalues = np.linalg.eigvalsh(block)
        if eigenvalues[0] > LEAST_EIGENVALUE * eigenvalues[-1]:
            yield model, rows, block


def model_covariances(points, models, covariances):
    """Covariances of all points of some models, one model after the other.

    ``points`` are NumberedPoints, ``covariances`` as in :func:`tested_again`, of as
    many axes as the points have. Gives the number of a model, its rows of ``points``
    and the matrix of all their coordinates [m²]; no models of more than MOST_POINTS
    points, and none whose covariances are not known.
    """
    size = np.diff(points.start)
    for part in _in_parts(models[size[models] <= MOST_POINTS], size):
        upper = [np.triu_indices(size[model]) for model in part]
        first = points.start[part]
        pairs = [
            points.rows[own + np.transpose(places)]
            for own, places in zip(first, upper, strict=True)
        ]
        ends = np.cumsum([len(each) for each in pairs])[:-1]
        found = np.split(covariances(np.concatenate(pairs)), ends)
        for model, places, blocks in zip(part, upper, found, strict=True):
            if np.isfinite(blocks).all():
                rows = np.arange(points.start[model], points.start[model + 1])
                yield model, rows, _full(blocks, places, len(rows))


def _in_parts(models, size):
    """Parts of models, none of them with many more pairs than fit in memory."""
    n_pairs = np.cumsum(size[models].astype(float) ** 2 / 2.0)
    ends = np.flatnonzero(np.diff(n_pairs // PAIRS_AT_ONCE)) + 1
    return [part for part in np.split(models, ends) if len(part)]


def _full(blocks, places, n_points):
    """Matrix of the blocks of its upper triangle."""
    n_axes = blocks.shape[1]
    full = np.empty((n_points, n_points, n_axes, n_axes))
    first, second = places
    full[second, first] = blocks.transpose(0, 2, 1)
    full[first, second] = blocks
    return full.transpose(0, 2, 1, 3).reshape(n_points * n_axes, -1)


def _residuals(fit, model, points, rows):
    """Transformed minus given of points that need not have been fitted."""
    of_model = np.full(len(rows), model)
    return fit.apply(of_model, points.source[rows]) - points.target[rows]


def design_of(fit, model, points, rows):
    """Derivatives of the ground coordinates of points by all parameters of a model.

    (n_rows, n_axes, n_parameters): by the shift, then by the others.
    """
    rest = sensitivity(fit, np.full(len(rows), model), points.source[rows])
    n_axes = rest.shape[1]
    shift = np.broadcast_to(np.eye(n_axes), (len(rows), n_axes, n_axes))
    return np.concatenate([shift, rest], axis=2)
