"""Column schemas of all input tables, and the checks that every table passes.

A check never stops at the first fault: it returns a :class:`CheckedTable` with the
table as far as it could be understood, every problem, and notes on what was ignored.
"""

from collections import Counter
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import pandas as pd

from einschalt.foundations import cell_values
from einschalt.foundations.arguments import described
from einschalt.foundations.errors import EinschaltError, TableError, name_some
from einschalt.foundations.frame_columns import names_not_in
from einschalt.foundations.key_columns import SeenNames, row_codes
from einschalt.foundations.missing_columns import columns_in_the_index, missing_columns
from einschalt.foundations.names import CodedColumns
from einschalt.foundations.names_as_numbers import remedy_of_two
from einschalt.foundations.number_parsing import MEND, MEND_OR_NONE

MOST_LISTED = 20  # rows of one fault said one by one; more are said once, and counted
FIRST_ROWS = 5  # of these, named beside the first
MODEL_UNIT = "millimetres"  # unless a flight says another
LINE = "line"  # name of an index that holds lines of a text file, header = line 1


@dataclass(frozen=True)
class Column:
    """One column: its name, what it holds, and what is allowed.

    ``kind`` is ``id`` (text), ``number`` or ``choice``; ``unit`` is said in messages.
    A cell may be empty where that of the column is which it belongs to.
    """

    name: str
    kind: str = "number"
    unit: str = ""
    is_required: bool = True
    is_positive: bool = False
    may_be_missing: bool = False
    choices: tuple[str, ...] = ()
    default: object = None
    belongs_to: str = ""


@dataclass(frozen=True)
class Schema:
    """The columns of a table and the key, if any, that no two rows may share."""

    name: str
    columns: tuple[Column, ...]
    key: tuple[str, ...]

    @property
    def names(self):
        """Names of all columns, in order."""
        return [column.name for column in self.columns]

    @property
    def number_names(self):
        """Names of the columns that hold numbers."""
        return [c.name for c in self.columns if c.kind == "number"]

    @property
    def id_names(self):
        """Names of the columns that hold text."""
        return [c.name for c in self.columns if c.kind in ("id", "choice")]

    def _changed(self, is_meant, **fields):
        columns = (replace(c, **fields) if is_meant(c) else c for c in self.columns)
        return replace(self, columns=tuple(columns))

    def requiring(self, *names):
        """Return the same schema in which some columns must be given."""
        return self._changed(lambda column: column.name in names, is_required=True)

    def in_unit(self, unit):
        """Return the same schema with other words for the unit of model lengths."""
        return self._changed(lambda column: column.unit == MODEL_UNIT, unit=unit)

    def only(self, *names):
        """Return the schema of some of the columns."""
        columns = tuple(c for c in self.columns if c.name in names)
        return Schema(self.name, columns, tuple(k for k in self.key if k in names))

    def without(self, *names):
        """Return the same schema in which some columns need not be given."""
        freed = self._changed(lambda column: column.name in names, is_required=False)
        return replace(freed, key=tuple(k for k in self.key if k not in names))


POINT_ID = Column("point_id", "id")
MODEL_ID = Column("model_id", "id")
COVERAGE = Column("coverage", "id", is_required=False, default="1")
# parallaxes and bases that name no coverage hold for the model of that name in any
COVERAGE_IF_GIVEN = Column("coverage", "id", is_required=False)
ROLES = ("control", "check")
# given points that share a shift: of one strip, photograph or part of a network
GROUP = Column("group", "id", is_required=False, may_be_missing=True)


def _number(name, unit, **flags):
    return Column(name, "number", unit, **flags)


def _numbers(unit, *names, **flags):
    return [_number(name, unit, **flags) for name in names]


OF_HEIGHT = {"is_required": False, "belongs_to": "height"}
PLAN_ERRORS = ("standard_error_easting", "standard_error_northing")
CONTROL_POINTS = Schema(
    "control_points",
    (
        POINT_ID,
        *_numbers("metres", "easting", "northing"),
        _number("height", "metres", is_required=False, may_be_missing=True),
        _number("standard_error_m", "metres", is_required=False, is_positive=True),
        Column("role", "choice", is_required=False, choices=ROLES, default="control"),
        # for the simultaneous adjustment, in place of standard_error_m
        *_numbers("metres", *PLAN_ERRORS, is_required=False, is_positive=True),
        _number("covariance_en", "square metres", is_required=False),
        _number("standard_error_height", "metres", is_positive=True, **OF_HEIGHT),
        *_numbers("square metres", "covariance_eh", "covariance_nh", **OF_HEIGHT),
        GROUP,
    ),
    key=("point_id",),
)
APPROXIMATE_POINTS = Schema(
    "approximate_points", (*CONTROL_POINTS.columns[:4], GROUP), key=("point_id",)
)
MODEL_POINTS = Schema(
    "model_points",
    (
        COVERAGE,
        MODEL_ID,
        POINT_ID,
        *_numbers("millimetres", "x", "y"),
        _number("z", "millimetres", is_required=False),
        _number("n_settings", "numbers", is_required=False, is_positive=True),
        _number("settings_spread", MODEL_UNIT, is_required=False, may_be_missing=True),
    ),
    key=("coverage", "model_id", "point_id"),
)
# as it was measured: points may be set several times, and their settings numbered
SETTING = "setting"
DOUBLED = "Delete one of the two, or rename it"
MEASURED_MODEL_POINTS = replace(
    MODEL_POINTS,
    columns=(*MODEL_POINTS.columns, Column(SETTING, "id", is_required=False)),
    key=(*MODEL_POINTS.key, SETTING),
)
Y_PARALLAXES = Schema(
    "y_parallaxes",
    (
        *(COVERAGE_IF_GIVEN, MODEL_ID, POINT_ID),
        *_numbers("millimetres", "x", "y", "z", "y_parallax"),
    ),
    key=("coverage", "model_id", "point_id"),
)
MODEL_BASES = Schema(
    "models",
    (
        COVERAGE_IF_GIVEN,
        MODEL_ID,
        _number("base", "millimetres", is_positive=True),
        Column("left_image", "id", is_required=False),
        Column("right_image", "id", is_required=False),
    ),
    key=("coverage", "model_id"),
)
IMAGE_POINTS = Schema(
    "image_points",
    (
        Column("image_id", "id"),
        POINT_ID,
        *_numbers("millimetres, or pixels of the camera", "x", "y"),
    ),
    key=("image_id", "point_id"),
)
IMAGE_PAIRS = Schema(
    "image_pairs",
    (
        *(COVERAGE, MODEL_ID, POINT_ID),
        *_numbers("millimetres", "x_left", "y_left", "x_right", "y_right"),
    ),
    key=("coverage", "model_id", "point_id"),
)
IMAGE_MODELS = Schema(
    "models",
    (COVERAGE, MODEL_ID, Column("left_image", "id"), Column("right_image", "id")),
    key=("coverage", "model_id"),
)


@dataclass(frozen=True, eq=False)
class CheckedTable:
    """A table after its check."""

    # the columns of the schema, ids as text, numbers as float; usable only where
    # ``problems`` is empty
    frame: pd.DataFrame
    problems: tuple[EinschaltError, ...] = ()
    notes: tuple[str, ...] = ()  # what was ignored or filled in
    key: tuple[str, ...] = ()  # its columns; empty where the key is not complete

    @cached_property
    def coded(self) -> CodedColumns:
        """The columns of the key as codes, each made when it is first asked for."""
        return CodedColumns(self.frame)


def check_table(frame, schema, *, source=None) -> CheckedTable:
    """Check a table against its schema.

    Its values are as they were read: numbers or the text that stands in the file; its
    index is said as the row: the line of the file, where it comes from one. ``source``
    is the file or argument that messages name. A fault that more than 20 rows of a
    column have is said once, with their number and the first of them; it stands for all
    of them (``stands_for``).
    """
    source = source or schema.name
    unfit = _unfit(frame, schema, source)
    if unfit is not None:
        return CheckedTable(pd.DataFrame(), (unfit,))
    if not all(isinstance(name, str) for name in frame.columns):
        frame = frame.rename(columns=str)
    problems = _check_columns(frame, schema, source)
    if frame.empty:
        return CheckedTable(frame, tuple(problems) or (_empty(frame, source),))
    names = list(frame.columns)
    ignored = names_not_in(frame, schema.names)
    notes = [f"{source}: ignored column {name_some(ignored)}"] if ignored else []
    columns = {}
    seen = _seen_names(frame, schema)
    for column in schema.columns:
        if names.count(column.name) == 1:
            raw = frame[column.name]
            values, faults = _check_values(frame, raw, column, source, seen)
            columns[column.name] = values
            problems += faults
            if coarse := cell_values.note_on_digits(raw, source):
                notes.append(coarse)
        elif column.name not in names and column.default is not None:
            everywhere = np.zeros(len(frame), dtype=np.intp)
            columns[column.name] = pd.array([column.default], "str").take(everywhere)
    # columns that are what they were given as are shared until someone writes to them
    checked = pd.DataFrame(columns, index=frame.index, copy=False)
    # a coverage that need not be given, and is not, is no part of the key
    optional = {column.name for column in schema.columns if not column.is_required}
    key = [name for name in schema.key if name in columns or name not in optional]
    key = tuple(key) if all(name in columns for name in key) else ()
    table = CheckedTable(checked, (), tuple(notes), key)
    given = [name for name in key if name in names]
    if key and _may_repeat(checked, key, given, seen):
        problems += _check_key(table, source, schema)
    return replace(table, problems=tuple(problems))


def _seen_names(frame, schema):
    """Names of the key as they stand in the table, looked over."""
    names = list(frame.columns)
    once = [name for name in schema.key if names.count(name) == 1]
    columns = {name: frame[name] for name in once}
    return SeenNames({n: c for n, c in columns.items() if cell_values.is_text(c)})


def _may_repeat(checked, key, given, seen):
    """Whether two rows could have one key.

    ``given``: what of it stood in the table; what was filled in is the same everywhere.
    """
    if given and all(name in seen.names and seen.is_tidy(name) for name in given):
        return seen.may_repeat
    return SeenNames({name: checked[name] for name in key}).may_repeat


def _unfit(frame, schema, source):
    """Say what is no table with one row of column names; None where it is one."""
    if isinstance(frame, pd.DataFrame) and frame.columns.nlevels == 1:
        return None
    columns = ", ".join(c.name for c in schema.columns if c.is_required)
    if isinstance(frame, pd.DataFrame):
        found = f"the column names have {frame.columns.nlevels} levels"
        remedy = "Take one level: table.columns = table.columns.get_level_values(0)"
        return TableError(found, expected=columns, remedy=remedy, file=source)
    return TableError(
        f"{described(frame)} is no table",
        expected=f"a DataFrame with the columns {columns}",
        remedy="Write pandas.DataFrame(…)",
        file=source,
    )


def _empty(frame, source):
    remedy = "Fill it, or leave it out"
    if frame.index.name == LINE:  # it was read from a file
        remedy = "Fill it, or take its key out of block.toml"
    return TableError(
        "the table has no rows",
        expected="at least one",
        remedy=remedy,
        file=source,
    )


def _check_columns(frame, schema, source):
    names = list(frame.columns)
    missing = [c.name for c in schema.columns if c.is_required and c.name not in names]
    header = 1 if frame.index.name == LINE else None
    in_index = [name for name in missing if name in frame.index.names]
    problems = []
    if in_index:
        problems.append(columns_in_the_index(in_index, names, schema, source))
    lacking = [name for name in missing if name not in in_index]
    problems += missing_columns(lacking, names, schema, source, header)
    doubled = sorted(name for name, n in Counter(names).items() if n > 1)
    problems += [
        TableError(
            f"column '{name}' stands twice",
            expected="each column once",
            remedy="Delete or rename one of them",
            file=source,
            row=header,
        )
        for name in doubled
    ]
    return problems


def _check_values(frame, raw, column, source, seen):
    if column.kind == "number":
        values, is_bad, say = cell_values.numbers(raw, column)
    elif column.kind == "choice":
        values, is_bad, say = cell_values.choices(raw, column)
    else:
        is_tidy = seen.is_tidy(column.name) if column.name in seen.names else None
        values, is_bad, say = cell_values.identifiers(raw, is_tidy=is_tidy)
        if column.may_be_missing and is_bad.any():
            is_bad = is_bad & ~cell_values.are_blank(raw)
    if list(frame.columns).count(column.belongs_to) == 1 and is_bad.any():
        blank = map(cell_values.are_blank, (raw, frame[column.belongs_to]))
        is_bad = is_bad & ~np.logical_and(*blank)

    def problem(place):
        found, expected, remedy = say(raw.iloc[place])
        if column.may_be_missing and remedy == MEND:
            remedy = MEND_OR_NONE  # the row has other uses
        facts = {"expected": expected, "remedy": remedy, "file": source}
        facts |= row_location(frame, place)
        return TableError(f"{column.name} {found}", **facts)

    places = np.flatnonzero(is_bad)
    if column.kind == "number" and raw.dtype == np.float64:
        values = raw  # pandas copies it when either table is written to
    return values, listed(places, problem, f"{column.name} is wrong")


def listed(places, problem, rest):
    """Make the problems of faulty rows; one for all of them where they are many.

    ``problem`` gives that of a position, ``rest`` is said of the others.
    """
    places = list(places)
    if len(places) <= MOST_LISTED:
        return [problem(place) for place in places]
    first, *others = (problem(place) for place in places[: FIRST_ROWS + 1])
    n_more = len(places) - 1
    rows = [str(other.row) for other in others if other.row is not None]
    named = f" ({', '.join(rows)}{', …' * (n_more > len(rows))})" if rows else ""
    text = f"{first.found}; {rest} in {n_more} more rows{named}"
    return [first.with_facts(found=text, stands_for=len(places))]


def row_location(frame, place):
    """Row, point and model of a position (not an index), as facts of an error."""
    label = _label(frame, place)
    return {
        "row": label if isinstance(label, (int, np.integer)) else None,
        "point": _cell(frame, "point_id", place),
        "model": _cell(frame, "model_id", place),
    }


def _label(frame, place):
    """Label of a row; its position, from 0, where rows of a script share labels."""
    is_by_position = frame.index.name != LINE and frame.index.has_duplicates
    return place if is_by_position else frame.index[place]


def _cell(frame, name, place):
    if list(frame.columns).count(name) != 1:
        return None
    value = frame[name].iloc[place]
    return None if pd.isna(value) else cell_values.whole_text(value).strip() or None


def _check_key(table, source, schema):
    frame, key = table.frame, list(table.key)
    codes = row_codes([table.coded[name] for name in key])
    if len(pd.unique(codes)) == len(codes):
        return []
    is_doubled = pd.Series(codes).duplicated(keep="first").to_numpy()
    is_given = (frame[key] != "").all(axis=1).to_numpy(dtype=bool)
    places = np.flatnonzero(is_doubled & is_given)
    firsts = np.flatnonzero(~is_doubled)
    first_of = dict(zip(codes[firsts], firsts, strict=True))

    remedy = DOUBLED
    if SETTING in schema.key and SETTING not in key:
        remedy = (
            f"{remedy}; or number repeated settings in a column '{SETTING}', and give "
            "each flight a file of its own"
        )

    def problem(place):
        return TableError(
            f"the row repeats row {_label(frame, first_of[codes[place]])}",
            expected=f"each {' + '.join(key)} once",
            remedy=remedy_of_two(_cell(frame, "point_id", place), source) or remedy,
            file=source,
            **row_location(frame, place),
        )

    return listed(places, problem, "earlier rows are repeated")


def with_coverage(frame):
    """Return the table with a column ``coverage``, "1" where it had none."""
    return frame if "coverage" in frame.columns else frame.assign(coverage="1")
