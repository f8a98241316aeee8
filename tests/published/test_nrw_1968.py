"""Nordrhein-Westfalen 1968: every point is measured in two coverages, and averaged.

A difference beyond 0.25 m is printed with both values; the mean of the point shown is
half a unit off in the northing, 70392.255 printed as 70392.26. Of the table of
differences ten rows are legible. The printed errors 5.5 and 4.0 cm of one value and of
the mean differ by 1/√2 within their print.
"""

import numpy as np
import pandas as pd
import pytest

import einschalt as es

HALF_UNIT = 0.005


@pytest.fixture
def case(read_case):
    return read_case("nrw1968_double_measurement")


def two_coverages(first, second):
    parts = []
    for coverage, values in (("1", first), ("2", second)):
        part = pd.DataFrame(np.atleast_2d(values), columns=["easting", "northing"])
        names = [f"{place + 1:04d}" for place in range(len(part))]
        parts.append(part.assign(coverage=coverage, point_id=names))
    return pd.concat(parts, ignore_index=True)


def test_mean_and_difference(case):
    data, printed = case["data"], case["printed"]
    values = two_coverages(data["first"], data["second"])
    result = es.average_coverages(values)
    mean = result.points[["easting", "northing"]].to_numpy()[0]
    # 1e-9 for the northing: 70392.255 lies on the edge of the interval
    np.testing.assert_allclose(mean, printed["mean"], rtol=0, atol=HALF_UNIT + 1e-9)
    difference = result.used.set_index("coverage")[["easting", "northing"]]
    found = (difference.loc["2"] - difference.loc["1"]).to_numpy()
    np.testing.assert_allclose(found, printed["difference"], rtol=0, atol=1e-9)
    # |d| / √2 is both the spread of one value and its error from the difference
    total = np.hypot(*printed["difference"]) / np.sqrt(2.0)
    np.testing.assert_allclose(result.points["spread_total"], total, rtol=1e-9)
    np.testing.assert_allclose(result.internal_single, total, rtol=1e-9)


def test_errors_from_the_table_of_differences(case):
    differences = np.array(case["data"]["differences_within_tolerance_R_H"])
    assert np.abs(differences).max() <= case["data"]["tolerance_m"]
    origin = np.array([28695.0, 70392.0])
    values = two_coverages(origin - differences / 2, origin + differences / 2)
    result = es.average_coverages(values)
    # note of the source: 0.060 m per coordinate for one value, 0.042 m for the mean
    np.testing.assert_allclose(
        result.internal_single / np.sqrt(2.0), 0.060, rtol=0, atol=5e-4
    )
    np.testing.assert_allclose(
        result.points["standard_error_internal"] / np.sqrt(2.0), 0.042, atol=5e-4
    )
    np.testing.assert_allclose(
        result.points[["easting", "northing"]], np.tile(origin, (10, 1)), rtol=1e-12
    )


def test_one_value_against_the_mean(case):
    printed = case["printed"]
    values = two_coverages([0.0, 0.0], [0.1, 0.0])
    result = es.average_coverages(values)
    found = result.points["standard_error_internal"].iloc[0] / result.internal_single
    ratio = printed["mean_error_mean_5000_cm"] / printed["mean_error_single_5000_cm"]
    # 4.0 ± 0.05 against 5.5 ± 0.05, and the rounding of the centimetres
    np.testing.assert_allclose(found, ratio, rtol=0, atol=0.03)
