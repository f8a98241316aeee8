"""The system in which results are told, where it is not that of the block.

Everything is computed in the system of the block. What is told of it is brought over at
the end: coordinates by the operation between the two systems, vectors and covariances
by its derivatives, which turn and scale them. The accuracy of the operation is an error
that all points share, as that of an operation by which control came.
"""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from einschalt.foundations.coordinate_operations import (
    Operation,
    offline,
    system_label,
)
from einschalt.foundations.errors import ProjectionError, SettingsError
from einschalt.foundations.frame_columns import PLAN, values_of
from einschalt.foundations.language import mark
from einschalt.foundations.projections import (
    label_of,
    plane_jacobian,
    read_crs,
    reproject,
)
from einschalt.foundations.units import RADIANS_PER_GON
from einschalt.pipeline.block.places import scale_problems, target_problems
from einschalt.pipeline.block.ways_between_systems import (
    BY_AXIS,
    demand_of,
    gives_heights,
    has_heights,
    in_as_many_axes,
    standard_errors_of,
)
from einschalt.stages.error_propagation.shared_error import APPROXIMATE, CONTROL

POSITIONS = ("", "two_step_")  # prefixes of columns that say where a point lies
VECTORS = ("residual", "difference", "distributed")
# lengths in the plane, which change with its scale
LENGTHS = (
    *("distance", "semi_major", "semi_minor", "spread_total"),
    *("largest_move", "move_rms", "m_t"),
)
AZIMUTH = "azimuth_gon"
OTHER_OUTPUT = mark("Name the system or the zone of the place as output_crs")


@dataclass(frozen=True, eq=False)
class OutputSystem:
    """The way from the system of a block into that of its results."""

    crs: str  # name of the system of the results
    # own, target: systems of pyproj (CRS), both with heights or both without
    own: Any
    target: Any
    operation: Operation
    grids: Path | None  # folder of grids beside PROJ's own
    note: str  # what was done

    @property
    def is_spatial(self) -> bool:
        """Whether heights change as well."""
        return has_heights(self.own)

    def told(
        self, table: pd.DataFrame | None, positions: pd.DataFrame | None = None
    ) -> pd.DataFrame | None:
        """Bring a table of results into the system of the results.

        ``positions``: easting, northing [, height] by point_id in the system of the
        block, for tables that have none. Other columns than those of points and vectors
        stay as they are, such as parameters of models.
        """
        if table is None or not len(table):
            return table
        points = self._where_rows_lie(table, positions)
        with offline(self.grids):
            jacobian = plane_jacobian(points, self.operation)
        scale = np.sqrt(np.abs(np.linalg.det(jacobian)))
        columns = {}
        for prefix in POSITIONS:
            if f"{prefix}{PLAN[0]}" in table:
                columns |= self._coordinates(table, points, prefix)
        columns |= _turned_vectors(table, jacobian)
        columns |= _turned_errors(table, jacobian)
        if AZIMUTH in table:
            columns[AZIMUTH] = _turned_azimuth(table[AZIMUTH].to_numpy(), jacobian)
        for name in table:
            if _is_length_in_plane(name) and name not in columns:
                columns[name] = table[name].to_numpy(dtype=float) * scale
        return table.assign(**columns)

    def _where_rows_lie(self, table, positions):
        """Where the rows lie; those that lie nowhere, in the middle of the others."""
        names = [*PLAN, "height"] if self.is_spatial else PLAN
        known = table if PLAN[0] in table else positions.reindex(table["point_id"])
        points = known.reindex(columns=names).to_numpy(dtype=float)
        whole = (table if positions is None else positions).reindex(columns=names)
        return np.where(np.isnan(points), np.nanmean(whole, axis=0), points)

    def _coordinates(self, table, points, prefix):
        """Positions of rows that lie at ``points``, in columns with a prefix."""
        axes = [*PLAN, "height"] if self.is_spatial else PLAN
        given = table.reindex(columns=[f"{prefix}{axis}" for axis in axes])
        known = given.notna().to_numpy()
        known = known & known[:, : len(PLAN)].all(axis=1, keepdims=True)
        at = np.where(known, given.to_numpy(dtype=float), points)
        with offline(self.grids):
            moved = np.where(known, self.operation.apply(at), np.nan)
        return {name: moved[:, k] for k, name in enumerate(given) if name in table}


def _is_length_in_plane(column):
    """Whether the scale of the plane changes a column: never one of heights."""
    if "height" in column.split("_"):
        return False
    return column in LENGTHS or column.startswith("standard_error_")


def _turned_vectors(table, jacobian):
    columns = {}
    for prefix in VECTORS:
        names = [f"{prefix}_{axis}" for axis in PLAN]
        if set(names) <= set(table):
            given = values_of(table, names)
            turned = np.einsum("nij,nj->ni", jacobian, given)
            columns |= dict(zip(names, turned.T, strict=True))
    return columns


def _turned_errors(table, jacobian):
    if not {*BY_AXIS, "covariance_en"} <= set(table):
        return {}
    covariance = np.empty((len(table), 2, 2))
    covariance[:, 0, 0], covariance[:, 1, 1] = (table[BY_AXIS].to_numpy() ** 2).T
    covariance[:, 0, 1] = covariance[:, 1, 0] = table["covariance_en"]
    turned = jacobian @ covariance @ np.swapaxes(jacobian, 1, 2)
    columns = {name: np.sqrt(turned[:, k, k]) for k, name in enumerate(BY_AXIS)}
    columns["covariance_en"] = turned[:, 0, 1]
    if {"covariance_eh", "covariance_nh"} <= set(table):
        with_height = values_of(table, ["covariance_eh", "covariance_nh"])
        turned = np.einsum("nij,nj->ni", jacobian, with_height)
        columns["covariance_eh"], columns["covariance_nh"] = turned.T
    return columns


def _turned_azimuth(azimuth, jacobian):
    along = np.column_stack(
        [np.sin(azimuth * RADIANS_PER_GON), np.cos(azimuth * RADIANS_PER_GON)]
    )
    east, north = np.einsum("nij,nj->in", jacobian, along)
    return np.mod(np.arctan2(east, north) / RADIANS_PER_GON, 200.0)


def output_system_of(block, settings) -> OutputSystem | None:
    """The way into the system that the settings ask for; None where it is the block's.

    A ProjectionError where no operation is accurate enough for the control points, or
    nobody knows what the heights are there.
    """
    name = settings.output_crs
    if not name:
        return None
    if block.crs is None:
        raise SettingsError(
            f"output_crs = {label_of(name)}, but the block has no crs",
            expected="the system of its coordinates",
            remedy="Add crs = … to [block], or take output_crs out",
        )
    try:
        own, target = read_crs(block.crs), read_crs(name)
    except ProjectionError as error:
        raise error.with_facts(found=f"output_crs: {error.found}") from error
    if own == target:
        return None
    known, error = _known_points(block)
    _require_system_of_heights(own, target, known)
    flat, said = in_as_many_axes(own, target, known)
    names = [*PLAN, "height"] if has_heights(flat[0]) else PLAN
    points = values_of(known, names)
    points = np.where(np.isnan(points), np.nanmean(points, axis=0), points)
    problems = target_problems(points, *flat, source=None)
    if problems:
        raise problems[0].with_facts(file=None, remedy=OTHER_OUTPUT)
    demand, grids = demand_of(settings, error), _grids(block, settings)
    moved, operation, better = reproject(points, *flat, demand, grids)
    distorted = scale_problems(*moved[:, :2].T, flat[1], source=None)
    if distorted:
        found = f"output_crs: {distorted[0].found}"
        raise distorted[0].with_facts(found=found, remedy=OTHER_OUTPUT)
    note = (
        f"output_crs: results transformed from {system_label(own)} to "
        f"{system_label(target)} by {operation}; parameters of models lead to "
        f"{system_label(own)}"
    )
    note += said
    if better is not None:
        note += better.as_better()
    return OutputSystem(name, *flat, operation, grids, note)


def _known_points(block):
    """Points that the results hang on, and their TOTAL standard errors [m] or None."""
    control = block.control_points
    if control is None:
        return block.approximate_points, block.approximate_m_0_m
    return control, standard_errors_of(control, None)


def _require_system_of_heights(own, target, points):
    if gives_heights(points) and has_heights(target) and not has_heights(own):
        raise ProjectionError(
            f"output_crs has a system of heights, {system_label(target)}, and the "
            f"block has none, {system_label(own)}",
            expected="crs of the block with its heights, such as EPSG:31255+5778",
            remedy="Add the vertical system to crs of the block, or take that of "
            "output_crs away",
        )


def _grids(block, settings):
    """Folder of grids, which the settings name from that of the block."""
    if not settings.grids:
        return None
    home = Path(block.files[0]).parent if block.files else Path()
    return home / settings.grids


def with_output_system(block, settings):
    """The block, with the error that the way into the output system adds to it.

    It is shared by all points, as that of an operation by which control came. With a
    note of what is done.
    """
    output = output_system_of(block, settings)
    if output is None or output.note in block.notes:  # a block of a result has it
        return block
    accuracy = output.operation.accuracy_m
    shared = {
        name: float(np.hypot(block.shared_errors_m.get(name, 0.0), accuracy))
        for name in (CONTROL, APPROXIMATE)
    }
    kept = block.shared_errors_m if accuracy == 0.0 else shared
    return replace(block, shared_errors_m=kept, notes=(*block.notes, output.note))
