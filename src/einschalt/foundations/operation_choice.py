"""Which of the operations between two reference systems is used, and why no other.

Only what is as good as is asked, and what a user names: never in silence. Errors tell
the candidates, and every way out.
"""

from dataclasses import dataclass, replace

import numpy as np

from einschalt.foundations.coordinate_operations import (
    CONVERSION,
    find_operations,
    held_grids,
    names_of,
    system_label,
)
from einschalt.foundations.databases_of_proj import second_name_of
from einschalt.foundations.errors import ProjectionError, name_some

MOST_CANDIDATES = 5
SEVERAL = ";"  # between the names of operations


@dataclass(frozen=True)
class Demand:
    """What is asked of an operation."""

    accuracy_m: float  # worst that may be used
    reason: str  # where that comes from, as messages say it
    # (parts of) names or codes of those that are taken whatever their accuracy
    operation: str = ""
    is_stated: bool = False  # by a user: then it holds where PROJ states none
    epoch: float | None = None  # of the coordinates, a decimal year
    is_fixed: bool = False  # whether no setting allows another one

    @property
    def names(self):
        """Names or codes of the operations that are asked for."""
        parts = (part.strip() for part in self.operation.split(SEVERAL))
        return [part for part in parts if part]


def choose_operation(source, target, bounds, demand):
    """Choose the operation between two systems for points within bounds [degrees].

    The most accurate one that is available, or the one that was asked for; and a better
    one whose grid is missing, or None. A ProjectionError names the candidates where
    none is good enough, or the one asked for is none of them.
    """
    found = find_operations(source, target, bounds)
    candidates = [one.at(demand.epoch) for one in found]
    way = f"{system_label(source)} to {system_label(target)}"
    if not candidates:
        raise _no_operation(source, target, bounds, way)
    if demand.names:
        return _chosen(candidates, way, demand), None
    enough = [one for one in candidates if one.accuracy_m <= demand.accuracy_m]
    good = [one for one in enough if one.can_run]
    if not good:
        _require_epoch(enough, way)
        raise ProjectionError(
            f"{way}: no operation is good enough; {_said(candidates)}",
            expected=f"an accuracy of {demand.accuracy_m:g} m, {demand.reason}",
            remedy=_remedy(candidates, demand),
        )
    best = candidates[0]
    is_better = not best.can_run and best.accuracy_m < good[0].accuracy_m
    return good[0], best if is_better else None


def _require_epoch(operations, way):
    """Refuse operations that lack nothing but the epoch of the coordinates."""
    lacking = [one for one in operations if one.transformer and not one.can_run]
    if lacking:
        raise ProjectionError(
            f"{way}: {lacking[0]}, and none is given: the frames move against each "
            "other, by centimetres a year",
            expected="the epoch for which the coordinates hold, as a decimal year",
            remedy="Set crs_epoch, such as crs_epoch = 2020.5",
        )


def _no_operation(source, target, bounds, way):
    """Tell datums that are not known to each other from heights that are not."""
    flat = source.to_2d(), target.to_2d()
    if flat != (source, target) and find_operations(*flat, bounds):
        return ProjectionError(
            f"PROJ knows no operation from {way} for heights, such as by a geoid, and "
            "one for the plan alone",
            expected="heights of a system that PROJ can bring into the other",
            remedy="Give the heights in the vertical system of the block, or take the "
            "vertical systems out of crs where the heights are in one already",
        )
    return ProjectionError(
        f"PROJ knows no operation from {way} that it can compute",
        expected="systems whose datums are known, and known to each other there",
        remedy="Correct crs, or give the coordinates in the system of the block",
    )


def _chosen(candidates, way, demand):
    wanted = demand.names
    called = [one for one in candidates if any(map(one.is_called, wanted))]
    called = [one for one in called if any(map(one.is_exactly, wanted))] or called
    usable = [one for one in called if one.transformer is not None]
    asked = f"{way}: crs_operation = {demand.operation!r}"
    if not called and candidates[0].name == CONVERSION:
        return candidates[0]  # it is for another way: here the datum stays
    if not called:
        raise ProjectionError(
            f"{asked} is none of the operations",
            expected=_said(candidates),
            remedy="Write one of these names, or its EPSG code; of several ways, such "
            f"as to output_crs, those of each, separated by {SEVERAL!r}",
        )
    if not usable:
        raise ProjectionError(
            f"{asked} cannot be used: {_said(called)}",
            expected="a grid that is there",
            remedy=f"{_where(called[0].missing)}. Or choose another operation",
        )
    _require_epoch(usable[:1], asked)
    one = usable[0]
    share_a_code = any(all(o.has_code(name) for o in called) for name in wanted)
    if not share_a_code and len({other.name for other in called}) > 1:
        raise ProjectionError(
            f"{asked} fits {len(called)} operations: {_said(called)}",
            expected="one of them",
            remedy="Write its whole name, or its EPSG code",
        )
    if np.isfinite(one.accuracy_m):
        return one
    if not demand.is_stated:
        raise ProjectionError(
            f"{asked}: PROJ states no accuracy for it",
            expected="an accuracy, since it is a source of error",
            remedy="Set crs_accuracy_m to the accuracy that it has",
        )
    return replace(one, accuracy_m=demand.accuracy_m)


def _said(candidates):
    rest = len(candidates) - MOST_CANDIDATES
    shown = candidates[:MOST_CANDIDATES]
    said = "; ".join(f"{one.name}: {one.worth}" for one in shown)
    return f"{said}; {rest} other operations" if rest > 0 else said


def _where(grids, is_fixed=False):
    """Say where grids are to be had, and where they are looked for."""
    names = names_of(grids)
    addresses = " and ".join(address for _, address in grids if address)
    seconds = [second_name_of(name) for name, _ in grids]
    seconds = " and ".join(name for name in seconds if name is not None)
    where = f"Get {names} from {addresses}, or from the national survey"
    if not addresses:
        where = f"Get {names} from the national survey"
    ways = [where]
    if seconds:
        ways.append(f"The national survey may call it {seconds}")
    if is_fixed:
        ways.append("PROJ looks for it in the folders that PROJ_DATA names")
        return ". ".join(ways)
    ways.append("Name its folder with --grids, or grids in [settings]")
    held = held_grids()
    if held is not None:  # folders that were named, beside PROJ's own
        ways.append(f"The folder that is named holds {name_some(held) or 'none'}")
    return ". ".join(ways)


def _remedy(candidates, demand):
    """Tell every way out: the grid, the accuracy, another operation."""
    stated = [one for one in candidates if np.isfinite(one.accuracy_m)]
    usable = [one for one in stated if one.transformer is not None]
    if demand.is_fixed:
        missing = stated[0].missing if stated else ()
        return _where(missing, is_fixed=True) if missing else ""
    ways = []
    if stated and stated[0].missing:
        best = stated[0]
        ways = [_where(best.missing)]
        if best.accuracy_m > demand.accuracy_m:
            ways.append(f"Set crs_accuracy_m = {best.accuracy_m:g} to use it")
    if usable:
        one = usable[0]
        keys = f"crs_accuracy_m = {one.accuracy_m:g}"
        keys = keys if one.can_run else f"crs_epoch and {keys}"
        use = f"Set {keys} to use {one.name}"
        ways.append(f"Or: {use}" if ways else use)
    else:
        ways.append("Choose an operation with crs_operation and crs_accuracy_m")
    return ". ".join(ways)
