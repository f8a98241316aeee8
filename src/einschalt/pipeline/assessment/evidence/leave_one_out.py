"""Leave-one-out over control: every control point once as if it were a check point.

Nothing is computed again. A fit without a point is the fit in which the point's target
is its own prediction, and that follows from residual and leverage; the rest follows
from the operators of the propagation. So one pass leaves out every point, each from all
models of both flights. Weights stay those of the whole block.

See docs/theory/claim.md.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pandas as pd
from scipy import sparse
from scipy.special import ndtr  # scipy.stats takes a second to import

from einschalt.foundations.frame_columns import PLAN, values_of, with_columns
from einschalt.foundations.names import encode
from einschalt.stages.error_propagation.covariances import propagate
from einschalt.stages.error_propagation.error_model import (
    HIGH,
    LOW,
    add_flight_sources,
)
from einschalt.theory.adjustment.multiple_testing import is_rejected_by_holm
from einschalt.theory.adjustment.point_operator import (
    PointOperator,
    on_diagonal,
    selection,
)

# what is left of a residual where the other points alone just determine the model
LEAST_REDUNDANCY = 1e-6
HEIGHT = 2
COLUMNS = [
    *("difference_easting", "difference_northing"),
    *("standard_error_easting", "standard_error_northing", "covariance_en"),
    *("standard_error_total", "w", "p_value"),
]


@dataclass(frozen=True, eq=False)
class LeftOutControl:
    """Control points predicted without themselves."""

    point_ids: np.ndarray  # shape (n_points,)
    # shape (n_points, n_axes); densified without the point, minus given [m]
    all_differences: np.ndarray
    chains: dict  # the differences from the errors of all sources
    of_control: PointOperator  # the same from those of the given coordinates
    of_flights: dict  # the same from those of each flight's measured coordinates
    all_covariance: np.ndarray  # shape (n_points, n_axes, n_axes); of the differences

    @property
    def differences(self) -> np.ndarray:
        """In plan, shape (n_points, 2) [m]."""
        return self.all_differences[:, : len(PLAN)]

    @property
    def covariance(self) -> np.ndarray:
        """Of the differences in plan, shape (n_points, 2, 2) [m²]."""
        return self.all_covariance[:, : len(PLAN), : len(PLAN)]

    @property
    def has_heights(self) -> bool:
        """Whether heights were predicted as well."""
        return self.all_differences.shape[1] > HEIGHT

    @property
    def of_heights(self) -> tuple[np.ndarray, np.ndarray]:
        """Differences in height, and their standard errors, (n_points,) each [m]."""
        variance = self.all_covariance[:, HEIGHT, HEIGHT]
        return self.all_differences[:, HEIGHT], np.sqrt(variance)

    @cached_property
    def squares(self) -> np.ndarray:
        """Square d V⁻¹ d of each difference, shape (n_points,); 2 on the average."""
        solved = np.linalg.solve(self.covariance, self.differences[:, :, None])
        return np.einsum("ni,ni->n", self.differences, solved[:, :, 0])

    @property
    def normalized_square(self) -> float:
        """Mean square of the differences by their covariances; 1 is expected."""
        return float(np.mean(self.squares) / 2.0)


def leave_out_control(examined):
    """Predict each control point of the high flight from all the others.

    None after iteration, without a high flight, or where sizes of errors are not known.
    Points without which a model is not determined are not among them.
    """
    model = examined.error_model
    if examined.iteration is not None or model is None or model.high is None:
        return None
    parts = _Prediction(examined, model)
    if not len(parts.rows):
        return None
    names = examined.block.control_points["point_id"].to_numpy(dtype=object)[parts.rows]
    of_control = parts.of_control()
    chains = parts.chains(of_control)
    found = propagate(names, chains, model.standard_errors)
    return LeftOutControl(
        *(names, parts.differences(), chains, of_control, parts.of_flights),
        found.covariance,
    )


def left_out_table(left_out, significance):
    """Differences of control points that were left out, with their tests.

    point_id, COLUMNS: differences, their standard errors and covariance [m, m²], w
    (length by standard errors), p_value; is_suspect (Holm over all points); of spatial
    models also difference_height, standard_error_height [m], p_value_height. No rows
    where nothing was left out.
    """
    if left_out is None:
        empty = pd.DataFrame(columns=["point_id", *COLUMNS], dtype=float)
        return empty.astype({"point_id": str}).assign(is_suspect=False)
    variance = left_out.covariance
    east, north = variance[:, 0, 0], variance[:, 1, 1]
    p_value = np.exp(-left_out.squares / 2.0)
    columns = (
        *left_out.differences.T,
        *(np.sqrt(east), np.sqrt(north), variance[:, 0, 1], np.sqrt(east + north)),
        *(np.sqrt(left_out.squares), p_value),
    )
    table = pd.DataFrame({"point_id": left_out.point_ids})
    table = with_columns(
        table,
        **dict(zip(COLUMNS, columns, strict=True)),
        is_suspect=is_rejected_by_holm(p_value, significance),
    )
    if not left_out.has_heights:
        return table
    height, error = left_out.of_heights
    table["difference_height"], table["standard_error_height"] = height, error
    table["p_value_height"] = 2.0 * ndtr(-np.abs(height / error))
    return table


def heights_left_out(table, column):
    """Differences in height of points that are no suspects: DataFrame by point_id.

    ``table`` has point_id, is_suspect and, of spatial models, ``column`` [m].
    """
    if column not in table:
        return pd.DataFrame({"height": np.array([])})
    good = table[~table["is_suspect"].to_numpy(dtype=bool)].set_index("point_id")
    return good[[column]].set_axis(["height"], axis=1).astype(np.float64)


def left_out_heights(two_step):
    """As its ``left_out_differences``, in height; without rows in the plane."""
    return heights_left_out(two_step.control_left_out, "difference_height")


class _Prediction:
    """Operators that predict control points without themselves.

    ``rows`` are those points in the table of control. Their predictions are
    ``of_values`` times the values of the low flight, plus ``of_ground`` times the
    approximate coordinates, plus ``of_misfits`` times the residuals of the high
    flight: what its models become without the point.
    """

    def __init__(self, examined, model):
        self.examined, self.model, self.axes = examined, model, model.axes
        high = examined.high.transformation
        self.high_fit = _Fitted(high.observed, model.high.operator)
        self.control_of_fitted = model.high.places[high.observed.ground_rows]
        control = encode(examined.block.control_points["point_id"])
        self.n_control = len(control)
        at_final = encode(examined.means.points["point_id"]).locate(control)
        at_ground = encode(examined.high.points["point_id"]).locate(control)
        is_used = np.zeros(self.n_control, dtype=bool)
        is_used[self.control_of_fitted] = True
        is_used[self.control_of_fitted[~self.high_fit.is_spare]] = False
        self.rows = np.flatnonzero(is_used & (at_final >= 0) & (at_ground >= 0))
        self._leave_out_of_low_flight(at_final)
        self.at_ground = at_ground[self.rows]
        self._combine()

    def _leave_out_of_low_flight(self, at_final):
        final = self.model.final
        at_rows = selection(at_final[self.rows], final.n_points, self.axes)
        picked = (at_rows @ final).formed()
        used = picked.used_sources
        low_fit = _Fitted(self.examined.low.observed, self.model.low, used)
        is_bound = picked.depends_on(low_fit.rows[~low_fit.is_spare])
        self.rows, self.used = self.rows[~is_bound], used
        keep = selection(np.flatnonzero(~is_bound), len(is_bound), self.axes)
        self.final = (keep @ picked).tocsr()
        self.of_values = (self.final @ low_fit.predicting()).tocsr()

    def _combine(self):
        model = self.model
        own = selection(self.at_ground, model.low.ground.n_sources, self.axes)
        shared = (self.final - self.of_values).row_sums()
        self.of_ground = (shared @ own).formed()
        through_values = (self.of_values @ model.low.ground).formed()
        self.through = (through_values + self.of_ground).tocsr()
        effect = (self.through @ model.high.mean @ self.high_fit.hat).tocsr()
        place = np.full(self.n_control, -1)
        place[self.rows] = np.arange(len(self.rows))
        of_fitted = place[self.control_of_fitted]
        fitted = np.flatnonzero(of_fitted >= 0)
        is_own = sparse.csr_array(
            (np.ones(len(fitted)), (of_fitted[fitted], fitted)),
            shape=(len(self.rows), len(of_fitted)),
        )
        own_effect = effect.masked(is_own)
        self.of_misfits = (own_effect @ self.high_fit.enlarging()).tocsr()

    @cached_property
    def of_flights(self):
        """Of the measured coordinates of each flight, the differences."""
        return {
            HIGH: (self._of_high_values @ self.model.high.operator.measured).formed(),
            LOW: (self.of_values @ self.model.low.measured).formed(),
        }

    @cached_property
    def _of_high_values(self):
        picked = (self.of_misfits @ self.high_fit.picked).formed()
        return ((self.through @ self.model.high.mean).formed() + picked).tocsr()

    def of_control(self):
        """Of the given coordinates of control, the differences."""
        model, misfits = self.model, self.of_misfits
        on_control = selection(self.control_of_fitted, self.n_control, self.axes)
        given = selection(self.rows, self.n_control, self.axes)
        of_fits = (self._of_high_values @ model.high.operator.ground).formed()
        of_fits = of_fits - (misfits @ on_control).formed()
        return (of_fits - given).tocsr()

    def chains(self, of_control):
        """Of each source, the differences as one product."""
        model, measured = self.model, self.of_flights
        given = model.high.control.picked(of_control).chains
        chains = {name: chain.tocsr() for name, chain in given.items()}
        for name, own in ((HIGH, model.high.own), (LOW, model.own)):
            chains = add_flight_sources(chains, measured[name], own)
        return chains

    def differences(self):
        """Predicted minus given coordinates, shape (n_points, n_axes) [m]."""
        examined = self.examined
        names = list(self.axes.names)
        given = values_of(examined.block.control_points, names)[self.rows]
        origin = given.mean(axis=0)
        points = examined.model_points[LOW]
        values = np.zeros((len(points), len(names)))
        fitted = examined.low.transform(points.iloc[self.used])
        values[self.used] = values_of(fitted, names) - origin
        ground = values_of(examined.high.points, names) - origin
        # models that are not usable have no part, but would spread their NaN
        misfits = np.nan_to_num(examined.high.transformation.fit.residuals)
        found = (
            self.of_values.of_vectors(values)
            + self.of_ground.of_vectors(ground)
            + self.of_misfits.of_vectors(misfits)
        )
        return found - (given - origin)


class _Fitted:
    """Fitted points of a flight, and what its models are without each of them."""

    def __init__(self, observed, operator, rows=None):
        self.measured, self.axes = operator.measured, operator.measured.axes
        self.n_rows = self.measured.n_points
        self.rows = observed.row_numbers
        if rows is not None:
            self.rows = self.rows[np.isin(self.rows, rows)]
        self.picked = selection(self.rows, self.n_rows, self.axes)
        own = self._own_blocks()
        self._unit = np.eye(own.shape[1], dtype=own.dtype)
        rest = self._unit - own
        smallest = np.linalg.svd(rest, compute_uv=False)[:, -1]
        self.is_spare = smallest > LEAST_REDUNDANCY
        rest[~self.is_spare] = self._unit
        self._enlarged = np.linalg.inv(rest)

    @property
    def hat(self):
        """What the values of all rows take from the targets of the fitted points."""
        own = selection(np.arange(self.n_rows), self.n_rows, self.axes)
        return ((own - self.measured) @ self.picked.T).finite()

    def _own_blocks(self):
        of_rows = self.picked - (self.picked @ self.measured).formed()
        return of_rows.finite().blocks_at(np.arange(len(self.rows)), self.rows)

    def enlarging(self):
        """Errors of prediction from residuals: (I − H)⁻¹ of each fitted point."""
        return on_diagonal(self._enlarged)

    def predicting(self):
        """Let all values be predicted without their own points, but for a share.

        The prediction is B x + (I − B) x₀ of the value x and the target x₀, with B =
        (I − H)⁻¹: this is B.
        """
        blocks = np.tile(self._unit, (self.n_rows, 1, 1))
        blocks[self.rows] = self._enlarged
        return on_diagonal(blocks)
