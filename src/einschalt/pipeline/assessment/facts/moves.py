"""How far points were moved: by iterations, and by the distribution of residuals."""

from dataclasses import dataclass

import numpy as np

from einschalt.pipeline.densification.iteration import LEAST_MOVE


@dataclass(frozen=True)
class IterationFacts:
    """The passes of the low flight onto its own coordinates."""

    # pass, largest move [m], at which point, root mean square [m]
    moves: tuple[tuple[int, float, str, float], ...]
    is_converged: bool
    least_move: float  # below which the passes end [m]
    most_passes: int  # that were asked for
    # control points that were held, models that have one, usable models
    n_held: int
    n_models_held: int
    n_models: int
    # propagated error of the new points after the first and the last pass, TOTAL, RMS
    # [m]; NaN where the errors were not propagated
    total_of_one_pass: float
    total: float


@dataclass(frozen=True)
class DistributionFacts:
    """Residuals of control, distributed to the points between them."""

    way: str  # residual_distribution of the settings
    # role, number of points, root mean square and largest move, TOTAL [m]
    moves: tuple[tuple[str, int, float, float], ...]
    is_propagated: bool  # whether there are standard errors of the points after it


def iteration_facts(examined) -> IterationFacts | None:
    """Collect the moves of all passes; None where one pass was asked for."""
    iteration = examined.iteration
    if iteration is None:
        return None
    table = iteration.moves
    columns = ("iteration", "largest_move", "point_id", "move_rms")
    rows = zip(*(table[name] for name in columns), strict=True)
    return IterationFacts(
        moves=tuple((int(k), float(most), p, float(rms)) for k, most, p, rms in rows),
        is_converged=iteration.is_converged,
        least_move=LEAST_MOVE,
        most_passes=examined.settings.iterations,
        n_held=iteration.n_held,
        n_models_held=iteration.n_models_held,
        n_models=iteration.n_models,
        total_of_one_pass=examined.total_of_one_pass,
        total=float(examined.figures.mean_within),
    )


def distribution_facts(examined) -> DistributionFacts | None:
    """Say how far the distribution of residuals moved points of each role, if any."""
    points = examined.points
    if "distributed_easting" not in points:
        return None
    moved = np.hypot(points["distributed_easting"], points["distributed_northing"])
    moves = tuple(
        (role, len(part), float(np.sqrt(np.mean(part**2))), float(part.max()))
        for role, part in moved.groupby(points["role"])
    )
    way = examined.settings.residual_distribution
    return DistributionFacts(way, moves, "standard_error_total" in points)
