import numpy as np
import pytest

from einschalt.theory.error_budget import total_error


def test_both_parts_add_by_squares():
    # 5 µm at 1:8000 are 4 cm; with 3 cm of the transformation 5 cm
    assert total_error(5e-6, 8000, 0.03) == pytest.approx(0.05, rel=1e-12)


def test_centre_of_a_model_of_the_paper():
    # Kovarik 1971, table 4a: 1:6000, m_g 10 µm, m_0 10 cm, a point every 200 m (28.6
    # in the overlap): m_t = m_0/√n in the centre, M printed as 6 cm
    found = 100 * total_error(10e-6, 6000, 0.10 / np.sqrt(28.6))
    assert found == pytest.approx(6.0, abs=0.5)


def test_arrays_of_any_shape():
    found = total_error(np.array([[0.0], [5e-6]]), 8000, np.array([0.0, 0.03]))
    np.testing.assert_allclose(found, [[0.0, 0.03], [0.04, 0.05]], rtol=1e-12)


def test_unknown_stays_unknown():
    assert np.isnan(total_error(5e-6, 8000, np.nan))
