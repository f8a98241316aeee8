"""Tables in the sheets of workbooks: .xlsx and .ods.

A cell is read as its value: what a formula gave when the workbook was saved; a formula
without one is refused where it is needed. Hidden sheets are read if they are named.
Formulas of .ods, macros, pictures and links do not even reach the reader, and nothing
computes those of .xlsx.
"""

import io
import re
import zipfile
import zlib
from dataclasses import replace
from pathlib import Path

import numpy as np

from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import (
    FileError,
    TableError,
    name_some,
    raise_problems,
)
from einschalt.foundations.near_words import nearest
from einschalt.foundations.tables import listed
from einschalt.interfaces.files import workbook_sizes
from einschalt.interfaces.files.cells_of_names import (
    WORKBOOK,
    hidden_columns,
    hidden_rows,
    no_texts,
)
from einschalt.interfaces.files.gdal_files import opened
from einschalt.interfaces.files.header_rows import (
    HEAD_ROWS,
    place_of_header,
    with_units,
)
from einschalt.interfaces.files.input_files import read_once
from einschalt.interfaces.files.names_in_workbooks import whole_names
from einschalt.interfaces.files.sheet_parts import fitting_parts, meant_part, parts_of
from einschalt.interfaces.files.understood_tables import (
    NOTHING_SAID,
    ReadTable,
    meant_header,
    understood,
)
from einschalt.interfaces.files.workbook_parts import (
    NO_VALUE,
    count_cells_of_ods,
    hidden_sheets,
    is_to_be_computed,
    with_marks,
)

SUFFIXES = (".xlsx", ".ods")
ZIP, OLE = b"PK\x03\x04", b"\xd0\xcf\x11\xe0"
FORMULA = re.compile(rb"""\s(table:formula)\s*=\s*("[^"]*"|'[^']*')""")
MOST_COLUMNS = 1000
TOO_MANY = "memory for row/cell repetition"  # what GDAL says of large .ods
# NotImplementedError, of a way of packing that is not known, is a RuntimeError
DAMAGES = (zipfile.BadZipFile, zlib.error, OSError, EOFError, RuntimeError, ValueError)


def understand_workbook(path, schema, said=NOTHING_SAID, *, source=None) -> ReadTable:
    """Read a sheet of a workbook; the index is its row, counted from 1.

    The sheet is ``said.sheet``, or the only one that has the columns of the schema.
    """
    source = source or Path(path).name
    cells, sheet, notes, data = _sheet(path, schema, said, source)
    cells, n_beside, more = meant_part(cells, schema, said, source, sheet)
    notes += more
    place, names = _header(cells, schema, said)
    row = int(cells.index[place])
    units = with_units(names, _first_rows(cells[place + 1 : place + 2])[0])
    names, place = (names, place) if units is None else (units, place + 1)
    values = cells.iloc[place + 1 :]
    is_used = [bool(n) or (values.iloc[:, k] != "").any() for k, n in enumerate(names)]
    columns = np.flatnonzero(is_used)
    frame = values.iloc[:, columns]
    frame = frame[(frame != "").any(axis=1)]
    notes += [] if n_beside else _note_on_gap(frame.index, f"{source}, sheet {sheet}")
    given = [n or f"(column {k + 1})" for k, n in enumerate(names) if is_used[k]]
    meant = meant_header(given, schema, said, source, row)
    frame.columns = list(meant.names)
    frame = _with_values(frame, schema, f"{source}, sheet {sheet}")
    places = {n: int(columns[k]) for k, n in enumerate(meant.names)}
    where = {n: k for n, k in places.items() if n in schema.id_names}
    held = _no_texts(data, sheet, where, source)
    frame, more = whole_names(frame, where, held, f"{source}, sheet {sheet}")
    notes += more
    read = {
        k: name
        for k, name, own in zip(columns.tolist(), given, meant.names, strict=True)
        if own in schema.names
    }
    notes += _notes_on_hidden(data, sheet, frame.index, read, source)
    table = understood(frame, schema, said, meant, source, is_of_cells=True)
    return replace(table, notes=(*notes, *table.notes), n_beside=n_beside)


def sheets_of(path, source):
    """Cells of all sheets that are shown and not empty, as text, by name."""
    sheets, hidden, _ = _all_sheets(path, source)
    return {name: cells for name, cells in sheets.items() if name not in hidden}


def _all_sheets(path, source):
    """Cells of all sheets of a workbook that are not empty, and those that are hidden.

    At least one of them is shown. Beside them the sound copy that they stand in.
    """
    suffix = Path(path).suffix.lower()
    data = sound_copy(read_once(path, source).data, suffix, source)
    try:
        hidden = hidden_sheets(data)
    except DAMAGES as error:
        raise _damaged(source) from error
    sheets = _cells_of(data, suffix, source)
    if not sheets:
        raise FileError("the workbook is empty", remedy="Fill it", file=source)
    if hidden.issuperset(sheets):
        raise FileError(
            f"all sheets with anything in them are hidden: {name_some(sheets)}",
            expected="a sheet that is shown",
            remedy="Show it in the spreadsheet, and save the workbook again",
            file=source,
        )
    return sheets, hidden.intersection(sheets), data


def _cells_of(data, suffix, source):
    """Cells of all sheets of a sound copy, but of those that are empty."""
    sheets = {}
    try:
        with opened({suffix: data}, source) as (pyogrio, copy):
            for name, _ in pyogrio.list_layers(copy):
                _, table = pyogrio.read_arrow(copy, layer=name, return_fids=True)
                _refuse_width(table.num_columns - 1, source)
                frame = table.to_pandas().set_index(table.column_names[0]).fillna("")
                frame = frame.astype("str").apply(lambda column: column.str.strip())
                frame.index.name = "row"
                if frame.size and (frame != "").to_numpy().any():
                    sheets[name] = frame
    except FileError as error:
        if TOO_MANY in str(error):
            n_cells = count_cells_of_ods(data)
            raise workbook_sizes.too_many_in_ods(n_cells, source) from error
        raise
    return sheets


def _refuse_width(n_columns, source):
    if n_columns > MOST_COLUMNS:
        raise FileError(
            f"a sheet has {n_columns} columns",
            expected=f"at most {MOST_COLUMNS}",
            remedy="Leave out the columns that are no part of the table",
            file=source,
        )


def _sheet(path, schema, said, source):
    """Cells of the sheet that is meant, its name, notes, and the sound copy."""
    sheets, hidden, data = _all_sheets(path, source)
    sheet, note = _meant_sheet(sheets, hidden, schema, said, source)
    notes = [note] if note else []
    return sheets[sheet], sheet, notes, data


def _note_on_gap(rows, where):
    """Say where a table goes on below an empty row: it may be another one."""
    gaps = np.flatnonzero(np.diff(rows.to_numpy()) > 1)
    if not len(gaps):
        return []
    row = int(rows[gaps[0]]) + 1
    return [f"{where}: what stands below the empty row {row} is read as well"]


def _notes_on_hidden(data, sheet, rows, columns, source):
    """Say which of the rows and columns that are read a spreadsheet does not show.

    ``columns``: names as they stand in the sheet, by their positions.
    """
    try:
        hidden = [row for row in sorted(hidden_rows(data, sheet)) if row in rows]
        unseen = sorted(hidden_columns(data, sheet).intersection(columns))
    except DAMAGES as error:
        raise _damaged(source) from error
    notes, some, named = [], name_some(hidden), [repr(columns[k]) for k in unseen]
    if hidden:
        notes.append(f"{source}, sheet {sheet}: hidden rows are read as well: {some}")
    some = name_some(named)
    if unseen:
        note = f"{source}, sheet {sheet}: hidden columns are read as well: {some}"
        notes.append(note)
    return notes


def _no_texts(data, sheet, where, source):
    try:
        return no_texts(data, sheet, list(where.values()))
    except DAMAGES as error:
        raise _damaged(source) from error


def _meant_sheet(sheets, hidden, schema, said, source):
    """Name of the sheet that is meant, and a note or None."""
    if said.sheet is not None:
        if said.sheet in sheets:
            note = f"{source}: sheet '{said.sheet}' is hidden"
            return said.sheet, note if said.sheet in hidden else None
        near = nearest(said.sheet, sheets)
        raise FileError(
            f"holds no sheet '{shortened(said.sheet)}' with anything in it",
            expected=name_some(sheets, 8),
            remedy=f"Did you mean '{near}'?" if near else "Correct sheet",
            file=source,
        )
    sheets = {name: cells for name, cells in sheets.items() if name not in hidden}
    if len(sheets) == 1:
        note = f"{source}: hidden sheet {name_some(hidden)} is not read"
        return next(iter(sheets)), note if hidden else None
    fitting = [n for n, cells in sheets.items() if _has_header(cells, schema, said)]
    if len(fitting) == 1:
        sheet, words = fitting[0], schema.name.replace("_", " ")
        note = f"{source}: sheet '{sheet}' alone has the columns of a table of {words}"
        return sheet, note
    raise FileError(
        f"holds {len(sheets)} sheets, of which {name_some(fitting) or 'none'} could be "
        "meant",
        expected="one table",
        remedy=f'Say which: sheet = "{(fitting or list(sheets))[0]}" in block.toml',
        file=source,
    )


def _first_rows(cells):
    """Cells of the rows that may have the names; one empty row where there is none."""
    rows = cells.iloc[:HEAD_ROWS].to_numpy(dtype=object).tolist()
    return rows or [[""] * cells.shape[1]]


def _has_header(cells, schema, said):
    if place_of_header(_first_rows(cells), schema, said) is not None:
        return True
    parts = parts_of(cells)
    return len(parts) > 1 and bool(fitting_parts(cells, parts, schema, said))


def _header(cells, schema, said):
    """Position of the row with the names, and these: titles may stand above it."""
    rows = _first_rows(cells)
    found = place_of_header(rows, schema, said)
    if found is not None:
        return found
    place = int(np.flatnonzero((cells != "").any(axis=1).to_numpy())[0])
    return place, cells.iloc[place].tolist()


def _with_values(frame, schema, source):
    """Refuse formulas without a value in columns that are read; others are empty."""
    problems = []
    for place, name in enumerate(frame.columns):
        if name not in schema.names:
            continue
        is_formula = (frame.iloc[:, place] == NO_VALUE).to_numpy(dtype=bool)

        def problem(row, name=name):
            return TableError(
                f"{name} is a formula without a value: no spreadsheet has computed it",
                expected="a formula with the value that it had when it was saved",
                remedy="Open the workbook in Excel or LibreOffice, and save it there",
                file=source,
                row=int(frame.index[row]),
            )

        rest = f"{name} is a formula without a value"
        problems += listed(np.flatnonzero(is_formula), problem, rest)
    raise_problems(problems)
    frame = frame.replace(NO_VALUE, "")
    return frame[(frame != "").any(axis=1)]


def sound_copy(data, suffix, source):
    """Copy a workbook without all that is no text, number or name of a sheet.

    A FileError where it would unpack to a monster, is damaged, or has XML entities.
    """
    if not data.startswith(ZIP):
        is_old = data.startswith(OLE)
        found = "is an old or an encrypted workbook" if is_old else "is no workbook"
        save = f"Save it as {suffix} without a password again"
        remedy = save if is_old else "Export it again"
        raise FileError(found, expected=suffix, remedy=remedy, file=source)
    copy = io.BytesIO()
    try:
        with (
            zipfile.ZipFile(io.BytesIO(data)) as packed,
            zipfile.ZipFile(copy, "w") as new,
        ):
            members = packed.infolist()
            workbook_sizes.refuse_size(members, len(data), source)
            texts = {}
            has_zeros = WORKBOOK in packed.namelist() and is_to_be_computed(
                packed.read(WORKBOOK)
            )
            for member in members:
                name = member.filename
                if name == "mimetype" or name.endswith((".xml", ".rels")):
                    text = packed.read(member)
                    workbook_sizes.refuse_entities(text, source)
                    text = with_marks(text, has_zeros=has_zeros)
                    # without a copy of hundreds of megabytes where there is none
                    has_formula = b"table:formula" in text
                    texts[name] = FORMULA.sub(b"", text) if has_formula else text
            workbook_sizes.refuse_cells(texts, len(data), source)
            for name, text in texts.items():
                new.writestr(name, text)
    except DAMAGES as error:
        raise _damaged(source) from error
    return copy.getvalue()


def _damaged(source):
    return FileError(
        "the workbook is damaged or truncated",
        expected="a workbook that a spreadsheet opens",
        remedy="Copy or export it again",
        file=source,
    )
