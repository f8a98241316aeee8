"""How far an observation is checked by the others."""

import numpy as np


def redundancy_numbers(leverage):
    """Redundancy number r = 1 − h of each observed coordinate.

    Their sum is the redundancy of the adjustment; an error of an observation shows
    itself in its residual with the factor −r.

    Parameters
    ----------
    leverage : ndarray
        Diagonal of the hat matrix.

    Returns
    -------
    ndarray
        Never below zero: where h is 1 up to rounding, r is 0.
    """
    return np.maximum(1.0 - np.asarray(leverage), 0.0)
