"""Numbers and names as sections and suggestions write them alike."""

import math

from einschalt.foundations.typesetting import fixed, number, number_word

LEAST_PROBABILITY = 0.001
MOST_PROBABILITY = 0.99
PPM = 1e6


def probability(p_value) -> str:
    """Write a probability with two digits; a very small one as less than 0.001.

    Examples
    --------
    >>> probability(0.0312), probability(2e-5), probability(float("nan"))
    ('0.031', '< 0.001', '–')
    """
    if not math.isfinite(p_value):
        return "–"
    if p_value < LEAST_PROBABILITY:
        return f"< {LEAST_PROBABILITY}"
    return number(min(p_value, MOST_PROBABILITY))


def ppm(value, error) -> str:
    """Write a small ratio with its standard error in parts per million.

    Examples
    --------
    >>> ppm(1.02e-4, 3.8e-6), ppm(-3e-6, 1.2e-5)
    ('102 ± 4 ppm', '-3 ± 12 ppm')
    """
    return f"{fixed(PPM * value, 0)} ± {fixed(PPM * error, 0)} ppm"


def mean_of(n_coverages) -> str:
    """Say of how many coverages a final coordinate is the mean.

    Examples
    --------
    >>> mean_of(1), mean_of(2)
    ('one coverage', 'mean of two coverages')
    """
    if n_coverages == 1:
        return "one coverage"
    return f"mean of {number_word(n_coverages)} coverages"
