"""The precision that is reported is the precision that it has.

Monte Carlo over simulated blocks with known truth: the propagated covariance must hold
the true errors; Kovarik's budget beside it does not.
"""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import chi2

SEEDS = range(20)
MODES = [
    ("most_central", "plain"),
    ("most_central", "weighted"),
    ("all", "plain"),
    ("all", "weighted"),
    ("all", "rigorous"),
]


def errors_of(result, truth):
    columns = ["easting", "northing"]
    true = truth.set_index("point_id").loc[result.points["point_id"], columns]
    return result.points[columns].to_numpy() - true.to_numpy()


@pytest.fixture(scope="module", params=MODES, ids=" ".join)
def runs(request, neukirchen, densified_neukirchen):
    """Errors and claims of 20 blocks, shape (20, n_points, ...)."""
    coverage_mean, weighting = request.param
    errors, covariances, paper = [], [], []
    for seed in SEEDS:
        result = densified_neukirchen(seed, coverage_mean, weighting)
        errors.append(errors_of(result, neukirchen(seed).truth))
        covariances.append(result.covariance)
        paper.append(result.points["standard_error_paper"].to_numpy())
    return SimpleNamespace(
        errors=np.concatenate(errors),
        covariances=np.concatenate(covariances),
        paper=np.concatenate(paper),
    )


def normalised_squares(runs):
    inverse = np.linalg.inv(runs.covariances)
    return np.einsum("ni,nij,nj->n", runs.errors, inverse, runs.errors)


def test_normalised_squared_error_is_one(runs):
    assert normalised_squares(runs).mean() / 2 == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize(("level", "tolerance"), [(0.95, 0.01), (0.393, 0.02)])
def test_ellipses_hold_what_they_say(runs, level, tolerance):
    inside = normalised_squares(runs) < chi2.ppf(level, 2)
    assert inside.mean() == pytest.approx(level, abs=tolerance)


def test_ellipses_of_the_paper_do_not(runs):
    per_coordinate = runs.paper**2 / 2
    squares = (runs.errors**2).sum(axis=1) / per_coordinate
    assert (squares < chi2.ppf(0.95, 2)).mean() < 0.80
