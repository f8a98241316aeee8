"""What more effort would gain in a planned block, and up to where it is worth it."""

from dataclasses import replace

import numpy as np
import pandas as pd

from einschalt.foundations import typesetting
from einschalt.foundations.kept_texts import retold
from einschalt.foundations.language import mark, translated
from einschalt.foundations.typesetting import fixed, number, wrapped
from einschalt.foundations.units import METRES_PER_UM
from einschalt.theory.planning.expected_precision import (
    FlightsToExpect,
    break_even,
    expected_parts,
)

MOST_COVERAGES = 4
WORTH_IT = mark(
    "Worth it, until the rest of the error is as large as the part that it reduces: "
    "{efforts}."
)
NOT_WORTH_IT = mark("Not worth it: {efforts}.")
TWICE = 0.5**0.5  # of twice as many settings or points


def flights_of(design) -> FlightsToExpect:
    """Put a design down as the closed estimate takes it."""
    return FlightsToExpect(
        scale_number=design.scale_number,
        high_scale_number=design.scale_of_high_flight,
        spacing=design.spacing,
        m_g=design.m_g_um * METRES_PER_UM,
        high_m_g=design.noise().high_m_g_um * METRES_PER_UM,
        n_coverages=design.n_coverages,
        control_error=design.control_standard_error,
        control_per_model=design.control_per_model,
    )


def effort_gains(expected) -> pd.DataFrame:
    """Estimate what more of each effort would make of the expected precision.

    effort, expected_mean [m, TOTAL], gain (part of the mean error that goes), the
    largest first: the propagated error times the ratio of closed estimates.
    """
    design = expected.design
    flights = flights_of(design)
    now = expected_parts(flights, design.model).mean
    efforts = {
        "points set twice as often in the low flight": {"m_g": TWICE * flights.m_g},
        "points set twice as often in the high flight": {
            "high_m_g": TWICE * flights.high_m_g
        },
        "a high flight lower by a fifth": {
            "high_scale_number": 0.8 * flights.high_scale_number
        },
        "twice as many points": {"spacing": TWICE * flights.spacing},
        "control of half the error": {"control_error": 0.5 * flights.control_error},
    }
    if design.n_coverages < MOST_COVERAGES:
        efforts["one coverage more of both flights"] = {
            "n_coverages": design.n_coverages + 1
        }
    if design.control_per_model == 5:
        efforts["nine control points in each high-flight model"] = {
            "control_per_model": 9
        }
    changed = [replace(flights, **change) for change in efforts.values()]
    ratio = np.array(
        [expected_parts(f, design.model).mean / now for f in changed], float
    )
    of_mean = expected.figures.mean * ratio
    table = pd.DataFrame(
        {"effort": list(efforts), "expected_mean": of_mean, "gain": 1.0 - ratio}
    )
    return table.sort_values("gain", ascending=False, ignore_index=True)


def describe_effort(expected) -> str:
    """Write what more effort would gain, and up to where it is worth it."""
    rows = [
        [
            retold(row.effort),
            fixed(100.0 * row.expected_mean, 1),
            fixed(100.0 * row.gain, 0),
        ]
        for row in effort_gains(expected).itertuples()
    ]
    design = expected.design
    flights = flights_of(design)
    limits = break_even(expected_parts(flights, design.model), flights)
    worth, not_worth = _worth(limits, design)
    said = [
        translated(message, efforts=", ".join(efforts))
        for message, efforts in ((WORTH_IT, worth), (NOT_WORTH_IT, not_worth))
        if efforts
    ]
    header = [translated("Gain of further effort (closed estimate)"), "cm", "%"]
    text = typesetting.table(rows, header=header, align="lrr")
    return f"{text}\n{wrapped(' '.join(said), first='  ', indent='    ')}"


def _worth(limits, design):
    """List what is worth an effort, with its limits, and what is not."""
    efforts = (_settings(limits), _coverages(limits, design), _points(limits, design))
    return [
        [text for is_worth, text in efforts if is_worth is wanted]
        for wanted in (True, False)
    ]


def _settings(limits):
    if limits.settings <= 1.0:
        return False, translated("more pointings in the low flight")
    if np.isinf(limits.settings):
        return True, translated("any number of pointings in the low flight")
    return True, translated(
        "up to {ratio} times as many pointings in the low flight",
        ratio=number(limits.settings),
    )


def _coverages(limits, design):
    if limits.n_coverages <= design.n_coverages:
        return False, translated("more coverages")
    if np.isinf(limits.n_coverages):
        return True, translated("any number of coverages")
    return True, translated("up to {most} coverages", most=number(limits.n_coverages))


def _points(limits, design):
    if limits.spacing >= design.spacing:
        return False, translated("denser points")
    return True, translated(
        "points down to {spacing} m apart", spacing=number(limits.spacing)
    )
