"""What a spreadsheet keeps to itself: formulas that were never computed, hidden sheets.

Programs that write workbooks leave the values of formulas to the spreadsheet. Until it
has saved them, such a cell is empty for everybody who does not compute.
"""

import html
import io
import re
import xml.etree.ElementTree as ET
import zipfile

# stands in the place of a value; no program writes this letter of nobody's
NO_VALUE = "\ue000formula"
EMPTY_CELL = re.compile(
    rb"<c(\s[^<>]*)?>\s*<f\b[^<>]*(?:/>|>[^<]*</f>)\s*(?:<v\s*/>|<v>\s*</v>)?\s*</c>"
)
KIND_OF_CELL = re.compile(rb"""\st\s*=\s*("[^"]*"|'[^']*')""")
ATTRIBUTES = rb"""((?:\s+[\w:.-]+\s*=\s*(?:"[^"]*"|'[^']*'))*)"""
EMPTY_CELL_OF_ODS = re.compile(
    rb"<table:table-cell" + ATTRIBUTES + rb"\s*(?:/>|>\s*</table:table-cell>)"
)
FORMULA_OF_ODS, VALUE_OF_ODS = b"table:formula", b"office:value-type"
STYLES, SHEETS = "xl/styles.xml", "xl/worksheets/"
FORMAT, FORMAT_OF_CELLS = (
    re.compile(rb"<numFmt\s[^<>]{0,2000}>"),
    re.compile(rb"<xf\b[^<>]{0,2000}>"),
)
FORMAT_NUMBER = re.compile(rb"""\snumFmtId=["'](\d+)""")
FORMAT_CODE = re.compile(rb"""\sformatCode\s*=\s*("[^"<>]*"|'[^'<>]*')""")
NUMBER_CELL = re.compile(rb"<c(\s[^<>]*)>\s*(?:<f\b[^<>]*(?:/>|>[^<]*</f>)\s*)?<v>")
STYLE_OF_CELL = re.compile(rb"""\ss=["'](\d+)""")
AS_NAME = re.compile(r"""^0{2,}(?![0.,E])|0(?:\\?[-/]|"[-/]")[0#?]""")
HIDDEN = ("hidden", "veryHidden")
ODS = "content.xml"
TABLE_OF_ODS = re.compile(rb"<table:table(\s[^<>]*)>")
NOT_SHOWN = re.compile(rb"""\stable:display\s*=\s*["']false""")


def with_marks(text):
    """A part of a workbook, NO_VALUE in each cell whose formula has no value.

    A text of no letters is a value: ``t="str"`` tells of it.
    """
    mark = NO_VALUE.encode()

    def marked(cell):
        attributes = cell[1] or b""
        kind = KIND_OF_CELL.search(attributes)
        if kind is not None and kind[1][1:-1] == b"str":
            return cell[0]
        rest = KIND_OF_CELL.sub(b"", attributes)
        return b'<c%s t="inlineStr"><is><t>%s</t></is></c>' % (rest, mark)

    def marked_of_ods(cell):
        attributes = cell[1]
        if FORMULA_OF_ODS not in attributes or VALUE_OF_ODS in attributes:
            return cell[0]
        return (
            b'<table:table-cell%s office:value-type="string"><text:p>%s</text:p>'
            b"</table:table-cell>" % (attributes, mark)
        )

    text = EMPTY_CELL.sub(marked, text) if b"<f" in text else text
    return (
        EMPTY_CELL_OF_ODS.sub(marked_of_ods, text) if FORMULA_OF_ODS in text else text
    )


def hidden_sheets(data):
    """Names of the sheets that a spreadsheet does not show, of a sound copy.

    A ValueError where it is damaged.
    """
    with zipfile.ZipFile(io.BytesIO(data)) as book:
        names = book.namelist()
        if "xl/workbook.xml" in names:
            return _hidden_of_xlsx(book.read("xl/workbook.xml"))
        return _hidden_of_ods(book.read("content.xml")) if ODS in names else set()


def formats_of_names(data):
    """Number formats by which cells of an .xlsx look like names, of a sound copy.

    Zeros in front or signs between digits, which no number has: a cell shows 0012 or
    1-12, and holds 12 or 112.
    """
    with zipfile.ZipFile(io.BytesIO(data)) as book:
        if STYLES not in book.namelist():
            return []
        styles = book.read(STYLES)
        numbers, codes = (
            [pattern.search(one) for one in FORMAT.findall(styles)]
            for pattern in (FORMAT_NUMBER, FORMAT_CODE)
        )
        formats = {
            number[1]: html.unescape(code[1][1:-1].decode("utf-8", errors="replace"))
            for number, code in zip(numbers, codes, strict=True)
            if number and code
        }
        formats = {k: code for k, code in formats.items() if AS_NAME.search(code)}
        _, _, of_cells = styles.partition(b"<cellXfs")
        of_cells, _, _ = of_cells.partition(b"</cellXfs>")
        used = [FORMAT_NUMBER.search(one) for one in FORMAT_OF_CELLS.findall(of_cells)]
        places = {
            b"%d" % k: formats[number[1]]
            for k, number in enumerate(used)
            if number and number[1] in formats
        }
        sheets = [name for name in book.namelist() if name.startswith(SHEETS)]
        found = {
            places[style[1]]
            for name in (sheets if places else [])
            for cell in NUMBER_CELL.findall(book.read(name))
            if (style := STYLE_OF_CELL.search(cell)) and style[1] in places
            if (kind := KIND_OF_CELL.search(cell)) is None or kind[1][1:-1] == b"n"
        }
    return sorted(found)


def count_cells_of_ods(data):
    """Cells that a sound copy of an .ods has, those that are repeated once."""
    with zipfile.ZipFile(io.BytesIO(data)) as book:
        return book.read(ODS).count(b"<table:table-cell")


def _hidden_of_xlsx(text):
    try:
        sheets = ET.fromstring(text).findall(".//{*}sheet")
    except ET.ParseError as error:
        raise ValueError from error
    return {sheet.get("name") for sheet in sheets if sheet.get("state") in HIDDEN}


def _hidden_of_ods(text):
    """Names of the tables whose style is not displayed."""
    styles = [one for one in text.split(b"<style:style")[1:] if NOT_SHOWN.search(one)]
    hidden = {_attribute(b"style:name", style) for style in styles}
    tables = [table[1] for table in TABLE_OF_ODS.finditer(text)] if hidden else []
    return {
        _attribute(b"table:name", table)
        for table in tables
        if _attribute(b"table:style-name", table) in hidden
    }


def _attribute(name, text):
    found = re.search(rb"\s%s\s*=\s*[\"']([^\"']*)" % name, text)
    return found and html.unescape(found[1].decode("utf-8", errors="replace"))
