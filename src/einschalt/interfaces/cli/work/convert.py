"""What ``einschalt convert`` does."""

import os
from contextlib import contextmanager, suppress
from dataclasses import replace

import tomli_w

from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import (
    FileError,
    OutputError,
    TableError,
    name_some,
    raise_problems,
)
from einschalt.foundations.kept_texts import kept, retold
from einschalt.foundations.language import ENGLISH, mark, translated, written_in
from einschalt.foundations.projections import code_of, label_of, read_source_crs
from einschalt.foundations.told_errors import told
from einschalt.interfaces.cli.exits import print_error, print_out
from einschalt.interfaces.cli.outcome import report, report_problems
from einschalt.interfaces.cli.work.answers import OF_TABLES
from einschalt.interfaces.files import odm_lists
from einschalt.interfaces.files.atomic import make_folder
from einschalt.interfaces.files.block_toml import write_keys
from einschalt.interfaces.files.csv_tables import write_csv
from einschalt.interfaces.files.header_lengths import in_written_units
from einschalt.interfaces.files.points_of_systems import is_same_plane
from einschalt.interfaces.files.tables_by_suffix import WRITTEN_SUFFIXES, write_table
from einschalt.interfaces.files.understood_tables import Said, answered_elsewhere
from einschalt.interfaces.new_block.kinds_of_tables import KINDS
from einschalt.interfaces.new_block.looked_at import look_at
from einschalt.interfaces.programs.block_tables import marker_reader_of
from einschalt.interfaces.programs.converted_faults import faults_of, faults_of_places
from einschalt.interfaces.programs.foreign import in_unit_of_system
from einschalt.interfaces.programs.recognised import reader_of

FOR_CONTROL = mark("In block.toml: [control_points] {line}")
LIST_SUFFIX = ".txt"
CONTROL, IMAGES = "control_points.csv", "image_points.csv"


def convert(given, output, *, kind, sheet, layer, crs, decimal, angles):
    """Convert markers or a table; what was understood goes to standard error."""
    read_markers = marker_reader_of(given)
    # a list has no place for what else a program has measured
    is_list = read_markers is not None and output.suffix.lower() == LIST_SUFFIX
    read = None if is_list else reader_of(given, kind)
    if read is not None:
        found = in_unit_of_system(read(given), given.name, crs)
        _convert_foreign(found, given, output, crs)
        return
    if read_markers is not None:
        markers = _in_system(read_markers(given, given.name), crs, given)
        _convert_markers(markers, given, output)
        return
    said = Said(sheet=sheet, layer=layer, crs=crs, decimal=decimal, angles=angles)
    try:
        found = look_at(given, said)
    except (TableError, FileError) as error:
        # there is no block.toml that could have the answer
        raise answered_elsewhere(error, OF_TABLES) from None
    _convert_table(found, given, output)


def _convert_foreign(foreign, given, output, crs):
    """Write the tables of another program into a folder, each as a file."""
    _print_notes(foreign.notes)
    if output.suffix and not output.is_dir():
        raise _no_folder(output)
    paths = {name: output / f"{name}.csv" for name in foreign.tables}
    cameras = _camera_paths(foreign.cameras, output)
    for path in (*paths.values(), *cameras.values()):
        _require_free(path)
    make_folder(output)
    with _all_or_none((*paths.values(), *cameras.values())):
        for name, path in cameras.items():
            write_keys(path, foreign.cameras[name])
        for name, path in paths.items():
            write_csv(foreign.tables[name], path)
    for name, path in cameras.items():
        report(path)
        facts = {"name": shortened(name), "file": given.name, "path": path}
        print_out(translated("camera {name} of {file} in {path}", **facts))
    for name, path in paths.items():
        report(path, **{f"n_{name}": len(foreign.tables[name])})
        facts = {"n": len(foreign.tables[name]), "file": given.name, "path": path}
        print_out(translated("{n:row|rows} of {file} in {path}", **facts))
    crs = _in_system(foreign, crs, given).crs
    _print_faults({n: (foreign.tables[n], path) for n, path in paths.items()}, crs)
    if crs is not None and CONTROL in {path.name for path in paths.values()}:
        print_out(translated(FOR_CONTROL, line=_crs_line(crs)))


@contextmanager
def _all_or_none(paths):
    """Remove files that were free before, if one of them could not be written.

    They would stand in the way of the next run.
    """
    try:
        yield
    except BaseException:
        for path in paths:
            with suppress(OSError):  # what went wrong before is told
                path.unlink(missing_ok=True)
        raise


def _print_faults(tables, crs):
    """Tell what check would refuse in tables that were written, by name."""
    for name, (frame, path) in tables.items():
        faults = faults_of(name, frame, path.name, crs)
        report_problems(*faults)
        for fault in faults:
            print_error(translated("problem: {problem}", problem=told(fault)))


def _camera_paths(cameras, output):
    """One camera.toml, or one for each camera, numbered."""
    if len(cameras) == 1:
        return dict.fromkeys(cameras, output / "camera.toml")
    return {n: output / f"camera_{k}.toml" for k, n in enumerate(cameras, 1)}


def _no_folder(output):
    return FileError(
        f"suffix '{output.suffix}' is none for what another program has measured",
        expected="a folder, or gcp_list.txt for markers",
        remedy="Name a folder",
        file=output,
    )


def _in_system(markers, crs, given):
    """The markers with the system that was said of them, if one was."""
    if crs is None:
        return markers
    system = read_source_crs(crs)
    if markers.crs is not None and not is_same_plane(system, markers.crs):
        raise FileError(
            f"is in {label_of(markers.crs)}, not in {label_of(crs)}",
            expected="the system of its coordinates: convert brings none into another",
            remedy="Leave --crs out",
            file=given.name,
        )
    return replace(markers, crs=markers.crs or code_of(crs))


def _convert_markers(markers, given, output):
    is_list = output.suffix.lower() == LIST_SUFFIX
    markers = odm_lists.as_listed(markers, given.name) if is_list else markers
    _print_notes(markers.notes)
    if is_list:
        for name, table in markers.tables().items():
            faults = faults_of(name, table, given.name, markers.crs)
            # its own lines are not those of the table
            raise_problems([fault.with_facts(row=None) for fault in faults])
        _require_free(output)
        make_folder(output.absolute().parent)
        odm_lists.write_odm(output, markers)
        report(output)
        facts = {"markers": _said(markers), "path": output}
        print_out(translated("{markers} in {path}", **facts))
        return
    if output.suffix and not output.is_dir():
        raise _no_folder(output)
    control, measured = output / CONTROL, output / IMAGES
    for path in (control, measured):
        _require_free(path)
    make_folder(output)
    with _all_or_none((control, measured)):
        write_csv(markers.control_points(), control)
        write_csv(markers.measurements, measured)
    report(control, measured)
    facts = {"markers": _said(markers), "file": given.name}
    facts |= {"control": control, "measured": measured}
    print_out(translated("{markers} of {file} in {control} and {measured}", **facts))
    paths = {"control_points": control, "image_points": measured}
    tables = markers.tables()
    _print_faults({n: (tables[n], path) for n, path in paths.items()}, markers.crs)
    if markers.crs is not None:
        print_out(translated(FOR_CONTROL, line=_crs_line(markers.crs)))


def _said(markers):
    return translated(
        "{n_points:point|points}, {n:measurement|measurements} in "
        "{n_images:image|images}",
        n_points=len(markers.points),
        n=len(markers.measurements),
        n_images=int(markers.measurements["image_id"].nunique()),
    )


def _print_notes(notes):
    for note in notes:
        print_error(translated("note: {note}", note=retold(note)))


def _convert_table(found, given, output):
    if len(found) > 1:
        parts = (one.said.sheet or one.said.layer for one in found)
        named = name_some(sorted({part for part in parts if part}), 8)
        held = kept("{n:table|tables}", n=len(found))
        raise FileError(
            f"holds {held}: {named}" if named else f"holds {held}",
            expected="one table",
            remedy="Say which by --sheet or --layer",
            file=given.name,
        )
    table = found[0]
    _print_notes(table.notes)
    if table.kind == "camera" or output.suffix.lower() not in WRITTEN_SUFFIXES:
        with written_in(ENGLISH):  # an error is told where it is shown
            held = table.description
        raise FileError(
            f"{given.name} holds {held}",
            expected="a table, and a file .csv or .parquet for it",
            remedy="Name such a file",
        )
    schema = KINDS[table.kind]
    if table.kind == "ground":
        raise_problems(faults_of_places(table.frame, given.name, table.crs))
    names = [name for name in schema.names if name in table.frame]
    if "longitude" in table.frame:  # checked as such when it was looked at
        names = ["point_id", "longitude", "latitude", *names[1:]]
    if table.left_out:
        _print_notes([f"{given.name}: left out {name_some(table.left_out, 8)}"])
    frame, note = in_written_units(table.frame, schema, table.unit, given.name)
    _print_notes([note] if note else [])
    _require_free(output)
    make_folder(output.absolute().parent)
    write_table(frame[list(dict.fromkeys(names))], output)
    report(output, n_rows=len(table.frame))
    facts = {"table": f"{table.title} ({table.description})", "path": output}
    print_out(translated("{table} in {path}", **facts))
    if table.crs is not None:
        line = _crs_line(table.crs)
        print_out(translated("In block.toml, for this table: {line}", line=line))


def _crs_line(crs):
    """The line of block.toml that names a system, and what it is."""
    # by its code where that says all; the text of a system may fill the screen
    name = crs if read_source_crs(crs).is_bound else code_of(crs)
    key = tomli_w.dumps({"crs": name}).rstrip("\n")  # WKT has quotes
    return f"{key}  # {label_of(crs)}"


def _require_free(path):
    if os.path.lexists(path):
        raise OutputError(
            "is there already",
            expected="a new file",
            remedy="Name another one, or remove it",
            file=path,
        )
