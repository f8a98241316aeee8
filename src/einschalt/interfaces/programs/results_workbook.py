"""Results as a workbook: a sheet for every table, with units, and what they mean.

Texts are written as texts: no name becomes a formula, a link or a number.
"""

import math
from datetime import datetime

import numpy as np
import pandas as pd

from einschalt.foundations.column_meanings import TABLES, meaning_of
from einschalt.foundations.display_names import printable
from einschalt.foundations.errors import FileError
from einschalt.foundations.extras import imported
from einschalt.interfaces.files.result_folder import decimals_of

ABOUT, COLUMNS = "about", "columns"
MOST_ROWS = 1_048_575
MOST_CHARACTERS = 32_767
WIDEST = 28


def write_workbook(handed, path):
    """Write every table, and two sheets that say what they are."""
    library = imported("xlsxwriter", "A workbook")
    for name, table in handed.tables.items():
        if len(table) > MOST_ROWS:
            raise FileError(
                f"table {name} has {len(table)} rows",
                expected=f"at most {MOST_ROWS}, as a sheet holds",
                remedy="Choose Parquet, or GeoParquet for the points",
                file=path.name,
            )
    options = {"constant_memory": True, "strings_to_numbers": False}
    book = library.Workbook(path, options)
    created = handed.created[:19]
    book.set_properties(
        {
            "title": printable(handed.name),
            "comments": "einschalt",
            **({"created": datetime.fromisoformat(created)} if created else {}),
        }
    )
    head = book.add_format({"bold": True, "bottom": 1, "text_wrap": True})
    _write_about(book, handed, head)
    formats = {}
    for name, table in handed.tables.items():
        _write_table(book, name, table, head, formats)
    _write_columns(book, handed, head)
    book.close()


def _write_about(book, handed, head):
    sheet = book.add_worksheet(ABOUT)
    sheet.set_column(0, 0, WIDEST)
    sheet.set_column(1, 1, 80)
    rows = [
        ("block", printable(handed.name)),
        ("reference system", handed.crs or "local, not georeferenced"),
        ("computed", handed.created),
        ("units", "metres unless the head of a column says another one"),
        ("TOTAL", "root of the squares of both standard errors in plan"),
        *((name, TABLES[name]) for name in handed.tables),
    ]
    for row, (word, text) in enumerate(rows):
        sheet.write_string(row, 0, word, head)
        sheet.write_string(row, 1, text)


def _write_table(book, name, table, head, formats):
    sheet = book.add_worksheet(name)
    sheet.freeze_panes(1, 1)
    sheet.autofilter(0, 0, len(table), table.shape[1] - 1)
    columns = []
    for place, column in enumerate(table):
        title = titled(column, name)
        decimals = decimals_of(column)
        if decimals is not None and decimals not in formats:
            shown = {"num_format": "0." + "0" * decimals}
            formats[decimals] = book.add_format(shown)
        own = formats.get(decimals)
        longest = table[column].astype(str).str.len().max()
        width = min(WIDEST, max(10, len(title) * 0.7, longest if own is None else 12))
        sheet.set_column(place, place, width, own)
        columns.append(_plain(table[column]))
    for place, column in enumerate(table):
        sheet.write_string(0, place, titled(column, name), head)
    for row, values in enumerate(zip(*columns, strict=True), 1):
        for place, value in enumerate(values):
            _write_cell(sheet, row, place, value)


def titled(column, table):
    """Name of a column with its unit in brackets.

    >>> titled("easting", "points"), titled("role", "points")
    ('easting [m]', 'role')
    """
    unit, _ = meaning_of(column, table) or ("", "")
    return f"{column} [{unit}]" if unit else column


def _plain(series):
    """Values of a column as Python has them; missing is None."""
    values = series.astype(object).to_numpy()
    return np.where(pd.isna(series), None, values)


def _write_cell(sheet, row, place, value):
    if value is None:
        return
    if isinstance(value, (bool, np.bool_)):
        sheet.write_boolean(row, place, bool(value))
    elif isinstance(value, (int, float, np.number)) and math.isfinite(value):
        sheet.write_number(row, place, value)
    else:
        sheet.write_string(row, place, printable(value)[:MOST_CHARACTERS])


def _write_columns(book, handed, head):
    sheet = book.add_worksheet(COLUMNS)
    for place, width in enumerate((20, 30, 8, 80)):
        sheet.set_column(place, place, width)
    rows = [("table", "column", "unit", "meaning")]
    for name, table in handed.tables.items():
        found = [(name, c, *(meaning_of(c, name) or ("", ""))) for c in table]
        rows += found
    for row, cells in enumerate(rows):
        for place, text in enumerate(cells):
            sheet.write_string(row, place, str(text), *([] if row else [head]))
