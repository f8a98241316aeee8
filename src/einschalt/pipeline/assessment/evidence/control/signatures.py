"""What errors of control, and of model heights, make of control that is left out.

Errors that are tried are patterns: of single points, or of many together.
"""

from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property

import numpy as np
from scipy import sparse

from einschalt.stages.error_propagation.error_model import HIGH, LOW
from einschalt.theory.adjustment.pattern_tests import (
    estimate_scores_together,
    estimate_together,
    examine_patterns,
    examine_scores,
    scores_of,
)
from einschalt.theory.adjustment.point_operator import Axes
from einschalt.theory.adjustment.rows_of_chains import filled, rows_of_chains

PLAN, HEIGHT = (0, 1), (2,)


class Kind(StrEnum):
    """What kind of pattern it is."""

    POINT = "point"  # one point by itself
    STEP = "step"  # all points on one side of a line
    GROUP = "group"  # points wherever they lie, all by the same: a list
    BEND = "bend"  # a quadratic strain
    SCALE = "scale"  # heights of models against those of control


@dataclass(frozen=True, eq=False)
class Pattern:
    """Errors of control, for an amplitude of one; or of the heights of models."""

    kind: Kind
    of_control: np.ndarray  # shape (n_control,)
    flights: tuple[str, ...] = ()  # whose heights are out of scale


def covariance_of(chains, sizes, axes):
    """Covariance of quantities in some axes, (n_axes · n_points, n_axes · n_points).

    ``chains`` lead from each source, whose errors have the ``sizes``.
    """
    found, kind = 0.0, next(iter(chains.values())).axes
    for source, rows in _rows_in(axes, chains):
        found = found + _covariance(rows, kind.each(sizes[source]).ravel())
    if kind is Axes.COMPLEX:  # errors of both coordinates are alike
        return np.block([[found.real, -found.imag], [found.imag, found.real]])
    return found


def _rows_in(axes, chains):
    """Rows of chains in some axes, all points of one axis first, of each source."""
    any_chain = next(iter(chains.values()))
    n_numbers, kind = any_chain.shape[0], any_chain.axes
    places = np.arange(n_numbers)
    if kind is not Axes.COMPLEX:
        places = np.concatenate([places[axis :: kind.value] for axis in axes])
    # first of all: what the steps make of other rows is not wanted
    chosen = sparse.eye_array(n_numbers, format="csr")[places]
    for source, rows in rows_of_chains(chains, chosen):
        yield source, rows.matrix


def _covariance(rows, size):
    """Of rows times independent errors; many that are not 0 multiply faster in full."""
    is_sparse = sparse.issparse(rows)
    numbers = rows.data if is_sparse else rows
    # models that are not usable have no part, but 0 · NaN would be NaN
    if np.isfinite(numbers).all() and np.isfinite(size).all():
        rows = filled(rows)
    elif not is_sparse:
        rows = sparse.csr_array(rows)
    if not sparse.issparse(rows):
        scaled = rows * size
        return scaled @ scaled.conj().T
    rows = rows.tocsr(copy=True)
    rows.data *= size[rows.indices]
    return (rows @ rows.conj().T).toarray()


class Signatures:
    """Differences of control points that were left out, and where they come from.

    Arrays have all points of the first axis, then all of the next one.
    """

    def __init__(self, examined, left_out):
        self.examined, self.left_out = examined, left_out
        self.model = examined.error_model
        self.axes = self.model.axes
        self.control = examined.block.control_points

    def observed(self, axes):
        """Differences [m], shape (n_axes · n_points,)."""
        return self.left_out.all_differences[:, list(axes)].T.ravel()

    def covariance(self, axes):
        """Covariance of the differences [m²], of as many rows as ``observed``.

        In plan with control heights as they show themselves, which tilt models.
        """
        return self._in_plan if tuple(axes) == PLAN else self._in_height

    @cached_property
    def _in_plan(self):
        sizes = self.examined.model_with_shown_heights.standard_errors
        return covariance_of(self.left_out.chains, sizes, PLAN)

    @cached_property
    def _in_height(self):
        return covariance_of(self.left_out.chains, self.model.standard_errors, HEIGHT)

    def of(self, patterns, axes):
        """Differences that each pattern makes for amplitudes of one.

        Shape (n_patterns, n_axes · n_points, n_amplitudes): an amplitude for each axis.
        """
        of_control = np.stack([pattern.of_control for pattern in patterns], axis=1)
        chain = self.left_out.of_control
        columns = []
        for axis in axes:
            given = self.axes.unpacked(chain.apply(self._packed(of_control, axis)))
            columns.append(np.concatenate([given[:, a] for a in axes]))
        found = np.stack(columns, axis=-1).swapaxes(0, 1)
        for place, pattern in enumerate(patterns):
            if pattern.flights:
                found[place, :, 0] = self._out_of_scale(pattern.flights)
        return found

    def scale_of_errors(self, flights):
        """How far out of scale heights of flights seem to be by their errors alone.

        These are in the heights that a scale would enlarge, and in the differences as
        well: where the ground is flat within them, they make all of both.
        """
        shown = np.mean(self._out_of_scale(flights) ** 2)
        return float(self._height_variance / shown) if shown > 0.0 else np.inf

    @cached_property
    def _height_variance(self):
        """Variance of a difference in height, in the mean of all [m²]."""
        return np.trace(self.covariance(HEIGHT)) / len(self.left_out.point_ids)

    def moved(self, pattern, amplitude, axes):
        """What a pattern does to the new points, TOTAL of the axes, RMS [m]."""
        if pattern.flights:
            of_flights = self._points_from_flights()
            errors = sum(
                (self._through(of_flights, name) for name in pattern.flights), start=0.0
            )
            return self._of_new(amplitude[0] * self.axes.unpacked(errors), axes)
        return self.moved_by(np.outer(pattern.of_control, amplitude), axes)

    def moved_by(self, errors, axes):
        """What errors of control, (n_control, n_axes) [m], do to the new points.

        TOTAL of the axes, RMS [m].
        """
        packed = sum(
            self._packed(errors[:, [place]], axis) for place, axis in enumerate(axes)
        )
        found = self.axes.unpacked(self.model.from_control.apply(packed)[:, 0])
        return self._of_new(found, axes)

    def _of_new(self, found, axes):
        points = self.examined.means.points["point_id"]
        new = self.examined.points
        new = new.loc[new["role"] == "new", "point_id"]
        is_new = points.isin(new).to_numpy()
        squares = np.sum(found[is_new][:, list(axes)] ** 2, axis=1)
        return float(np.sqrt(np.nanmean(squares))) if is_new.any() else np.nan

    def _points_from_flights(self):
        """Final points from the measured coordinates of each flight."""
        model = self.model
        through = model.final @ model.low.ground @ model.high.mean
        return {
            HIGH: through @ model.high.operator.measured,
            LOW: model.final @ model.low.measured,
        }

    def _packed(self, columns, axis):
        """Errors of one axis, (n_control, n_patterns), as numbers of the operators."""
        if self.axes is Axes.COMPLEX:
            return columns * (1.0, 1j)[axis]
        packed = np.zeros((columns.shape[0] * self.axes.value, columns.shape[1]))
        packed[axis :: self.axes.value] = columns
        return packed

    def _out_of_scale(self, flights):
        """Differences in height where those of models are too large by themselves."""
        found = sum(
            (self._through(self.left_out.of_flights, name) for name in flights),
            start=0.0,
        )
        return self.axes.unpacked(found)[:, HEIGHT[0]]

    def _through(self, operators, flight):
        """What heights of a flight do that are larger by their own size."""
        return operators[flight].apply(self._heights_of(flight))

    def _heights_of(self, flight):
        """Heights of a flight's model points above their mean, as errors, packed."""
        points = self.examined.model_points[flight]
        fit = self.examined.low if flight == LOW else self.examined.high.transformation
        height = fit.values(points)["height"].to_numpy(dtype=float)
        errors = np.zeros((len(points), self.axes.value))
        errors[:, HEIGHT[0]] = np.nan_to_num(height - np.nanmean(height))
        return self.axes.packed(errors)


class Differences:
    """Control in some axes, less what is predicted without it."""

    def __init__(self, signatures, axes):
        self.signatures, self.axes = signatures, axes

    def tests(self, patterns, is_free):
        """Test patterns, each by itself: PatternTests or None."""
        try:
            return examine_patterns(*self._of(patterns, is_free))
        except np.linalg.LinAlgError:  # points without errors of their own
            return None

    def together(self, patterns, is_free):
        """Amplitudes of patterns that were tested, all at once."""
        return estimate_together(*self._of(patterns, is_free))

    def _of(self, patterns, is_free):
        signatures, axes = self.signatures, self.axes
        of_free = [Pattern(Kind.POINT, row) for row in np.eye(len(is_free))[is_free]]
        free = None
        if of_free:
            made = signatures.of(of_free, axes)
            free = np.moveaxis(made, 1, 0).reshape(made.shape[1], -1)
        shown = signatures.of(patterns, axes)
        return signatures.observed(axes), signatures.covariance(axes), shown, free

    def scores(self, patterns, is_free):
        """What is known of amplitudes of one axis: scores, and their information."""
        return scores_of(*self._of(patterns, is_free))


class Scores:
    """What all models know of control in plan, or of its heights."""

    def __init__(self, scores):
        self.known = scores

    def tests(self, patterns, is_free):
        """Test patterns, each by itself: PatternTests."""
        return examine_scores(*self._of(patterns, is_free))

    def together(self, patterns, is_free):
        """Amplitudes of patterns, all at once."""
        return estimate_scores_together(*self._of(patterns, is_free))

    def scores(self, patterns, is_free):
        """What is known of amplitudes of one axis: scores, and their information."""
        values, information, rows, free = self._of(patterns, is_free)
        if len(free):
            kept = self.known.without(is_free[self.known.places])
            values, information = kept.values, kept.information
            rows = rows[:, ~is_free[self.known.places]]
        return rows @ values[:, 0], rows @ information @ rows.T

    def _of(self, patterns, is_free):
        scores = self.known
        rows = np.stack([pattern.of_control for pattern in patterns])
        free = np.flatnonzero(is_free[scores.places])
        return scores.values, scores.information, rows[:, scores.places], free
