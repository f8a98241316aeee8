"""Models of a spatial block without the bends that all of a flight share.

What all models of a flight are bent by shows where they are adjusted together. Two
steps, which transform model by model, begin with models that are corrected by it, and
its error is one of their sources.
"""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from einschalt.foundations.errors import GeometryError
from einschalt.stages.simultaneous.adjustment import (
    GIVEN_UP,
    AdjustmentOptions,
    begin_search,
)
from einschalt.stages.simultaneous.determined_part import (
    determined_part,
    part_of,
)
from einschalt.stages.simultaneous.outlier_removal import weigh_part
from einschalt.stages.simultaneous.shared_bends import (
    every_term,
    find_shared_bends,
    made_by_errors,
)
from einschalt.stages.simultaneous.tables import scale_table
from einschalt.stages.stage2_relative_orientation import RelativeOrientation
from einschalt.theory.block_adjustment.common_border import UndeterminedTermsError
from einschalt.theory.block_adjustment.gross_errors import ContradictedModelError
from einschalt.theory.block_adjustment.shared_bend import AnswerToBends, BendTest
from einschalt.theory.block_adjustment.spatial_solution import NoConvergenceError

XYZ = ["x", "y", "z"]
# an adjustment of more takes as long as all that two steps do
MOST_MODELS = 2000


@dataclass(frozen=True, eq=False)
class BentFlights:
    """Bends that models of each flight share, as an adjustment of all shows them."""

    # of each flight: what coefficients of 1 move its model points by, and the
    # projection centres after them, row for row, (n_rows, 3, n_terms) [model units]
    columns: dict[str, np.ndarray]
    coefficients: np.ndarray  # (n_terms,), with the sign of what corrects the models
    covariance: np.ndarray  # (n_terms, n_terms)
    tests: dict[str, BendTest]  # of each flight that has terms
    # flights whose heights are out of scale, which is not corrected: as of a
    # BlockAdjustment; a flight without terms may have one
    height_scales: pd.DataFrame

    def straightened(
        self, flights: dict[str, RelativeOrientation]
    ) -> dict[str, RelativeOrientation]:
        """Correct the models of the flights."""
        return {
            name: self._corrected(oriented, self.columns[name] @ self.coefficients)
            for name, oriented in flights.items()
        }

    @staticmethod
    def _corrected(oriented, moved):
        points, centres = oriented.model_points, oriented.centres
        n_points = len(points)
        corrected = points.assign(**_moved(points, moved[:n_points]))
        if len(moved) > n_points:
            centres = centres.assign(**_moved(centres, moved[n_points:]))
        return replace(oriented, model_points=corrected, centres=centres)


def _moved(table, by):
    return {name: table[name] + by[:, k] for k, name in enumerate(XYZ)}


def bent_flights(tables, outliers, significance, searches) -> BentFlights | None:
    """Estimate the bends that models of each flight share; None where none show.

    Nor heights that are out of scale.

    All models of the tables (BlockTables) are adjusted together for it, without those
    that contradict the others; of more than 2000 this is not done. ``outliers``:
    whether gross errors are kept. ``searches``: Searches that adjustments of these
    tables share.
    """
    if not tables.is_spatial or len(tables.models) > MOST_MODELS:
        return None
    snoops = "keep" if outliers == "keep" else "snoop"
    options = AdjustmentOptions(
        deformation="modelled", outliers=snoops, significance=significance
    )
    part, verdicts = determined_part(tables)
    try:
        for _ in range(len(tables.models) // 2):
            try:
                return _estimated(tables, part, verdicts, options, searches)
            except (NoConvergenceError, ContradictedModelError) as error:
                placed = np.flatnonzero(verdicts.is_fine)
                if error.n_models != len(placed):  # of an adjustment of some of them
                    return None
                verdicts.verdict[placed[error.model]] = GIVEN_UP[type(error)]
                part = part_of(tables, verdicts)
    except (GeometryError, UndeterminedTermsError):
        pass  # all models together are not determined: nothing tells
    return None


def _estimated(tables, part, verdicts, options, searches):
    part, begun, search = begin_search(tables, part, verdicts, options, searches)
    weighed = search()
    bends = find_shared_bends(tables, weighed, options)
    scales = scale_table(tables, bends)
    if bends.modelled is None:
        return _without_terms(tables, scales) if len(scales) else None
    part = bends.given_to(part)
    begun = begun.readjusted(part.observations)
    weighed = weigh_part(tables, part, begun, options)
    solution = weighed.block.solution
    plain = replace(solution.observations, shared_bend=None)
    plain = solution.readjusted(plain)
    answer = AnswerToBends.of(plain, bends.modelled)
    made = made_by_errors(tables, weighed, plain, answer)
    cofactors = solution.common_cofactors
    every = every_term(tables).of_flights(bends.flights)
    return BentFlights(
        _by_flight(tables, every.columns),
        solution.common,
        cofactors @ made.sums @ cofactors,
        {
            tables.flights[test.flight]: test
            for test in bends.tests
            if test.flight in bends.flights
        },
        scales,
    )


def _without_terms(tables, scales):
    """Straight models whose heights are out of scale."""
    none = np.zeros((len(tables.row), 3, 0))
    columns = _by_flight(tables, none)
    return BentFlights(columns, np.zeros(0), np.zeros((0, 0)), {}, scales)


def _by_flight(tables, columns):
    """Displacements of the rows of each flight's own table."""
    ends = np.cumsum(tables.n_rows)
    in_order = np.zeros((ends[-1], *columns.shape[1:]))
    in_order[tables.row] = columns
    starts = ends - tables.n_rows
    return {
        name: in_order[start:end]
        for name, start, end in zip(tables.flights, starts, ends, strict=True)
    }
