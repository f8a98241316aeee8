"""To how many digits numbers were given, as far as all of them tell it."""

import numpy as np

FEWEST = 5  # numbers that tell of digits
LEAST_SHARE = 0.95
COARSEST, FINEST = 3, -7  # powers of ten that are tried
# of a last digit: what reading as floating point leaves of it
ROUNDING = 1e-3


def resolution_of(values) -> float:
    """Find the power of ten that nearly all numbers are multiples of.

    Parameters
    ----------
    values : array_like, shape (n,)
        NaN where there is none.

    Returns
    -------
    float
        The largest one that 95 % of at least 5 different numbers share; 0 where they
        are too few, or have more digits than are looked at.

    Examples
    --------
    >>> resolution_of([5012.3, 5047.1, 4988.0, 5101.7, 5060.2])
    0.1
    """
    values = np.unique(np.asarray(values, dtype=float))
    values = values[np.isfinite(values)]
    if len(values) < FEWEST:
        return 0.0
    for power in range(COARSEST, FINEST - 1, -1):
        # a quotient by a power of ten below one is less exact than a product
        steps = values / 10.0**power if power >= 0 else values * 10.0**-power
        is_multiple = np.abs(steps - np.round(steps)) < ROUNDING
        if np.mean(is_multiple) >= LEAST_SHARE:
            # equal ones, but for rounding, tell of digits once
            if len(np.unique(np.round(steps))) < FEWEST:
                return 0.0
            return float(10.0**power) if power >= 0 else 1.0 / 10.0**-power
    return 0.0
