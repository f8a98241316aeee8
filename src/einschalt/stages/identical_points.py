"""Identical points: those that models and ground coordinates have in common."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from einschalt.foundations import tables
from einschalt.foundations.arguments import as_numbers
from einschalt.foundations.batches import segments
from einschalt.foundations.errors import TableError
from einschalt.foundations.frame_columns import columns_of, values_of
from einschalt.foundations.names import CodedPairs, pair_up, rows_of_names
from einschalt.stages.transformation_kinds import Kind
from einschalt.theory.transformation.point_tests import CommonPoints

ROW_NAMES = ("coverage", "model_id", "point_id")


@dataclass(frozen=True, eq=False)
class Observations:
    """Identical points of both frames, sorted by model."""

    # source, target: (n, n_coordinates)
    source: np.ndarray
    target: np.ndarray
    weights: np.ndarray  # (n,)
    start: np.ndarray  # (n_models + 1,)
    rows: pd.DataFrame  # their coverage, model_id, point_id
    # row_numbers, ground_rows: (n,): their places in the tables of model points and of
    # ground points
    row_numbers: np.ndarray
    ground_rows: np.ndarray
    models: CodedPairs  # coverage and model_id of all rows of the model points
    given: tables.CheckedTable  # the model points

    @property
    def points(self) -> CommonPoints:
        """The same as plain arrays, for theory."""
        return CommonPoints(self.source, self.target, self.weights, self.start)

    @classmethod
    def of(
        cls,
        checked: tables.CheckedTable,
        placed: tables.CheckedTable,
        kind: Kind,
        weights: ArrayLike | pd.Series | None,
    ) -> "Observations":
        """Find the identical points of two checked tables."""
        models = pair_up(checked.coded["coverage"], checked.coded["model_id"])
        model_points, ground = checked.frame, placed.frame
        ground_row = rows_of_names(model_points["point_id"], ground["point_id"])
        target = values_of(ground, kind.target)
        is_whole = np.isfinite(target).all(axis=1)
        common = np.flatnonzero((ground_row >= 0) & is_whole[ground_row])
        sort = segments(models.codes[common], len(models))
        rows = common[sort.order]
        ground_rows = ground_row[rows]
        of_rows = _weights_of_rows(model_points, weights)
        return cls(
            source=values_of(model_points, kind.source)[rows],
            target=target[ground_rows],
            weights=_weights(model_points, ground, of_rows, rows, ground_rows),
            start=sort.start,
            rows=columns_of(model_points, ROW_NAMES).take(rows),
            row_numbers=rows,
            ground_rows=ground_rows,
            models=models,
            given=checked,
        )


def _weights_of_rows(model_points, weights):
    """Bring ``weights`` into one array for the rows of the model points, or None."""
    n_rows = len(model_points)
    if weights is None:
        return None
    if isinstance(weights, pd.Series):
        by_point = pd.to_numeric(weights, errors="coerce")
        by_row = by_point
        by_point = by_point.set_axis(weights.index.map(str))
        is_by_row = by_row.index.equals(model_points.index)
        is_by_point = model_points["point_id"].isin(by_point.index).any()
        if is_by_row and is_by_point:
            raise TableError(
                "the index of weights is that of the rows, and names points as well",
                expected="one or the other",
                remedy="Give an array for the rows, or a Series by point_id",
            )
        if is_by_row:
            return by_row.to_numpy(dtype=float)
        if by_point.index.is_unique:
            return model_points["point_id"].map(by_point).to_numpy(dtype=float)
        raise TableError(
            "weights has several rows for it",
            expected="a Series with each point_id once, or one weight for each row",
            point=by_point.index[by_point.index.duplicated()][0],
        )
    expected = "a Series by point_id, or one weight for each row of model_points"
    given = as_numbers("weights", weights, expected=expected)
    if given.shape not in {(), (n_rows,)}:
        raise TableError(
            f"weights has the shape {given.shape}",
            expected=f"one weight for each of the {n_rows} rows of model_points",
            remedy="Or give a Series by point_id",
        )
    return np.broadcast_to(given, n_rows)


def _weights(model_points, ground, of_rows, rows, ground_rows):
    """Product of all the weights that an observation was given."""
    weights = np.ones(len(rows))
    if of_rows is not None:
        weights *= of_rows[rows]
    if "weight" in model_points:
        weights *= model_points["weight"].to_numpy()[rows]
    if "weight" in ground:
        weights *= ground["weight"].to_numpy()[ground_rows]
    is_good = np.isfinite(weights) & (weights > 0.0)
    if is_good.all():
        return weights
    place = int(np.argmin(is_good))
    raise TableError(
        f"weight {weights[place]} of an observation",
        expected="a positive weight for every point",
        remedy="Give it a weight, or take the point out",
        point=model_points["point_id"].iloc[rows[place]],
        model=model_points["model_id"].iloc[rows[place]],
    )
