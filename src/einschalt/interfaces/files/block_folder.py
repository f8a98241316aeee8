"""A block is read from a folder: block.toml and the tables that it names.

Reading looks at everything before it complains: each file, each table, and how the
tables that are right fit each other (:func:`find_problems`).
"""

from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from einschalt.foundations import tables
from einschalt.foundations.display_names import as_unicode
from einschalt.foundations.errors import (
    BlockError,
    EinschaltError,
    FileError,
    SettingsError,
    raise_problems,
)
from einschalt.foundations.projections import label_of, read_crs, read_source_crs
from einschalt.interfaces.files import elsewhere
from einschalt.interfaces.files.block_file import block_file
from einschalt.interfaces.files.block_parts import (
    FLIGHT_FACTS,
    FLIGHT_TABLES,
    POINT_TABLES,
    Readers,
)
from einschalt.interfaces.files.block_toml import (
    BlockToml,
    named_file,
    read_block_toml,
    said_of,
    with_row,
)
from einschalt.interfaces.files.camera_toml import camera_of
from einschalt.interfaces.files.cut_files import note_on_last_model
from einschalt.interfaces.files.flights_apart import require_one_flight
from einschalt.interfaces.files.grid_files import grid_folder, grids_between
from einschalt.interfaces.files.input_files import (
    companions,
    read_once,
)
from einschalt.interfaces.files.points_of_systems import (
    bring,
    is_in_no_system,
    is_same_plane,
    other_system,
    require_columns,
    schema_in,
    with_plane_names,
)
from einschalt.pipeline.block.axis_order import own_axis_problems
from einschalt.pipeline.block.block import FLIGHTS, Block, Flight
from einschalt.pipeline.block.check import check_block
from einschalt.pipeline.block.scales import coarse_digits
from einschalt.pipeline.block.ways_between_systems import (
    demand_of,
    notes_of_unused,
    standard_errors_of,
    with_one_error,
)


@dataclass(frozen=True, eq=False)
class BlockFindings:
    """Everything that is wrong with a block folder."""

    problems: tuple[EinschaltError, ...]  # stop the computation
    model_problems: tuple[EinschaltError, ...]  # will be rows of ``failures``
    notes: tuple[str, ...]  # what was ignored, filled in or reprojected
    block: Block | None  # None where there are problems


def read_block(path, given=None, *, kind=Block, readers=None):
    """Read a block as ``kind``, Block or a class derived from it.

    ``path`` is the folder, or its block.toml; ``given``: settings that go before those
    in it; ``readers``: of files that are no plain tables as well. The tables
    keep the line of their file as index. Several faults come together in a BlockError.
    """
    found = find_problems(path, given, kind=kind, readers=readers)
    raise_problems(found.problems)
    return found.block


def find_problems(path, given=None, *, kind=Block, readers=None) -> BlockFindings:
    """Look for everything that is wrong with a block, without raising."""
    try:
        path = block_file(path)
        file = read_once(path, path.name)
        toml = _understood(file, read_block_toml)
        toml.settings = toml.settings.updated(given or {})
    except EinschaltError as error:
        return BlockFindings((error,), (), (), None)
    reading = _Reading(file, toml, readers or Readers())
    fields = reading.fields()
    problems = reading.toml.problems
    if not problems:
        try:
            block = kind(**fields)
        except EinschaltError:
            pass  # all that is wrong is collected below, with what was noted
        else:
            return BlockFindings((), tuple(block.model_problems), block.notes, block)
    # a Block cannot be had yet, but its fields can be looked at
    found = check_block(SimpleNamespace(**fields), frozenset(toml.said))
    text = file.data.decode("utf-8-sig")
    problems = [with_row(p, text, toml.source) for p in (*problems, *found.problems)]
    notes = tuple(dict.fromkeys((*fields["notes"], *found.notes)))
    return BlockFindings(tuple(problems), found.model_problems, notes, None)


def _understood(file, read, *more):
    """What a reader makes of a file, where that stayed the same meanwhile."""
    try:
        return read(file, *more)
    finally:  # half a file has faults of its own, which nobody can mend
        file.require_unchanged()


def _frame_of(table):
    """Rows and columns of a table; None where it could not be read."""
    return None if table is None else table.frame


def _unit_of(section, key):
    """Unit of the coordinates of a table of a flight; None of points on the ground."""
    if key == "file":
        return None
    if key == "image_points":
        return "mm" if section.camera is None else "px"
    return section.model_unit


class _Reading:
    """Reads the tables that block.toml names, and keeps what is wrong with them."""

    def __init__(self, file, toml: BlockToml, readers: Readers):
        self.folder = file.path.parent
        self.readers = readers
        self.toml = toml
        self.sources = {"block": toml.source}
        self.checksums = {toml.source: file.checksum()}
        self.files = [file.path.absolute()]  # the present folder may be another later
        self.notes, self.shared_errors_m, self.axes_told = [], {}, {}

    def fields(self):
        """Return the fields of the block, as far as they could be read."""
        sections = self.toml.sections
        block, approximate = map(sections.get, ("block", "approximate_points"))
        self.crs = block.crs if block else None
        # a wrong path is told where no point needs a grid yet, too
        self.grids = self._said(
            "settings", "grids", lambda: grid_folder(self.toml.settings, self.folder)
        )
        points = {name: self._points(name) for name in POINT_TABLES}
        if not (self.axes_told or self.toml.problems or self.toml.settings.output_crs):
            self.notes += notes_of_unused(self.toml.settings)
        return {
            **points,
            **{name: self._flight(name) for name in FLIGHTS},
            "approximate_m_0_m": approximate.m_0_m if approximate else None,
            "crs": self.crs,
            "name": (block and block.name) or as_unicode(self.folder.resolve().name),
            **{n: getattr(block, n, None) or "" for n in ("project", "operator")},
            "settings": self.toml.settings,
            "sources": self.sources,
            "checksums": self.checksums,
            "files": tuple(self.files),
            "may_be_unmeasured": any(self._given("may_be_unmeasured").values()),
            "notes": tuple(self.notes),
            "shared_errors_m": self.shared_errors_m,
            "axes_told": self.axes_told,
            "group_errors_m": self._given("group_error_m"),
            "correlation_lengths_m": self._given("correlation_length_m"),
        }

    def _given(self, key):
        """A fact of the tables of points, by their names."""
        known = {n: getattr(self.toml.sections.get(n), key, None) for n in POINT_TABLES}
        return {name: value for name, value in known.items() if value is not None}

    def _flight(self, name):
        section = self.toml.sections.get(name)
        if section is None:
            return None
        given = {
            key: _frame_of(self._table(name, key, schema))
            for key, schema in FLIGHT_TABLES.items()
            if named_file(getattr(section, key)) is not None
        }
        if isinstance(section.base, (int, float)):
            given["base"] = section.base
        if section.camera is not None:
            given["camera"] = self._camera(name, section.camera)
        if (name, "camera") in self.toml.said and "image_points" in given:
            # what the camera would have made of them nobody knows
            self.toml.said.add((name, "image_points"))
            del given["image_points"]
        facts = {key: getattr(section, key) for key in FLIGHT_FACTS}
        return Flight(**facts, **given)

    def _camera(self, section, given):
        """Camera of a flight, from its own file or from block.toml."""
        if isinstance(given, dict):
            name, file = f"{section}.camera", self.toml.source
            return self._said(section, "camera", lambda: camera_of(given, name, file))
        self.sources[f"{section}.camera"] = given
        named = given, section, "camera"
        return self._said(
            section, "camera", lambda: self._file(*named, self.readers.camera)
        )

    def _table(self, section, key, schema, crs=None):
        """Table that a key names."""
        keys = self.toml.sections[section]
        keys = keys if key == "file" else getattr(keys, key)
        source = named_file(keys)
        table = section if key == "file" else f"{section}.{key}"
        self.sources[table] = source

        def read(file, source):
            unit = _unit_of(self.toml.sections[section], key)
            said = said_of(keys, crs or self.crs, unit)
            beside = self._companions(file.path, source, table)
            known = {"source": source, "beside": beside}
            found = self.readers.table(file, schema, said, **known)
            elsewhere.require_some_column(file.path, self.folder, found.frame, schema)
            notes = require_one_flight(found.frame, schema, source)
            return replace(found, notes=(*found.notes, *notes))

        done = self._said(section, key, lambda: self._file(source, section, key, read))
        if done is not None:
            self.notes += done.notes
            if key in ("model_points", "image_points"):
                part = "model_id" if key == "model_points" else "image_id"
                note = note_on_last_model(done.frame, part, source)
                self.notes += [note] if note else []
        return done

    def _companions(self, path, source, table):
        """Files that belong to a table, such as the .dbf of a shapefile; signed for."""
        folder, beside = Path(source).parent, companions(path)
        names = {one: str(folder / one.relative_to(path.parent)) for one in beside}
        parts = {one.name.removeprefix(path.stem): names[one] for one in names}
        self.sources |= {f"{table}{part}": name for part, name in parts.items()}
        return tuple(self._signed(one, name) for one, name in names.items())

    def _file(self, source, section, key, read):
        """What a function reads from a file, which is signed for."""
        file = self._signed(self._path(source, section, key), source)
        with elsewhere.discreetly(file.path, self.folder, source):
            return _understood(file, read, source)

    def _signed(self, path, source):
        file = read_once(path, source)
        self.checksums[source] = file.checksum()
        self.files.append(file.path.absolute())
        return file

    def _said(self, section, key, read):
        """What a function reads; None, and said, where that fails."""
        try:
            return read()
        except BlockError as error:
            self.toml.said.add((section, key))
            self.toml.problems += error.problems
        except EinschaltError as error:
            self.toml.say(error, section, key)
        return None

    def _path(self, source, section, key):
        if not source.strip():
            raise FileError(
                f"[{section}] {key} is empty",
                expected="the name of a table",
                remedy=f"Name the table, or take {key} out",
                file=self.toml.source,
                section=section,
                key=key,
            )
        sections = self.toml.sections.values()
        values = (v for s in sections for v in vars(s).values())
        taken = {named_file(v) for v in values} - {None}
        key = f"[{section}] {key}"
        return elsewhere.require_named_file(self.folder, source, key, taken)

    def _points(self, name):
        section = self.toml.sections.get(name)
        if section is None or section.file is None:
            return None
        own = (
            None if section.crs is None else other_system(self.toml, section.crs, name)
        )
        if is_in_no_system(self.toml, section.crs, name):
            return None
        schema = POINT_TABLES[name]
        stated = schema if own is None else schema_in(schema, own)
        done = self._table(name, "file", stated, section.crs)
        if done is None:
            return None
        frame, source = done.frame, self.sources[name]
        if done.crs is not None:
            own = self._own_system(done.crs, section.crs, own, name)
            if own is None and is_in_no_system(
                self.toml, section.crs or done.crs, name
            ):
                return None
        schema = schema if own is None else schema_in(schema, own)
        if own is not None and not self._has_its_columns(frame, own, name):
            return None
        checked = tables.check_table(frame, schema, source=source)
        if checked.problems:
            if own is not None:
                self.toml.said.add((name, "file"))
                self.toml.problems += checked.problems
                return None
            return frame  # check_block says what is wrong, in the words of the file
        error = getattr(section, "standard_error_m", None)
        if error is not None:
            frame, notes = with_one_error(frame, error, checked.frame, source)
            self.notes += notes
        if section.shared_error_m is not None:
            self.shared_errors_m[name] = section.shared_error_m
        if own is None:
            return frame
        frame, understood = with_plane_names(frame), with_plane_names(checked.frame)
        return self._in_crs_of_block(frame, understood, own, name)

    def _has_its_columns(self, frame, own, name):
        try:
            require_columns(frame, own, self.sources[name])
        except EinschaltError as error:
            self.toml.say(error, name, "file")
            return False
        return True

    def _in_crs_of_block(self, frame, checked, own, name):
        problems, _ = own_axis_problems(checked, own, self.sources[name])
        if problems or ("settings", "grids") in self.toml.said:
            self.toml.said.add((name, "file"))
            self.toml.problems += problems
            return None
        return self._said(
            name, "file", lambda: self._brought(frame, checked, own, name)
        )

    def _brought(self, frame, checked, own, name):
        """Points in the system of the block, and what that adds to their errors."""
        source, settings = self.sources[name], self.toml.settings
        m_0_m = getattr(self.toml.sections[name], "m_0_m", None)
        error = frame.get("standard_error_m", m_0_m)
        error = standard_errors_of(checked, error)
        demand, systems = demand_of(settings, error), (own, read_crs(self.crs))
        files = self._grids(grids_between(*systems, self.grids))
        how = {"grids": self.grids, "source": source}
        try:
            done = bring(frame, checked, systems, demand, **how)
        except EinschaltError as error:
            raise error.with_facts(file=source) from error
        finally:
            for file in files:
                file.require_unchanged()
        self.notes.append(done.note)
        if own.axis_info[0].unit_name == "degree":
            self.notes += coarse_digits(checked, error, source, in_degrees=True)
        self.axes_told[name] = done.axes_told
        before = self.shared_errors_m.get(name, 0.0)
        shared = float(np.hypot(before, done.operation.accuracy_m))
        if shared > 0.0:
            self.shared_errors_m[name] = shared
        return done.frame

    def _grids(self, paths):
        """Files of grids, which are signed for as the tables are."""
        names = {table: table.partition(".")[2] for table in paths}
        self.sources |= names
        return [self._signed(path, names[table]) for table, path in paths.items()]

    def _own_system(self, found, stated, own, name):
        """System of points whose file states one, ``found``."""
        system, source = read_source_crs(found), self.sources[name]
        if stated is None and self.crs is None and not system.is_geographic:
            label = label_of(found)
            self.notes.append(f"{source}: in {label}; block.toml names no system")
            return None
        if stated is None:
            return other_system(self.toml, found, name)
        if not is_same_plane(system, stated):
            label = label_of(found)
            problem = SettingsError(
                f"[{name}] crs = {label_of(stated)}, but {source} says {label}",
                expected="the system of the coordinates",
                remedy="Take crs out, or correct it in the file",
                file=self.toml.source,
                section=name,
                key="crs",
            )
            self.toml.say(problem, name, "crs")
        return own
