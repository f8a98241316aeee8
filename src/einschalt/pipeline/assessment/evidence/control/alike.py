"""Whether control points that were set aside are off in one direction.

Errors of single control points have nothing in common. If a part of the control is
shifted, the block bends between both parts, and data snooping refuses whichever points
are fewer or weaker, right or wrong: their strains are parallel, if not equal. No
residual is left then that tells which part is wrong.
"""

import numpy as np

from einschalt.foundations.frame_columns import values_of

# that single errors lie as close to one direction, or to one line, as those found
SIGNIFICANCE = 0.1
FEWEST = 2
FEWEST_CONFIRMING = 4  # check points


def may_hold_wrong_control(examined) -> bool:
    """Tell whether control that contradicts an adjustment takes part, or may do so."""
    control = examined.adjustment.control
    is_kept = bool((control["is_suspect"] & ~control["is_set_aside"]).any())
    return is_kept or examined.set_aside_is_alike


def set_aside_may_be_right(examined) -> bool:
    """Tell whether control that was set aside is off in one direction.

    Not where check points agree with the adjustment without it.
    """
    known = examined.known_check
    is_confirmed = known.count >= FEWEST_CONFIRMING and not known.are_beyond
    return not is_confirmed and are_set_aside_alike(examined.adjustment.control)


def are_set_aside_alike(control) -> bool:
    """Tell whether strains are more parallel than independent errors would be.

    Parameters
    ----------
    control : DataFrame
        Of an adjustment: strain_easting, strain_northing [m], is_set_aside.
    """
    is_out = control["is_set_aside"].to_numpy(dtype=bool)
    strain = values_of(control, ["strain_easting", "strain_northing"])[is_out]
    if len(strain) < FEWEST:
        return False
    direction = np.arctan2(strain[:, 1], strain[:, 0])
    # in one direction, or along one line: two looks at the same points (Bonferroni)
    p_values = [_chance_of_arc(direction, period) for period in (2.0 * np.pi, np.pi)]
    return bool(2.0 * min(p_values) <= SIGNIFICANCE)


def _chance_of_arc(direction, period):
    """Probability that random directions lie in an arc as short as these do.

    n (arc/period)^(n - 1) while the arc is at most half of the period, where no two of
    the points can both be its beginning; Stevens (1939). 1 beyond.
    """
    ordered = np.sort(np.mod(direction, period))
    gaps = np.diff(ordered, append=ordered[0] + period)
    share = 1.0 - gaps.max() / period
    n = len(ordered)
    return min(n * share ** (n - 1), 1.0) if share <= 0.5 else 1.0
