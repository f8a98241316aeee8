"""What points with given coordinates say of the claimed figure."""

from dataclasses import dataclass

import numpy as np

from einschalt.pipeline.assessment.credibility import MIN_REPORTED_RATIO, TOTAL
from einschalt.theory.adjustment.global_tests import ratio_limits, ratio_p_value
from einschalt.theory.adjustment.significance import FINDING_SIGNIFICANCE

DIFFERENCES = ["difference_easting", "difference_northing"]


@dataclass(frozen=True, eq=False)
class KnownPoints:
    """Densified less given coordinates of known points, against what is claimed."""

    point_ids: np.ndarray  # shape (n_points,)
    differences: np.ndarray  # shape (n_points, 2) [m]
    # of the differences, since both coordinates have errors: TOTAL, root mean square
    # [m]; NaN where it is not known
    claimed: float

    @property
    def count(self):
        """Number of points."""
        return len(self.point_ids)

    @property
    def rms(self):
        """Root mean square of the differences, TOTAL [m]; NaN without points."""
        squares = np.sum(self.differences**2, axis=1)
        squares = squares[np.isfinite(squares)]
        return float(np.sqrt(squares.mean())) if len(squares) else np.nan

    @property
    def ratio(self):
        """Root mean square by the claimed one."""
        return self.rms / self.claimed

    @property
    def are_beyond(self):
        """Whether the differences are larger than chance explains."""
        return bool(self.ratio > self._limits()[1])

    @property
    def are_too_small(self):
        """Whether the differences are smaller than chance explains."""
        return bool(self.ratio < self._limits()[0])

    @property
    def p_value(self):
        """Probability of differences this large if the claim holds."""
        return float(ratio_p_value(self.ratio, 2 * self.count))

    def _limits(self):
        return ratio_limits(2 * self.count, FINDING_SIGNIFICANCE, MIN_REPORTED_RATIO)


def check_points(examined) -> KnownPoints:
    """Check points, which entered no fit."""
    points = examined.points
    return _compared(examined, points[points["role"] == "check"])


def control_points(examined) -> KnownPoints:
    """Control points that the result holds."""
    return _compared(examined, examined.held_control)


def _compared(examined, rows):
    differences = rows[DIFFERENCES].to_numpy(dtype=float)
    names = rows["point_id"].to_numpy(dtype=object)
    return KnownPoints(names, differences, _claimed(examined, rows))


def _claimed(examined, rows):
    """Total figure claimed for densified - given: both have an error."""
    given = examined.block.control_points
    variance = rows[examined.claimed_column].to_numpy(dtype=float) ** 2
    if examined.claimed_column == TOTAL:
        # given and densified share it, so that their difference is without
        variance = np.maximum(variance - examined.figures.shared_error**2, 0.0)
    if given is not None and "standard_error_m" in given:
        errors = given.set_index("point_id")["standard_error_m"].astype(float)
        variance = variance + np.nan_to_num(errors.reindex(rows["point_id"])) ** 2
    variance = variance[np.isfinite(variance)]
    return float(np.sqrt(variance.mean())) if len(variance) else np.nan
