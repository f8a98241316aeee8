"""Cells of a workbook that hold a number or a date in the place of a name.

A spreadsheet makes dates, times, powers of ten and truth values of what is typed, such
as 7/8, 7:30, 1E5 and TRUE, and shows numbers as their format says: 1.1 as 1.10. What
was typed, the cell no longer tells; that it was no text, it does.
"""

import io
import posixpath
import re
import xml.etree.ElementTree as ET
import zipfile
from dataclasses import dataclass

from einschalt.foundations.number_parsing import is_number
from einschalt.interfaces.files.workbook_parts import ODS, STYLES, formats_of_styles

DATE, POWER, TRUTH, DIGITS, LOOK = "date", "power", "truth", "digits", "look"
WORKBOOK, RELATIONS = "xl/workbook.xml", "xl/_rels/workbook.xml.rels"
GENERAL = "General"
PLAIN = (GENERAL, "GENERAL", "general", "Standard", "@", "")
BUILT_IN = {0: GENERAL, 1: "0", 2: "0.00", 3: "#,##0", 4: "#,##0.00", 9: "0%"}
BUILT_IN |= {10: "0.00%", 11: "0.00E+00", 12: "# ?/?", 13: "# ??/??", 48: "##0.0E+0"}
BUILT_IN |= {49: "@"}
DATES = {*range(14, 23), *range(27, 37), *range(45, 48), *range(50, 59)}
BUILT_IN |= dict.fromkeys(DATES, "date")
# texts, escaped letters, colours and countries, of which no letter is one of a date
NO_LETTERS = re.compile(
    r'"[^"]*"|\\.|_.|\*.|\[(?!h+\]|m+\]|s+\])[^\]]*\]', re.IGNORECASE
)
OF_A_DATE, OF_A_POWER = re.compile(r"[dmyhsDMYHS]"), re.compile(r"[eE][+-]")
DECIMALS = re.compile(r"#*(,##)?0(?:\.(0+))?")
FEW_DIGITS = 15
MOST_DIGITS = 1e15  # beyond them a spreadsheet keeps none
A_THOUSAND = 1000.0
# the reference stands first, as all programs write it
OTHER_CELL = re.compile(rb"""<c(?=[\s/>])(?! r="[A-Z])""")
STYLE = re.compile(rb"""\ss=["'](\d+)""")
KIND = re.compile(rb"""\st=["'](\w+)""")
CELLS = (
    rb"""<c r="(%s)(\d+)"([^<>]*)>(?:\s*<f\b[^<>]*(?:/>|>[^<]*</f>)\s*)?<v>([^<]*)"""
)
HIDDEN_ROW = re.compile(
    rb"""<row(?=[^<>]*\shidden=["'](?:1|true))[^<>]*?\sr=["'](\d+)"""
)
HIDDEN_COLUMN = re.compile(
    rb"""<col(?=[^<>]*\shidden=["'](?:1|true))(?=[^<>]*\smin=["'](\d+))"""
    rb"""(?=[^<>]*\smax=["'](\d+))"""
)
MOST_REPEATED = 1000
OF_TEXT = ("s", "str", "inlineStr", "e")


@dataclass(frozen=True)
class NoText:
    """What a cell holds in place of a text: its kind, and its format or its look."""

    kind: str
    look: str


def no_texts(data, sheet, columns):
    """Cells of some columns of a sheet that are no texts, and may look otherwise.

    ``data``: of a sound copy; ``columns``: positions from 0. Each by its row in the
    sheet and its column; None where the file does not say where its cells stand.
    """
    with zipfile.ZipFile(io.BytesIO(data)) as book:
        if WORKBOOK in book.namelist():
            text = _sheet_of_xlsx(book, sheet)
            if text is None or OTHER_CELL.search(text):
                return None
            return _of_xlsx(text, book, columns)
        return _of_ods(book.read(ODS), sheet, columns)


def hidden_rows(data, sheet):
    """Rows of a sheet that a spreadsheet does not show, by hand or by a filter."""
    with zipfile.ZipFile(io.BytesIO(data)) as book:
        if WORKBOOK in book.namelist():
            text = _sheet_of_xlsx(book, sheet) or b""
            return {int(row) for row in HIDDEN_ROW.findall(text)}
        text = book.read(ODS)
        is_any = b"table:visibility" in text
        return set(_hidden_of_ods(text, sheet)) if is_any else set()


def hidden_columns(data, sheet):
    """Positions, from 0, of the columns that a spreadsheet does not show."""
    with zipfile.ZipFile(io.BytesIO(data)) as book:
        if WORKBOOK in book.namelist():
            text = _sheet_of_xlsx(book, sheet) or b""
            pairs = [(int(a) - 1, int(b)) for a, b in HIDDEN_COLUMN.findall(text)]
            return {k for a, b in pairs for k in range(a, min(b, MOST_REPEATED))}
        text = book.read(ODS)
        is_any = b"table:visibility" in text
        return set(_hidden_columns_of_ods(text, sheet)) if is_any else set()


def _hidden_columns_of_ods(text, sheet):
    own, place = _table_of_ods(text, sheet), 0
    for one in own.iter() if own is not None else ():
        if _is(one, "table-column"):
            n_columns = int(_attribute(one, "number-columns-repeated") or 1)
            if _attribute(one, "visibility") in ("collapse", "filter"):
                yield from range(place, place + min(n_columns, MOST_REPEATED))
            place += n_columns


def _hidden_of_ods(text, sheet):
    for row, one in _rows_of_ods(text, sheet):
        if _attribute(one, "visibility") in ("collapse", "filter"):
            n_rows = int(_attribute(one, "number-rows-repeated") or 1)
            yield from range(row, row + min(n_rows, MOST_REPEATED))


def _rows_of_ods(text, sheet):
    """Rows of a sheet, with the number of the first that each stands for."""
    own, row = _table_of_ods(text, sheet), 1
    for one in own.iter() if own is not None else ():
        if _is(one, "table-row"):
            yield row, one
            row += int(_attribute(one, "number-rows-repeated") or 1)


def _table_of_ods(text, sheet):
    """The sheet of a name, or None; a ValueError where it is damaged."""
    try:
        tables = ET.fromstring(text).findall(".//{*}table")
    except ET.ParseError as error:
        raise ValueError from error
    return next((t for t in tables if _attribute(t, "name") == sheet), None)


def _sheet_of_xlsx(book, sheet):
    """Text of the part that holds a sheet; None where the workbook does not tell."""
    try:
        sheets = ET.fromstring(book.read(WORKBOOK)).findall(".//{*}sheet")
        related = ET.fromstring(book.read(RELATIONS)).findall(".//{*}Relationship")
    except (ET.ParseError, KeyError):
        return None
    targets = {one.get("Id"): one.get("Target", "") for one in related}
    for one in sheets:
        if one.get("name") == sheet:
            own = next((v for k, v in one.attrib.items() if k.endswith("}id")), "")
            place = posixpath.join("/xl", targets.get(own, "")).lstrip("/")
            return book.read(place) if place in book.namelist() else None
    return None


def _of_xlsx(text, book, columns):
    styles = book.read(STYLES) if STYLES in book.namelist() else b""
    of_styles, codes = formats_of_styles(styles)
    places = {_letters(column).encode(): column for column in columns}
    pattern = re.compile(CELLS % b"|".join(places))
    found, known = {}, {}
    for letters, row, attributes, value in pattern.findall(text) if places else ():
        if attributes not in known:  # a few, of all cells
            known[attributes] = _format_of(attributes, of_styles, codes)
        kind, code = known[attributes]
        is_short = len(value) <= FEW_DIGITS and b"E" not in value
        if kind in OF_TEXT or (kind == "n" and code in PLAIN and is_short):
            continue
        what = _what(kind, code, value.decode("ascii", errors="replace"))
        if what is not None:
            found[int(row), places[letters]] = NoText(what, code)
    return found


def _format_of(attributes, of_styles, codes):
    """Kind of a cell, and the code of its format."""
    kind, style = KIND.search(attributes), STYLE.search(attributes)
    number = of_styles.get(int(style[1]) if style else 0, 0)
    # what is left are sums of money
    code = codes.get(number, BUILT_IN.get(number, f"[{number}]"))
    return kind[1].decode() if kind else "n", code


def _letters(column):
    """Letters of a column by its position.

    >>> _letters(0), _letters(25), _letters(26)
    ('A', 'Z', 'AA')
    """
    letters, rest = "", column + 1
    while rest:
        rest, place = divmod(rest - 1, 26)
        letters = chr(ord("A") + place) + letters
    return letters


def _what(kind, code, value):
    return {"b": TRUTH, "d": DATE}.get(kind) or what_it_is(code, value)


def what_it_is(code, value):
    """Kind of a number that may not look as it is read; None of one that does.

    >>> what_it_is("0.00E+00", "100000"), what_it_is("dd. mmm", "45146")
    ('power', 'date')
    >>> what_it_is("0.00", "1.1"), what_it_is("0.0", "1.1"), what_it_is("General", "7")
    ('look', None, None)
    """
    is_long = is_number(value) and abs(float(value)) >= MOST_DIGITS
    if code in PLAIN:
        return DIGITS if is_long else None
    plain = NO_LETTERS.sub("", code.partition(";")[0])
    if OF_A_DATE.search(plain):
        return DATE
    if OF_A_POWER.search(plain):
        return POWER
    if is_long:
        return DIGITS
    return None if is_number(value) and _looks_plain(code, float(value)) else LOOK


def _looks_plain(code, value):
    """Whether a format shows a number with the digits that it has, and no others."""
    shown = DECIMALS.fullmatch(code)
    if shown is None or (shown[1] and abs(value) >= A_THOUSAND):
        return False
    text = f"{value:.{len(shown[2] or '')}f}"
    return text == (str(int(value)) if value == int(value) else repr(value))


def _of_ods(text, sheet, columns):
    """As of .xlsx; a cell of .ods tells what it shows."""
    found = {}
    for row, one in _rows_of_ods(text, sheet):
        for column, cell in _cells(one, columns):
            what = _what_of_ods(cell)
            if what is not None:
                found[row, column] = what
    return found


def _cells(row, columns):
    """Cells of a row in some columns, with these."""
    place = 0
    for cell in row:
        if not (_is(cell, "table-cell") or _is(cell, "covered-table-cell")):
            continue
        end = place + int(_attribute(cell, "number-columns-repeated") or 1)
        yield from ((k, cell) for k in columns if place <= k < end)
        place = end


def _what_of_ods(cell):
    kind = _attribute(cell, "value-type")
    shown = "\n".join("".join(p.itertext()) for p in cell if _is(p, "p"))
    if kind in ("date", "time"):
        return NoText(DATE, shown)
    if kind == "boolean":
        return NoText(TRUTH, shown)
    if kind not in ("float", "percentage", "currency"):
        return None
    value = _attribute(cell, "value") or ""
    if what := what_it_is(GENERAL, value):
        return NoText(what, shown)
    if not shown or not is_number(value) or shown.replace(",", ".") in _texts(value):
        return None
    is_power = is_number(shown.replace(",", ".")) and "e" in shown.casefold()
    return NoText(POWER if is_power else LOOK, shown)


def _texts(value):
    number = float(value)
    return {value, repr(number), str(int(number)) if number == int(number) else ""}


def _is(element, name):
    return element.tag.endswith("}" + name)


def _attribute(element, name):
    found = (v for k, v in element.attrib.items() if k.endswith("}" + name))
    return next(found, None)
