"""Names in workbooks, as they were typed where the cell still tells.

One of which the spreadsheet may have made something else is refused; one that only
looks otherwise than it is read is said.
"""

import numpy as np

from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import TableError, name_some, raise_problems
from einschalt.foundations.number_parsing import CLOCK
from einschalt.foundations.tables import listed
from einschalt.interfaces.files.cells_of_names import (
    DATE,
    DIGITS,
    LOOK,
    POWER,
    TRUTH,
    NoText,
)

# where a file does not tell which cells are texts
LIKE_A_DATE = r"\d{4}[-/]\d\d[-/]\d\d([ T].*)?"
WHOLE = r"(-?\d+)\.0{6,}"  # as some programs write whole numbers


def whole_names(frame, columns, held, source):
    """The frame with names as they were typed, and notes.

    ``columns``: positions of the names in the sheet; ``held``: what ``no_texts`` says
    of them. A name that may have been something else is a problem of its row.
    """
    changed, problems, notes = {}, [], []
    for name, column in columns.items():
        if list(frame.columns).count(name) != 1:
            continue
        values = frame[name].str.replace(f"^{WHOLE}$", r"\1", regex=True)
        of_rows = _of_rows(values, held, column)
        places = [k for k, one in enumerate(of_rows) if one and one.kind != LOOK]

        def problem(place, name=name, values=values, of_rows=of_rows):
            return _problem(
                name,
                shortened(values.iloc[place]),
                of_rows[place].kind,
                {"file": source, "row": int(frame.index[place])},
            )

        problems += listed(places, problem, "so is the name")
        notes += _note(name, values, of_rows, source)
        changed[name] = values
    raise_problems(problems)
    return frame.assign(**changed), notes


def _of_rows(values, held, column):
    """What stands in each row in place of a text, or None."""
    if held is None:
        is_date = values.str.fullmatch(LIKE_A_DATE).to_numpy(dtype=bool)
        return [NoText(DATE, "") if one else None for one in is_date]
    if not held:
        return []
    return [held.get((row, column)) for row in values.index.tolist()]


def _problem(name, value, kind, where):
    if kind == TRUTH:
        found = f"{name} is TRUE or FALSE, which a spreadsheet makes of these words"
    elif kind == POWER:
        found = (
            f"{name} '{value}' is shown as a power of ten: a spreadsheet makes one of "
            "names such as 1E5"
        )
    elif kind == DIGITS:
        found = (
            f"{name} '{value}' is a number of 16 digits or more, of which a "
            "spreadsheet keeps 15"
        )
    elif CLOCK.fullmatch(value):
        found = (
            f"{name} is a time of day: a spreadsheet makes one of names such as 7:30"
        )
    else:
        found = (
            f"{name} '{value}' is a date or a time: a spreadsheet makes one of names "
            "such as 7/8 and 7:30"
        )
    return TableError(
        found,
        expected="the name as text",
        remedy="Give the column the format Text, and the names again",
        **where,
    )


def _note(name, values, of_rows, source):
    """Say which names look otherwise than they are read."""
    places = np.flatnonzero([one is not None and one.kind == LOOK for one in of_rows])
    if not len(places):
        return []
    looks = name_some(sorted({of_rows[k].look for k in places}))
    row, value = int(values.index[places[0]]), shortened(values.iloc[places[0]])
    note = (
        f"{source}: {name} '{value}' in row {row} is a number that the cell may show "
        f"otherwise ({looks}): give names the format Text, as they are to be read"
    )
    return [note]
