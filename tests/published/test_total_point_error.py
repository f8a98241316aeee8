"""Finsterwalder and Mohr 1960, and a block of 994 points: what 'total' means.

Both print errors per coordinate and of the point: total = √(m_x² + m_y²), and √2 times
the coordinate's where both are equal. So Kovarik 1971 uses them, and this project.
"""

import numpy as np
import pandas as pd

import einschalt as es
from einschalt.theory.adjustment.least_squares import total_from_coordinate


def test_total_from_both_coordinates(read_case):
    case = read_case("convention_total_point_error")
    # differences ±d/2 of two coverages: the error of a single value is |d| / √2
    half = np.column_stack([case["data"]["mx"], case["data"]["my"]]) / np.sqrt(2.0)
    for errors, printed in zip(half, case["printed"]["m_total"], strict=True):
        values = pd.DataFrame(
            np.array([errors, -errors]), columns=["easting", "northing"]
        ).assign(point_id="a", coverage=["1", "2"])
        mean = es.average_coverages(values)
        # 0.11: the components are printed to 0.1 as well
        np.testing.assert_allclose(mean.internal_single, printed, rtol=0, atol=0.11)


def test_total_is_root_two_of_coordinate(read_case):
    printed = read_case("convention_total_point_error")["printed"]
    found = total_from_coordinate(printed["m_coord"])
    # half a unit of the coordinate's error, times √2, and of the total
    np.testing.assert_allclose(found, printed["m_lage"], rtol=0, atol=0.121)
