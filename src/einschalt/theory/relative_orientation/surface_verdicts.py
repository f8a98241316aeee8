"""What a model's figure of points is worth: safe, weak or critical, and why.

safe
    The terrain does not matter much: omega is less than twice as uncertain as in flat
    terrain.
weak
    It is 2 to 10 times as uncertain, or the points leave the elements uncertain
    whatever the terrain.
critical
    10 times and more, or the points do not determine the elements.

In a symmetrical valley the limits lie at 50 % and 90 % of the critical depth.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from einschalt.foundations import typesetting
from einschalt.foundations.language import Amount
from einschalt.theory.relative_orientation.parallax_equations import N_ELEMENTS

SAFE, WEAK, CRITICAL = range(3)
VERDICTS = ("safe", "weak", "critical")
WEAK_INFLATION = 2.0
CRITICAL_INFLATION = 10.0
ON_SURFACE_INFLATION = 1e6
ROUNDING = 1.0 - 1e-9
"""A valley at just half of its critical depth is weak, however it is rounded."""
WEAK_UNCERTAINTY = 2e3
"""A parallax error of 1e-4 of the depth turns a bundle by more than 0.2 rad."""
CRITICAL_UNCERTAINTY = 2e4
SHORT_BASE = 0.01
LONG_BASE = 10.0
THIN = 0.01
"""In depths: what is wrong with a figure is then blamed on its base, or its width."""


@dataclass(frozen=True)
class Cause:
    """Why a verdict falls."""

    level: int
    reason: str


NEAR_SURFACE = (
    "its points lie near a dangerous surface, "
    "where omega is {inflation} times as uncertain as on flat terrain"
)
CAUSES = {
    "safe": Cause(SAFE, ""),
    "too_few": Cause(CRITICAL, "{n_points:point|points}, but five are needed"),
    "not_located": Cause(CRITICAL, "a point has no coordinates, or impossible ones"),
    "behind": Cause(
        CRITICAL, "a point lies at or above the projection centres, z >= 0"
    ),
    "no_base": Cause(CRITICAL, "it has no base"),
    "short_base": Cause(CRITICAL, "its base is less than a hundredth of its depth"),
    "long_base": Cause(CRITICAL, "its base is more than ten times its depth"),
    "no_figure": Cause(
        CRITICAL,
        "its points lie on a line or close together, and do not determine the elements",
    ),
    "on_surface": Cause(
        CRITICAL,
        "its points lie on a dangerous surface, and do not determine the elements",
    ),
    "at_surface": Cause(CRITICAL, NEAR_SURFACE),
    "lost": Cause(CRITICAL, "its points do not determine the elements"),
    "only_relief": Cause(
        WEAK, "only its relief lets the points determine the elements"
    ),
    "thin_figure": Cause(WEAK, "its points lie nearly on a line or close together"),
    "near_surface": Cause(WEAK, NEAR_SURFACE),
    "weak_figure": Cause(
        WEAK, "its points cover too little of the model, or its base is short"
    ),
}


@dataclass(frozen=True, eq=False)
class Figure:
    """What is judged, one value per model, ndarray of shape (n_models,)."""

    n_points: np.ndarray  # of int
    relative_base: np.ndarray  # base over depth
    # both of bool: a point lies at or above the base; all points have coordinates
    is_behind: np.ndarray
    is_located: np.ndarray
    # standard deviation of the points across their line of best fit, over depth
    width: np.ndarray
    inflation: np.ndarray  # sigma(omega) over that of the flat twin
    # both: largest standard error of a correction of unit length, for parallax errors
    # of 1 depth: of the model, and of its flat twin
    uncertainty: np.ndarray
    flat_uncertainty: np.ndarray


@dataclass(frozen=True, eq=False)
class SurfaceVerdict:
    """Verdicts on all models."""

    level: np.ndarray  # of int, (n_models,): SAFE, WEAK or CRITICAL
    cause: np.ndarray  # of int, (n_models,): place in ``CAUSES``
    figure: Figure  # what was judged

    @property
    def names(self):
        """Texts safe, weak or critical, ndarray of object, shape (n_models,)."""
        return np.array(VERDICTS, dtype=object)[self.level]

    @cached_property
    def reasons(self):
        """Why it is not safe, ndarray of object, shape (n_models,); empty where it is.

        A sentence without its full stop.
        """
        reasons = np.full(len(self.cause), "", dtype=object)
        causes = tuple(CAUSES.values())
        for model in np.flatnonzero(self.level != SAFE):
            reasons[model] = causes[self.cause[model]].reason.format(
                n_points=Amount(self.figure.n_points[model]),
                inflation=typesetting.number(self.figure.inflation[model]),
            )
        return reasons


def judge(figure):
    """Judge the figures of all models; of several causes the first one counts."""
    has_base = (figure.relative_base > 0.0) & np.isfinite(figure.relative_base)
    is_thin = figure.width < THIN
    is_lost = figure.uncertainty > CRITICAL_UNCERTAINTY
    is_lost_in_plane = figure.flat_uncertainty > CRITICAL_UNCERTAINTY
    is_weak = figure.uncertainty > WEAK_UNCERTAINTY
    is_weak_in_plane = figure.flat_uncertainty > WEAK_UNCERTAINTY
    is_near = figure.inflation >= WEAK_INFLATION * ROUNDING
    is_at = figure.inflation >= CRITICAL_INFLATION * ROUNDING
    conditions = {
        "too_few": figure.n_points < N_ELEMENTS,
        "not_located": ~figure.is_located,
        "behind": figure.is_behind,
        "no_base": ~has_base,
        "short_base": is_lost & is_lost_in_plane & (figure.relative_base < SHORT_BASE),
        "long_base": figure.relative_base > LONG_BASE,
        "no_figure": (is_lost & is_lost_in_plane) | (is_thin & (is_lost | is_at)),
        "on_surface": figure.inflation > ON_SURFACE_INFLATION,
        "at_surface": is_at,
        "lost": is_lost,
        "only_relief": is_lost_in_plane,
        "thin_figure": is_thin & (is_weak | is_near),
        "weak_figure": is_weak & (is_weak_in_plane | ~is_near),
        "near_surface": is_near,
    }
    causes = [list(CAUSES).index(name) for name in conditions]
    cause = np.select(list(conditions.values()), causes, default=0)
    level = np.array([found.level for found in CAUSES.values()])[cause]
    return SurfaceVerdict(level, cause, figure)
