"""Whether models hold enough points to be planned, and what would give them enough."""

import math
from dataclasses import dataclass

import numpy as np

from einschalt.foundations.errors import GeometryError
from einschalt.foundations.typesetting import number, per_cent, scale
from einschalt.pipeline.planning.flights.arguments import RANGES
from einschalt.theory.planning.leverage import LEAST_POINTS

MOST_ON_THE_GROUND = 0.5
"""Of the points: where as many are control, most of the work is done on the ground, and
the rest would be surveyed there as well, and better, with the instrument at hand."""
BELOW = 1.0 + 1e-9
"""Heights that stand on the limit are kept, whatever their last digit."""
MORE = 1.001  # of an advised number: what lies on a limit is not above it
STEP_DOWN = 0.95  # of a spacing, to the next that is tried, as of heights upwards


def require_points(model, scale_number, spacing):
    """Refuse combinations whose models hold too few points to plan anything.

    Of every scale number with every spacing: one that is larger than a model, or fewer
    points in a model than the transformation needs, is a GeometryError.
    """
    smallest, widest = float(np.min(scale_number)), float(np.max(spacing))
    along, across = (smallest * side for side in model.extent)
    n_points = float(model.n_points(smallest, widest))
    least = LEAST_POINTS[model.kind]
    remedy = _of_scale_or_spacing(smallest, widest, min(model.extent) / 2.0)
    if widest > min(along, across):
        raise GeometryError(
            f"spacing = {widest:g} m is larger than a model at {scale(smallest)}, "
            f"{along:.4g} x {across:.4g} m",
            expected="several points in every model",
            remedy=remedy,
        )
    if n_points < least:
        raise GeometryError(
            f"{number(n_points)} points lie in a model at {scale(smallest)} with "
            f"a spacing of {widest:g} m",
            expected=f"at least {least} for kind = {model.kind}",
            remedy=remedy,
        )


def _of_scale_or_spacing(smallest, widest, half):
    """What gives the models points enough, as far as it may be asked for.

    Which of the values are to be changed is up to the planner: both ways, with their
    numbers. ``half`` of a model's shorter side [m in the image].
    """
    larger, closer = upwards(widest / half), downwards(smallest * half)
    is_scale = float(larger) in RANGES["scale_number"]
    is_spacing = float(closer) in RANGES["spacing"]
    if is_scale and is_spacing:
        return (
            f"For {widest:g} m give scale numbers of at least "
            f"{larger}, or for {scale(smallest)} spacings of at most {closer} m"
        )
    if is_scale:
        return f"For {widest:g} m give scale numbers of at least {larger}"
    if is_spacing:
        return f"For {scale(smallest)} give spacings of at most {closer} m"
    return "Give smaller spacings, or less overlap"


@dataclass(frozen=True)
class ModelFill:
    """How full the models of combinations are, and how high they are flown, (n,)."""

    n_points: np.ndarray  # in a model of the low flight
    in_high_model: np.ndarray  # in one of the high flight; control is chosen of them
    height: np.ndarray  # of the high flight above ground [m]
    least: int  # points that a transformation needs
    wanted: np.ndarray  # control in a model of the high flight
    limit: float  # of the height [m]

    @property
    def is_low(self):
        """Which combinations fly low enough."""
        return self.height <= self.limit

    @property
    def is_determined(self):
        """Whose models hold more points than their transformation needs."""
        return self.n_points > self.least

    @property
    def is_possible(self):
        """Which fly low enough and have points enough in both flights."""
        is_enough = self.in_high_model >= self.wanted
        return self.is_low & self.is_determined & is_enough

    @property
    def lacking(self):
        """How much smaller the spacing, or larger the scale number, has to be."""
        of_high = self.wanted / self.in_high_model
        return np.sqrt(np.maximum(self.least / self.n_points, of_high)) * MORE


def model_fill(given, model, distance, max_height) -> ModelFill:
    """Count the points in the models of combinations.

    ``given`` has scale_number, high_over_low, spacing and control_per_model, (n,);
    ``distance`` is the principal distance [m], ``max_height`` the limit above ground,
    None if there is none [m].
    """
    n_points = model.n_points(given["scale_number"], given["spacing"])
    return ModelFill(
        n_points,
        given["high_over_low"] ** 2 * n_points,
        distance * given["high_over_low"] * given["scale_number"],
        LEAST_POINTS[model.kind],
        given["control_per_model"],
        np.inf if max_height is None else max_height * BELOW,
    )


def too_few_points(fill, given, model, max_height, does) -> GeometryError:
    """Give the refusal of combinations none of which is possible.

    ``does(spacing=…, scale_number=…, max_height=…)`` tells whether there is a plan with
    these instead: nothing is advised that would be refused for another reason.
    """
    if not fill.is_low.any():
        return GeometryError(
            f"the lowest high flight is flown {number(fill.height.min(), 3)} m above "
            "ground",
            expected=f"at most {max_height:g} m",
            remedy=_of_height(fill, given, max_height, does),
        )
    remedy = _remedy(fill, given, does)
    if not (fill.is_low & fill.is_determined).any():
        return GeometryError(
            f"at most {fill.n_points[fill.is_low].max():.2g} points lie in a model",
            expected=f"more than {fill.least} for kind = {model.kind}",
            remedy=remedy,
        )
    most = downwards(fill.in_high_model[fill.is_low & fill.is_determined].max())
    return GeometryError(
        f"at most {float(most):g} points lie in a high-flight model",
        expected=f"{fill.wanted.min():.0f} that can be control",
        remedy=remedy,
    )


def too_much_control(of_points, spacing, max_height, does, *, over_area=False):
    """Give the refusal of plans whose control is too great a part of all points.

    ``of_points`` is that part, ``spacing`` [m] that of the points, (n,); ``does`` as
    with :func:`too_few_points`. ``over_area`` tells that there are plans over an area,
    where control is set for all models together.
    """
    largest = np.max(spacing * np.sqrt(MOST_ON_THE_GROUND / of_points)) / MORE
    apart = _spacing_that(does, largest)
    if apart:
        remedy = of_closer_points(apart, is_limited=max_height is not None)
    elif max_height is None:
        remedy = "Give larger scale numbers of the high flight (--high-over-low)"
    else:
        remedy = "Give a greater --max-height"
    if over_area:
        remedy = (
            "Give the area (--area): over it control is set for all models together, "
            f"which takes less of it. Or: {remedy}"
        )
    found = f"control would be at least {per_cent(np.min(of_points))} of the points"
    if over_area:
        found = (
            "control at the corners and in the middle of each model of the high flight "
            f"would be at least {per_cent(np.min(of_points))} of the points"
        )
    return refusal_of_control(found, remedy)


def of_closer_points(apart, *, is_limited):
    """Say what else there is for less control than points that are closer.

    ``apart``: how far they may be apart, as it is written [m]; ``is_limited``: whether
    the high flight cannot be higher.
    """
    if is_limited:
        return (
            f"Give spacings of at most {apart} m: control grows with the "
            "models of the high flight, which cannot be larger below --max-height"
        )
    return (
        f"Give spacings of at most {apart} m, or larger scale numbers "
        "of the high flight (--high-over-low)"
    )


def refusal_of_control(found, remedy) -> GeometryError:
    """Give the refusal of plans that survey too many of their points."""
    return GeometryError(
        found,
        expected=f"less than {per_cent(MOST_ON_THE_GROUND)}: the rest would be better "
        "surveyed on the ground as well",
        remedy=remedy,
    )


def _remedy(fill, given, does):
    """What gives the models enough points, the limit of height being kept."""
    apart = np.max((given["spacing"] / fill.lacking)[fill.is_low])
    spacing = _spacing_that(does, apart)
    needed = fill.height * fill.lacking
    lowest = int(np.argmin(needed))
    exactly = given["scale_number"][lowest] * fill.lacking[lowest]
    larger = upwards(exactly)
    is_too_high, height = needed[lowest] > fill.limit, ""
    if is_too_high:
        height = needed[lowest] * float(larger) / exactly
        height = _height_that(does, height, 2.0 * height, scale_number=float(larger))
    if not spacing:
        return _without_spacing(larger, height, is_too_high=is_too_high)
    if is_too_high:
        if not height:
            return f"Give spacings of at most {spacing} m"
        return (
            f"Give spacings of at most {spacing} m: scale numbers of at least "
            f"{larger}, which would do as well, are flown too high for --max-height "
            f"(high flight {height} m)"
        )
    if not does(scale_number=float(larger)):
        return f"Give spacings of at most {spacing} m"
    return (
        f"Give spacings of at most {spacing} m, or scale numbers of at least {larger}"
    )


def _without_spacing(larger, height, *, is_too_high):
    """What helps where no spacing does."""
    if not is_too_high:
        return f"Give scale numbers of at least {larger}"
    if not height:
        return "Give smaller spacings, and a greater --max-height"
    return (
        f"Give scale numbers of at least {larger} with a --max-height of at least "
        f"{height} m"
    )


def _of_height(fill, given, max_height, does):
    """What makes the high flight low enough, and keeps points enough in the models."""
    nearest = given["high_over_low"] == given["high_over_low"].min()
    # both in proportion to the scale number
    lower = max_height / fill.height[nearest]
    most = np.max(lower * given["scale_number"][nearest])
    enough = np.max(lower * given["spacing"][nearest] / fill.lacking[nearest])
    is_enough = fill.lacking <= MORE
    least = ""
    if is_enough.any():
        least = _height_that(does, np.min(fill.height[is_enough]), fill.height.max())
    scales = spacings = ""
    if most >= RANGES["scale_number"].low:
        scales = downwards(most, 3)
        spacings = _spacing_that(does, enough, scale_number=float(scales))
    if not spacings:
        if not least:
            return "Give smaller spacings, and a greater --max-height"
        return f"Give a --max-height of at least {least} m"
    if not least:
        return (
            f"Give scale numbers of at most {scales} with spacings of at most "
            f"{spacings} m"
        )
    if float(spacings) < given["spacing"].min():
        return (
            f"Give scale numbers of at most {scales} with spacings of at most "
            f"{spacings} m, or a --max-height of at least {least} m"
        )
    return (
        f"Give scale numbers of at most {scales}, or a --max-height of at least "
        f"{least} m"
    )


def _spacing_that(does, largest, **changes):
    """Write the largest round spacing with which there is a plan, or "" [m]."""
    spacing = downwards(largest)
    while float(spacing) >= RANGES["spacing"].low:
        if does(spacing=float(spacing), **changes):
            return spacing
        spacing = downwards(STEP_DOWN * float(spacing))
    return ""


def _height_that(does, lowest, highest, **changes):
    """Write the least round height below which there is a plan, or "" [m]."""
    height = upwards(lowest, 3)
    while not does(max_height=float(height), **changes):
        if float(height) > highest:
            return ""
        height = upwards(float(height) / STEP_DOWN, 3)
    return height


def downwards(value, significant=2):
    """Write a number that may not be exceeded.

    >>> downwards(6.99), downwards(1250.0), downwards(60.0)
    ('6.9', '1200', '60')
    """
    return _rounded(math.floor, value, significant)


def upwards(value, significant=2):
    """Write a number that has to be reached.

    >>> upwards(4348.0), upwards(60.0)
    ('4400', '60')
    """
    return _rounded(math.ceil, value, significant)


def _rounded(towards, value, significant):
    exponent = math.floor(math.log10(value)) - significant + 1
    # what is a round number but for its last digit stays as it is
    steps = towards(round(value / 10.0**exponent, 6))
    return f"{steps * 10.0**exponent:.{max(-exponent, 0)}f}"
