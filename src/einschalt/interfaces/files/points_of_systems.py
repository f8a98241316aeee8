"""Ground points of any reference system, brought into that of the block.

Plane systems have columns easting, northing in their own unit, geographic ones
longitude, latitude: named columns, so that no authority's order of axes matters.
"""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from einschalt.foundations import tables
from einschalt.foundations.coordinate_operations import (
    Operation,
    offline,
    system_label,
)
from einschalt.foundations.errors import (
    EinschaltError,
    ProjectionError,
    SettingsError,
    TableError,
)
from einschalt.foundations.projections import (
    METRE,
    read_crs,
    read_source_crs,
    reproject,
    turn,
)
from einschalt.pipeline.block.axis_order import tells_axes
from einschalt.pipeline.block.places import target_problems
from einschalt.pipeline.block.ways_between_systems import (
    BY_AXIS,
    PLANE,
    gives_heights,
    has_heights,
    in_as_many_axes,
)

GEOGRAPHIC = ("longitude", "latitude")
UNITS = {"degree": "degrees", "metre": "metres", "grad": "grads"}


def schema_in(schema, crs):
    """Schema of points that are given in a system of their own, in its unit.

    With longitude and latitude where it is geographic.
    """
    of_plane, *_, of_heights = (
        UNITS.get(axis.unit_name, f"{axis.unit_name} units") for axis in crs.axis_info
    )
    names = dict(zip(PLANE, GEOGRAPHIC if crs.is_geographic else PLANE, strict=True))
    changed = {name: (other, of_plane) for name, other in names.items()}
    if len(crs.axis_info) > len(PLANE):
        changed["height"] = "height", of_heights
    columns = (
        replace(c, **dict(zip(("name", "unit"), changed[c.name], strict=True)))
        if c.name in changed
        else c
        for c in schema.columns
    )
    return replace(schema, columns=tuple(columns))


def require_columns(frame, crs, source):
    """Refuse degrees in columns that say metres."""
    has = set(frame.columns)
    if crs.is_geographic and has & set(PLANE) and not has & set(GEOGRAPHIC):
        unit = UNITS.get(crs.axis_info[0].unit_name, "its unit")
        raise TableError(
            f"{system_label(crs)} is geographic, but the columns are easting and "
            "northing",
            expected=f"columns longitude and latitude, in {unit}",
            remedy="Rename the columns, or name the plane system of the coordinates",
            file=source,
            row=1 if frame.index.name == tables.LINE else None,
        )


def other_system(toml, crs, name):
    """System of the points of a table, where that of the block is known and another.

    ``toml``: what block.toml says, to which faults of the systems are added.
    """
    try:
        own = read_source_crs(crs)
    except EinschaltError as error:
        found = f"[{name}] {error.found}"
        where = {"file": toml.source, "section": name, "key": "crs"}
        toml.say(error.with_facts(found=found, **where), name, "crs")
        return None
    of_block = _crs_of_block(toml)
    if of_block is None and ("block", "crs") not in toml.said:
        file = toml.sections[name].file
        problem = SettingsError(
            "[block] crs is missing",
            expected=f"a system into which {file} is transformed",
            remedy=f"Add crs = … to [block], or take it out of [{name}]",
            file=toml.source,
            section="block",
            key="crs",
        )
        toml.say(problem, "block", "crs")
    try:
        is_other = of_block is not None and own != read_crs(of_block)
    except EinschaltError:  # said by check_facts
        return None
    return own if is_other else None


def is_in_no_system(toml, crs, name):
    """Whether a fault of their crs leaves open what the coordinates of points are.

    That is said, and what they are not in another system is no fault of theirs.
    """
    faulty = {(name, "crs")} if crs is None else {(name, "crs"), ("block", "crs")}
    is_said = bool(faulty & toml.said)
    of_block = _crs_of_block(toml)
    if not is_said and crs is not None and of_block is not None:
        try:
            read_crs(of_block)
        except EinschaltError:  # said by check_facts
            is_said = True
    if is_said:
        toml.said.add((name, "file"))
    return is_said


def _crs_of_block(toml):
    block = toml.sections.get("block")
    return block.crs if block else None


def is_same_plane(system, stated):
    """Whether a system is the stated one, heights aside; also where that is unknown."""
    try:
        return system.to_2d() == read_source_crs(stated).to_2d()
    except ProjectionError:  # said where the stated one is read
        return True


def with_plane_names(frame):
    """Points with their first two coordinates called easting and northing."""
    return frame.rename(columns=dict(zip(GEOGRAPHIC, PLANE, strict=True)))


@dataclass(frozen=True, eq=False)
class Brought:
    """Points in the system of the block."""

    frame: pd.DataFrame
    operation: Operation
    note: str  # what was done
    axes_told: bool  # whether their system tells easting from northing there


def bring(frame, checked, systems, demand, *, grids=None, source=""):
    """Bring points into the system of the block.

    ``frame`` is as read and ``checked`` as understood, with plane names in both;
    ``systems`` are their own and that of the block. An EinschaltError where no
    operation meets the ``demand``, the points lie elsewhere, or nobody knows what their
    heights are in the system of the block.
    """
    _require_system_of_heights(checked, *systems)
    (own, target), said = in_as_many_axes(*systems, checked)
    names = [*PLANE, "height"] if has_heights(own) else PLANE
    given = checked[names].to_numpy(dtype=float)
    lacks_height = np.isnan(given).any(axis=1)
    points = np.where(np.isnan(given), np.nanmean(given, axis=0), given)
    problems = target_problems(points, own, target, source)
    if problems:
        raise problems[0]
    moved, operation, better = reproject(points, own, target, demand, grids)
    columns = {name: moved[:, place] for place, name in enumerate(names)}
    if "height" in columns:
        columns["height"] = np.where(lacks_height, np.nan, columns["height"])
    columns |= _turned_errors(checked, points, own, operation, grids)
    labels = map(system_label, systems)
    note = transformation_note(source, len(frame), *labels, operation)
    if better is not None:
        note += better.as_better()
    is_told = _axes_told(checked, points, own, target)
    return Brought(frame.assign(**columns), operation, f"{note}{said}", is_told)


def transformation_note(source, n_points, own, target, operation) -> str:
    """Write how points came from their system into that of the block."""
    grids = " and ".join(name for name, _ in operation.grids)
    if not grids:
        return (
            f"{source}: {n_points} points transformed from {own} to {target} by "
            f"{operation}"
        )
    return (
        f"{source}: {n_points} points transformed from {own} to {target} by "
        f"{operation} with {grids}"
    )


def _axes_told(checked, points, own, target):
    """Whether points with axes exchanged would lie outside of one of both systems."""
    exchanged = points.copy()
    exchanged[:, :2] = points[:, 1::-1]
    return tells_axes(checked, own) or bool(target_problems(exchanged, own, target, ""))


def _require_system_of_heights(checked, own, target):
    """Refuse heights of which nobody knows what they are in the system of the block."""
    if not gives_heights(checked) or has_heights(own) == has_heights(target):
        return
    way = f"{system_label(own)} to {system_label(target)}"
    if has_heights(target):
        raise ProjectionError(
            f"{way}: the heights of the points have no system, those of the block do",
            expected="crs of the points with their heights, such as EPSG:25833+5621",
            remedy="Add the vertical system to crs of the points, or take that of the "
            "block away",
        )
    if own.is_compound and own.axis_info[-1].unit_name == METRE:
        return
    kind = f"in {own.axis_info[-1].unit_name}" if own.is_compound else "ellipsoidal"
    raise ProjectionError(
        f"{way}: the heights of the points are {kind}, and the block has no system of "
        "heights",
        expected="crs of the block with its heights, such as EPSG:31255+5778",
        remedy="Add the vertical system to crs of the block, or take the heights out",
    )


def _turned_errors(checked, points, own, operation, grids):
    """Standard errors along the axes of the block, where the table has them by axis."""
    names = BY_AXIS
    if not set(names) <= set(checked):
        return {}
    with offline(grids):
        angle = turn(points, own, operation)
    covariance = np.zeros((len(checked), 3, 3))
    covariance[:, 0, 0], covariance[:, 1, 1] = (checked[names].to_numpy() ** 2).T
    pairs = {"covariance_en": (0, 1), "covariance_eh": (0, 2), "covariance_nh": (1, 2)}
    for name, (one, two) in pairs.items():
        if name in checked:
            covariance[:, one, two] = covariance[:, two, one] = checked[name]
    rotation = np.zeros_like(covariance)
    rotation[:, 0, 0] = rotation[:, 1, 1] = np.cos(angle)
    rotation[:, 1, 0] = np.sin(angle)
    rotation[:, 0, 1] = -rotation[:, 1, 0]
    rotation[:, 2, 2] = 1.0
    turned = rotation @ covariance @ np.swapaxes(rotation, 1, 2)
    errors = {n: np.sqrt(turned[:, k, k]) for k, n in enumerate(names)}
    kept = {n: at for n, at in pairs.items() if n == "covariance_en" or n in checked}
    return errors | {name: turned[:, one, two] for name, (one, two) in kept.items()}
