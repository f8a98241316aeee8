"""The part of a block that can be determined, and where its models stand to begin."""

import numpy as np
import pandas as pd

from einschalt.foundations.errors import GeometryError, name_some
from einschalt.stages.simultaneous.failed_models import STAGE, why_failed
from einschalt.stages.simultaneous.outlier_removal import begin_part, with_centres
from einschalt.theory.block_adjustment import determinacy
from einschalt.theory.block_adjustment.spatial_solution import adjust_models

WHOLE_BLOCK = "No model of the block could be determined"


def determined_part(tables):
    """Part of a block that can be determined, and the verdicts on all its models."""
    observations = tables.observations
    if tables.is_spatial:
        every = np.ones(observations.n_models, dtype=bool)
        ground = _without_centres(tables, every).observations
        observations = ground.ties_in_plan()
    verdicts = determinacy.examine(observations)
    return part_of(tables, verdicts), verdicts


def placed_points(tables):
    """Coordinates of the points by a plain adjustment, without precision and tests.

    DataFrame of point_id, easting, northing [, height]; projection centres have none. A
    GeometryError where nothing can be determined, a NoConvergenceError where spatial
    models do not converge.
    """
    part, _ = determined_part(tables)
    return places_of(tables, part, adjust_models(part.observations))


def places_of(tables, part, solution):
    """Coordinates of the points of a solution, projection centres without."""
    is_ground = ~tables.is_centre[part.points]
    names = ["easting", "northing", "height"][: solution.points.shape[1]]
    table = pd.DataFrame(solution.points[is_ground], columns=names)
    table.insert(0, "point_id", tables.point_id[part.points][is_ground])
    return table


def part_of(tables, verdicts):
    """Part with the models that are fine, without projection centres.

    A GeometryError where none is.
    """
    if not verdicts.is_fine.any():
        reason, remedy = why_failed(verdicts, 0, tables.kind[0])
        raise GeometryError(
            f"{WHOLE_BLOCK}: {reason}",
            expected="models that hang together, with control",
            remedy=remedy,
            model=name_some(tables.models["model_id"]),
            stage=STAGE,
        )
    return _without_centres(tables, verdicts.is_fine)


def _without_centres(tables, is_kept):
    """Points on the ground of the models that are kept."""
    observations = tables.observations
    is_ground = ~tables.is_centre[observations.point]
    rows = np.flatnonzero(is_ground & is_kept[observations.model])
    return observations.of_rows(rows, np.flatnonzero(is_kept))


def _terms(part, options):
    flights = set(part.observations.flight.tolist())
    return tuple(terms for terms in options.common if terms.flight in flights)


def begun_part(tables, part, verdicts, options):
    """Part without loose models, which become verdicts, and its block to begin with."""
    begun = begin_part(part, options, _terms(part, options))
    while (loose := determinacy.loose_models(begun.solution)).any():
        cause = determinacy.why_loose(begun.solution, loose)
        verdicts.verdict[part.models[loose]] = cause[loose]
        part = part_of(tables, verdicts)
        begun = begin_part(part, options, _terms(part, options))
    if tables.is_centre.any():
        part, begun = with_centres(tables, part, begun, verdicts.is_fine)
    return part, begun
