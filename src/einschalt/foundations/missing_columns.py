"""Columns that a table lacks: what is there in their place, and how to mend it."""

from einschalt.foundations.column_words import COLUMN_WORDS, folded, in_other_unit
from einschalt.foundations.errors import TableError, name_some
from einschalt.foundations.near_words import nearest

ANGLES = {"easting": "longitude", "northing": "latitude"}
OF_SECTION = (
    'Say crs = "EPSG:4326", or the system of the receiver, in the section of these '
    "points"
)
OF_SCRIPT = "Transform them into the system of the block first, with pyproj for example"


def columns_in_the_index(missing, names, schema, source):
    """Columns of which pandas has made labels of rows."""
    return TableError(
        f"the index of the table has {name_some(missing)}, no column; its columns are "
        f"{name_some(names, 8) or 'none'}",
        expected=", ".join(c.name for c in schema.columns if c.is_required),
        remedy="Give table.reset_index()",
        file=source,
    )


def missing_columns(missing, names, schema, source, header):
    """Errors of the columns that are missing, one of both where angles stand for them.

    ``header``: line of the file in which the names stand; None without one.
    """
    found = [_missing_column(name, names, schema, source, header) for name in missing]
    of_angles = [one for one in found if one.remedy in (OF_SECTION, OF_SCRIPT)]
    return [one for one in found if one not in of_angles[1:]]


def _missing_column(name, names, schema, source, header):
    """A column that is missing: in another unit, under another name, or at all."""
    other = in_other_unit(names, schema, name)
    if other is not None:
        unit = next(column.unit for column in schema.columns if column.name == name)
        return TableError(
            f"column '{name}' is missing; '{other[0]}' is in {other[1]}",
            expected=unit,
            remedy=f"Give it in {unit}, or correct its name if that is wrong",
            file=source,
            row=header,
        )
    if _are_angles(names, ANGLES.get(name)):
        return TableError(
            f"column '{name}' is missing, found longitudes and latitudes",
            expected="metres, or the system of these degrees",
            remedy=OF_SCRIPT if header is None else OF_SECTION,
            file=source,
            row=header,
        )
    near = nearest(name, [n for n in names if n not in schema.names])
    mend = f"Rename '{near}' to '{name}'" if near else f"Add it as '{name}'"
    return TableError(
        f"column '{name}' is missing, found {name_some(names, 8) or 'none'}",
        expected=", ".join(c.name for c in schema.columns if c.is_required),
        remedy=mend,
        file=source,
        row=header,
    )


def _are_angles(names, angle):
    """Whether both angles stand in a table, one of them in place of a length."""
    words = {folded(name) for name in names}
    both = [words & {w for n, w in COLUMN_WORDS if n == a} for a in ANGLES.values()]
    return angle is not None and all(both)
