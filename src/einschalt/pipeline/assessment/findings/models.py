"""Models that failed or are weak, and points that hang on them."""

import numpy as np

from einschalt.foundations.names import is_among
from einschalt.foundations.units import METRES_PER_MM
from einschalt.pipeline.assessment.evidence.control.expected_scatter import expected_m_0
from einschalt.pipeline.assessment.evidence.ground.frame import (
    LARGEST_DIAGONAL_M,
    LARGEST_STRETCH,
    are_mirrored,
)
from einschalt.pipeline.assessment.evidence.ground.model_scales import (
    find_models_in_another_unit,
)
from einschalt.pipeline.assessment.finding import Gravity
from einschalt.pipeline.assessment.findings.kinds import (
    MODEL,
    finding,
    first_names,
    models_of,
    row_keys,
    weak_models,
    weak_points,
)
from einschalt.theory.adjustment.least_squares import pool_standard_errors

LARGE_M_0 = 3.0
MOST_REASONS = 20
MOST_NAMED_OF_A_REASON = 10


def failed_models(examined):
    """Models that gave no transformation, counted by their reason."""
    failures = examined.failures
    if failures.empty:
        return None
    keys = ["flight", "coverage", "model_id"]
    n_failed = len(failures[keys].drop_duplicates())
    groups = failures.groupby(["flight", "reason", "remedy"], sort=False, dropna=False)
    biggest = sorted(groups, key=lambda group: -len(group[1]))
    return finding(
        "failed_models",
        names=failures["model_id"].drop_duplicates(),
        statistic="number of failed models",
        observed=n_failed,
        expected=0.0,
        facts={
            "n_failed": n_failed,
            "n_models": sum(f.n_models for f in examined.block.flights.values()),
            "n_reasons": len(biggest),
            "reasons": tuple(_reason(*group) for group in biggest[:MOST_REASONS]),
        },
    )


def _reason(key, rows):
    flight, reason, remedy = key
    return {
        "flight": str(flight),
        "reason": str(reason),
        "remedy": remedy.strip() if isinstance(remedy, str) else "",
        "n_models": len(rows),
        "models": first_names(rows["model_id"])[:MOST_NAMED_OF_A_REASON],
    }


def points_without_coordinates(examined):
    """Points that the low flight measured and no usable model holds."""
    measured = examined.block.low_flight.model_table()["point_id"]
    is_lost = ~is_among(measured, examined.points["point_id"])
    lost = measured[is_lost].drop_duplicates()
    return weak_points(
        "points_without_coordinates", lost, remedy="look_at_their_models"
    )


def models_with_large_m_0(examined):
    """Models that fit far worse than their flight, and than their points let expect."""
    models = examined.models[examined.models["is_usable"].astype(bool)]
    of_flights = {
        flight: pool_standard_errors(rows["m_0"], rows["redundancy"])
        for flight, rows in models.groupby("flight")
    }
    usual = models["flight"].map(of_flights)
    is_large = models["m_0"] > LARGE_M_0 * usual
    worst = models[is_large & ~_as_expected(examined, models, is_large)]
    worst = worst.sort_values("m_0", ascending=False)
    if worst.empty:
        return None
    largest = float(worst["m_0"].iloc[0])
    return finding(
        "models_with_large_m_0",
        names=worst["model_id"],
        statistic="m_0 of a model",
        observed=largest,
        expected=usual[worst.index[0]],
        remedy="look_at_residuals",
        facts={**models_of(worst), "times_usual": LARGE_M_0, "largest_m_0": largest},
    )


def _as_expected(examined, models, is_asked):
    """Which models that are asked for fit no worse than propagated errors make them."""
    is_expected = is_asked & False
    place = examined.models.groupby("flight").cumcount()
    for flight, rows in models[is_asked].groupby("flight"):
        expected = expected_m_0(examined, flight, place[rows.index].to_numpy())
        is_expected[rows.index] = rows["m_0"] <= LARGE_M_0 * expected
    return is_expected


def mirrored_models(examined):
    """Affine models with a negative determinant, which no camera makes by itself.

    All of them may be mirrored by a left-handed machine. Where no reference system has
    let the coordinates pass, it may as well be control with its axes exchanged.
    """
    frame = examined.frame
    if not frame.n_mirrored:
        return None
    facts = {"n_mirrored": frame.n_mirrored, "n_affine": frame.n_affine}
    if frame.is_mirrored:
        return finding(
            "all_models_mirrored",
            gravity=Gravity.NOTE if frame.has_system else Gravity.GRAVE,
            remedy="exchange_axes_unless_left_handed",
            facts=facts,
        )
    models = are_mirrored(examined.models)
    mirrored = models[models["is_mirrored"]]
    if mirrored.empty:  # of other kinds some may be so by their control
        return None
    return finding(
        "mirrored_models",
        names=mirrored["model_id"],
        remedy="look_for_exchanged_names",
        facts={**facts, "models": row_keys(mirrored, MODEL)},
    )


def models_larger_than_film(examined):
    """Flights whose models no photograph of their scale holds: wrong units."""
    found = examined.frame.impossible_films
    if not found:
        return None
    worst = max(found, key=lambda film: film.on_film)
    return finding(
        "models_larger_than_film",
        names=[film.flight for film in found],
        statistic="diameter of the median model in its photograph",
        observed=worst.on_film,
        expected=LARGEST_DIAGONAL_M,
        remedy="look_at_units_and_scale_number",
        facts={
            "flight": worst.flight,
            "diameter": worst.diameter,
            "scale_number": worst.scale_number,
            "on_film_mm": worst.on_film / METRES_PER_MM,
            "largest_mm": LARGEST_DIAGONAL_M / METRES_PER_MM,
        },
    )


def models_in_another_unit(examined):
    """Models of flights with y-parallaxes that have another scale than the others."""
    found = find_models_in_another_unit(examined)
    if found.empty:
        return None
    farthest = found["scale_ratio"].map(np.log).abs().sort_values(ascending=False)
    found = found.loc[farthest.index]
    ratio = float(found["scale_ratio"].iloc[0])
    return finding(
        "models_in_another_unit",
        names=found["model_id"],
        statistic="size of the coordinates of a model by that of its flight",
        observed=ratio,
        expected=1.0,
        remedy="convert_these_models",
        facts={**models_of(found), "ratio": ratio},
    )


def scale_numbers_contradicted(examined):
    """Flights whose photographs have another scale than their scale number."""
    frame = examined.frame
    found = frame.films_out_of_scale
    if not found:
        return None
    worst = max(found, key=lambda film: abs(np.log(film.scale_ratio)))
    of_all = frame.is_out_of_scale
    return finding(
        "scale_numbers_contradicted",
        names=[film.flight for film in found],
        statistic="scale number, from image coordinates and ground",
        observed=worst.scale_ratio * worst.scale_number,
        expected=worst.scale_number,
        remedy="look_at_units_of_control" if of_all else "correct_scale_number",
        facts={
            "flight": worst.flight,
            "scale_number": worst.scale_number,
            "found": worst.scale_ratio * worst.scale_number,
        },
    )


def stretched_models(examined):
    """Models of which one axis is stretched more than film can be."""
    frame = examined.frame
    if not frame.is_stretched:
        return None
    return finding(
        "stretched_models",
        statistic="common stretch of one axis of the models against the other",
        observed=frame.stretch,
        expected=0.0,
        remedy="look_at_units_of_each_axis",
        facts={
            "n_models": frame.common.n_models,
            "per_cent": 100.0 * frame.stretch,
            "largest_per_cent": 100.0 * LARGEST_STRETCH,
        },
    )


def points_in_one_coverage(examined):
    """Points that no second coverage confirms, where the flight has one."""
    if examined.block.low_flight.n_coverages == 1:
        return None
    points = examined.points
    single = points[points["n_coverages"] == 1]
    return weak_points(
        "points_in_one_coverage",
        single["point_id"],
        remedy="nothing_confirms_them",
        n_in_one_model=int((single["n_models"] == 1).sum()),
    )


def points_in_one_model(examined):
    """Points that not even a second model confirms, in a flight of one coverage."""
    if examined.block.low_flight.n_coverages != 1:
        return None
    points = examined.points
    alone = points[(points["n_coverages"] == 1) & (points["n_models"] == 1)]
    names = alone["point_id"]
    return weak_points("points_in_one_model", names, remedy="nothing_confirms_them")


def models_without_redundancy(examined):
    """Models that any residual escapes."""
    models = examined.models
    exact = models[models["is_usable"].astype(bool) & (models["redundancy"] == 0)]
    return weak_models(
        "models_without_redundancy", exact, remedy="gross_errors_cannot_be_seen"
    )


TWO_STEP = SIMULTANEOUS = (
    failed_models,
    points_without_coordinates,
    models_with_large_m_0,
    mirrored_models,
    models_in_another_unit,
    models_larger_than_film,
    scale_numbers_contradicted,
    stretched_models,
    points_in_one_coverage,
    points_in_one_model,
    models_without_redundancy,
)
