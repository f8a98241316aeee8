"""Errors that say where, what was found, what was expected, and how to mend it.

Every user error is an :class:`EinschaltError`. Its text is written once, here, from
facts that stay readable as attributes::

    low_flight.csv, row 214, point 1043, model 7/8: northing 'n/a' is not a number;
    expected metres. Give a value or delete the row.
"""

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Self

from einschalt.foundations.display_names import all_shortened, shortened

MOST_NAMED = 5
LONGEST_NAME = 60  # characters of a name in a message


# what programs are told of a fault
FACTS = ("found", "expected", "remedy", "file", "row", "point", "model")
# facts that are written as they are; a file may come as a path
NAMED = ("file", "point", "model")


class EinschaltError(Exception):
    """An error that the user can correct.

    Parameters
    ----------
    found : str
        What was found, with the offending value quoted.
    expected : str, optional
        What is allowed.
    remedy : str, optional
        How to mend it, one sentence.
    file, row, point, model : optional
        Where. ``row`` is the line of the file (the header is line 1).
    stage : str, optional
        The stage of the pipeline in which it came up.
    section, key : str, optional
        Where in block.toml: they are said in ``found``, and give the row.
    stands_for : int, optional
        How many faults it stands for, where they were counted and not listed.
    """

    def __init__(
        self,
        found: str,
        *,
        expected: str = "",
        remedy: str = "",
        file: object = None,
        row: int | None = None,
        point: object = None,
        model: object = None,
        stage: str | None = None,
        section: str | None = None,
        key: str | None = None,
        stands_for: int = 1,
    ) -> None:
        self.found = found
        self.expected = expected
        self.remedy = remedy
        self.file = None if file is None else str(file)
        self.row = None if row is None else int(row)
        self.point = None if point is None else str(point)
        self.model = None if model is None else str(model)
        self.stage = stage
        self.section = section
        self.key = key
        self.stands_for = stands_for
        super().__init__(self._text())

    @property
    def where(self) -> str:
        """File, row, point and model, as far as they are known."""
        parts = [
            self.file,
            None if self.row is None else f"row {self.row}",
            None if self.point is None else f"point {shortened_name(self.point)}",
            None if self.model is None else f"model {shortened_name(self.model)}",
        ]
        return ", ".join(part for part in parts if part)

    def _text(self):
        text = f"{self.where}: {self.found}" if self.where else self.found
        if self.expected:
            text += f"; expected {self.expected}"
        return " ".join(_sentence(part) for part in (text, self.remedy) if part)

    def with_facts(self, **facts: object) -> Self:
        """Return the same fault with more facts, such as the file."""
        said = {
            name: str(fact) if name in NAMED and fact is not None else fact
            for name, fact in facts.items()
        }
        return _rebuild(type(self), {**self.__dict__, **said})

    def __reduce__(self):
        """Keep the keyword facts when the error crosses a process border."""
        return _rebuild, (type(self), self.__dict__.copy())


def _sentence(text):
    return text if text.endswith("?") else text.rstrip(".") + "."


def _rebuild(kind, facts):
    error = kind.__new__(kind)
    error.__dict__.update(facts)
    Exception.__init__(error, error._text())
    return error


class FileError(EinschaltError):
    """A file is missing, unreadable, or not what its name says."""


class OutputError(FileError):
    """Writing would lose what is there already, or another run is writing there."""


class ChangedFileError(FileError):
    """A file changed while it was read; the next reading may find it sound."""


class TableError(EinschaltError):
    """A column or a value of a table is wrong."""


class SettingsError(EinschaltError):
    """A key or value of block.toml, of Settings or of an argument is wrong."""


class ConsistencyError(EinschaltError):
    """Tables that are each right do not fit each other."""


class GeometryError(EinschaltError):
    """Too few points, or points in a position that determines nothing."""


class ProjectionError(EinschaltError):
    """A coordinate reference system is unknown or cannot be reached."""


class BlockError(EinschaltError):
    """Several faults of one block's input, kept in ``problems``."""

    def __init__(self, problems: Sequence[EinschaltError]):
        self.problems = tuple(problems)
        super().__init__(_several(self.problems))

    def _text(self):
        return _several(self.problems)


def _several(problems):
    shown = spread(problems)
    total = sum(problem.stands_for for problem in problems)
    rest = total - sum(problem.stands_for for problem in shown)
    more = [f"and {rest} more"] if rest > 0 else []
    lines = [*(str(problem) for problem in shown), *more]
    return "\n".join([f"{total} problems:", *(f"  {line}" for line in lines)])


def facts_of(error: object) -> list[dict]:
    """Facts of a fault, or of each of several, for programs: what is not known is None.

    Any other error, or a text, is what was found.

    >>> (one,) = facts_of(TableError("easting 'n/a'", file="a.csv", row=7))
    >>> one["found"], one["file"], one["row"], one["remedy"]
    ("easting 'n/a'", 'a.csv', 7, None)
    """
    return [
        {name: getattr(one, name, None) or None for name in FACTS}
        | ({} if hasattr(one, "found") else {"found": str(one)})
        for one in getattr(error, "problems", (error,))
    ]


def spread(problems: Sequence[EinschaltError]) -> list[EinschaltError]:
    """At most five problems, so chosen that every file has its turn."""
    turns = Counter()
    ranked = []
    for place, problem in enumerate(problems):
        ranked.append((turns[problem.file], place))
        turns[problem.file] += 1
    chosen = sorted(place for _, place in sorted(ranked)[:MOST_NAMED])
    return [problems[place] for place in chosen]


def raise_problems(problems: Sequence[EinschaltError]):
    """Raise nothing, the one problem, or all of them as a BlockError.

    One that stands for many rows is many.
    """
    if len(problems) == 1 and problems[0].stands_for == 1:
        raise problems[0]
    if problems:
        raise BlockError(problems)


def name_some(names: Iterable[str], most: int = MOST_NAMED) -> str:
    """At most five names, then how many more there are.

    >>> name_some(["a", "b", "c"], most=2)
    'a, b and 1 more'
    """
    names = [str(name) for name in names]
    shown = ", ".join(all_shortened(names[:most], LONGEST_NAME))
    rest = len(names) - most
    return f"{shown} and {rest} more" if rest > 0 else shown


def shortened_name(name: object) -> str:
    """Shorten a name that a message holds."""
    return shortened(name, LONGEST_NAME)


class EinschaltWarning(UserWarning):
    """Something that the user should know, although the result stands."""
