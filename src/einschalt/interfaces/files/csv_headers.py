"""The line of a CSV table that names its columns.

Blank lines, comments and titles may stand before it, and it may be a comment itself, as
some programs write it. A list of points may have none.
"""

import csv
import io
import re
from dataclasses import dataclass, field, replace
from functools import cached_property

from einschalt.foundations.decimal_commas import is_measure
from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import FileError, TableError, name_some
from einschalt.foundations.header_units import is_unit
from einschalt.interfaces.files.header_rows import (
    HEAD_ROWS,
    is_list_of_points,
    is_long_list,
    place_of_header,
    places_of_marks,
    usual_places,
    with_units,
)
from einschalt.interfaces.files.input_files import HEAD_BYTES
from einschalt.interfaces.files.understood_tables import is_header, is_whole_header

SEPARATORS = {",": "commas", ";": "semicolons", "\t": "tabs", "|": "bars"}
COMMENT = "#"
HEAD_COMMENTS = (COMMENT, "%", "//", "!")  # the others before the names only
SEPARATOR_LINE = re.compile(r'"?sep=([,;\t|])"?\s*', re.IGNORECASE)  # of Excel
BEFORE_NAMES = re.compile(r"^\s*(format|columns|spalten)\s*:", re.IGNORECASE)
BLANK = " "
BLANKS = re.compile(rb"[ \t]+")
WIDE_BLANKS = re.compile(r"\s*\t\s*|\s{2,}")  # between columns whose cells have blanks
# a line below the names, or between parts, of a list that was printed
RULE = re.compile(r"[\s|+;,]*[-=_*~\u2500-\u257f]{3,}[-=_*~\u2500-\u257f|+;,\s]*")
HAS_WORD = re.compile(r"[^\W\d_]{3}")  # no line of numbers is a title
MOST_COLUMNS = 1000
FEWEST_VALUES = 2  # of a line that has values in place of names


@dataclass(frozen=True)
class Header:
    """Names of the columns, and how they are parted."""

    names: list[str]
    separator: str
    row: int  # its line
    end: int  # the last line before the values
    # of a list without names: positions of what is no coordinate
    usual: dict | None = field(default=None)
    is_by_blanks: bool = False  # in the file; the separator is what replaced them
    titles: tuple[str, ...] = ()  # lines above the names, as pages may repeat them

    @cached_property
    def title_of_a_page(self):
        """What matches a line that repeats a title, whatever its numbers are."""
        if not self.titles:
            return None
        patterns = (r"\s+".join(map(_any_digits, one.split())) for one in self.titles)
        return re.compile(rf"[^\S\n]*(?:{'|'.join(patterns)})\s*$")

    @property
    def shown_separator(self):
        """What parts the columns in the file."""
        return "blanks" if self.is_by_blanks else SEPARATORS[self.separator]


def read_header(data, schema, said, source):
    """Find the line of the names; columns parted by blanks are parted by tabs then."""
    row, lines, comment, separator = _head(data)
    header = _known(lines, row, separator, schema, said)
    if header is None and comment is not None and lines:
        header = _in_comment(comment, lines[0], separator, row, (schema, said))
    header = header or _missing(lines, row, separator, (schema, said), source)
    header = header or _first(lines, row, separator, schema, source)
    if (
        any(header.names) and header.names.count("") > 1
    ):  # separators end the line, and name no column
        while header.names[-1] == "":
            header.names.pop()
    if header.separator != BLANK:
        return data, header
    blanks = BLANKS
    if _are_wide(header, lines[header.end + 1 - row :]):
        blanks = re.compile(WIDE_BLANKS.pattern.encode())
    data = b"\n".join(blanks.sub(b"\t", one.strip()) for one in data.splitlines())
    return data, replace(header, separator="\t", is_by_blanks=True)


def _any_digits(word):
    """Pattern of a word in which numbers may differ, as of pages and dates."""
    return re.sub(r"\d+", r"\\d+", re.escape(word))


def _are_wide(header, lines):
    """Whether only gaps of two blanks part lines into as many values as names."""
    title = header.title_of_a_page
    values = [
        one.strip()
        for one in lines
        if one.strip() and not RULE.fullmatch(one) and not (title and title.match(one))
    ]
    n_names = len(header.names)
    if not values or all(len(one.split()) == n_names for one in values):
        return False
    return all(len(WIDE_BLANKS.split(one)) == n_names for one in values)


def _head(data):
    """The first line that is no comment, and those below it.

    Its number, the lines, the comment before it (number, text), and the separator that
    a line of its own names.
    """
    text = io.StringIO(
        data[:HEAD_BYTES].decode("utf-8", errors="replace"), newline=None
    )
    first, lines, comment, separator = 0, [], None, None
    for row, line in enumerate(text, 1):
        named = SEPARATOR_LINE.fullmatch(line)
        sign = next((one for one in HEAD_COMMENTS if line.startswith(one)), None)
        if lines:
            lines.append(line)
        elif named:
            separator = named[1]
        elif sign is not None:
            comment = row, line.removeprefix(sign)
        elif line.strip():
            first, lines = row, [line]
        if len(lines) > HEAD_ROWS:
            break
    return first, lines, comment, separator


def _separator_of(line):
    # commas may be decimal: of two signs as frequent, the other one parts columns
    counts = {sign: line.count(sign) for sign in reversed(SEPARATORS)}
    return max(counts, key=counts.get) if any(counts.values()) else BLANK


def _separators_of(line):
    """Signs that may part the values of a line, the most frequent one first.

    Commas may be decimal, or separate thousands, and be the most frequent sign then.
    """
    first = _separator_of(line)
    others = [sign for sign in (";", "\t", "|", BLANK) if sign != first]
    return [first, *(sign for sign in others if sign in line.strip())]


def _parted(line, separator):
    if separator == BLANK:
        return _words(line)
    try:
        return [name.strip() for name in next(csv.reader([line], delimiter=separator))]
    except (csv.Error, StopIteration):
        return [""] * (MOST_COLUMNS + 1)


def _words(line):
    """Words of a line that blanks part, each with the unit in brackets behind it.

    >>> _words("No  y [m]  x (m)  (old)")
    ['No', 'y [m]', 'x (m)', '(old)']
    """
    words = []
    for word in line.split():
        is_bracketed = word[:1] + word[-1:] in ("[]", "()")
        if words and is_bracketed and is_unit(word[1:-1]):
            words[-1] += f" {word}"
        else:
            words.append(word)
    return words


def _known(lines, row, separator, schema, said):
    """Names of which all required columns are known; None where no line has them."""
    separators = [separator or _separator_of(line) for line in lines]
    rows = [_parted(*pair) for pair in zip(lines, separators, strict=True)]
    found = place_of_header(rows, schema, said)
    by_gaps = [
        WIDE_BLANKS.split(line.strip()) if sign == BLANK else cells
        for line, sign, cells in zip(lines, separators, rows, strict=True)
    ]
    if by_gaps != rows:
        found = _fitting(found, place_of_header(by_gaps, schema, said), lines)
    if found is None:
        return None
    place, names = found
    parted = separators[place]
    end = row + place
    units = (
        with_units(names, _parted(lines[place + 1], parted))
        if rows[place + 1 :]
        else None
    )
    titles = [one for one in lines[:place] if HAS_WORD.search(one)]
    if parted == BLANK and len(lines[place].split()) != len(names):
        titles.append(
            lines[place]
        )  # once more, it would be no row as long as the names
    return Header(
        units or names,
        parted,
        row + place,
        end + (units is not None),
        titles=tuple(titles),
    )


def _fitting(by_words, by_gaps, lines):
    """The header whose names are as many as the values below it, of two readings.

    One whose words are all names, and one whose names have blanks; each may be None.
    """
    if by_words is None or by_gaps is None:
        return by_words or by_gaps
    below = (one for one in lines[by_words[0] + 1 :] if not RULE.fullmatch(one))
    n_values = next((len(one.split()) for one in below if one.strip()), 0)
    return by_gaps if len(by_gaps[1]) == n_values else by_words


def _in_comment(comment, line, separator, row, meant):
    """Names in the last comment before the values; None where there are none.

    It may have names of more columns than there are, as DBAT's do where no errors
    follow; all that are needed must then stand before these. ``meant``: schema, and
    what the user says.
    """
    schema, said = meant
    text = BEFORE_NAMES.sub("", comment[1])
    for sign in [separator] if separator else _separators_of(line):
        names, above = _parted(line, sign), _parted(text, sign)
        if is_header(names, schema) or not is_header(above, schema):
            continue
        first = above[: len(names)]
        if len(above) == len(names) or (
            len(above) > len(names) and is_whole_header(first, schema, said)
        ):
            return Header(first, sign, comment[0], row - 1)
    return None


def _missing(lines, row, separator, meant, source):
    """Positions in place of names, where points are listed without them.

    A list of many columns needs an answer: three numbers behind a place may be standard
    errors, variances, weights or angles. ``meant``: schema, and what the user says.
    """
    schema, said = meant
    line = lines[0] if lines else ""
    for sign in [separator] if separator else _separators_of(line):
        cells = _parted(line, sign) if line else []
        places = places_of_marks(cells, schema)
        is_long = is_long_list(cells, schema)
        if is_long and not set(said.columns.values()) & set(_places(cells)):
            _refuse_long(cells, {"file": source, "row": row})
        if is_long or is_list_of_points(cells, schema):
            rows = [_parted(one, sign) for one in lines[:HEAD_ROWS]]
            places = usual_places(rows, schema)
        if places is not None:
            names = _places(cells)
            usual = {name: names[k] for name, k in places.items()}
            return Header(names, sign, row, row - 1, usual)
    return None


def _places(cells):
    return [f"column {k}" for k in range(1, len(cells) + 1)]


def _refuse_long(cells, where):
    behind = name_some([cell for cell in cells[4:] if cell], 3)
    raise TableError(
        f"the columns have no names, and of {len(cells)} nothing tells what the last "
        f"ones are: {behind}",
        expected="a line with the names, or a name, two coordinates, a height and a "
        "kind alone",
        remedy="Write a line with the names above the values, parted as they are, such "
        "as point_id easting northing height standard_error_easting "
        "standard_error_northing standard_error_height; other columns may have any "
        "name",
        **where,
    )


def _first(lines, row, separator, schema, source):
    """The first line as it stands; refused where it is no line of names."""
    line = lines[0] if lines else ""
    separator = separator or _separator_of(line)
    words = line.split()
    if separator == BLANK and not (len(words) > 1 and is_header(words, schema)):
        separator = ","
    names = _parted(line, separator) if line else [""]
    _refuse_header(names, line, separator, {"file": source, "row": row})
    return Header(names, separator, row, row)


def _refuse_header(names, line, separator, where):
    if len(names) > MOST_COLUMNS:
        # of a long line no more than its beginning is here
        is_many = line.count(separator) >= MOST_COLUMNS
        raise FileError(
            f"the header has more than {MOST_COLUMNS} columns"
            if is_many
            else "the header has a name that is longer than any line",
            expected=f"at most {MOST_COLUMNS}, each with a short name",
            remedy="Leave out the columns that are no part of the table",
            **where,
        )
    if len(names) == 1 and len(line.split()) > 1:
        found = f"the header is {shortened(line.strip(), 80)!r}"
        # a title may have one, such as a year
        if sum(map(is_measure, line.split()[1:])) >= FEWEST_VALUES:
            raise FileError(
                found,
                expected="names of columns, and no values",
                remedy="Write a line with the names of the columns above the values",
                **where,
            )
        raise FileError(
            found,
            expected="columns separated by commas, semicolons or tabs",
            remedy="Separate the columns by commas",
            **where,
        )
