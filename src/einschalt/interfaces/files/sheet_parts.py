"""Tables that stand one below the other in a sheet, parted by empty rows.

Only a row that names the columns of a table that a block can have begins another one:
empty rows alone part nothing, nor does a header that stands there once more.
"""

import numpy as np

from einschalt.foundations import tables
from einschalt.foundations.decimal_commas import is_measure
from einschalt.foundations.errors import FileError
from einschalt.interfaces.files.header_rows import HEAD_ROWS, joined, place_of_header
from einschalt.interfaces.files.understood_tables import NOTHING_SAID, is_whole_header

# the most particular first: a table of model points could be one of ground points
PARTICULAR = (
    tables.Y_PARALLAXES,
    tables.IMAGE_POINTS,
    tables.IMAGE_MODELS,
    tables.MODEL_BASES,
    tables.MEASURED_MODEL_POINTS,
)
GROUND = tables.CONTROL_POINTS
MOST_TITLES = 5  # rows above the names
MOST_LOOKED_AT = 1000  # rows that follow an empty one


class SeveralTablesError(FileError):
    """More than one table of a sheet could be meant."""


def parts_of(cells):
    """Rows of each table of a sheet, as slices; one where there are no others.

    ``cells``: text, a row without any is empty.
    """
    is_empty = (cells == "").all(axis=1).to_numpy()
    starts = np.flatnonzero(~is_empty[1:] & is_empty[:-1]) + 1
    last, _ = _names_below(cells, int(np.argmin(is_empty)))
    edges = [0]
    for start in starts[:MOST_LOOKED_AT].tolist():
        names, has_title = _names_below(cells, start)
        # a header that stands there once more is that of a list that goes on
        if names is None or (names == last and not has_title):
            continue
        if last is not None:  # otherwise titles stand above the first table
            edges.append(start)
        last = names
    return [slice(*pair) for pair in zip(edges, [*edges[1:], len(cells)], strict=True)]


def fitting_parts(cells, parts, schema, said):
    """The parts that are tables of a schema, and none of a more particular one."""
    names = [one.name for one in PARTICULAR]
    place = names.index(schema.name) if schema.name in names else len(names)
    found = []
    for part in parts:
        rows = _first_rows(cells.iloc[part])
        is_other = any(
            place_of_header(rows, s, NOTHING_SAID) for s in PARTICULAR[:place]
        )
        if place_of_header(rows, schema, said) and not is_other:
            found.append(part)
    return found


def meant_part(cells, schema, said, source, sheet):
    """Cells of the table that is meant, how many others the sheet has, and notes."""
    parts = parts_of(cells)
    fitting = fitting_parts(cells, parts, schema, said) if len(parts) > 1 else []
    if not fitting:
        return cells, 0, []
    said_rows = [f"{a} to {b}" for a, b in (_rows_of(cells.iloc[p]) for p in fitting)]
    if len(fitting) > 1:
        raise SeveralTablesError(
            f"sheet '{sheet}' has {len(fitting)} tables that could be meant, in the "
            f"rows {', '.join(said_rows)}",
            expected="one table that has these columns",
            remedy="Put each of them on a sheet of its own",
            file=source,
        )
    note = (
        f"{source}: sheet '{sheet}' has {len(parts)} tables, one below the other; "
        f"read are the rows {said_rows[0]}"
    )
    return cells.iloc[fitting[0]], len(parts) - 1, [note]


def _rows_of(cells):
    """First and last row of a part that are not empty, as the sheet counts them."""
    rows = cells.index[(cells != "").any(axis=1)]
    return int(rows[0]), int(rows[-1])


def _first_rows(cells):
    return cells.iloc[:HEAD_ROWS].to_numpy(dtype=object).tolist()


def _names_below(cells, start):
    """Names of a table that begins at a row, None of none; whether it has a title."""
    rows = cells.iloc[start : start + MOST_TITLES].to_numpy(dtype=object).tolist()
    above = []
    for place, row in enumerate(rows):
        if not any(row) or any(map(is_measure, row)):
            break
        for names in (joined(above, row), row):
            schemas = (*PARTICULAR, GROUND)
            if names and any(is_whole_header(names, s, NOTHING_SAID) for s in schemas):
                return row, place > 0 and names is row
        above = row
    return None, False
