"""Everything that is wrong with a block's input: as lines, and as a table."""

from rich.console import Group
from rich.table import Table
from rich.text import Text

from einschalt.foundations.display_names import printable
from einschalt.foundations.kept_texts import place_text, retold
from einschalt.foundations.language import translated
from einschalt.foundations.told_errors import told
from einschalt.foundations.typesetting import MISSING


def problem_lines(found) -> list[str]:
    """One whole message a line, after what it is: nothing is cut, for searching.

    What it is stays English: other programs look for these words.
    """
    return [
        f"{kind}: {_one_line(tell(message))}"
        for kind, messages, tell in (
            ("problem", found.problems, told),
            ("model", found.model_problems, told),
            ("note", found.notes, retold),
        )
        for message in messages
    ]


def problem_tables(found) -> Group:
    """Tables for a terminal; long texts are folded, not cut."""
    tables = [
        _table(title, problems)
        for title, problems in (
            (translated("Problems"), found.problems),
            (translated("Models that cannot be used"), found.model_problems),
        )
        if problems
    ]
    notes = [
        Text(translated("note: {note}", note=_one_line(retold(note))))
        for note in found.notes
    ]
    return Group(*tables, *notes)


def conclusion(found) -> str:
    """Say how much is wrong."""
    n_problems, n_models = len(found.problems), len(found.model_problems)
    parts = []
    if n_problems:
        parts.append(translated("{n:problem|problems}", n=n_problems))
    if n_models:
        parts.append(translated("{n:model|models} that cannot be used", n=n_models))
    return ", ".join(parts) or translated("nothing wrong")


def _table(title, problems):
    table = Table(title=title, title_justify="left", show_lines=True)
    for name in (
        *(translated("file"), translated("row"), "id", translated("found")),
        *(translated("expected"), translated("remedy")),
    ):
        table.add_column(name, overflow="fold")
    for problem in problems:
        # Text, since a name may look like markup
        table.add_row(*map(Text, _cells(problem)))
    return table


def _cells(problem):
    ids = [
        place_text(kind, _one_line(name))
        for kind, name in (("point", problem.point), ("model", problem.model))
        if name is not None
    ]
    row = MISSING if problem.row is None else f"{problem.row:d}"
    texts = map(retold, (problem.found, problem.expected or "", problem.remedy or ""))
    file = _one_line(problem.file or MISSING)
    return [file, row, "\n".join(ids) or MISSING, *map(_one_line, texts)]


def _one_line(message):
    return printable(" ".join(str(message).split("\n")))
