"""Rows that name the columns of a table: of a text, or of a sheet.

Titles may stand above them, the names may stand in two rows, one below the other, and
a row of units may follow.
"""

from einschalt.foundations.column_words import PLANE, kind_of
from einschalt.foundations.decimal_commas import is_measure
from einschalt.foundations.header_units import (
    DEGREES,
    GONS,
    METRES_PER_LENGTH,
    PACKED,
    PIXELS,
    plain_unit,
)
from einschalt.interfaces.files.places_of_images import IMAGE_SUFFIXES
from einschalt.interfaces.files.understood_tables import is_whole_header

HEAD_ROWS = 30  # in which the names of the columns must stand
LENGTHS = {*METRES_PER_LENGTH, "ft", "US ft", PIXELS}
UNITS = {*LENGTHS, *DEGREES, *GONS, PACKED}
FEWEST_UNITS = 2  # of a row in which other words stand
NO_UNITS = {"", "-", "–", "—"}
FEWEST_CELLS, MOST_CELLS = 3, 6  # of a list without names
FEWEST_MARK_CELLS = 4  # of one of image points


def place_of_header(rows, schema, said):
    """Position of the row with the names among the first ones, and the names.

    ``rows``: cells as text, without blanks around them. None where no row, alone or
    with the one above, has all columns that the schema requires.
    """
    above = []
    for place, cells in enumerate(rows[:HEAD_ROWS]):
        for names in (joined(above, cells), cells):
            if names and is_whole_header(names, schema, said):
                return place, names
        above = cells
    return None


def joined(upper, lower):
    """Names of two rows, the upper one where the lower is empty; None if it never is.

    Both of them where the lower one is a unit.

    >>> joined(["No", "Plane", "", "H"], ["", "E", "N", ""])
    ['No', 'E', 'N', 'H']
    >>> joined(["No", "Plane", "", "Höhe"], ["", "E", "N", "[m ü. A.]"])
    ['No', 'E', 'N', 'Höhe [m ü. A.]']
    """
    if len(upper) != len(lower):
        return None
    names = [_one_name(up, low) for up, low in zip(upper, lower, strict=True)]
    return None if names == lower else names


def _one_name(upper, lower):
    is_unit = lower.startswith(("[", "(")) or plain_unit(lower) in LENGTHS
    if upper and lower and is_unit:
        return f"{upper} [{lower.strip('[]() ')}]"
    return lower or upper


def with_units(names, cells):
    """Names with the units that stand below them; None where these are none.

    >>> with_units(["No", "E", "N"], ["", "[m]", "[m]"])
    ['No', 'E [m]', 'N [m]']
    >>> with_units(["No", "E", "N"], ["Text", "Meter", "Meter"])
    ['No', 'E [m]', 'N [m]']
    >>> with_units(["No", "E", "N"], ["m", "1.0", "2.0"])
    """
    units = [plain_unit(cell) for cell in cells]
    n_lengths = sum(unit in LENGTHS for unit in units)
    is_each = {*units} <= UNITS | NO_UNITS
    # words such as Text or Nr. may stand beside: a point has no unit for a coordinate
    is_row = n_lengths >= FEWEST_UNITS and not any(map(is_measure, cells))
    has_units = not UNITS.isdisjoint(units)
    if not (has_units and (is_each or is_row) and len(names) == len(units)):
        return None
    pairs = zip(names, units, strict=True)
    return [f"{n} [{unit}]" if n and unit in UNITS else n for n, unit in pairs]


def is_list_of_points(cells, schema):
    """Whether a row is that of a list without names: a name and two or more numbers.

    >>> from einschalt.foundations.tables import CONTROL_POINTS
    >>> is_list_of_points(["7/8", "13082.6", "326844.2"], CONTROL_POINTS)
    True
    """
    return (
        set(PLANE) <= set(schema.names)
        and FEWEST_CELLS <= len(cells) <= MOST_CELLS
        and bool(cells[0])
        and all(map(is_measure, cells[1:3]))
    )


def is_long_list(cells, schema):
    """Whether a row is that of a list without names, but of more columns.

    >>> from einschalt.foundations.tables import CONTROL_POINTS
    >>> cells = "7/8 13082.6 326844.2 512.1 0.01 0.01 0.02".split()
    >>> is_long_list(cells, CONTROL_POINTS), is_long_list(cells[:5], CONTROL_POINTS)
    (True, False)
    """
    first = cells[:MOST_CELLS]
    return len(cells) > MOST_CELLS and is_list_of_points(first, schema)


def places_of_marks(cells, schema):
    """Columns of a list without names of image points: two names, and two numbers.

    Which of the names is that of the image tells its suffix; None where it does not, or
    where the row is of another list.

    >>> from einschalt.foundations.tables import IMAGE_POINTS
    >>> places_of_marks(["DJI_1.JPG", "P1", "562.3", "2047.5", "1"], IMAGE_POINTS)
    {'image_id': 0, 'point_id': 1, 'x': 2, 'y': 3}
    """
    is_known = {"image_id", "point_id", "x", "y"} <= set(schema.names)
    is_one = FEWEST_MARK_CELLS <= len(cells) <= MOST_CELLS and all(cells[:2])
    if not (is_known and is_one and all(map(is_measure, cells[2:4]))):
        return None
    are_images = [cell.casefold().endswith(IMAGE_SUFFIXES) for cell in cells[:2]]
    if sum(are_images) != 1:
        return None
    image = are_images.index(True)
    return {"image_id": image, "point_id": 1 - image, "x": 2, "y": 3}


def usual_places(rows, schema):
    """Columns of such a list beside the two coordinates, by their positions.

    ``rows``: the first ones; what a column holds tells the first cell that is filled.

    >>> from einschalt.foundations.tables import CONTROL_POINTS
    >>> rows = [["1", "13082.6", "326844.2", ""], ["2", "13182.6", "326844.2", "512"]]
    >>> usual_places(rows, CONTROL_POINTS)
    {'point_id': 0, 'height': 3}
    """
    found = {"point_id": 0}
    width = len(rows[0])
    cells = [
        next((row[k] for row in rows if len(row) == width and row[k]), "")
        for k in range(width)
    ]
    for place, cell in enumerate(cells[3:], 3):
        if place == 3 and is_measure(cell) and "height" in schema.names:
            found["height"] = place
        elif "role" in schema.names and "role" not in found and kind_of(cell):
            found["role"] = place
    return found
