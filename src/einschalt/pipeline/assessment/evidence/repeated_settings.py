"""m_g estimated from points that were set several times, beside the given m_g."""

import pandas as pd

from einschalt.foundations import tables
from einschalt.foundations.units import METRES_PER_UM
from einschalt.pipeline.assessment.evidence.ground.model_scales import scales_of_models
from einschalt.pipeline.block.repeated_pointings import SPREAD
from einschalt.theory.adjustment.global_tests import ratio_p_value
from einschalt.theory.adjustment.significance import FINDING_SIGNIFICANCE
from einschalt.theory.measuring_error import m_g_from_repeated_settings

MODEL = ["flight", "coverage", "model_id"]
COLUMNS = [
    *("flight", "n_points", "n_settings", "redundancy", "m_g_um", "m_g_settings_um"),
    *("standard_error_um", "p_value", "is_larger", "is_smaller"),
]
POINT_COLUMNS = [*MODEL, "point_id", "n_settings", "spread_um", "p_value"]
# a larger m_g that changes nothing is not worth a word
MIN_REPORTED_RATIO = 1.10


def m_g_of_repeated_settings(examined):
    """Compare the m_g of each flight with what repeated settings say: COLUMNS.

    n_settings of the n_points that were set several times; redundancy: settings less
    points; p_value: that settings of the given m_g scatter as much (χ² of both
    coordinates). A smaller m_g is no contradiction, since the given one holds film,
    lens and model as well.
    """
    points = spread_of_points(examined)
    rows = [
        _of_flight(name, found, examined.block.flights[name].m_g_um)
        for name, found in points.groupby("flight", sort=False)
    ]
    return pd.DataFrame(rows, columns=COLUMNS).astype(
        {"is_larger": bool, "is_smaller": bool}
    )


def _of_flight(name, points, m_g_um):
    n_settings = points["n_settings"].to_numpy()
    found, error = m_g_from_repeated_settings(points["spread_um"], n_settings)
    redundancy = float((n_settings - 1.0).sum())
    p_value = _p_value(found, m_g_um, redundancy)
    is_larger = p_value < FINDING_SIGNIFICANCE and found > MIN_REPORTED_RATIO * m_g_um
    counts = (len(points), n_settings.sum(), redundancy)
    is_smaller = (
        p_value > 1.0 - FINDING_SIGNIFICANCE and MIN_REPORTED_RATIO * found < m_g_um
    )
    verdicts = bool(is_larger), bool(is_smaller)
    return (name, *counts, m_g_um, found, error, p_value, *verdicts)


def _p_value(spread_um, m_g_um, redundancy):
    """Probability of at least this scatter, 2 (k − 1) s² / m_g² being χ²."""
    return ratio_p_value(spread_um / m_g_um, 2.0 * redundancy)


def spread_of_points(examined):
    """How far the settings of each point lie apart in the image: POINT_COLUMNS.

    spread_um is total, of one setting; points that were set several times, in usable
    models.
    """
    parts = [
        _points_of(name, flight, examined.models)
        for name, flight in examined.block.flights.items()
        if not flight.has_images and SPREAD in flight.model_points
    ]
    return pd.concat([pd.DataFrame(columns=POINT_COLUMNS), *parts], ignore_index=True)


def _points_of(name, flight, models):
    points = tables.with_coverage(flight.model_points).assign(flight=name)
    if "n_settings" not in points:
        points = points.assign(n_settings=1.0)
    points = points[points[SPREAD].notna() & (points["n_settings"] > 1.0)]
    scales = models[MODEL].assign(scale=scales_of_models(models, flight))
    points = points.merge(scales, on=MODEL)
    on_ground = points[SPREAD] * points["scale"]
    points = points.assign(spread_um=on_ground / flight.scale_number / METRES_PER_UM)
    points = points[points["spread_um"].notna()]
    redundancy = points["n_settings"] - 1.0
    p_value = _p_value(points["spread_um"], flight.m_g_um, redundancy)
    return points.assign(p_value=p_value)[POINT_COLUMNS]
