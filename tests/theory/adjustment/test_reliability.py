import numpy as np

from einschalt.theory.adjustment.reliability import redundancy_numbers
from einschalt.theory.transformation.affine import fit_affine


def test_one_less_leverage():
    np.testing.assert_array_equal(redundancy_numbers([0.25, 1.0]), [0.75, 0.0])


def test_never_below_zero_through_rounding():
    assert redundancy_numbers([1.0 + 1e-15])[0] == 0.0
    assert np.isnan(redundancy_numbers([np.nan])[0])


def test_error_of_an_observation_shows_with_minus_its_redundancy_number():
    rng = np.random.default_rng(1)
    xy = rng.uniform(-100, 100, (8, 2))
    en = 3.0 * xy
    clean = fit_affine(xy, en, np.ones(8), np.array([0, 8]))
    wrong = en.copy()
    wrong[5, 0] += 1.0
    fit = fit_affine(xy, wrong, np.ones(8), np.array([0, 8]))
    # residuals are transformed − given
    change = fit.residuals[5, 0] - clean.residuals[5, 0]
    np.testing.assert_allclose(change, -redundancy_numbers(fit.leverage)[5, 0])
