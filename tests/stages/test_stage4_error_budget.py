import numpy as np
import pandas as pd
import pytest

import einschalt as es
from einschalt.foundations.errors import SettingsError


def test_micrometres_and_scale_number_become_metres_on_the_ground():
    # 5 µm at 1:8000 are 4 cm; with 3 cm of the transformation 5 cm
    assert es.error_budget(5.0, 8000, 0.03) == pytest.approx(0.05, rel=1e-12)
    assert es.error_budget(10, 6000, 0) == pytest.approx(0.06, rel=1e-12)


def test_number_gives_a_number_and_table_an_array():
    assert isinstance(es.error_budget(5.0, 8000, 0.03), float)
    found = es.error_budget(5.0, 8000, pd.Series([0.0, 0.03]))
    np.testing.assert_allclose(found, [0.04, 0.05], rtol=1e-12)
    grid = es.error_budget([[5.0], [10.0]], 8000, [0.0, 0.03, 0.06])
    assert grid.shape == (2, 3)


def test_unknown_error_of_the_transformation_stays_unknown():
    # a minimal model has no m_0: nothing is said instead of something wrong
    found = es.error_budget(5.0, 8000, np.array([np.nan, 0.03]))
    np.testing.assert_allclose(found, [np.nan, 0.05])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((-5.0, 8000, 0.03), r"m_g_um = -5; expected 0 or more"),
        ((5.0, 0, 0.03), r"scale_number = 0; expected a positive number"),
        ((5.0, [8000, -6000], 0.03), r"scale_number = -6000; expected a positive"),
        ((5.0, 8000, [0.1, -0.03]), r"m_t = -0\.03; expected 0 or more"),
    ],
)
def test_errors_below_zero_are_refused(arguments, message):
    with pytest.raises(SettingsError, match=message):
        es.error_budget(*arguments)
