"""Simulated blocks, many of them: what precision is claimed, and what it is.

Monte Carlo on an engine: every repetition is a task of its own, with its own seed, so
that the table is the same for any number of processes, and on a cluster.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.stats import chi2

from einschalt.foundations.errors import SettingsError
from einschalt.foundations.language import mark, mark_each, translated
from einschalt.foundations.typesetting import length, per_cent
from einschalt.pipeline.batch.local_engine import run_in_order
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.geometry import BlockGeometry
from einschalt.pipeline.simulation.noise import BlockNoise
from einschalt.pipeline.simulation.simulate_block import simulate_block

CONFIDENCE = 0.95
COLUMNS = [
    *("seed", "n_points", "error_total", "standard_error_total"),
    *("standard_error_paper", "standard_error_internal", "share_in_ellipses"),
]


@dataclass(frozen=True)
class Experiment:
    """What is repeated; the fields are those of :func:`simulate_block`."""

    preset: str = "neukirchen"
    geometry: BlockGeometry | None = None
    noise: BlockNoise | None = None
    settings: Settings | None = None  # with which each block is computed


@dataclass(frozen=True)
class _Repetition:
    experiment: Experiment
    seed: int


def repeat_simulation(experiment, n_repetitions, engine, *, first_seed=0):
    """Simulate and compute blocks, and set truth against claim.

    One row per repetition, with ``first_seed`` and the next ones: seed, n_points (new
    points), error_total (RMS of computed less true), standard_error_total,
    standard_error_paper, standard_error_internal (RMS of what is claimed), all TOTAL
    [m]; share_in_ellipses: of the new points whose true position lies in their 95 %
    ellipse, NaN where none are claimed.
    """
    if n_repetitions not in range(1, 10**7):
        raise SettingsError(
            f"n_repetitions = {n_repetitions!r}", expected="a whole number from 1"
        )
    seeds = range(first_seed, first_seed + n_repetitions)
    tasks = [_Repetition(experiment, seed) for seed in seeds]
    rows = run_in_order(engine, run_repetition, tasks)
    return pd.DataFrame(rows, columns=COLUMNS)


def run_repetition(repetition) -> dict:
    """Simulate and compute one block.

    A row of :func:`repeat_simulation`.
    """
    asked = repetition.experiment
    block = simulate_block(
        asked.preset, seed=repetition.seed, geometry=asked.geometry, noise=asked.noise
    )
    result = densify(block, asked.settings)
    points = result.solution.points  # not judged: the truth is known
    new = points[points["role"] == "new"]
    error = _true_error(new, block.truth)
    return {
        "seed": repetition.seed,
        "n_points": len(new),
        "error_total": float(np.sqrt(np.mean(np.sum(error**2, axis=1)))),
        "standard_error_total": result.figures.mean_total,
        "standard_error_paper": result.figures.mean_paper,
        "standard_error_internal": result.figures.mean_internal,
        "share_in_ellipses": _share_in_ellipses(new, error),
    }


def _true_error(points, truth):
    true = truth.set_index("point_id").loc[points["point_id"]]
    axes = ["easting", "northing"]
    return points[axes].to_numpy() - true[axes].to_numpy()


def _share_in_ellipses(points, error):
    if "covariance_en" not in points:
        return np.nan
    east = points["standard_error_easting"].to_numpy() ** 2
    north = points["standard_error_northing"].to_numpy() ** 2
    both = points["covariance_en"].to_numpy()
    square = (
        north * error[:, 0] ** 2
        - 2.0 * both * error[:, 0] * error[:, 1]
        + east * error[:, 1] ** 2
    ) / (east * north - both**2)
    return float(np.mean(square <= chi2.ppf(CONFIDENCE, df=2)))


LABELS = mark_each(
    {
        "error_total": "true error",
        "standard_error_total": "claimed, propagated",
        "standard_error_paper": "claimed after Kovarik",
        "standard_error_internal": "claimed, internal",
    }
)


def summarize_repetitions(table) -> str:
    """Say what is claimed and what is true, over all repetitions."""
    rms = {name: _rms(table[name]) for name in COLUMNS[2:6]}
    share = table["share_in_ellipses"].mean()
    message = mark("{n:repetition|repetitions}, new points (total, RMS)")
    labels = {name: translated(text) for name, text in LABELS.items()}
    width = max(map(len, labels.values()))
    lines = [translated(message, n=len(table))]
    lines += [
        f"  {label:<{width}}  {length(rms[name]):>8}" for name, label in labels.items()
    ]
    if np.isfinite(share):
        message = mark("true position within the {level} ellipses: {share}")
        facts = {"level": per_cent(CONFIDENCE), "share": per_cent(share, 1)}
        lines.append(f"  {translated(message, **facts)}")
    return "\n".join(lines)


def _rms(values):
    values = values.dropna()
    return float(np.sqrt(np.mean(values**2))) if len(values) else np.nan
