"""Standard errors from a sum of squared residuals."""

import numpy as np

SQRT2 = np.sqrt(2.0)


def standard_error_of_unit_weight(sum_of_squares, redundancy):
    """Standard error of unit weight s_0 = √(vᵀPv / redundancy).

    Parameters
    ----------
    sum_of_squares : ndarray, shape (n_models,)
        Weighted sum of squared residuals vᵀPv.
    redundancy : ndarray of int, shape (n_models,)
        Observations less unknowns.

    Returns
    -------
    ndarray, shape (n_models,)
        Per coordinate; NaN where nothing is redundant, since nothing is known then.

    Examples
    --------
    >>> standard_error_of_unit_weight(np.array([8.0, 0.0]), np.array([2, 0]))
    array([ 2., nan])
    """
    redundancy = np.asarray(redundancy, dtype=float)
    has_redundancy = redundancy > 0
    variance = np.divide(
        sum_of_squares,
        redundancy,
        out=np.full(redundancy.shape, np.nan),
        where=has_redundancy,
    )
    return np.sqrt(variance)


def pooled_standard_error(sum_of_squares, redundancy):
    """Standard error of unit weight of several models together.

    √(Σ vᵀPv / Σ redundancy); NaN where nothing is redundant.
    """
    total = np.array([np.nansum(sum_of_squares)])
    return float(
        standard_error_of_unit_weight(total, np.array([np.sum(redundancy)]))[0]
    )


def pool_standard_errors(standard_errors, redundancy):
    """Standard error of several samples taken together, from theirs: √(Σ r s² / Σ r).

    Per coordinate or total, in any unit; one that is NaN takes no part. NaN where
    nothing is redundant.

    >>> pool_standard_errors(np.array([1.0, 5.0, np.nan]), np.array([2, 1, 0]))
    3.0
    """
    standard_errors = np.asarray(standard_errors, dtype=float)
    is_known = np.isfinite(standard_errors)
    redundancy = np.where(is_known, np.asarray(redundancy, dtype=float), 0.0)
    squares = redundancy * np.where(is_known, standard_errors, 0.0) ** 2
    return pooled_standard_error(squares, redundancy)


def total_from_coordinate(standard_error):
    """Total point error √(σ_E² + σ_N²) of equal errors: √2 times either of them."""
    return SQRT2 * standard_error
