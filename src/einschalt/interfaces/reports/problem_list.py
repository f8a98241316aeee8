"""Everything that is wrong with a block's input: as lines, and as a table."""

from rich.console import Group
from rich.table import Table
from rich.text import Text

from einschalt.foundations.display_names import printable
from einschalt.foundations.typesetting import MISSING, count

COLUMNS = ("file", "row", "id", "found", "expected", "remedy")


def problem_lines(found) -> list[str]:
    """One whole message a line, after what it is: nothing is cut, for searching."""
    return [
        f"{kind}: {_one_line(message)}"
        for kind, messages in (
            ("problem", found.problems),
            ("model", found.model_problems),
            ("note", found.notes),
        )
        for message in messages
    ]


def problem_tables(found) -> Group:
    """Tables for a terminal; long texts are folded, not cut."""
    tables = [
        _table(title, problems)
        for title, problems in (
            ("Problems", found.problems),
            ("Models that cannot be used", found.model_problems),
        )
        if problems
    ]
    notes = [Text(f"note: {_one_line(note)}") for note in found.notes]
    return Group(*tables, *notes)


def conclusion(found) -> str:
    """Say how much is wrong."""
    n_problems, n_models = len(found.problems), len(found.model_problems)
    said = [count(n_problems, "problem")] if n_problems else []
    if n_models:
        said.append(f"{count(n_models, 'model')} that cannot be used")
    return ", ".join(said) or "nothing wrong"


def _table(title, problems):
    table = Table(title=title, title_justify="left", show_lines=True)
    for name in COLUMNS:
        table.add_column(name, overflow="fold")
    for problem in problems:
        # Text, since a name may look like markup
        table.add_row(*map(Text, _cells(problem)))
    return table


def _cells(problem):
    ids = [
        f"{kind} {_one_line(name)}"
        for kind, name in (("point", problem.point), ("model", problem.model))
        if name is not None
    ]
    row = MISSING if problem.row is None else f"{problem.row:d}"
    texts = (problem.found, problem.expected or "", problem.remedy or "")
    file = _one_line(problem.file or MISSING)
    return [file, row, "\n".join(ids) or MISSING, *map(_one_line, texts)]


def _one_line(message):
    return printable(" ".join(str(message).split("\n")))
