"""Verdicts: which cause counts where several hold."""

from dataclasses import replace

import numpy as np
import pytest

from einschalt.theory.relative_orientation.surface_verdicts import (
    CAUSES,
    CRITICAL_UNCERTAINTY,
    VERDICTS,
    WEAK_UNCERTAINTY,
    Figure,
    judge,
)

GOOD = Figure(
    n_points=np.array([6]),
    relative_base=np.array([0.6]),
    is_behind=np.array([False]),
    is_located=np.array([True]),
    width=np.array([0.3]),
    inflation=np.array([1.0]),
    uncertainty=np.array([6.0]),
    flat_uncertainty=np.array([6.0]),
)
LOST = 2.0 * CRITICAL_UNCERTAINTY
SHAKY = 2.0 * WEAK_UNCERTAINTY


@pytest.mark.parametrize(
    ("changes", "cause"),
    [
        ({}, "safe"),
        ({"inflation": 1.999}, "safe"),
        ({"inflation": 2.0 - 1e-15}, "near_surface"),
        ({"inflation": 9.99}, "near_surface"),
        ({"inflation": 10.0 - 1e-14}, "at_surface"),
        ({"inflation": np.inf, "uncertainty": LOST}, "on_surface"),
        ({"inflation": np.inf, "n_points": 4}, "too_few"),
        ({"inflation": np.nan, "is_behind": True}, "behind"),
        ({"is_behind": True, "is_located": False}, "not_located"),
        ({"relative_base": 0.0}, "no_base"),
        ({"relative_base": -1.0}, "no_base"),
        ({"relative_base": np.nan}, "no_base"),
        ({"relative_base": np.inf}, "no_base"),
        ({"uncertainty": LOST, "flat_uncertainty": LOST}, "no_figure"),
        (
            {"uncertainty": LOST, "flat_uncertainty": LOST, "relative_base": 1e-3},
            "short_base",
        ),
        ({"relative_base": 1e-3}, "safe"),
        ({"relative_base": 9.99}, "safe"),
        ({"relative_base": 10.01}, "long_base"),
        ({"uncertainty": LOST}, "lost"),
        ({"flat_uncertainty": LOST}, "only_relief"),
        ({"flat_uncertainty": np.inf, "inflation": 0.0}, "only_relief"),
        ({"uncertainty": SHAKY, "flat_uncertainty": SHAKY}, "weak_figure"),
        ({"uncertainty": SHAKY, "inflation": 3.0}, "near_surface"),
        ({"width": 0.001}, "safe"),
        ({"width": 0.001, "inflation": 3.0}, "thin_figure"),
        ({"width": 0.001, "inflation": 30.0}, "no_figure"),
    ],
)
def test_first_cause_counts(changes, cause):
    arrays = {name: np.array([value]) for name, value in changes.items()}
    verdict = judge(replace(GOOD, **arrays))
    assert list(CAUSES)[verdict.cause[0]] == cause
    assert verdict.names[0] == VERDICTS[CAUSES[cause].level]
    assert (verdict.reasons[0] == "") == (cause == "safe")


def test_reasons_hold_their_figures():
    verdict = judge(replace(GOOD, inflation=np.array([14.2])))
    assert verdict.reasons[0] == (
        "its points lie near a dangerous surface, where omega is 14 times as uncertain "
        "as on flat terrain"
    )
    verdict = judge(replace(GOOD, n_points=np.array([1])))
    assert verdict.reasons[0] == "1 point, but five are needed"
