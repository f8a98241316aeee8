"""Simulated blocks, many of them: what precision is claimed, and what it is.

Monte Carlo on an engine: every repetition is a task of its own, with its own seed, so
that the table is the same for any number of processes, and on a cluster.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.stats import chi2

from einschalt.foundations.errors import SettingsError
from einschalt.foundations.language import mark, mark_each, translated
from einschalt.foundations.typesetting import length, length_column, per_cent
from einschalt.pipeline.batch.local_engine import run_in_order
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.geometry import BlockGeometry
from einschalt.pipeline.simulation.noise import BlockNoise
from einschalt.pipeline.simulation.simulate_block import simulate_block

CONFIDENCE = 0.95
PAIRS_DRAWN = 4000
SIMULATING = mark("simulating blocks")
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
    # gives the block of a seed, in place of all that; it goes to other processes
    source: Callable | None = None
    title: str | None = None  # of the blocks

    def block(self, seed):
        """Simulate the block of a seed."""
        if self.source is not None:
            return self.source(seed)
        names = ("geometry", "noise", "title")
        given = {name: getattr(self, name) for name in names}
        return simulate_block(self.preset, seed=seed, **given)


@dataclass(frozen=True)
class _Repetition:
    experiment: Experiment
    seed: int


def repeat_simulation(
    experiment, n_repetitions, engine, *, first_seed=0, progress=None
):
    """Simulate and compute blocks, and set truth against claim.

    One row per repetition, with ``first_seed`` and the next ones: seed, n_points (new
    points), error_total (RMS of computed less true), standard_error_total,
    standard_error_paper, standard_error_internal (RMS of what is claimed), all TOTAL
    [m]; share_in_ellipses: of the new points whose true position lies in their 95 %
    ellipse, NaN where none are claimed. ``progress(title, fraction)`` is told.
    """
    if n_repetitions not in range(1, 10**7):
        raise SettingsError(
            f"n_repetitions = {n_repetitions!r}", expected="a whole number from 1"
        )
    seeds = range(first_seed, first_seed + n_repetitions)
    tasks = [_Repetition(experiment, seed) for seed in seeds]

    def answered(number):
        if progress is not None:
            progress(SIMULATING, number / len(tasks))

    answered(0)
    rows = run_in_order(engine, run_repetition, tasks, answered=answered)
    return pd.DataFrame(rows, columns=COLUMNS)


def run_repetition(repetition) -> dict:
    """Simulate and compute one block.

    A row of :func:`repeat_simulation`.
    """
    asked = repetition.experiment
    block = asked.block(repetition.seed)
    return claim_and_truth(block, densify(block, asked.settings))


def claim_and_truth(block, result) -> dict:
    """Set what is claimed of a simulated block's new points against the truth.

    A row of :func:`repeat_simulation`.
    """
    points = result.solution.points  # not judged: the truth is known
    new = points[points["role"] == "new"]
    error = true_errors(new, block.truth)
    return {
        "seed": block.seed,
        "n_points": len(new),
        "error_total": float(np.sqrt(np.mean(np.sum(error**2, axis=1)))),
        "standard_error_total": result.figures.mean_total,
        "standard_error_paper": result.figures.mean_paper,
        "standard_error_internal": result.figures.mean_internal,
        "share_in_ellipses": _share_in_ellipses(new, error),
    }


def chance_of_error(result) -> float:
    """Standard deviation of error_total, the RMS of true errors, by chance [m].

    Points share errors: as many as they are, they tell of few independent ones. By the
    covariances of pairs that are drawn; NaN where none are propagated.

    Notes
    -----
    The variance of the mean square of n normal errors with the covariance C is
    2 tr(C²)/n².
    """
    errors, points = result.solution.errors, result.solution.points
    new = np.flatnonzero((points["role"] == "new").to_numpy())
    if errors is None or len(new) < 2:
        return np.nan
    drawn = np.random.default_rng(0).integers(len(new), size=(PAIRS_DRAWN, 2))
    drawn = drawn[drawn[:, 0] != drawn[:, 1]]
    own = errors.covariance[new][:, :2, :2]
    between = errors.covariance_at(new[drawn])[:, :2, :2]
    own_square, square = ((part**2).sum(axis=(1, 2)).mean() for part in (own, between))
    of_mean = 2.0 * (own_square + (len(new) - 1) * square) / len(new)
    mean = np.trace(own, axis1=1, axis2=2).mean()
    return float(np.sqrt(of_mean) / (2.0 * np.sqrt(mean)))


def true_errors(points, truth):
    """Computed less true easting, northing of some points, (n_points, 2) [m]."""
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


PLANNED = mark("planned")
LABELS = mark_each(
    {
        "error_total": "true error",
        "standard_error_total": "claimed, propagated",
        "standard_error_paper": "claimed after Kovarik",
        "standard_error_internal": "claimed, internal",
    }
)


def figures_of_repetitions(table) -> dict:
    """Root mean squares over all repetitions [m], and the share in the ellipses."""
    rms = {name: _rms(table[name]) for name in COLUMNS[2:6]}
    return rms | {"share_in_ellipses": float(table["share_in_ellipses"].mean())}


def summarize_repetitions(table, planned=None) -> str:
    """Say what is claimed and what is true, over all repetitions.

    ``planned``: what a plan expects of them [m].
    """
    rms = figures_of_repetitions(table)
    share = rms["share_in_ellipses"]
    message = mark("{n:repetition|repetitions}, new points (total, RMS)")
    labels = {name: translated(text) for name, text in LABELS.items()}
    width = max(map(len, labels.values()))
    lines = [translated(message, n=len(table))]
    sizes = {name: length(rms[name]) for name in labels}
    if planned is not None:
        labels, sizes = (
            {"planned": first} | rest
            for first, rest in (
                (translated(PLANNED), labels),
                (length(planned), sizes),
            )
        )
        width = max(map(len, labels.values()))
    lines += [f"  {label:<{width}}  {sizes[name]:>8}" for name, label in labels.items()]
    if np.isfinite(share):
        message = mark("true position within the {level} ellipses: {share}")
        facts = {"level": per_cent(CONFIDENCE), "share": per_cent(share, 1)}
        lines.append(f"  {translated(message, **facts)}")
    return "\n".join(lines)


def describe_trial(planned, row, chance) -> str:
    """Set what a plan expects beside what its simulated block has come to.

    ``planned`` [m]; ``row`` is one of :func:`claim_and_truth`, ``chance`` what
    :func:`chance_of_error` gives.
    """
    sizes = {
        translated(PLANNED): planned,
        translated(LABELS["standard_error_total"]): row["standard_error_total"],
        translated(LABELS["error_total"]): row["error_total"],
    }
    width = max(map(len, sizes))
    message = mark("Planned and simulated: {n:new point|new points} (total, RMS)")
    lines = [translated(message, n=row["n_points"])]
    unit, (*texts, by_chance) = length_column([*sizes.values(), chance])
    lines += [
        f"  {label:<{width}}  {text:>6} {unit}"
        for label, text in zip(sizes, texts, strict=True)
    ]
    if np.isfinite(chance):
        message = mark("± {size} by chance")
        said = translated(message, size=f"{by_chance} {unit}")
        lines[-1] += f"  ({said})"
    return "\n".join(lines)


def _rms(values):
    values = values.dropna()
    return float(np.sqrt(np.mean(values**2))) if len(values) else np.nan
