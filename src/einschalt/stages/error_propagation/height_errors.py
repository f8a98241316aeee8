"""How large errors of measured heights are, which nobody states: the models show it.

m_g is an error in plan. The z of a machine has another one, by the ratio of flying
height to base and by the operator's eye. How far the heights of a point in several
models differ, less what all other errors make of that, gives its ratio to m_g; where
points lie in one model each, the height residuals at the fitted points do.
"""

from dataclasses import replace

import numpy as np
from scipy import sparse

from einschalt.foundations.names import encode
from einschalt.stages.model_screening import suspect_rows
from einschalt.theory.adjustment.point_operator import Axes

MOST_DRAWS, FEWEST_DRAWS = 100, 10
NUMBERS_AT_ONCE = 3_000_000
HEIGHT = 2
# with fewer degrees of freedom the size is a guess
FEWEST_DEGREES = 3.0
# photographs that look down do not measure heights better than positions
LEAST_RATIO = 1.0
# times the median of what all other errors make of the squares
MOST_FROM_OTHERS = 10.0


def with_measured_heights(model, points, fits):
    """Give the z of machines an error of the size that the models show.

    ``model`` takes z to have the error of a coordinate in plan; ``points`` are the
    model points of flights with machine coordinates, the high one first. The same model
    in plan; None where nothing checks the heights of a flight.
    """
    for name, table in points.items() if model.axes is Axes.SPACE else ():
        heights = _Heights(name, table, fits[name])
        ratio = _ratio_to_plan(model, heights)
        if not np.isfinite(ratio):
            return None
        in_plan = model.standard_errors[name]
        sizes = in_plan[:, None] * [1.0, 1.0, ratio]
        model = replace(model, standard_errors={**model.standard_errors, name: sizes})
    return model


def _ratio_to_plan(model, heights):
    """Error of a measured height over that of a coordinate in plan."""
    name, sizes = heights.name, model.standard_errors
    none = {source: np.zeros(len(of_source)) for source, of_source in sizes.items()}
    in_plan = sizes[name][:, None] * [1.0, 1.0, 0.0]
    of_height = sizes[name][:, None] * [0.0, 0.0, 1.0]
    look = heights.differences if heights.n_repeated else heights.residuals
    from_others = _mean_squares(look(_drawn(model, {**sizes, name: in_plan})))
    if not len(from_others):  # no model has heights to spare
        return np.nan
    from_heights = _mean_squares(look(_drawn(model, {**none, name: of_height})))
    # a model that may tilt by metres tells nothing of centimetres
    told = from_others <= MOST_FROM_OTHERS * np.median(from_others)
    own = np.sum(from_heights[told])
    # what heights of equal errors make of the sum, in squares of one of them
    if own < FEWEST_DEGREES * np.mean(sizes[name] ** 2):
        return np.nan
    excess = np.sum((_mean_squares(look(None)) - from_others)[told])
    return max(np.sqrt(max(excess, 0.0) / own), LEAST_RATIO)


def _mean_squares(columns):
    """Squares of each row, on the average of the draws."""
    return np.mean(columns**2, axis=1)


def _drawn(model, sizes):
    n_numbers = max(model.low.measured.shape[0], 1)
    n_draws = int(np.clip(NUMBERS_AT_ONCE // n_numbers, FEWEST_DRAWS, MOST_DRAWS))
    model = replace(model, standard_errors=sizes)
    return model, model.draw(n_draws, seed=0)


class _Heights:
    """Heights of a flight, as they were measured or as errors move them."""

    def __init__(self, name, points, fit):
        self.name, self.observed, self.residual = name, fit.observed, fit.fit.residuals
        is_checked = fit.models["is_usable"].to_numpy() & (fit.fit.redundancy > 0)
        self.fitted = np.flatnonzero(
            np.repeat(is_checked, np.diff(self.observed.start))
        )
        values = fit.values(points)
        height = values["height"].to_numpy()
        is_good = np.isfinite(height) & ~suspect_rows(values, fit)
        self.rows = np.flatnonzero(is_good)
        self.values = height[self.rows, None]
        group = encode(points["point_id"].iloc[self.rows]).codes
        n_rows, n_groups = len(group), int(group.max(initial=-1)) + 1
        self.of_point = sparse.csr_array(
            (np.ones(n_rows), (np.arange(n_rows), group)), shape=(n_rows, n_groups)
        )
        self.n_repeated = n_rows - n_groups

    def differences(self, drawn):
        """Heights less the mean of their point, shape (n_rows, n_draws)."""
        values = self.values if drawn is None else self._of_flight(drawn)[self.rows]
        count = self.of_point.sum(axis=0)[:, None]
        values = values - values.mean(axis=0)  # large heights lose no digits
        return values - self.of_point @ ((self.of_point.T @ values) / count)

    def residuals(self, drawn):
        """Height residuals of fitted points, shape (n_fitted, n_draws)."""
        if drawn is None:
            return self.residual[self.fitted, HEIGHT, None]
        values = self._of_flight(drawn)[self.observed.row_numbers[self.fitted]]
        onto = self.observed.ground_rows[self.fitted]
        model, errors = drawn
        if model.is_last(self.name):
            return values - _heights(errors.ground)[model.places[onto]]
        return values - _heights(errors.control)[model.high.places[onto]]

    def _of_flight(self, drawn):
        model, errors = drawn
        return _heights(errors.low if model.is_last(self.name) else errors.high)


def _heights(numbers):
    return Axes.SPACE.unpacked(numbers)[:, HEIGHT]
