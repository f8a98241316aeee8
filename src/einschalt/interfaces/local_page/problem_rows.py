"""Problems beside the rows that they mean, as they stand in the file."""

import csv
from dataclasses import dataclass
from itertools import islice

from einschalt.foundations.display_names import printable, shortened
from einschalt.foundations.told_errors import told
from einschalt.interfaces.local_page.pages import one_line
from einschalt.interfaces.local_page.refusals import RefusedError

TEXTS = (".csv", ".txt", ".tsv")
AROUND = 1  # rows before and after that are shown
MOST_SHOWN = 200  # problems
MOST_ROW = 2_000_000
MOST_CELLS = 24
WIDEST_CELL = 60


@dataclass(frozen=True)
class Row:
    """A row of a file, and what is wrong with it."""

    number: int
    cells: tuple[str, ...]
    bad_cells: frozenset = frozenset()
    problems: tuple[str, ...] = ()


@dataclass(frozen=True)
class FileProblems:
    """Problems of one file: with rows that are shown, and others."""

    name: str
    header: tuple[str, ...] = ()
    rows: tuple[Row, ...] = ()
    messages: tuple[str, ...] = ()  # of the whole file


def problems_by_file(problems, place):
    """Problems in the order of their files; of each its rows with their neighbours."""
    by_file = {}
    for problem in problems[:MOST_SHOWN]:
        by_file.setdefault(problem.file, []).append(problem)
    return [_of_file(name, some, place) for name, some in by_file.items()]


def _of_file(name, problems, place):
    with_rows = {}
    for problem in problems:
        if problem.row is not None:
            with_rows.setdefault(problem.row, []).append(problem)
    lines = _lines(place, name, with_rows) if name and with_rows else {}
    shown = {row: some for row, some in with_rows.items() if row in lines}
    rest = [p for p in problems if p.row not in shown]
    is_table = str(name).lower().endswith(TEXTS)
    delimiter = _delimiter(lines.get(1, "")) if is_table else None
    header = _cells(lines[1], delimiter) if shown and is_table else ()
    rows = [
        _row(number, lines[number], delimiter, header, shown.get(number, ()))
        for number in sorted(lines)
        if shown and not (is_table and number == 1 and 1 not in shown)
    ]
    # the file is the heading above them
    messages = tuple(_one_line(problem.with_facts(file=None)) for problem in rest)
    return FileProblems(printable(name or ""), header, tuple(rows), messages)


def _lines(place, name, rows):
    """Lines of a file by number: the first, and those around the rows."""
    try:
        path = place.root.find(f"{place.root.name(place.folder)}/{name}")
    except RefusedError:
        return {}
    if not name.lower().endswith((*TEXTS, ".toml")) or not path.is_file():
        return {}
    wanted = {n + k for n in rows for k in range(-AROUND, AROUND + 1)}
    wanted = {n for n in wanted if 0 < n <= MOST_ROW} | {1}
    with path.open(encoding="utf-8-sig", errors="replace", newline=None) as file:
        lines = enumerate(islice(file, max(wanted)), 1)
        return {n: line.rstrip("\n") for n, line in lines if n in wanted}


def _row(number, line, delimiter, header, problems):
    cells = _cells(line, delimiter)
    messages = tuple(_message_in_row(problem) for problem in problems)
    bad = frozenset(
        k
        for k, cell in enumerate(cells)
        for problem in problems
        if _is_meant(problem, cell, header[k] if k < len(header) else "")
    )
    return Row(number, cells, bad, messages)


def _is_meant(problem, cell, column):
    """Whether a message quotes a cell, or begins with its column or names its point."""
    is_quoted = bool(cell) and f"'{cell}'" in problem.found
    is_column = bool(column) and problem.found.startswith(f"{column} ")
    is_point = column == "point_id" and problem.found.startswith("no model")
    return is_quoted or is_column or is_point


def _message_in_row(problem):
    """The message without the file and the row, beside which it stands."""
    plain = problem.with_facts(file=None, row=None)
    return _one_line(plain)


def _one_line(problem):
    return one_line(told(problem))


def _delimiter(header):
    counts = {sign: header.count(sign) for sign in (",", ";", "\t")}
    return max(counts, key=counts.get)


def _cells(line, delimiter):
    if delimiter is None:
        return (shortened(line, 2 * WIDEST_CELL),)
    try:
        cells = next(csv.reader([line], delimiter=delimiter), [])
    except csv.Error:  # a cell beyond all measure, or a NUL
        cells = [line]
    return tuple(shortened(cell, WIDEST_CELL) for cell in cells[:MOST_CELLS])
