"""The tables of all flights as the observations of one adjustment, coded once."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from einschalt.foundations import tables
from einschalt.foundations.batches import segments
from einschalt.foundations.errors import TableError, name_some, raise_problems
from einschalt.foundations.frame_columns import values_of
from einschalt.foundations.names import encode, encode_pairs, ranks
from einschalt.foundations.tables import check_table
from einschalt.stages.simultaneous.image_errors import MeasuredImages
from einschalt.stages.simultaneous.shared_control import INDEPENDENT, shared_control
from einschalt.stages.transformation_kinds import SPATIAL
from einschalt.theory.adjustment.least_squares import SQRT2
from einschalt.theory.adjustment.point_operator import Axes
from einschalt.theory.block_adjustment.observations import BlockObservations
from einschalt.theory.block_adjustment.spatial_observations import SpatialObservations

COVARIANCES = {
    (0, 1): "covariance_en",
    (0, 2): "covariance_eh",
    (1, 2): "covariance_nh",
}
CENTRE = "is_centre"


@dataclass(frozen=True, eq=False)
class MeasuredFlight:
    """What one flight brings into the adjustment."""

    name: str
    # coverage, model_id, point_id, x, y [, z, is_centre]; where that is true, the row
    # is a projection centre
    model_points: pd.DataFrame
    # (n_rows,), or (n_rows, 3) of spatial models; of one measured coordinate on the
    # ground, row for row [m]
    standard_error: np.ndarray
    # affine, helmert or helmert_3d, which needs the other flights to be so too
    kind: str
    # (n_rows, 2, n_elements): measured coordinates by independent errors of variance 1
    # that all points of a model share, in their unit; of plane models
    orientation: np.ndarray | None = None
    # image points behind the model points, where these come from images
    images: MeasuredImages | None = None


@dataclass(frozen=True, eq=False)
class BlockTables:
    """Observations of a block, with the names behind the codes."""

    observations: BlockObservations | SpatialObservations
    flights: tuple[str, ...]
    models: pd.DataFrame  # flight, coverage, model_id of each model
    kind: np.ndarray  # (n_models,): affine, helmert or helmert_3d
    point_id: np.ndarray  # (n_points,)
    # (n_points,): projection centres of spatial models; their point_id is flight and
    # image_id with a blank between them
    is_centre: np.ndarray
    coverage: np.ndarray  # (n_models,): number of the coverage, flights apart
    row: np.ndarray  # (n_rows,): row of each observation in the tables of all flights
    n_rows: tuple[int, ...]  # of the table of each flight
    images: tuple[MeasuredImages | None, ...]  # of each flight

    @property
    def has_unknown_groups(self) -> bool:
        """Whether control shares shifts whose size neither table nor block tells."""
        shared = self.observations.shared_control
        return shared is not None and shared.is_unknown

    @property
    def is_spatial(self) -> bool:
        """Whether the models are spatial, and the points have heights."""
        return isinstance(self.observations, SpatialObservations)


def code_block(flights, control_points, known=INDEPENDENT) -> BlockTables:
    """Bring the tables of a block together.

    ``known`` says what the errors of control have in common (SharedErrors).

    ``control_points``: point_id, easting, northing [, height, NaN where a point is
    known in plan alone] [, standard_error_m
    (total)] [, role] and, where they are known, standard_error_easting,
    standard_error_northing, standard_error_height, covariance_en, covariance_eh,
    covariance_nh. Check points take no part. Without any standard error control is
    held.
    """
    parts = [_checked(flight) for flight in flights]
    numbers = [encode_pairs(part["coverage"], part["model_id"]) for part in parts]
    first = np.concatenate([[0], np.cumsum([len(number) for number in numbers])])
    model = np.concatenate(
        [number.codes + start for number, start in zip(numbers, first, strict=False)]
    )
    points, is_centre = _encode_points(parts)
    is_spatial = any(flight.kind == SPATIAL for flight in flights)
    flight = np.repeat(np.arange(len(flights)), np.diff(first))
    kind = np.array([f.kind for f in flights], dtype=object)[flight]
    models = _model_names(flights, flight, numbers)
    control, control_row = _given_control(control_points, points, is_spatial=is_spatial)
    order = segments(model, int(first[-1])).order
    xyz = _coordinates(parts, is_spatial=is_spatial)
    measured = {
        "model": model[order],
        "point": points.codes[order],
        "standard_error": np.concatenate([f.standard_error for f in flights])[order],
        **_of_names(flight, models, points),
        **control,
    }
    if not is_spatial and (shared := _orientation(flights)) is not None:
        measured["orientation"] = shared[order]
    observations = _observations(xyz[order], kind, measured)
    common = shared_control(control_points, known, control_row, observations.point_rank)
    if common is not None:
        observations = observations.with_shared_control(common)
    return BlockTables(
        observations,
        tuple(flight.name for flight in flights),
        models,
        kind,
        _as_given(points.names, is_centre),
        is_centre,
        encode_pairs(models["flight"], models["coverage"]).codes,
        order,
        tuple(len(part) for part in parts),
        tuple(flight.images for flight in flights),
    )


def _model_names(flights, flight, numbers):
    """Names of all models: flight, coverage, model_id."""
    return pd.DataFrame(
        {
            "flight": np.array([f.name for f in flights], dtype=object)[flight],
            "coverage": np.concatenate([number.first for number in numbers]),
            "model_id": np.concatenate([number.second for number in numbers]),
        }
    )


def _of_names(flight, models, points):
    """Fields of the observations that names of models and points decide."""
    return {
        "flight": flight,
        "model_rank": ranks(*(models[name] for name in models)),
        "point_rank": ranks(points.names),
    }


def _coordinates(parts, *, is_spatial):
    """Of the models of all flights, shape (n_rows, 2) or (n_rows, 3)."""
    names = list("xyz" if is_spatial else "xy")
    return np.concatenate([values_of(part, names) for part in parts])


def _orientation(flights):
    """Errors of orientations of all flights; 0 where there are none."""
    known = [f.orientation for f in flights if f.orientation is not None]
    if not known:
        return None
    n_elements = known[0].shape[2]
    parts = [
        np.zeros((len(f.model_points), 2, n_elements))
        if f.orientation is None
        else f.orientation
        for f in flights
    ]
    return np.concatenate(parts)


def _observations(xyz, kind, measured):
    if xyz.shape[1] == len("xyz"):
        return SpatialObservations(xyz=xyz, **measured)
    return BlockObservations(xy=xyz, is_affine=kind == "affine", **measured)


# no name of a point begins like this
HIDDEN = "\x00"


def _encode_points(parts):
    """Points by name, projection centres apart from points of the same name."""
    is_centre = np.concatenate([_is_centre(part) for part in parts])
    names = np.concatenate([part["point_id"].to_numpy(object) for part in parts])
    names[is_centre] = HIDDEN + names[is_centre]
    points = encode(names)
    of_points = np.zeros(len(points), dtype=bool)
    of_points[points.codes[is_centre]] = True
    return points, of_points


def _as_given(names, is_centre):
    """Names without the mark of projection centres."""
    names = np.array(names, dtype=object)
    names[is_centre] = [name.removeprefix(HIDDEN) for name in names[is_centre]]
    return names


def _is_centre(part):
    if CENTRE not in part:
        return np.zeros(len(part), dtype=bool)
    return part[CENTRE].to_numpy(bool)


def _checked(flight):
    axes = "xyz" if flight.kind == SPATIAL else "xy"
    schema = tables.MODEL_POINTS.only("coverage", "model_id", "point_id", *axes)
    if flight.kind == SPATIAL:
        schema = schema.requiring("z")
    checked = check_table(flight.model_points, schema)
    raise_problems([p.with_facts(file=p.file or flight.name) for p in checked.problems])
    if CENTRE not in flight.model_points:
        return checked.frame
    return checked.frame.assign(**{CENTRE: flight.model_points[CENTRE].to_numpy()})


def _given_control(control_points, points, *, is_spatial):
    """Fields of the observations that are of control, and its row for each point."""
    axes = (Axes.SPACE if is_spatial else Axes.PLANE).names
    n_points, d = len(points), len(axes)
    coordinates = np.full((n_points, d), np.nan)
    covariance = np.zeros((n_points, d, d))
    given = {"control": coordinates, "control_covariance": covariance}
    row = np.full(n_points, -1)
    if control_points is None or len(control_points) == 0:
        return given, row
    schema = tables.CONTROL_POINTS.only("point_id", *axes, "role")
    if is_spatial:
        schema = schema.requiring("height")
    checked = check_table(control_points, schema)
    raise_problems(checked.problems)
    frame = checked.frame
    place = points.locate(names := encode(frame["point_id"]))[names.codes]
    is_used = (frame["role"] != "check").to_numpy() & (place >= 0)
    used = np.flatnonzero(is_used)
    coordinates[place[used]] = (known := values_of(frame, axes))[used]
    own = _covariances(control_points, axes)
    is_none = np.isnan(known)
    own[is_none[:, :, None] | is_none[:, None, :]] = 0.0  # known in plan alone
    _refuse_impossible(own, is_none, frame)
    covariance[place[used]] = own[used]
    row[place[used]] = used
    return given, row


def _refuse_impossible(covariance, is_none, frame):
    """Refuse covariances that no errors can have; ``is_none`` are not given, (n, d)."""
    is_given = covariance.any(axis=(1, 2))
    whole = covariance + is_none[:, :, None] * np.eye(is_none.shape[1])
    is_possible = np.linalg.eigvalsh(whole)[:, 0] > 0.0
    wrong = np.flatnonzero(is_given & ~is_possible)
    if len(wrong) == 0:
        return
    raise TableError(
        f"standard errors and covariances of {name_some(frame['point_id'].iloc[wrong])}"
        " contradict each other, or are given in part",
        expected="a standard error of each coordinate, and covariances below their "
        "products",
        remedy="Complete them, or delete covariance_en and its like",
        file="control_points",
    )


def _covariances(control_points, axes):
    """Covariance of each row of control; 0 where no standard error is given.

    A height that has no standard error of its own has that of one coordinate.
    """
    n, d = len(control_points), len(axes)
    covariance = np.zeros((n, d, d))
    if "standard_error_m" in control_points:
        total = control_points["standard_error_m"].to_numpy(float)
        covariance[:, range(d), range(d)] = (np.nan_to_num(total) / SQRT2)[:, None] ** 2
    for axis, name in enumerate(axes):
        own = control_points.get(f"standard_error_{name}")
        if own is not None:
            known = own.notna().to_numpy()
            covariance[known, axis, axis] = own.to_numpy(float)[known] ** 2
    for (one, other), name in COVARIANCES.items():
        if name in control_points and other < d:
            both = np.nan_to_num(control_points[name].to_numpy(float))
            covariance[:, one, other] = covariance[:, other, one] = both
    return covariance
