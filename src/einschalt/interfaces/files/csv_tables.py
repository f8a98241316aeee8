"""CSV tables: what people look at and edit.

Read: the encoding that the bytes tell, any line ends, columns parted by commas,
semicolons, tabs or blanks as the header has them, decimal points, or decimal commas
where no comma parts the columns; lines that begin with # are comments. A sound file is
read by pyarrow in one sweep. Only where that fails, the file is read again row by row,
so that the message can quote what stands there, and where.

Written: UTF-8, commas, Unix line ends; a missing number is an empty field. Equal
tables give equal bytes. A text that a spreadsheet would compute as a formula gets an
apostrophe before it, which reading takes away again: names come back as they went
(docs/files.md).
"""

import csv
import io
import re
from dataclasses import replace
from pathlib import Path

import pandas as pd
import pyarrow as pa
import pyarrow.compute as pc
from pyarrow import csv as arrow_csv

from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import (
    TableError,
    name_some,
    raise_problems,
)
from einschalt.foundations.tables import LINE, check_table, listed
from einschalt.interfaces.files.arrow_columns import table_as_arrow
from einschalt.interfaces.files.atomic import replacing
from einschalt.interfaces.files.csv_headers import COMMENT, RULE, read_header
from einschalt.interfaces.files.csv_parts import (
    count_byte,
    read_fast,
    start_of_line,
)
from einschalt.interfaces.files.cut_files import require_whole_end
from einschalt.interfaces.files.rows_of_no_data import counts
from einschalt.interfaces.files.text_encodings import read_table_text
from einschalt.interfaces.files.understood_tables import (
    COMMA,
    NOTHING_SAID,
    ReadTable,
    meant_header,
    understood,
)

# a quotation mark that neither opens nor closes a cell: pyarrow guesses at it
QUOTE_IN_TEXT = re.compile(
    rb'[^,;|\t\r\n"]"[^,;|\t\r\n"]|""[^,;|\t\r\n"]|[^,;|\t\r\n"]""'
)
SPECIAL = '",\r\n'
AS_FORMULA = r'^="(.*)"$'
NEEDS_QUOTES = f"[{SPECIAL}]|^{COMMENT}"
SIGNS = "=+\\-@＝＋－＠"  # a formula starts with one, also in wide letters
FORMULA = f"^[\t\r]*[{SIGNS}]"
# a number, digits with letters (+12a), signs alone: nothing in them can be computed
NO_FORMULA = rf"^([+-]\d\w*|[+-](\d+\.?\d*|\.\d+)([eE][+-]?\d+)?|[{SIGNS}]+)$"
# where the list separator is a semicolon, what follows it is a cell of its own
INNER_FORMULA = f"(; *)('*[\t\r]*[{SIGNS}])"
INNER_MARKED = f"(; *)'('*[\t\r]*[{SIGNS}])"
MAY_BE_EITHER = f"^['\t\r{SIGNS}]"  # a formula, or what is marked as one
# an apostrophe of our own, or one that would be taken for it
MARKED = f"^'('*[\t\r{SIGNS}])"
# what needs neither quotes nor an apostrophe, as almost every text
PLAIN = f"^([^\t'{SIGNS}{COMMENT}{SPECIAL};][^{SPECIAL};]*)?$"
END_OF_DOS = b"\x1a"  # Ctrl-Z, with which old programs end a text
LONGEST_VALUE = 131_072  # characters, the limit of Python's module csv
LARGEST_FIXED = 1e15  # beyond it a float has no decimals to print


def read_csv(path, schema, *, source=None):
    """Read all columns of a CSV table; its index is the line, the header being line 1.

    Names are text, numbers float where all of them can be read, otherwise everything is
    text; ``check_table`` looks at the values. Several faults come together in a
    BlockError. 1 million rows of 5 columns take about 0.1 s.
    """
    return understand_csv(path, schema, source=source).frame


def understand_csv(path, schema, said=NOTHING_SAID, *, source=None) -> ReadTable:
    """Read a CSV table as :func:`read_csv` does, and say how it was understood.

    ``said``: what is known of it beside its name.
    """
    source = source or Path(path).name
    data, note = read_table_text(path, source)
    whole = data  # of which an end by Ctrl-Z tells that it is
    data = data.removesuffix(END_OF_DOS)
    data, header = read_header(data, schema, said, source)
    meant = meant_header(
        header.names, schema, said, source, header.row, usual=header.usual
    )
    header = replace(header, names=list(meant.names))
    frame, rows = None, None
    may_have_commas = header.separator != "," or b'"' in data
    # with decimal commas a point is a question, which a number no longer asks
    is_text = may_have_commas and said.decimal == COMMA
    if _is_plain(data, header):
        # then all as text, to be quoted
        for numbers in ([] if is_text else schema.number_names, []):
            frame = read_fast(data, header, schema, numbers) if frame is None else frame
    if frame is None:
        rows = _Rows(header, source)
        frame = rows.read(data)
    if b"'" in data or b'="' in data:
        frame = _without_marks(frame, schema)
    table = understood(frame, schema, said, meant, source)
    notes = [note, *table.notes]
    if rows is not None:
        rows.raise_problems(table.frame, schema)
        notes += rows.notes
    require_whole_end(whole, header, source)
    return replace(table, notes=tuple(note for note in notes if note))


def _without_marks(frame, schema):
    """Take away what keeps spreadsheets from computing a name: '0012 and ="0012"."""
    names = [name for name in schema.id_names if list(frame.columns).count(name) == 1]
    found = {}
    for name in names:
        texts = frame[name]
        if texts.str.startswith('="').any():  # of a sheet; our own have an apostrophe
            texts = texts.str.replace(AS_FORMULA, r"\1", regex=True)
        if texts.str.startswith("'").any():
            texts = texts.str.replace(MARKED, r"\1", regex=True)
        if texts.str.contains("'", regex=False).any():
            texts = texts.str.replace(INNER_MARKED, r"\1\2", regex=True)
        found[name] = texts
    return frame.assign(**found)


def _is_plain(data, header):
    """Whether pyarrow would not pass over anything that must be said."""
    # single bytes are found ten times as fast as pairs of them
    n_returns = b"\r" in data and count_byte(data, b"\r")
    return (
        len(set(header.names)) == len(header.names)
        and (not n_returns or n_returns == data.count(b"\r\n"))
        and not (b'"' in data and QUOTE_IN_TEXT.search(data))
        and not (b"#" in data and _has_comment(data, header))
        and not _has_titles(data, header)
    )


def _has_comment(data, header):
    return data.find(b"\n#", start_of_line(data, header.end + 1) - 1) >= 0


def _has_titles(data, header):
    """Whether a line below the names repeats one above them, as of a further page."""
    if header.title_of_a_page is None:
        return False
    lines = data[start_of_line(data, header.end + 1) :].decode("utf-8")
    return re.search(rf"(?m)^{header.title_of_a_page.pattern}", lines) is not None


class _Rows:
    """Rows of a text, everything as text, with the line on which each begins."""

    def __init__(self, header, source):
        self.header = header
        self.source = source
        self.rows = []
        self.lines = []
        self.problems = []
        self.ragged = []
        self.comments = []
        self.rules = []
        self.titles = []  # of further pages
        self.total = None  # a last line that counts the rows
        self.is_open = False  # whether a row goes on, since a quote is open

    def read(self, data):
        """Read all rows after the header, and keep what is wrong."""
        reader = csv.reader(
            self._lines(data), delimiter=self.header.separator, strict=True
        )
        line = 1
        try:
            for row in reader:
                self.is_open = False
                if line > self.header.end and any(value.strip() for value in row):
                    self._keep(row, line, reader.line_num)
                line = reader.line_num + 1
        except csv.Error as error:
            self.problems.append(self._quote_problem(line, reader.line_num, error))
        self._leave_out_count()
        rest = "the number of values is not that of the header"
        self.problems[:0] = listed(self.ragged, self._ragged_problem, rest)
        index = pd.Index(self.lines, name=LINE)
        return pd.DataFrame(self.rows, columns=self.header.names, index=index)

    def _leave_out_count(self):
        """Leave out a last line of one value that counts the rows above it."""
        if not self.ragged or (self.lines and self.ragged[-1][1] < self.lines[-1]):
            return
        texts = [value.strip() for value in self.ragged[-1][0] if value.strip()]
        if len(texts) == 1 and counts(texts[0], len(self.rows)):
            self.ragged.pop()
            self.total = texts[0]

    def _lines(self, data):
        """Lines of a text, comments as empty ones."""
        text = io.StringIO(data.decode("utf-8"), newline="")
        for row, line in enumerate(text, 1):
            if row <= self.header.end:
                yield "\n"  # titles may have quotes that nobody closes
                continue
            is_comment = line.startswith(COMMENT) and not self.is_open
            is_rule = not self.is_open and RULE.fullmatch(line) is not None
            is_title = not self.is_open and self._is_title(line)
            self.is_open = True
            if is_comment:
                self.comments.append(row)
            if is_rule:
                self.rules.append(row)
            if is_title:
                self.titles.append(row)
            yield "\n" if is_comment or is_rule or is_title else line

    def _is_title(self, line):
        title = self.header.title_of_a_page
        return title is not None and title.match(line) is not None

    @property
    def notes(self):
        """Say which rows were passed over, in notes."""
        notes = []
        if self.comments:
            rows = name_some(self.comments)
            notes.append(f"{self.source}: rows that begin with # are comments: {rows}")
        if self.rules:
            rows = name_some(self.rules)
            notes.append(f"{self.source}: rows of dashes left out: {rows}")
        if self.titles:
            rows = name_some(self.titles)
            notes.append(f"{self.source}: rows repeating the title left out: {rows}")
        if self.total is not None:
            said = shortened(self.total)
            notes.append(f"{self.source}: the last row, {said!r}, left out")
        return notes

    def raise_problems(self, frame, schema):
        """Raise what is wrong with rows, and with the values of the others."""
        if self.problems:
            values = check_table(frame, schema, source=self.source).problems
            problems = [*self.problems, *(values if self.rows else ())]
            last = self.lines[-1] + 1 if self.lines else 0
            raise_problems(sorted(problems, key=lambda one: one.row or last))

    def _keep(self, row, line, last_line):
        n_columns = len(self.header.names)
        if len(row) > n_columns and not any(row[n_columns:]):
            row = row[:n_columns]  # some programs end each line with a separator
        if len(row) == len(self.header.names):
            self.rows.append(row)
            self.lines.append(line)
        else:
            self.ragged.append((row, line, last_line))

    def _ragged_problem(self, ragged):
        row, line, last_line = ragged
        if last_line > line:
            return self._quote_problem(line, last_line)
        n_values, n_columns = len(row), len(self.header.names)
        remedy = (
            "Part the values as the header does, and leave none out; delete the row "
            "if it is a remark"
        )
        if self.header.is_by_blanks and n_values > n_columns:
            remedy = "Write names without blanks, or part the columns by tabs"
        elif self.header.is_by_blanks:
            remedy = (
                "Part the values by semicolons, which show an empty one; delete the "
                "row if it is a remark"
            )
        elif n_values > n_columns:
            remedy = f"Put a value that holds {self._name} itself into quotes"
            if self.header.separator == ",":
                remedy = "Write decimal points, not commas, and quote texts with commas"
        if sum(map(bool, row)) == 1 < n_columns - 1:
            # of such a row nothing tells whether its values are lost
            remedy = (
                f"{remedy}; if it is the title of another table, put what follows into "
                "a file of its own"
            )
        return TableError(
            f"the row has {n_values} values, the header {n_columns}",
            expected=f"{n_columns} values separated by {self._name}",
            remedy=remedy,
            file=self.source,
            row=line,
        )

    @property
    def _name(self):
        return self.header.shown_separator

    def _quote_problem(self, line, last_line, error=None):
        if "field larger" in str(error):
            return TableError(
                f"a value has more than {LONGEST_VALUE} characters",
                expected=f"values separated by {self._name}",
                remedy="Look for a quote that opens and is not closed, or shorten it",
                file=self.source,
                row=line,
            )
        if last_line > line or "end of data" in str(error):
            return TableError(
                "a quote opens here and is not closed on its line",
                expected="quotes in pairs",
                remedy="Close it, or delete it",
                file=self.source,
                row=line,
            )
        return TableError(
            "a closing quote is followed by more text",
            expected=f"quotes around whole values, separated by {self._name}",
            remedy="Delete the quotes, or double the one inside the value",
            file=self.source,
            row=line,
        )


def write_csv(frame, path, *, decimals=None):
    """Write a table without its index as CSV, whole or not at all.

    Of pandas or of ``table_as_arrow``. ``decimals`` has, by column, how many are kept;
    every other number is written with as many digits as bring it back unchanged.
    """
    given = table_as_arrow(frame)
    names = given.column_names
    columns = [
        _as_written(column, (decimals or {}).get(name))
        for name, column in zip(names, given.columns, strict=True)
    ]
    with replacing(path) as hidden, hidden.open("wb") as file:
        file.write(
            ",".join(_quoted(pa.array(names, pa.string())).to_pylist()).encode("utf-8")
        )
        file.write(b"\n")
        if any(_has_special(column) for column in columns):
            file.write(_joined(columns))
        elif columns:
            table = pa.table(columns, names=names)
            options = arrow_csv.WriteOptions(include_header=False, quoting_style="none")
            arrow_csv.write_csv(table, file, options)


def _as_written(column, decimals):
    (values,) = column.chunks
    if _is_text(values):
        return _harmless(values)
    if decimals is None or not pa.types.is_floating(values.type):
        return values
    largest = pc.max(pc.abs(values)).as_py()
    if largest is not None and not largest < LARGEST_FIXED:
        return values
    return values.cast(pa.decimal128(38, decimals))


def _harmless(texts):
    """Put an apostrophe before what a spreadsheet would compute."""
    if _are_plain(texts):
        return texts
    if pc.any(pc.match_substring(texts, ";")).as_py():
        texts = pc.replace_substring_regex(texts, INNER_FORMULA, r"\1'\2")
    if not pc.any(pc.match_substring_regex(texts, MAY_BE_EITHER)).as_py():
        return texts
    is_marked, is_formula, is_harmless = (
        pc.match_substring_regex(texts, pattern)
        for pattern in (MARKED, FORMULA, NO_FORMULA)
    )
    needs_mark = pc.or_(is_marked, pc.and_not(is_formula, is_harmless))
    if not pc.any(needs_mark).as_py():
        return texts
    apostrophe, nothing = (pa.scalar(sign, texts.type) for sign in ("'", ""))
    marked = pc.binary_join_element_wise(apostrophe, texts, nothing)
    return pc.if_else(needs_mark, marked, texts)


def _is_text(values):
    return pa.types.is_string(values.type) or pa.types.is_large_string(values.type)


def _are_plain(texts):
    return pc.all(pc.match_substring_regex(texts, PLAIN), min_count=0).as_py()


def _has_special(values):
    if not _is_text(values) or _are_plain(values):
        return False
    found = (pc.any(pc.match_substring(values, sign)).as_py() for sign in SPECIAL)
    return any(found) or pc.any(pc.starts_with(values, COMMENT)).as_py()


def _quoted(texts):
    """Put the texts into quotes that would not come back without."""
    is_special = pc.match_substring_regex(texts, NEEDS_QUOTES)
    doubled = pc.replace_substring(texts, '"', '""')
    quote, nothing = (pa.scalar(sign, texts.type) for sign in ('"', ""))
    quoted = pc.binary_join_element_wise(quote, doubled, quote, nothing)
    return pc.if_else(is_special, quoted, texts)


def _joined(columns):
    """Join columns to the bytes of all lines; slower, but only for special texts."""
    kind = pa.large_string()
    texts = [
        _quoted(values.cast(kind)) if _is_text(values) else values.cast(kind)
        for values in columns
    ]
    lines = pc.binary_join_element_wise(
        *texts, pa.scalar(",", kind), null_handling="replace", null_replacement=""
    )
    return "".join(f"{line}\n" for line in lines.to_pylist()).encode("utf-8")
