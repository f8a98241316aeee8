"""block.toml: which tables a block has, and the facts beside them.

Reading keeps what is right where something else is wrong, so that the tables can be
looked at in the same run: :class:`BlockToml` holds the sections as far as they could
be understood, the problems, and which keys they concern.
"""

import re
import tomllib
from dataclasses import dataclass, field
from numbers import Real
from pathlib import Path
from typing import Any, Literal

import tomli_w
from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator

from einschalt.foundations.arguments import described
from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import BlockError, EinschaltError, SettingsError
from einschalt.foundations.near_words import nearest
from einschalt.interfaces.files.atomic import write_text
from einschalt.interfaces.files.input_files import read_text_bytes
from einschalt.interfaces.files.toml_faults import toml_fault
from einschalt.interfaces.files.understood_tables import Said
from einschalt.pipeline.settings import Settings, setting_problem

BLOCK_FILE = "block.toml"
LONGEST_TOML = 2**20
DEEPEST_TOML = 8
MOST_SHOWN = 100
KEY = re.compile(r"""^\s*["']?([\w-]+)["']?\s*=""")
SECTION = re.compile(r"""^\s*\[\s*["']?([\w.-]+)["']?\s*\]""")


def _text(what):
    return Field(default=None, description=f"a text: {what}")


def _table():
    return Field(
        default=None,
        description="a text: the name of a table, or {file = …} with columns, sheet, "
        "layer or decimal beside it",
    )


def _measure(unit, **limits):
    return Field(default=None, description=f"a number ({unit})", **limits)


def _shared_error():
    unit = "metres, TOTAL, above 0, at most 100, that all points share"
    return _measure(unit, gt=0, le=100)


def _group_error():
    return _measure("metres, TOTAL, of the shift that points of one group share")


def _correlation_length():
    return _measure("metres; errors of points are alike over it, 0 where independent")


class _Section(BaseModel):
    # strict: 7.5 in quotes is no number, true is no 1; TOML knows nan and inf
    model_config = ConfigDict(
        extra="forbid", strict=True, frozen=True, allow_inf_nan=False
    )


class BlockSection(_Section):
    """[block]: its names, and its coordinate reference system."""

    name: str | None = _text("the name of the block")
    project: str | None = _text("the name of the project, for the report")
    operator: str | None = _text("who is responsible, for the report")
    crs: str | None = _text("an EPSG code such as 'EPSG:31255'")


class TableKeys(_Section):
    """A table: its file, and what is to be known for reading it."""

    file: str = Field(description="a text: the name of a table")
    columns: dict[str, str] | None = Field(
        default=None, description='names as in {easting = "Rechtswert"}'
    )
    sheet: str | None = _text("the name of a sheet of the workbook")
    layer: str | None = _text("the name of a layer of the file")
    decimal: Literal[",", "."] | None = Field(
        default=None, description='"," or ".", where the table does not tell'
    )
    angles: Literal["degrees", "D.MMSS"] | None = Field(
        default=None,
        description='"degrees" or "D.MMSS", of longitudes and latitudes',
    )
    where: dict[str, str] | None = Field(
        default=None, description='a column and a value as in {Flug = "tief"}'
    )


class ControlPointsSection(TableKeys):
    """[control_points]: the table, and what holds for all its points."""

    crs: str | None = _text("an EPSG code such as 'EPSG:31255'")
    standard_error_m: float | None = Field(
        default=None, gt=0, le=10, description="a number above 0, at most 10 metres"
    )
    shared_error_m: float | None = _shared_error()
    group_error_m: float | None = _group_error()
    correlation_length_m: float | None = _correlation_length()
    may_be_unmeasured: bool = Field(default=False, description="true or false")


class ApproximatePointsSection(TableKeys):
    """[approximate_points]: the table, and the error of all its points."""

    crs: str | None = _text("an EPSG code such as 'EPSG:31255'")
    m_0_m: float | None = _measure("metres")
    shared_error_m: float | None = _shared_error()
    group_error_m: float | None = _group_error()
    correlation_length_m: float | None = _correlation_length()
    may_be_unmeasured: bool = Field(default=False, description="true or false")


class FlightSection(_Section):
    """[high_flight] and [low_flight]: tables, and facts of the flight."""

    scale_number: float = Field(description="a number (the denominator)")
    m_g_um: float = Field(description="a number (micrometres in the image)")
    transformation: str = Field(
        default="affine", description="a text: affine, helmert, rigid or helmert_3d"
    )
    model_points: Any = _table()
    model_unit: str = Field(default="mm", description="a text: mm, cm, m or um")
    y_parallaxes: Any = _table()
    base: Any = Field(
        default=None,
        description="a number in model_unit, or a text: the name of a table",
    )
    image_points: Any = _table()
    models: Any = _table()
    principal_distance_mm: float | None = _measure("millimetres")
    camera: Any = Field(
        default=None,
        description="a text: the name of a file such as camera.toml, or a section",
    )
    orientation_case: str | None = _text(
        "independent, dependent_left or dependent_right"
    )
    orientation_method: str | None = _text("least_squares, krames or gruber")

    @field_validator("camera")
    @classmethod
    def _section_or_name(cls, value):
        if not isinstance(value, (str, dict)):
            raise ValueError
        return value

    @field_validator("base")
    @classmethod
    def _number_or_table(cls, value):
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            return value
        return _file_of(value)

    @field_validator("model_points", "y_parallaxes", "image_points", "models")
    @classmethod
    def _table_alone(cls, value):
        return _file_of(value)


def _file_of(value):
    """The name of a table, or what stands in place of it: {file = …, columns = …}."""
    if isinstance(value, dict):
        return TableKeys.model_validate(value)
    if not isinstance(value, str):
        raise ValueError
    return value


def said_of(keys, crs=None, unit=None) -> Said:
    """What a section, or {file = …}, says of a table.

    Its ground coordinates are in crs, those of its models or images in a unit.
    """
    if not isinstance(keys, TableKeys):
        return Said(crs=crs, unit=unit)
    columns, where = keys.columns or {}, keys.where or {}
    parts = (keys.sheet, keys.layer, keys.decimal)
    return Said(columns, *parts, crs, unit, where=where, angles=keys.angles)


def named_file(value):
    """File that a key names, by its name alone or with what is said of its table.

    None where the value is no name of a file.
    """
    value = value.file if isinstance(value, TableKeys) else value
    return value if isinstance(value, str) else None


SECTIONS = {
    "block": BlockSection,
    "control_points": ControlPointsSection,
    "high_flight": FlightSection,
    "approximate_points": ApproximatePointsSection,
    "low_flight": FlightSection,
}


@dataclass(eq=False)
class BlockToml:
    """What block.toml says."""

    source: str  # what the file is called in messages
    sections: dict = field(default_factory=dict)  # keys that are wrong are None
    settings: Settings = field(default_factory=Settings)
    problems: list[EinschaltError] = field(default_factory=list)
    # section and key (empty: the whole section) of what the problems tell
    said: set[tuple[str, str]] = field(default_factory=set)

    def say(self, problem, section, key=""):
        """Keep a problem, and what it is about."""
        self.problems.append(problem)
        self.said.add((section, key))


def read_block_toml(path) -> BlockToml:
    """Read block.toml; what is no TOML is raised, other faults are ``problems``."""
    source = Path(path).name
    text = read_text_bytes(path, source).decode("utf-8")
    given = _parsed(text, source)
    toml = BlockToml(source)
    for name, fields in given.items():
        if not isinstance(fields, dict):
            toml.say(_stray(name, fields, source), name if name in SECTIONS else "")
        elif name in SECTIONS:
            toml.sections[name] = _section(toml, name, fields)
        elif name == "settings":
            _settings(toml, fields)
        else:
            _unknown_section(toml, name)
    toml.problems[:] = [with_row(problem, text, source) for problem in toml.problems]
    return toml


def _parsed(text, source):
    try:
        return parse_toml(text, source)
    except tomllib.TOMLDecodeError as error:
        reason, row = toml_fault(error)
        # lines as TOML counts them; str.splitlines parts at more signs than these
        lines = text.removesuffix("\n").split("\n")
        row = row or len(lines)
        line = lines[row - 1].strip()
        raise SettingsError(
            f"{shortened(line, MOST_SHOWN)!r} is no TOML: {reason}",
            expected="key = value",
            remedy=_toml_remedy(line, reason),
            file=source,
            row=row,
        ) from error


def parse_toml(text, source):
    """Parse TOML that may be made to harm: too long, too deep, too long a number.

    What is no TOML raises tomllib's own TOMLDecodeError.
    """
    if len(text) > LONGEST_TOML:
        raise SettingsError(
            f"the file has {len(text)} characters",
            expected=f"at most {LONGEST_TOML}",
            remedy="Put tables into files of their own",
            file=source,
        )
    try:
        given = tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        raise
    except (RecursionError, ValueError) as error:  # Python's limits on what it parses
        is_deep = isinstance(error, RecursionError)
        raise SettingsError(
            "brackets are nested too deeply" if is_deep else "a number is too long",
            expected="key = value",
            remedy="Take it out",
            file=source,
        ) from error
    parts = [given]
    for _ in range(DEEPEST_TOML):
        parts = [
            value for part in parts if isinstance(part, dict) for value in part.values()
        ]
    if parts:
        raise SettingsError(
            f"keys are nested more than {DEEPEST_TOML} deep",
            expected="key = value below a section",
            remedy="Take them out",
            file=source,
        )
    return given


def _toml_remedy(line, reason):
    if "\\" in line:
        return "Write paths with / or in single quotes"
    if re.search(r"=\s*[+-]?\d+,\d+\s*(#.*)?$", line):
        return "Write a decimal point"
    if "overwrite" in reason or "twice" in reason:
        return "Give each key and each section once"
    return "Put texts into straight quotes, and write decimal points"


def _section(toml, name, fields):
    kind = SECTIONS[name]
    try:
        return kind.model_validate(fields)
    except ValidationError as error:
        faults = [(str(fault["loc"][0]), fault) for fault in error.errors()]
    unknown = [key for key, fault in faults if fault["type"] == "extra_forbidden"]
    meant = {nearest(key, kind.model_fields) for key in unknown} - {None}
    toml.said.update((name, key) for key in meant)
    for key, fault in faults:
        if fault["type"] != "missing" or key not in meant:
            toml.say(setting_problem(fault, name, kind, file=toml.source), name, key)
    wrong = {key for key, _ in faults}
    sound = {key: value for key, value in fields.items() if key not in wrong}
    required = [key for key, known in kind.model_fields.items() if known.is_required()]
    return kind.model_construct(**{**dict.fromkeys(required), **sound})


def _settings(toml, fields):
    try:
        toml.settings = Settings(**fields)
    except BlockError as error:
        for problem in error.problems:
            toml.say(_at_home(problem, toml.source), "settings")
    except EinschaltError as error:
        toml.say(_at_home(error, toml.source), "settings")


def _at_home(problem, source):
    """A problem of [settings], with the sections of its key if that is of others."""
    homes = [] if problem.key in Settings.model_fields else _homes(problem.key)
    told = {"remedy": f"Put it below {' or '.join(homes)}"} if homes else {}
    return problem.with_facts(file=source, **told)


def _homes(key):
    """Sections in which a key may stand."""
    homes = [s for s, kind in SECTIONS.items() if key in kind.model_fields]
    homes += ["settings"] * (key in Settings.model_fields)
    return [f"[{home}]" for home in homes]


def _unknown_section(toml, name):
    known = [*SECTIONS, "settings"]
    near = nearest(name, known)
    problem = SettingsError(
        f"[{shortened(name)}] is an unknown section",
        expected=", ".join(f"[{section}]" for section in known),
        remedy=f"Write [{near}]" if near else "Take it out",
        file=toml.source,
        section=name,
    )
    toml.say(problem, near or name)


def _stray(name, value, source):
    if name in SECTIONS or name == "settings":
        return SettingsError(
            f"{shortened(name)} = {described(value)}",
            expected=f"a section [{name}]",
            remedy=f"Write [{name}], and its keys on the lines below",
            file=source,
            key=name,
        )
    homes = _homes(name)
    sections = " or ".join(homes)
    return SettingsError(
        f"{shortened(name)} = {described(value)} stands outside of all sections",
        expected="keys below a section such as [block]",
        remedy=f"Put it below {sections}" if homes else "Take it out",
        file=source,
        key=name,
    )


def with_row(problem, text, source):
    """Add the line of block.toml that a problem is about, where it can be found.

    Problems of other files are given back as they are.
    """
    is_placed = problem.section is not None or problem.key is not None
    if not is_placed or problem.file != source or problem.row is not None:
        return problem
    section = None
    row_of_section = None
    for row, line in enumerate(text.split("\n"), 1):
        if opened := SECTION.match(line):
            section = opened[1]
            row_of_section = row if section == problem.section else row_of_section
        key = KEY.match(line)
        if section == problem.section and key and key[1] == problem.key:
            return problem.with_facts(row=row)
    return problem.with_facts(row=row_of_section)


def write_block_toml(path, sections):
    """Write block.toml without keys that are None, and without empty sections."""
    known = {name: _known(fields) for name, fields in sections.items()}
    write_text(path, tomli_w.dumps({k: keys for k, keys in known.items() if keys}))


def write_keys(path, fields):
    """Write a TOML file without sections, and without keys that are None."""
    write_text(path, tomli_w.dumps(_known(fields)))


def _known(fields):
    return {key: _plain(value) for key, value in fields.items() if value is not None}


def _plain(value):
    """A number of Python's, also where it came from an array; 8000, not 8000.0."""
    if isinstance(value, bool) or not isinstance(value, Real):
        return value
    is_whole = float(value).is_integer() and abs(value) < 2**53
    return int(value) if is_whole else float(value)
