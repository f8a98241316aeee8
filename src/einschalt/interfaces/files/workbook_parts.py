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
FORMULA_CELL = (
    rb"<c(\s[^<>]*)?>\s*<f\b[^<>]*(?:/>|>[^<]*</f>)\s*(?:<v\s*/>|<v>\s*%s</v>)?\s*</c>"
)
EMPTY_CELL, ZERO_CELL = (re.compile(FORMULA_CELL % v) for v in (b"", b"0?\\s*"))
# a spreadsheet that has computed all of it takes this away when it saves
TO_BE_COMPUTED = re.compile(rb"""<calcPr[^<>]*\sfullCalcOnLoad=["'](?:1|true)""")
KIND_OF_CELL = re.compile(rb"""\st\s*=\s*("[^"]*"|'[^']*')""")
ATTRIBUTES = rb"""((?:\s+[\w:.-]+\s*=\s*(?:"[^"]*"|'[^']*'))*)"""
EMPTY_CELL_OF_ODS = re.compile(
    rb"<table:table-cell" + ATTRIBUTES + rb"\s*(?:/>|>\s*</table:table-cell>)"
)
FORMULA_OF_ODS, VALUE_OF_ODS = b"table:formula", b"office:value-type"
STYLES = "xl/styles.xml"
FORMAT, FORMAT_OF_CELLS = (
    re.compile(rb"<numFmt\s[^<>]{0,2000}>"),
    re.compile(rb"<xf\b[^<>]{0,2000}>"),
)
FORMAT_NUMBER = re.compile(rb"""\snumFmtId=["'](\d+)""")
FORMAT_CODE = re.compile(rb"""\sformatCode\s*=\s*("[^"<>]*"|'[^'<>]*')""")
HIDDEN = ("hidden", "veryHidden")
ODS = "content.xml"
TABLE_OF_ODS = re.compile(rb"<table:table(\s[^<>]*)>")
NOT_SHOWN = re.compile(rb"""\stable:display\s*=\s*["']false""")


def is_to_be_computed(text):
    """Whether a program asks the spreadsheet to compute what it has written.

    ``text``: the part of an .xlsx that lists its sheets. Such programs write 0 where
    they do not know what a formula gives.
    """
    return TO_BE_COMPUTED.search(text) is not None


def with_marks(text, *, has_zeros=False):
    """A part of a workbook, NO_VALUE in each cell whose formula has no value.

    A text of no letters is a value: ``t="str"`` tells of it. ``has_zeros``: 0 is none.
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

    pattern = ZERO_CELL if has_zeros else EMPTY_CELL
    text = pattern.sub(marked, text) if b"<f" in text else text
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


def formats_of_styles(styles):
    """Number of the format of each style of an .xlsx, and codes of formats by numbers.

    ``styles``: the part that lists them; formats that every spreadsheet has are not
    there.
    """
    numbers, codes = (
        [pattern.search(one) for one in FORMAT.findall(styles)]
        for pattern in (FORMAT_NUMBER, FORMAT_CODE)
    )
    formats = {
        int(number[1]): html.unescape(code[1][1:-1].decode("utf-8", errors="replace"))
        for number, code in zip(numbers, codes, strict=True)
        if number and code
    }
    _, _, of_cells = styles.partition(b"<cellXfs")
    of_cells, _, _ = of_cells.partition(b"</cellXfs>")
    used = [FORMAT_NUMBER.search(one) for one in FORMAT_OF_CELLS.findall(of_cells)]
    return {k: int(n[1]) for k, n in enumerate(used) if n}, formats


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
