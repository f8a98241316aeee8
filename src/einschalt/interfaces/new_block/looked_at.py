"""Files are looked at: which table of a block each of them could be, and why."""

import re
import tomllib
from dataclasses import dataclass, field, replace
from pathlib import Path

import pandas as pd

from einschalt.foundations import tables
from einschalt.foundations.errors import (
    EinschaltError,
    FileError,
    TableError,
    name_some,
    raise_problems,
)
from einschalt.foundations.frame_columns import names_not_in
from einschalt.foundations.language import mark_each, translated
from einschalt.foundations.names_as_numbers import remedy_of_two
from einschalt.interfaces.files import gdal_files, point_layers, workbooks
from einschalt.interfaces.files.flights_apart import TwoFlightsError, require_one_flight
from einschalt.interfaces.files.input_files import (
    companions,
    is_there,
    read_once,
    refuse_other_kinds,
)
from einschalt.interfaces.files.sheet_parts import SeveralTablesError
from einschalt.interfaces.files.tables_by_suffix import (
    CSV_SUFFIXES,
    READ_SUFFIXES,
    understand_table,
)
from einschalt.interfaces.files.understood_tables import Said
from einschalt.interfaces.new_block.kinds_of_tables import (
    KINDS,
    fitting_schema,
    has_table_of,
    holds_degrees,
    meant_schema,
    refuse_nameless,
    refuse_other_coordinates,
    system_of_foreign,
)
from einschalt.interfaces.programs import block_tables, recognised
from einschalt.interfaces.programs.pixel_cameras import without_pitch

MOST_HEADINGS = 8
PITCH = "pixel_size_um"
NO_POINTS = re.compile("Line|Curve|Polygon|Surface")  # kinds of geometry
WORDS = mark_each(
    {
        "y_parallaxes": "y-parallaxes",
        "image_points": "image points",
        "models": "models and their images",
        "base": "bases of the models",
        "model_points": "model points",
        "ground": "ground points",
        "camera": "a camera",
    }
)
AMOUNTS = mark_each(
    {
        "model_id": "{n:model|models}",
        "image_id": "{n:image|images}",
        "point_id": "{n:point|points}",
    }
)


@dataclass(frozen=True, eq=False)
class Looked:
    """A table, and what it could be."""

    path: Path
    kind: str  # of KINDS, or "camera"
    frame: pd.DataFrame  # as checked; empty for a camera
    said: Said
    notes: tuple[str, ...] = ()
    crs: str | None = None  # that the file states
    left_out: tuple[str, ...] = ()  # columns that are no part of the table
    unit: str | None = None  # of its model or image coordinates, if the header has it
    camera: dict | None = None  # keys of a camera, if there is only one
    unusable: dict = field(default_factory=dict)  # why all cameras are, by their names

    @property
    def title(self):
        """Name of the file, of its sheet or layer, and of the flight in it."""
        parts = (self.said.sheet or self.said.layer, *self.said.where.values())
        return ", ".join([self.path.name, *filter(None, parts)])

    @property
    def lacks_pitch(self):
        """Whether it is a camera that does not say how large a pixel is."""
        keys = self.camera
        return keys is not None and keys["convention"] != "mm" and PITCH not in keys

    @property
    def description(self):
        """What it holds, with numbers."""
        kind = translated(WORDS[self.kind])
        if self.kind == "camera":
            return kind
        numbers = [
            translated(amount, n=self._n_different(name))
            for name, amount in AMOUNTS.items()
            if name in self.frame
        ]
        rows = translated("{n:row|rows}", n=len(self.frame))
        return f"{kind}: {', '.join([rows, *numbers])}"

    def _n_different(self, name):
        """Count names; those of models are told apart by their coverage."""
        has_coverages = name == "model_id" and "coverage" in self.frame
        key = ["coverage", name] if has_coverages else [name]
        return len(self.frame[key].dropna(subset=name).drop_duplicates())


def files_below(folder):
    """Files of a folder that may be tables or cameras; images and maps are none."""
    known = (*READ_SUFFIXES, ".toml", ".json", *recognised.SUFFIXES)
    parts = _of_projects(folder)
    return sorted(
        path
        for path in Path(folder).iterdir()
        if path not in parts
        and path.suffix.lower() in known
        and path.suffix.lower() not in recognised.IF_NAMED
        and path.is_file()
        and not path.name.startswith(".")
    )


def _of_projects(folder):
    """Files that are read as parts of a project beside them."""
    projects = [p for p in Path(folder).iterdir() if p.suffix.lower() == ".opf"]
    return {part for project in projects for part in companions(project)}


def look_at(path, said) -> list[Looked]:
    """Look at a file, and at each sheet or layer of it, or at one: FILE:SHEET.

    ``said``: what the user says of all tables. A FileError where it holds none that is
    known; a TableError where one has two meanings.
    """
    path, part = _part_of(Path(path))
    if part is not None:
        is_book = path.suffix.lower() in workbooks.SUFFIXES
        said = replace(said, **{"sheet" if is_book else "layer": part})
    if path.is_dir():
        raise FileError(
            "is a folder",
            expected="files",
            remedy="Convert a folder of COLMAP or MicMac first: einschalt convert "
            "FOLDER OUT; otherwise name the files in it",
            file=path.name,
        )
    file = read_once(path, path.name)
    if path.suffix.lower() == ".toml":
        return _camera(file, said)
    foreign = _foreign(file, said)
    if foreign is not None:
        return foreign
    parts = _parts(file, said)
    found, refused = [], []
    for part in parts:
        try:
            found += _tables(file, part)
        except EinschaltError as error:
            refused.append(error)
    # a workbook has sheets of other things beside
    questions = [error for error in refused if _is_of_rows(error)]
    if questions or not found:
        raise (questions or refused)[0]
    return found


def _part_of(path):
    """File, and the sheet or layer that is named behind it."""
    name, sign, part = path.name.rpartition(":")
    whole = path.with_name(name) if name else path
    is_part = bool(sign and part) and not is_there(path) and is_there(whole)
    return (whole, part) if is_part else (path, None)


def _foreign(file, said):
    """Tables of another program's file; None where it is a plain table."""
    if said.columns or said.decimal:
        return None
    beside = tuple(read_once(one, one.name) for one in companions(file.path))
    foreign = block_tables.found_in(file, file.source, beside, said.crs)
    if foreign is None:
        return None
    found, told = [], []
    for kind in ("ground", "image_points"):
        if block_tables.STANDS_FOR[KINDS[kind].name] not in foreign.tables:
            continue
        table = block_tables.table_of(foreign, KINDS[kind], file.source)
        if len(table.frame):
            looked = _looked(file, kind, table, _said_of(table, said, file.source))
            # of the file: once is enough
            new = tuple(note for note in looked.notes if note not in told)
            told += new
            found.append(replace(looked, notes=new))
    if foreign.cameras or (found and foreign.unusable):
        is_only = len(foreign.cameras) + len(foreign.unusable) == 1
        keys = next(iter(foreign.cameras.values()), None) if is_only else None
        known = {
            "camera": keys,
            "unusable": {} if foreign.cameras else foreign.unusable,
        }
        own = Said(crs=said.crs)
        camera = Looked(file.path, "camera", pd.DataFrame(), own, **known)
        # what was said of the file is said of its tables already, and for the size of
        # a pixel the user is asked
        asked = without_pitch(foreign.cameras, file.source)
        rest = tuple(note for note in foreign.notes if note not in asked)
        found.append(camera if found else replace(camera, notes=rest))
    if not found:
        held = name_some(name.replace("_", " ") for name in foreign.tables)
        raise FileError(
            f"holds {held}, of which no block is made",
            expected="ground points, image points or a camera",
            remedy="Leave it out",
            file=file.source,
        )
    return found


def _said_of(table, said, source):
    return Said(crs=system_of_foreign(table, said, source))


def _is_of_rows(error):
    """Whether a table is refused for what stands in it, and not for its columns."""
    faults = getattr(error, "problems", [error])
    is_named = any("is missing, found" in fault.found for fault in faults)
    return isinstance(faults[0], TableError) and not is_named


def _is_ragged(error):
    """Whether rows have not as many values as the header."""
    fault = getattr(error, "problems", [error])[0]
    return "values, the header" in fault.found


def _camera(file, said):
    try:
        keys = tomllib.loads(file.data.decode("utf-8-sig"))
    except ValueError:
        keys = {}
    nested = keys.get("camera")
    keys = nested if isinstance(nested, dict) else keys
    if "convention" in keys:
        # what it lacks is told where it is read: it is the user's own
        return [Looked(file.path, "camera", pd.DataFrame(), said, camera=keys)]
    raise FileError(
        "is no camera", remedy="Name tables and camera.toml", file=file.source
    )


def _parts(file, said):
    """What is to be said of the file, once for each of its tables."""
    suffix = file.path.suffix.lower()
    if said.sheet or said.layer:
        return [said]
    if suffix in workbooks.SUFFIXES:
        names = list(workbooks.sheets_of(file, file.source))
        parts = [replace(said, sheet=name) for name in names]
    elif suffix == ".gpkg":
        point_layers.require_kind(file)
        with gdal_files.opened({suffix: file.data}, file.source) as (pyogrio, copy):
            layers = [(str(n), kind) for n, kind in pyogrio.list_layers(copy)]
        # a table has no kind of geometry; lines and areas are no part of a block
        names = [name for name, kind in layers if not NO_POINTS.search(kind or "")]
        names = names or [name for name, _ in layers]
        if len(layers) > 1:
            return [replace(said, layer=name) for name in names]
        parts = [said]
    else:
        return [said]
    return parts if len(parts) > 1 else [said]


def _looked(file, kind, table, said):
    """The table, checked."""
    fit = fitting_schema(kind, table, said)
    notes = (*table.notes, *require_one_flight(table.frame, fit, file.source))
    checked = tables.check_table(table.frame, fit, source=file.source)
    left_out = names_not_in(table.frame, fit.names)
    raise_problems(_said_of_guess(kind, checked.problems, left_out, file.source))
    found = (said, notes, table.crs, left_out, table.unit)
    return Looked(file.path, kind, checked.frame, *found)


def _said_of_guess(kind, problems, left_out, file):
    """Faults of a table that may be of another kind: points that stand in it twice.

    Points stand in a table of model points once for each model.
    """
    if kind != "ground" or not left_out:
        return problems
    unknown = name_some(map(repr, left_out), MOST_HEADINGS)
    return [
        problem.with_facts(
            found=f"taken for ground points, {problem.found}",
            remedy="If it holds model points, rename the column of their models to "
            f"model_id: one of {unknown}. Otherwise delete one of the two",
        )
        if problem.remedy in (tables.DOUBLED, remedy_of_two(problem.point, file))
        else problem
        for problem in problems
    ]


def _tables(file, said):
    """The tables of a sheet, a layer or a text; others than sheets have one."""
    try:
        first, n_beside = _table(file, said)
    except TwoFlightsError as error:
        parted = [_table(file, replace(said, where=part))[0] for part in error.parts]
        if not parted:
            raise
        return parted
    found = [first]
    if n_beside:  # each is of another kind: two of one kind are refused
        for kind in KINDS:
            try:
                table, _ = _table(file, said, (kind,))
            except EinschaltError:  # the sheet has none of this kind
                continue
            rows = {*table.frame.index}
            if rows.isdisjoint(*(one.frame.index for one in found)):
                found.append(table)
    return found


def _table(file, said, kinds=tuple(KINDS)):
    """The table as the first kind whose columns it has; how many stand beside it."""
    beside = [read_once(one, one.name) for one in companions(file.path)]
    questions, refused = [], []
    for kind in kinds:
        schema = meant_schema(kind, said.crs)
        known = _columns_of(kind, schema, said)
        own = replace(said, columns=known)
        try:
            table = understand_table(
                file, schema, own, source=file.source, beside=tuple(beside)
            )
        except SeveralTablesError:  # as other kinds they would be read as one
            raise
        except EinschaltError as error:
            questions += [error] if _is_of_rows(error) else []
            refused += [error] if isinstance(error, FileError) else []
            continue
        if has_table_of(kind, table, said):
            return _looked(file, kind, table, own), table.n_beside
    if said.degrees_crs not in (None, said.crs) and holds_degrees(file, said):
        return _table(file, replace(said, crs=said.degrees_crs), kinds)
    # below a title that is taken for the header, all rows are too long
    questions.sort(key=_is_ragged)
    if questions:
        raise questions[0]
    if file.path.suffix.lower() not in set(READ_SUFFIXES) - set(CSV_SUFFIXES):
        refuse_other_kinds(file.data, file.source, "CSV, .xlsx or .gpkg")
    if refused:
        raise refused[0]
    refuse_other_coordinates(file, said)
    refuse_nameless(file, said)
    names = _headings(file, said)
    raise FileError(
        f"holds no table that a block could have; its columns are {names}"
        if names
        else "holds no table that a block could have",
        expected="y-parallaxes, image points, models and their images, bases of the "
        "models, model points or ground points",
        remedy="Leave it out, or say columns in block.toml (docs/tables.md)",
        file=file.source,
    )


def _columns_of(kind, schema, said):
    """What the user says of columns that a kind of table has.

    Models and images have names of points of their own.
    """
    is_meant = set(schema.names) - (set() if kind == "ground" else {"point_id"})
    return {name: said.columns[name] for name in said.columns if name in is_meant}


def _headings(file, said):
    """Columns of a table as they stand in it; empty where none can be read."""
    try:
        table = understand_table(file, KINDS["ground"], said, source=file.source)
    except EinschaltError:  # that it holds no known table is said
        return ""
    return name_some(map(repr, map(str, table.frame.columns)), MOST_HEADINGS)
