"""What the two-step way reaches on simulated Neukirchen, against the truth.

The figures are those of an independent simulation (docs/theory/error_budget.md), in
centimetres, TOTAL: its layout is described there, its random numbers are others.
"""

import numpy as np
import pandas as pd
import pytest

SEEDS = range(20)


def total_errors(values, truth):
    """Total error of each row against the truth [m]."""
    columns = ["easting", "northing"]
    true = truth.set_index("point_id").loc[values["point_id"], columns].to_numpy()
    return np.hypot(*(values[columns].to_numpy() - true).T)


def rms_cm(values):
    return 100.0 * np.sqrt(np.mean(np.asarray(values) ** 2))


def figures_of(result, truth):
    single = most_central(result.single_values)
    return {
        "approximations": rms_cm(total_errors(result.approximations, truth)),
        "single": rms_cm(total_errors(single, truth)),
        "mean": rms_cm(total_errors(result.points, truth)),
        "single_paper": 100.0 * result.figures.single_paper,
        "mean_paper": 100.0 * result.figures.mean_paper,
        "mean_internal": 100.0 * result.figures.mean_internal,
    }


def most_central(values):
    """Choose by plain pandas, so that the test does not lean on stage 5."""
    eccentricity = values[["position_u", "position_v"]].abs().max(axis=1)
    rows = eccentricity.groupby([values["point_id"], values["coverage"]]).idxmin()
    return values.loc[rows]


@pytest.fixture(scope="module")
def most_central_figures(neukirchen, densified_neukirchen):
    rows = [
        figures_of(
            densified_neukirchen(seed, "most_central", "plain"), neukirchen(seed).truth
        )
        for seed in SEEDS
    ]
    return pd.DataFrame(rows)


@pytest.mark.parametrize(
    ("figure", "expected", "tolerance"),
    [
        ("approximations", 9.3, 0.6),
        ("single", 6.2, 0.4),
        ("mean", 5.4, 0.4),
        ("single_paper", 5.2, 0.2),
        ("mean_paper", 3.7, 0.2),
    ],
)
def test_most_central_of_both_coverages(
    most_central_figures, figure, expected, tolerance
):
    assert most_central_figures[figure].mean() == pytest.approx(expected, abs=tolerance)


def test_paper_and_internal_figures_are_too_small(most_central_figures):
    mean = most_central_figures.mean()
    assert mean["mean"] / mean["mean_paper"] > 1.3
    assert mean["mean_internal"] == pytest.approx(3.03, abs=0.15)
    assert mean["mean_internal"] < mean["mean_paper"] < mean["mean"]


def test_all_models_of_both_flights(neukirchen, densified_neukirchen):
    points = [densified_neukirchen(seed, "all", "plain").points for seed in SEEDS]
    truths = [neukirchen(seed).truth for seed in SEEDS]
    means = [rms_cm(total_errors(*pair)) for pair in zip(points, truths, strict=True)]
    assert np.mean(means) == pytest.approx(4.8, abs=0.4)
