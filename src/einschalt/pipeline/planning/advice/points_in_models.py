"""Whether models hold enough points to be planned, and what would give them enough."""

import math

import numpy as np

from einschalt.foundations.errors import GeometryError
from einschalt.foundations.typesetting import number, per_cent, scale
from einschalt.pipeline.planning.arguments import RANGES
from einschalt.theory.planning.leverage import LEAST_POINTS

MOST_ON_THE_GROUND = 0.5
"""Of the points: where as many are control, most of the work is done on the ground, and
the rest would be surveyed there as well, and better, with the instrument at hand."""
BELOW = 1.0 + 1e-9
"""Heights that stand on the limit are kept, whatever their last digit."""
MORE = 1.001  # of an advised number: what lies on a limit is not above it


def require_points(model, scale_number, spacing):
    """Refuse combinations whose models hold too few points to plan anything.

    Of every scale number with every spacing: one that is larger than a model, or fewer
    points in a model than the transformation needs, is a GeometryError.
    """
    smallest, widest = float(np.min(scale_number)), float(np.max(spacing))
    along, across = (smallest * side for side in model.extent)
    n_points = float(model.n_points(smallest, widest))
    least = LEAST_POINTS[model.kind]
    # which of the values are to be changed is up to the planner: both ways, with their
    # numbers
    half = min(model.extent) / 2.0
    remedy = f"For {widest:g} m give scale numbers of at least {upwards(widest / half)}"
    if smallest * half >= RANGES["spacing"].low:
        remedy = (
            f"For {widest:g} m give scale numbers of at least "
            f"{upwards(widest / half)}, or for {scale(smallest)} spacings of at most "
            f"{downwards(smallest * half)} m"
        )
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


def with_enough_points(given, model, distance, max_height):
    """Tell which combinations have enough points in their models and fly low enough.

    ``given`` has scale_number, high_over_low, spacing and control_per_model, (n,);
    ``distance`` is the principal distance [m], ``max_height`` the limit above ground,
    None if there is none [m]. GeometryError, with what would be possible, if no
    combination is.
    """
    n_points = model.n_points(given["scale_number"], given["spacing"])
    # control is chosen among the points
    in_high_model = given["high_over_low"] ** 2 * n_points
    height = distance * given["high_over_low"] * given["scale_number"]
    limit = np.inf if max_height is None else max_height * BELOW
    least, wanted = LEAST_POINTS[model.kind], given["control_per_model"]
    is_low, is_determined = height <= limit, n_points > least
    is_possible = is_low & is_determined & (in_high_model >= wanted)
    if is_possible.any():
        return is_possible
    # how much smaller the spacing, or larger the scale number, has to be
    lacking = np.sqrt(np.maximum(least / n_points, wanted / in_high_model)) * MORE
    if not is_low.any():
        raise GeometryError(
            f"the lowest high flight is flown {number(height.min(), 3)} m above ground",
            expected=f"at most {max_height:g} m",
            remedy=_of_height(given, lacking, height, max_height),
        )
    remedy = _remedy(given, lacking, height, limit)
    if not (is_low & is_determined).any():
        raise GeometryError(
            f"at most {n_points[is_low].max():.2g} points lie in a model",
            expected=f"more than {least} for kind = {model.kind}",
            remedy=remedy,
        )
    most = downwards(in_high_model[is_low & is_determined].max())
    raise GeometryError(
        f"at most {float(most):g} points lie in a high-flight model",
        expected=f"{wanted.min():.0f} that can be control",
        remedy=remedy,
    )


def too_much_control(of_points, spacing, max_height):
    """Give the refusal of plans whose control is too great a part of all points.

    ``of_points`` is that part, ``spacing`` [m] that of the points, (n,).
    """
    spacing = np.max(spacing * np.sqrt(MOST_ON_THE_GROUND / of_points)) / MORE
    remedy = (
        f"Give spacings of at most {downwards(spacing)} m: control grows with the "
        "models of the high flight, which cannot be larger below --max-height"
    )
    if max_height is None:
        remedy = (
            f"Give spacings of at most {downwards(spacing)} m, or larger scale numbers "
            "of the high flight (--high-over-low)"
        )
    return GeometryError(
        f"control would be at least {per_cent(np.min(of_points))} of the points",
        expected=f"less than {per_cent(MOST_ON_THE_GROUND)}: the rest would be better "
        "surveyed on the ground as well",
        remedy=remedy,
    )


def _remedy(given, lacking, height, limit):
    """What gives the models enough points, the limit of height being kept."""
    spacing = downwards(np.max((given["spacing"] / lacking)[height <= limit]))
    needed = height * lacking
    lowest = int(np.argmin(needed))
    larger = upwards(given["scale_number"][lowest] * lacking[lowest])
    if float(spacing) < RANGES["spacing"].low:
        return f"Give scale numbers of at least {larger}"
    if needed[lowest] <= limit:
        return (
            f"Give spacings of at most {spacing} m, or scale numbers of at least "
            f"{larger}"
        )
    return (
        f"Give spacings of at most {spacing} m: scale numbers of at least {larger}, "
        "which would do as well, are flown too high for --max-height (high flight "
        f"{upwards(needed[lowest])} m)"
    )


def _of_height(given, lacking, height, max_height):
    """What makes the high flight low enough, and keeps points enough in the models."""
    nearest = given["high_over_low"] == given["high_over_low"].min()
    # both in proportion to the scale number
    lower = max_height / height[nearest]
    most = np.max(lower * given["scale_number"][nearest])
    enough = np.max(lower * given["spacing"][nearest] / lacking[nearest])
    is_enough = lacking <= MORE
    least = upwards(np.min(height[is_enough]), 3) if is_enough.any() else ""
    if most < RANGES["scale_number"].low or enough < RANGES["spacing"].low:
        if not least:
            return "Give smaller spacings, and a greater --max-height"
        return f"Give a --max-height of at least {least} m"
    scales, spacings = downwards(most, 3), downwards(enough)
    if not least:
        return (
            f"Give scale numbers of at most {scales} with spacings of at most "
            f"{spacings} m"
        )
    if enough < given["spacing"].min():
        return (
            f"Give scale numbers of at most {scales} with spacings of at most "
            f"{spacings} m, or a --max-height of at least {least} m"
        )
    return (
        f"Give scale numbers of at most {scales}, or a --max-height of at least "
        f"{least} m"
    )


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
