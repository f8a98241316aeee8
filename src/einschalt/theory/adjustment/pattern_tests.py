"""Whether one of several patterns is hidden in correlated errors.

Each pattern has amplitudes that are estimated by least squares with the full covariance
of the errors, and tested against zero: χ² where the sizes of the errors are known, F
where they are only known but for a common factor.

Source: Teunissen 2006, Testing theory, ch. 4 (the w-test for several dimensions); see
docs/theory/claim.md.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular
from scipy.special import chdtrc, fdtrc  # scipy.stats takes a second to import

# of the largest information on an amplitude: below it nothing is known of a pattern
LEAST_INFORMATION = 1e-8
# of the largest eigenvalue of an information: what is smaller is rounding
LEAST_RANK = 1e-6


@dataclass(frozen=True, eq=False)
class PatternTests:
    """Patterns, each tested as if it were the only one; NaN where nothing is known."""

    amplitudes: np.ndarray  # shape (n_patterns, n_amplitudes)
    squares: np.ndarray  # shape (n_patterns,); χ² with n_amplitudes degrees of freedom
    p_values: np.ndarray  # shape (n_patterns,)
    # shape (n_patterns,); if all errors were larger by an unknown common factor
    p_values_if_scaled: np.ndarray
    total: float  # χ² of all errors
    n: int  # their number, its degrees of freedom

    @property
    def worst(self):
        """Place of the clearest pattern; None where nothing could be tested."""
        is_known = np.isfinite(self.squares)
        return int(np.nanargmax(self.squares)) if is_known.any() else None


def nested_p_value(tests, place, freed):
    """P value of the F test of a pattern against all that it moves, free by itself.

    Whatever common factor all errors have.

    Parameters
    ----------
    tests : PatternTests
    place : int
        Of the pattern among them.
    freed : PatternTests
        Of the same errors, where what the pattern moves was free.

    Returns
    -------
    float
        Small where the free amplitudes explain significantly more than the pattern;
        NaN where they are no more than it has, or nothing is left to compare with.
    """
    n_amplitudes = tests.amplitudes.shape[1]
    n_more = tests.n - freed.n - n_amplitudes
    if n_more <= 0 or freed.n <= 0:
        return np.nan
    more = max(tests.total - freed.total - tests.squares[place], 0.0)
    rest = freed.total / freed.n
    return float(fdtrc(n_more, freed.n, more / n_more / rest)) if rest > 0.0 else np.nan


def examine_patterns(observed, covariance, signatures, free=None) -> PatternTests:
    """Estimate and test the amplitudes of each pattern by itself.

    Parameters
    ----------
    observed : ndarray, shape (n,)
        Errors, of expectation zero where there is no pattern.
    covariance : ndarray, shape (n, n)
        Of these errors, positive definite.
    signatures : ndarray, shape (n_patterns, n, n_amplitudes)
        What a pattern makes of the errors for amplitudes of one.
    free : ndarray, shape (n, n_free), optional
        What is in the errors beside them, in sizes that nobody knows.

    Raises
    ------
    numpy.linalg.LinAlgError
        The covariance is not positive definite.

    Examples
    --------
    >>> step = np.array([[[0.0], [0.0], [1.0], [1.0]]])
    >>> found = examine_patterns(np.array([0.1, 0.0, 5.0, 5.2]), np.eye(4), step)
    >>> found.amplitudes.round(2).tolist(), found.squares.round(1).tolist()
    ([[5.1]], [52.0])
    """
    n_patterns, n, n_amplitudes = signatures.shape
    white, shown, n_free = _whitened(observed, covariance, signatures, free)
    information = np.einsum("npa,npb->pab", shown, shown)
    right = np.einsum("npa,n->pa", shown, white)
    least = np.linalg.eigvalsh(information)[:, 0] if n_patterns else np.zeros(0)
    is_known = least > LEAST_INFORMATION * information.max(initial=0.0)
    amplitudes = np.full((n_patterns, n_amplitudes), np.nan)
    solved = np.linalg.solve(information[is_known], right[is_known][:, :, None])
    amplitudes[is_known] = solved[:, :, 0]
    squares = np.einsum("pa,pa->p", right, amplitudes)
    total = white @ white
    return _tested(amplitudes, squares, total, n - n_free)


def estimate_together(observed, covariance, signatures, free=None):
    """Amplitudes of all patterns at once, shape (n_patterns, n_amplitudes).

    Arguments as for :func:`examine_patterns`; of what nothing is known the smallest.
    """
    n_patterns, _, n_amplitudes = signatures.shape
    white, shown, _ = _whitened(observed, covariance, signatures, free)
    found = np.linalg.lstsq(shown.reshape(len(shown), -1), white, rcond=LEAST_RANK)[0]
    return found.reshape(n_patterns, n_amplitudes)


def scores_of(observed, covariance, signatures, free=None):
    """What is known of amplitudes of one axis, all of them together.

    Arguments as for :func:`examine_patterns`, with one amplitude a pattern.

    Returns
    -------
    scores : ndarray, shape (n_patterns,)
        Information times amplitudes.
    information : ndarray, shape (n_patterns, n_patterns)
        Their covariance without a pattern, of any rank.

    Examples
    --------
    >>> scores, information = scores_of([6.0, 2.0], 2.0 * np.eye(2), [[[1], [0]]])
    >>> scores.round(9).tolist(), information.round(9).tolist()
    ([3.0], [[0.5]])
    """
    white, shown, _ = _whitened(observed, covariance, np.asarray(signatures), free)
    shown = shown[:, :, 0]
    return shown.T @ white, shown.T @ shown


def _whitened(observed, covariance, signatures, free):
    """Errors and patterns with unit covariance, what is free taken out of them.

    Shapes (n,), (n, n_patterns, n_amplitudes), and the number of what was free.
    """
    n_patterns, n, n_amplitudes = signatures.shape
    root = np.linalg.cholesky(covariance)
    white = solve_triangular(root, observed, lower=True)
    flat = np.moveaxis(signatures, 1, 0).reshape(n, -1)
    shown = solve_triangular(root, flat, lower=True)
    n_free = 0
    if free is not None and free.size:
        known = _directions(solve_triangular(root, free, lower=True))
        n_free = known.shape[1]
        white = white - known @ (known.T @ white)
        shown = shown - known @ (known.T @ shown)
    return white, shown.reshape(n, n_patterns, n_amplitudes), n_free


def _directions(columns):
    """Orthonormal columns that span the same space."""
    vectors, sizes, _ = np.linalg.svd(columns, full_matrices=False)
    return vectors[:, sizes > LEAST_RANK * sizes.max(initial=0.0)]


def examine_scores(scores, information, patterns, free=()) -> PatternTests:
    """Test patterns of displacements by the scores of an adjustment.

    Parameters
    ----------
    scores : ndarray, shape (n, n_axes)
        Weight times displacement of each point; their covariance is ``information``
        in each axis, apart from patterns, and axes are independent.
    information : ndarray, shape (n, n)
        Of each axis, of any rank.
    patterns : ndarray, shape (n_patterns, n)
        Displacements for amplitudes of one; each axis has an amplitude of its own.
    free : sequence of int
        Places of points that may be displaced as they like.

    Examples
    --------
    >>> w = np.eye(4) - 0.25
    >>> displaced = np.array([[0.0, 0.0], [0.1, 0.0], [6.0, 0.1], [6.1, 0.0]])
    >>> found = examine_scores(w @ displaced, w, np.array([[0.0, 0.0, 1.0, 1.0]]))
    >>> found.amplitudes.round(2).tolist()
    [[6.0, 0.05]]
    """
    scores, values, kept = _known_scores(scores, information, free)
    white = (kept / np.sqrt(values)).T @ scores
    known = np.sum(((patterns @ kept) * np.sqrt(values)) ** 2, axis=1)
    # a pattern of which hardly anything shows could be of any size
    whole = np.sum(patterns**2, axis=1) * values.max(initial=0.0)
    is_told = known > LEAST_INFORMATION * whole
    right = patterns @ (kept @ (kept.T @ scores))
    known = np.where(is_told, known, np.nan)[:, None]
    amplitudes = right / known
    squares = np.sum(right * amplitudes, axis=1)
    return _tested(amplitudes, squares, float(np.sum(white**2)), white.size)


def estimate_scores_together(scores, information, patterns, free=()):
    """Amplitudes of all patterns at once, shape (n_patterns, n_axes).

    Arguments as for :func:`examine_scores`; of what nothing is known the smallest.
    """
    scores, values, kept = _known_scores(scores, information, free)
    shown = (np.sqrt(values)[:, None] * kept.T) @ patterns.T
    white = (kept / np.sqrt(values)).T @ scores
    return np.linalg.lstsq(shown, white, rcond=LEAST_RANK)[0]


def _known_scores(scores, information, free):
    """Scores without points that are free, and what is known: values and vectors."""
    if len(free):
        # eliminated from the normal equations
        share = information[:, free] @ np.linalg.pinv(
            information[np.ix_(free, free)], hermitian=True
        )
        scores = scores - share @ scores[free]
        information = information - share @ information[free]
    values, vectors = np.linalg.eigh((information + information.T) / 2.0)
    is_known = values > LEAST_RANK * max(values.max(initial=0.0), 0.0)
    return scores, values[is_known], vectors[:, is_known]


def _tested(amplitudes, squares, total, n):
    """Probabilities of patterns by their squares, and by those of all ``n`` errors."""
    n_amplitudes = amplitudes.shape[1]
    degrees = n - n_amplitudes
    rest = np.maximum(total - squares, 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = (squares / n_amplitudes) / (rest / degrees)
    return PatternTests(
        amplitudes,
        squares,
        chdtrc(n_amplitudes, squares),
        fdtrc(n_amplitudes, degrees, ratio)
        if degrees > 0
        else np.ones(len(amplitudes)),
        float(total),
        n,
    )
