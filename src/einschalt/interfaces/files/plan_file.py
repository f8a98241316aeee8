"""A plan in JSON: what other programs read of it, and what its simulation needs.

The file stands in the folder of a plan; heights of the ground stand beside it.
"""

import json
import math
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd
from pydantic import TypeAdapter, ValidationError

from einschalt.foundations import tables
from einschalt.foundations.arguments import described
from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import (
    BlockError,
    EinschaltError,
    FileError,
    raise_problems,
)
from einschalt.interfaces.files.atomic import write_text
from einschalt.interfaces.files.input_files import read_text_bytes
from einschalt.interfaces.files.json_text import parsed_json
from einschalt.interfaces.files.tables_by_suffix import read_table, write_table
from einschalt.pipeline.planning.area.flight_area import FlightArea
from einschalt.pipeline.planning.area.simulated_plan import PlannedBlock, another_row
from einschalt.pipeline.planning.estimate.search import PlanFrame
from einschalt.pipeline.planning.flights.flight_design import FlightDesign
from einschalt.pipeline.planning.ground.ground_heights import GroundHeights

PLAN_FILE, HEIGHTS_FILE, ROWS_FILE = "plan.json", "ground_heights.parquet", "plans.csv"
FORMAT = 1
ANEW = "Plan again with einschalt plan … --output FOLDER"

HEIGHTS = tables.Schema(
    "ground_heights",
    (
        *(
            tables.Column(name, unit="metres")
            for name in ("easting", "northing", "height", "lowest", "highest")
        ),
        # 1 beside the area: cameras fly over it too, and its border lies between
        tables.Column("is_beside", is_required=False, default=0.0),
    ),
    key=(),
)
ROW_UNITS = {
    "scale_number": "numbers such as 8000 for 1:8000",
    "high_scale_number": "numbers such as 8000 for 1:8000",
    "spacing": "metres",
    "m_g_um": "micrometres",
    **dict.fromkeys(("n_settings", "n_coverages", "control_per_model"), "numbers"),
}
ROWS = tables.Schema(
    "plans",
    tuple(tables.Column(n, unit=u, is_positive=True) for n, u in ROW_UNITS.items()),
    key=(),
)


@dataclass(frozen=True)
class _Area:
    """How the area of a plan is written."""

    geometry: dict  # of GeoJSON, in the system of the plan
    crs: str | None = None
    name: str = ""
    heights: str | None = None  # HEIGHTS_FILE, where there are some
    follows: bool = False


@dataclass(frozen=True)
class _Written:
    """What a simulation reads of plan.json."""

    format: int
    expected: float
    design: dict
    frame: dict | None = None
    area: _Area | None = None


def write_plan_file(folder, planned, figures, frame=None):
    """Write a planned block, with the figures that programs are told of it.

    ``frame`` is that of the search that it is from.
    """
    content = {
        "format": FORMAT,
        "expected": planned.expected,
        "figures": plain(figures),
        "design": plain(asdict(planned.design)),
        "frame": None if frame is None else plain(asdict(frame)),
        "area": None if planned.area is None else _written_area(planned, folder),
    }
    text = json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False)
    write_text(folder / PLAN_FILE, f"{text}\n")


def plain(value):
    """What JSON can hold: no number that is none or infinite, nothing of numpy."""
    if isinstance(value, dict):
        return {str(key): plain(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [plain(one) for one in value]
    if hasattr(value, "item"):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _written_area(planned, folder):
    import shapely  # noqa: PLC0415 - loaded when an area is planned

    area, heights = planned.area, planned.heights
    if heights is not None:
        parts = [heights] if heights.beside is None else [heights, heights.beside]
        tables_of = [_table_of(part, k) for k, part in enumerate(parts)]
        write_table(pd.concat(tables_of, ignore_index=True), folder / HEIGHTS_FILE)
    return {
        "geometry": shapely.geometry.mapping(area.shape),
        "crs": area.crs,
        "name": planned.name,
        "heights": None if heights is None else HEIGHTS_FILE,
        "follows": planned.follows,
    }


def _table_of(heights, is_beside):
    extremes = [heights.height, heights.height]
    if heights.extremes is not None:
        extremes = heights.extremes.T
    columns = *heights.plane.T, heights.height, *extremes, float(is_beside)
    return pd.DataFrame(dict(zip(HEIGHTS.names, columns, strict=True)))


def read_plan_file(path, row=None) -> PlannedBlock:
    """Read a plan's folder, or its plan.json, as a block that can be simulated.

    ``row``: another one of the plans in plans.csv, counted from 1. FileError where a
    file is missing or damaged.
    """
    path = Path(path)
    path = path / PLAN_FILE if path.is_dir() else path
    written = _content(path)
    with _named(path.name):
        planned, frame = _planned(written, path.parent)
    if row is None:
        return planned
    values = _row(path.parent / ROWS_FILE, row)
    if frame is None:
        raise FileError(
            f"has no frame, with which plan {row} of {ROWS_FILE} could be laid out",
            expected="the frame of a search",
            remedy="Leave --row out, or plan again with --target",
            file=path.name,
        )
    with _named(ROWS_FILE, int(values.name)):
        return another_row(planned, values, frame)


@contextmanager
def _named(file, row=None):
    """Name the file in errors that do not know where the faulty value stands."""
    try:
        yield
    except BlockError as error:
        raise BlockError([_with_place(p, file, row) for p in error.problems]) from None
    except EinschaltError as error:
        raise _with_place(error, file, row) from None


def _with_place(error, file, row):
    return error if error.file else error.with_facts(file=file, row=row)


def _content(path):
    source = path.name
    data = read_text_bytes(path, source)
    try:
        content = parsed_json(data)
        content = content if isinstance(content, dict) else {}
        known = {n: content[n] for n in _Written.__dataclass_fields__ if n in content}
        written = _valid(_Written, known)
    except RecursionError:
        raise _damaged("it is nested too deeply", source) from None
    except (ValueError, TypeError) as error:
        raise _damaged(str(error), source) from None
    if written.format != FORMAT:
        raise _damaged(f"it has the format {written.format}", source)
    return written


def _damaged(why, source):
    return FileError(
        f"is no plan that can be simulated: {shortened(why, 80)}",
        expected="plan.json as einschalt plan writes it",
        remedy=ANEW,
        file=source,
    )


def _valid(kind, fields):
    """Build a dataclass of what JSON holds, its values of the kinds that it names."""
    unknown = sorted(set(fields) - set(kind.__dataclass_fields__))
    if unknown:
        raise ValueError(f"{unknown[0]} is unknown")
    try:
        # of JSON, since there a list may be a tuple, and a text still is no number
        return TypeAdapter(kind).validate_json(json.dumps(fields), strict=True)
    except ValidationError as error:
        fault = error.errors()[0]
    where = ".".join(map(str, fault["loc"]))
    if fault["type"].startswith("missing"):
        raise ValueError(f"{where} is missing")
    raise ValueError(f"{where} = {described(fault['input'])}")


def _planned(written, folder):
    """The block that is written, and the frame of its search, if there was one."""
    design, frame = dict(written.design), None
    if design.get("most_work", 0.0) is None:
        design["most_work"] = np.inf
    try:
        design = _valid(FlightDesign, design)
        if written.frame is not None:
            frame = _valid(PlanFrame, written.frame)
    except (ValueError, TypeError) as error:
        raise _damaged(str(error), PLAN_FILE) from None
    if not 0.0 < written.expected < np.inf:
        raise _damaged(f"expected is {written.expected:g}", PLAN_FILE)
    if written.area is None:
        return PlannedBlock(design, written.expected), frame
    area = _area_of(written.area)
    heights = None
    if written.area.heights is not None:
        if written.area.heights != HEIGHTS_FILE:
            named = described(written.area.heights)
            raise _damaged(f"area.heights = {named}", PLAN_FILE)
        heights = _heights_of(folder / HEIGHTS_FILE, area)
    return PlannedBlock(
        *(design, written.expected, area, heights),
        max_height=None if frame is None else frame.max_height,
        follows=written.area.follows,
        name=written.area.name,
    ), frame


def _area_of(written):
    import shapely  # noqa: PLC0415 - loaded when an area is planned

    try:
        shape = shapely.from_geojson(json.dumps(written.geometry, allow_nan=False))
    except (shapely.errors.ShapelyError, ValueError):
        raise _damaged("the area is no polygon", PLAN_FILE) from None
    return FlightArea(shape, written.crs)


def _heights_of(path, area):
    checked = tables.check_table(read_table(path, HEIGHTS), HEIGHTS, source=path.name)
    raise_problems(checked.problems)
    values = checked.frame[HEIGHTS.names].to_numpy(dtype=float)
    is_beside = values[:, 5] > 0.5
    held, beside = (
        GroundHeights(rows[:, :2], rows[:, 2], path.name, rows[:, 3:5])
        for rows in (values[~is_beside], values[is_beside])
    )
    if not is_beside.any():
        return held
    return replace(held, beside=beside).with_border(area)


def _row(path, row):
    """Values of one plan, whatever the others are; named by its line."""
    table = read_table(path, ROWS)
    n_rows = len(table)
    if n_rows == 0:
        raise FileError("has no plans", remedy=ANEW, file=path.name)
    if not 1 <= row <= n_rows:
        raise FileError(
            f"has no plan {row}",
            expected=f"1 to {n_rows}, counted from the first row of figures",
            remedy="Give another --row",
            file=path.name,
        )
    only = table.iloc[[row - 1]]
    checked = tables.check_table(only, ROWS, source=path.name)
    raise_problems(checked.problems)
    return checked.frame.iloc[0]
