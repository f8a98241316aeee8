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
# residuals so small beside what their errors make are rounding, of which a part is as
# large as a gross error beside the rest
LEAST_S_0 = 0.1


@dataclass(frozen=True, eq=False)
class NumberedPoints(CommonPoints):
    """Common points that know which model points they are."""

    # (n,): rows of the table of model points, or what their covariances are asked by
    rows: np.ndarray

    @classmethod
    def of(cls, observed, weights, rows):
        """Points as a transformation has observed them, with weights of their own."""
        given = observed.source, observed.target, weights, observed.start
        return cls(*given, rows)

    def _taken(self, rows, start, *_):
        of_points = self.source, self.target, self.weights
        return NumberedPoints(*(a[rows] for a in of_points), start, self.rows[rows])


def tested_again(tests, fit, points, covariances, significance) -> PointTests:
    """Test models of which a point stands out, with the covariances of all points.

    ``points`` are the NumberedPoints of ``fit``, in which ``tests`` were made.
    ``covariances`` gives those of the errors behind the residuals for pairs of rows
    (n_pairs, 2): (n_pairs, 2, 2) [m²]. Models in space, and of more than MOST_POINTS
    points, keep their tests. Models are tested that would have a suspect at the
    ``significance``, and rarer ones.
    """
    w, p_value = tests.w.copy(), tests.p_value.copy()
    level = max(STANDS_OUT, significance)
    stands_out = is_rejected_by_holm(p_value, level, points.start)
    for models, rows, found in _plane_covariances(points, stands_out, covariances):
        design = design_of(fit, models, points, rows)
        again = correlated_point_tests(fit.residuals[rows], design, found)
        is_told = ~_are_rounding(fit.residuals[rows], found)
        w[rows[is_told]], p_value[rows[is_told]] = (
            values[is_told] for values in (again.w, again.p_value)
        )
    return PointTests(w, p_value)


def _are_rounding(residuals, covariances):
    """Whether residuals of models are far smaller than their errors, (n_models,)."""
    flat = residuals.reshape(len(residuals), -1, 1)
    squares = np.sum(flat * np.linalg.solve(covariances, flat), axis=(1, 2))
    return squares < LEAST_S_0**2 * flat.shape[1]


def tested_beside(tests, fit, kept, out, covariances) -> PointTests:
    """Test points that were taken out, each beside the points that ``fit`` has kept.

    As :func:`tested_again`; ``tests`` are those of the points ``out``.
    """
    w, p_value = tests.w.copy(), tests.p_value.copy()
    points, is_out, place = _merged(kept, out)
    for models, rows, found in _plane_covariances(points, is_out, covariances):
        of_rows = models, points, rows
        residuals = _residuals(fit, *of_rows)
        is_told = ~_are_rounding(residuals, found)
        given = residuals, design_of(fit, *of_rows), found
        of_told = (values[is_told] for values in (rows, *given))
        for at, *of_model in zip(*of_told, strict=True):
            for one in np.flatnonzero(is_out[at]):
                again = _with_one(one, is_out[at], *of_model)
                row = place[at[one]]
                w[row], p_value[row] = again
    return PointTests(w, p_value)


def _with_one(one, is_out, residuals, design, covariance):
    """Give w and P of one of the points that are out, beside all that are not."""
    take = np.flatnonzero(~is_out | (np.arange(len(is_out)) == one))
    numbers = (AXES_OF_A_POINT * take[:, None] + [0, 1]).ravel()
    block = covariance[np.ix_(numbers, numbers)]
    again = correlated_point_tests(residuals[take], design[take], block)
    last = np.flatnonzero(take == one)[0]
    f = AXES_OF_A_POINT * len(take) - design.shape[2]
    return _w_beside(again.w[last], f), again.p_value[last]


def _w_beside(w, redundancy):
    """Make w by the s_0 of the points beside it of one by the s_0 of all."""
    share = np.minimum(w**2 / redundancy, 1.0)
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


def _plane_covariances(points, is_asked, covariances):
    """Models in plan with points that are asked for, as :func:`model_covariances`.

    None whose covariances are hardly regular beside their rounding.
    """
    asked = segment_sum(is_asked.astype(np.int64), points.start) > 0
    is_plane = points.target.shape[1] == AXES_OF_A_POINT
    asked = np.flatnonzero(asked & is_plane)
    for models, rows, found in model_covariances(points, asked, covariances):
        eigenvalues = np.linalg.eigvalsh(found)
        is_regular = eigenvalues[:, 0] > LEAST_EIGENVALUE * eigenvalues[:, -1]
        if is_regular.any():
            yield models[is_regular], rows[is_regular], found[is_regular]


def model_covariances(points, models, covariances):
    """Covariances of all points of some models, those with as many points together.

    ``points`` are NumberedPoints, ``covariances`` as in :func:`tested_again`, of as
    many axes as the points have. Gives numbers of models (n,), their rows of ``points``
    (n, n_points) and the matrices of all their coordinates, (n, n_axes n_points,
    n_axes n_points) [m²]; no models of more than MOST_POINTS points, and none whose
    covariances are not known.
    """
    size = np.diff(points.start)
    for part in _in_parts(models[size[models] <= MOST_POINTS], size):
        alike = [part[size[part] == n] for n in np.unique(size[part])]
        rows = [points.start[g][:, None] + np.arange(size[g[0]]) for g in alike]
        upper = [np.triu_indices(own.shape[1]) for own in rows]
        pairs = [
            np.stack([own[:, one], own[:, two]], axis=-1)
            for own, (one, two) in zip(rows, upper, strict=True)
        ]
        asked = np.concatenate([each.reshape(-1, 2) for each in pairs])
        ends = np.cumsum([each.size // 2 for each in pairs])[:-1]
        found = np.split(covariances(points.rows[asked]), ends)
        for some, own, places, blocks in zip(alike, rows, upper, found, strict=True):
            of_models = blocks.reshape(len(some), -1, *blocks.shape[1:])
            is_known = np.isfinite(of_models).all(axis=(1, 2, 3))
            if is_known.any():
                full = _full(of_models[is_known], places, own.shape[1])
                yield some[is_known], own[is_known], full


def _in_parts(models, size):
    """Parts of models, sorted by size, with not many more pairs than fit in memory."""
    models = models[np.argsort(size[models], kind="stable")]
    n_pairs = np.cumsum(size[models].astype(float) ** 2 / 2.0)
    ends = np.flatnonzero(np.diff(n_pairs // PAIRS_AT_ONCE)) + 1
    return [part for part in np.split(models, ends) if len(part)]


def _full(blocks, places, n_points):
    """Matrices of the blocks of their upper triangles, (n, n_numbers, n_numbers)."""
    n_models, _, n_axes, _ = blocks.shape
    full = np.empty((n_models, n_points, n_points, n_axes, n_axes))
    first, second = places
    full[:, second, first] = blocks.transpose(0, 1, 3, 2)
    full[:, first, second] = blocks
    n_numbers = n_points * n_axes
    return full.transpose(0, 1, 3, 2, 4).reshape(n_models, n_numbers, n_numbers)


def _residuals(fit, models, points, rows):
    """Transformed minus given of points that need not have been fitted."""
    of_rows = np.repeat(models, rows.shape[1])
    residuals = fit.apply(of_rows, points.source[rows.ravel()])
    return residuals.reshape(*rows.shape, -1) - points.target[rows]


def design_of(fit, models, points, rows):
    """Derivatives of the ground coordinates of points by all parameters of models.

    Of rows (n_models, n_points): (n_models, n_points, n_axes, n_parameters), by the
    shift, then by the others.
    """
    of_rows = np.repeat(models, rows.shape[1])
    rest = sensitivity(fit, of_rows, points.source[rows.ravel()])
    n_axes = rest.shape[1]
    shift = np.broadcast_to(np.eye(n_axes), (len(rest), n_axes, n_axes))
    together = np.concatenate([shift, rest], axis=2)
    return together.reshape(*rows.shape, *together.shape[1:])
