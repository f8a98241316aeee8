"""The tables of all flights as the observations of one adjustment, coded once."""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from einschalt.foundations import tables
from einschalt.foundations.batches import segments
from einschalt.foundations.errors import raise_problems
from einschalt.foundations.names import encode, encode_pairs
from einschalt.foundations.tables import check_table
from einschalt.theory.adjustment.least_squares import SQRT2
from einschalt.theory.block_adjustment.observations import BlockObservations

COVARIANCE = ("standard_error_easting", "standard_error_northing", "covariance_en")


@dataclass(frozen=True, eq=False)
class MeasuredFlight:
    """What one flight brings into the adjustment.

    Attributes
    ----------
    name : str
    model_points : DataFrame
        coverage, model_id, point_id, x, y.
    standard_error : ndarray, shape (n_rows,)
        Of one measured coordinate on the ground, row for row [m].
    kind : {"affine", "helmert"}
    """

    name: str
    model_points: pd.DataFrame
    standard_error: np.ndarray
    kind: str


@dataclass(frozen=True, eq=False)
class BlockTables:
    """Observations of a block, with the names behind the codes.

    Attributes
    ----------
    observations : BlockObservations
    flights : tuple of str
    models : DataFrame
        flight, coverage, model_id of each model.
    point_id : ndarray of object, shape (n_points,)
    coverage : ndarray of int, shape (n_models,)
        Number of the coverage, flights apart.
    control_row : ndarray of int, shape (n_points,)
        Row of the given coordinates, −1 where there are none.
    """

    observations: BlockObservations
    flights: tuple[str, ...]
    models: pd.DataFrame
    point_id: np.ndarray
    coverage: np.ndarray
    control_row: np.ndarray


def code_block(flights, control_points) -> BlockTables:
    """Bring the tables of a block together.

    Parameters
    ----------
    flights : sequence of MeasuredFlight
    control_points : DataFrame
        point_id, easting, northing [, standard_error_m (total)] [, role] and, where
        they are known, standard_error_easting, standard_error_northing, covariance_en.
        Check points take no part. Without any standard error control is held.

    Returns
    -------
    BlockTables

    Raises
    ------
    TableError
        A column is missing or a value is not what it should be.
    """
    parts = [_checked(flight) for flight in flights]
    numbers = [encode_pairs(part["coverage"], part["model_id"]) for part in parts]
    first = np.concatenate([[0], np.cumsum([len(number) for number in numbers])])
    model = np.concatenate(
        [number.codes + start for number, start in zip(numbers, first, strict=False)]
    )
    points = encode(
        np.concatenate([part["point_id"].to_numpy(object) for part in parts])
    )
    order = segments(model, int(first[-1])).order
    xy = np.concatenate([part[["x", "y"]].to_numpy(float) for part in parts])
    error = np.concatenate([flight.standard_error for flight in flights])
    flight = np.repeat(np.arange(len(flights)), np.diff(first))
    models = pd.DataFrame(
        {
            "flight": np.array([f.name for f in flights], dtype=object)[flight],
            "coverage": np.concatenate([number.first for number in numbers]),
            "model_id": np.concatenate([number.second for number in numbers]),
        }
    )
    given = _given_control(control_points, points)
    observations = BlockObservations(
        model=model[order],
        point=points.codes[order],
        xy=xy[order],
        standard_error=error[order],
        is_affine=np.array([f.kind == "affine" for f in flights])[flight],
        flight=flight,
        control=given.coordinates,
        control_covariance=given.covariance,
    )
    coverage = encode_pairs(models["flight"], models["coverage"]).codes
    names = tuple(flight.name for flight in flights)
    return BlockTables(observations, names, models, points.names, coverage, given.row)


def _checked(flight):
    schema = tables.MODEL_POINTS.only("coverage", "model_id", "point_id", "x", "y")
    checked = check_table(flight.model_points, schema)
    raise_problems([p.with_facts(file=p.file or flight.name) for p in checked.problems])
    return checked.frame


@dataclass(frozen=True, eq=False)
class _Given:
    coordinates: np.ndarray
    covariance: np.ndarray
    row: np.ndarray


def _given_control(control_points, points):
    """Control of each coded point."""
    n_points = len(points)
    coordinates = np.full((n_points, 2), np.nan)
    covariance = np.zeros((n_points, 2, 2))
    row = np.full(n_points, -1)
    if control_points is None or len(control_points) == 0:
        return _Given(coordinates, covariance, row)
    schema = tables.CONTROL_POINTS.only("point_id", "easting", "northing", "role")
    checked = check_table(control_points, schema)
    raise_problems(checked.problems)
    frame = checked.frame
    place = points.locate(names := encode(frame["point_id"]))[names.codes]
    is_used = (frame["role"] != "check").to_numpy() & (place >= 0)
    used = np.flatnonzero(is_used)
    coordinates[place[used]] = frame[["easting", "northing"]].to_numpy(float)[used]
    covariance[place[used]] = _covariances(control_points)[used]
    row[place[used]] = used
    return _Given(coordinates, covariance, row)


def _covariances(control_points):
    """Covariance of each row of control; 0 where no standard error is given."""
    covariance = np.zeros((len(control_points), 2, 2))
    if "standard_error_m" in control_points:
        total = control_points["standard_error_m"].to_numpy(float)
        per_coordinate = np.nan_to_num(total) / SQRT2
        covariance[:, 0, 0] = covariance[:, 1, 1] = per_coordinate**2
    if set(COVARIANCE[:2]) <= set(control_points):
        east, north = (control_points[name].to_numpy(float) for name in COVARIANCE[:2])
        both = np.zeros(len(control_points))
        if COVARIANCE[2] in control_points:
            both = np.nan_to_num(control_points[COVARIANCE[2]].to_numpy(float))
        own = np.stack(
            [np.stack([east**2, both], -1), np.stack([both, north**2], -1)], 1
        )
        is_given = np.isfinite(east) & np.isfinite(north)
        covariance[is_given] = own[is_given]
    return covariance


def with_standard_errors(observations, factors):
    """Observations whose standard errors are multiplied.

    Parameters
    ----------
    observations : BlockObservations
    factors : ndarray, shape (n_rows,)

    Returns
    -------
    BlockObservations
    """
    return replace(observations, standard_error=observations.standard_error * factors)
