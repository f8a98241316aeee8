"""Numbers and names as sections and suggestions write them alike."""

import math

from einschalt.foundations.display_names import printable
from einschalt.foundations.language import figure, mark_each, translated
from einschalt.foundations.typesetting import (
    fixed,
    length,
    names,
    number,
    number_word,
    round_by_error,
)

FLIGHTS = mark_each({"high_flight": "high flight", "low_flight": "low flight"})
SHORT = mark_each({"high_flight": "high", "low_flight": "low"})
TRANSFORMATIONS = mark_each(
    {
        "affine": "affine",
        "helmert": "Helmert",
        "rigid": "rigid",
        "helmert_3d": "spatial Helmert",
    }
)
LEAST_PROBABILITY = 0.001
MOST_PROBABILITY = 0.99
PPM = 1e6


def flight_name(flight) -> str:
    """Write the name of a flight as it stands in a sentence.

    Examples
    --------
    >>> flight_name("low_flight")
    'low flight'
    """
    return translated(FLIGHTS.get(flight, flight.replace("_", " ")))


def transformation_name(kind) -> str:
    """Write the kind of a transformation as it stands in a table.

    Examples
    --------
    >>> transformation_name("helmert_3d")
    'spatial Helmert'
    """
    if kind in TRANSFORMATIONS:
        return translated(TRANSFORMATIONS[kind])
    return printable(kind).replace("_", " ")


def some_of(ids, n_all, most=5) -> str:
    """Write the first names of many, and how many more there are.

    Examples
    --------
    >>> some_of(["7/8", "8/9", "9/10"], 1061, most=2)
    '7/8, 8/9 and 1059 more'
    """
    shown = list(ids)[:most]
    rest = n_all - len(shown)
    if rest <= 0:
        return names(shown)
    return translated("{names} and {rest} more", names=names(shown), rest=rest)


def some_models(models, n_all) -> str:
    """Write the first of many models, each with its flight.

    Examples
    --------
    >>> some_models([("low_flight", "7/8"), ("high_flight", "3")], 2)
    'low 7/8, high 3'
    """
    return some_of(
        [f"{short_flight_name(flight)} {model}" for flight, model in models],
        n_all,
    )


def some_observations(observations, n_all, most=4) -> str:
    """Write the first of many observations: flight, coverage, model, point.

    Examples
    --------
    >>> some_observations([("low_flight", "1", "7/8", "P 12")], 3)
    'low 1 7/8 P 12 and 2 more'
    """
    shown = [
        f"{short_flight_name(flight)} {coverage} {model} {point}"
        for flight, coverage, model, point in observations
    ]
    return some_of(shown, n_all, most)


def some_image_points(points, n_all, most=4) -> str:
    """Write the first of many image points: flight, model, point.

    Examples
    --------
    >>> some_image_points([("low_flight", "7/8", "12")], 1)
    'low 7/8 12'
    """
    shown = [
        f"{short_flight_name(flight)} {model} {point}"
        for flight, model, point in points
    ]
    return some_of(shown, n_all, most)


def short_flight_name(flight) -> str:
    """Write the name of a flight beside that of a model."""
    return translated(SHORT.get(flight, flight.removesuffix("_flight")))


def length_or_worse(credible) -> str:
    """Write a figure of precision, which may be a lower bound."""
    if not credible.is_lower_bound:
        return length(credible.value)
    return translated("{length} or worse", length=length(credible.value))


def with_error(value, standard_error) -> str:
    """Write an estimate with its standard error.

    Examples
    --------
    >>> with_error(4.9713, 0.1342)
    '4.97 ± 0.13'
    """
    value, error = round_by_error(value, standard_error)
    return f"{value} ± {error}"


def two_figures(flights, message) -> str:
    """Write the given m_g of flights, and the one that something else shows."""
    return "; ".join(
        translated(
            message,
            flight=flight_name(part["flight"]),
            given=number(part["given_um"]),
            shown=with_error(part["estimated_um"], part["standard_error_um"]),
        )
        for part in flights
    )


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
        return f"< {figure(LEAST_PROBABILITY)}"
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
        return translated("one coverage")
    return translated("mean of {number} coverages", number=number_word(n_coverages))
