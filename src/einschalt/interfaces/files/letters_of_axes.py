"""A Y and an X on the ground: which of them is the easting, and where they count to.

Their system tells, by the names of its axes or by its area, or the language of the
table. What nothing tells is asked, and so is what the names and the area contradict.
"""

import numpy as np
import pandas as pd

from einschalt.foundations.areas_of_use import in_extent
from einschalt.foundations.column_words import GEODETIC, PLANE
from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import ProjectionError, TableError
from einschalt.foundations.projections import axis_letters, is_of_krovak, label_of
from einschalt.foundations.tables import LINE
from einschalt.foundations.units import METRES_PER_KM
from einschalt.foundations.words_of_countries import SOUTHING_IS_X
from einschalt.interfaces.files.lists_without_names import HEIGHT, HIGHEST_M

AS_TABLES = {
    "de": "as German tables have them",
    "pl": "as Polish tables have them",
    "sl": "as Slovene tables have them",
    "hr": "as Croatian tables have them",
    "hu": "as Hungarian tables have them",
    "ro": "as Romanian tables have them",
    "tr": "as Turkish tables have them",
    "ja": "as Japanese and Chinese tables have them",
    "nl": "as Dutch tables have them",
}
# of points of the earth's surface from its centre
RADII_M = 6.34e6, 6.40e6


def with_axes(frame, crs, meant, source):
    """The frame in which Y and X are what they are in their country, and a note.

    Parameters
    ----------
    frame : DataFrame
        Y as northing and X as easting, for the time being.
    crs : str or None
        System of the points.
    meant : Meant
        What the names of the columns mean.
    source : str
        Name of the file.

    Raises
    ------
    TableError
        Nothing tells which of them is the easting, or it is contradicted.
    """
    _refuse_geocentric(frame, source)
    y, x = meant.letters
    turned = frame.rename(columns=dict(zip(PLANE, reversed(PLANE), strict=True)))
    named = None if meant.is_by_place else _by_name(crs)
    by_name = None if named is None else turned if named == GEODETIC else frame
    chosen, reason = by_name, f"as {label_of(crs)} names its axes"
    is_inside = [_is_in_area(one, crs) for one in (frame, turned)]
    if is_inside in ([True, False], [False, True]):
        by_area = frame if is_inside[0] else turned
        if by_name is not None and by_area is not by_name and not is_of_krovak(crs):
            raise _contradiction(meant, crs, named, source, frame.index.name == LINE)
        if by_area is not by_name:
            chosen = by_area
            reason = f"since only so the points lie in the area of {label_of(crs)}"
    elif is_inside == [False, False] and is_of_krovak(crs):
        orders = {(y, x): turned, (x, y): frame}
        for names, one in orders.items():
            counted = _to_south_and_west(one, crs)
            if counted is not None:
                return counted, _note_of_signs(*names, crs, source)
        # who wrote them has not the axes of the map
        raise _question_of_axes(meant, source, frame.index.name == LINE)
    if chosen is None and meant.practice is not None:
        chosen = turned if meant.practice == GEODETIC else frame
        reason = AS_TABLES[meant.language]
    if chosen is None:
        raise _question_of_axes(meant, source, frame.index.name == LINE)
    east = x if chosen is frame else y
    north = y if chosen is frame else x
    return chosen, f"{source}: {east!r} is easting, {north!r} is northing, {reason}"


def _refuse_geocentric(frame, source):
    """Refuse X, Y, Z from the centre of the earth, as receivers of satellites give."""
    if HEIGHT not in frame or not len(frame):
        return
    place = [_median(frame[name]) for name in (*PLANE, HEIGHT)]
    radius, (low, high) = np.linalg.norm(place), RADII_M
    if abs(place[2]) > HIGHEST_M and low < radius < high:
        raise TableError(
            f"X, Y and Z are geocentric, {radius / METRES_PER_KM:.0f} km from the "
            "centre of the earth",
            expected="coordinates of a plane system, or longitudes and latitudes",
            remedy="Export these from the receiver's program, or convert them first",
            file=source,
        )


def _to_south_and_west(frame, crs):
    """Coordinates of Krovak's projection that count to the west and south, or None.

    So do those of the land survey; the systems whose axes point to the east and north
    have the same numbers with a minus.
    """
    counted = frame.assign(**{name: _negative(frame[name]) for name in PLANE})
    return counted if _is_in_area(counted, crs) else None


def _negative(series):
    """Values with the other sign; what is no number stays as it is, to be refused."""
    numbers = pd.to_numeric(series, errors="coerce").astype(float)
    if not (numbers.isna() & series.notna()).any():
        return -numbers
    return (-numbers).astype(object).where(numbers.notna(), series)


def _note_of_signs(west, south, crs, source):
    return (
        f"{source}: {west!r} counts to the west, {south!r} to the south, since only so "
        f"the points lie in the area of {label_of(crs)}: with a minus they are easting "
        "and northing"
    )


def _by_name(crs):
    try:
        return None if crs is None else axis_letters(crs)
    except ProjectionError:  # said where the system is read
        return None


def _is_in_area(frame, crs):
    """Whether the middle of the points lies in the area of their system."""
    if crs is None:
        return None
    try:
        is_inside = in_extent(*(_median(frame[name]) for name in PLANE), crs)
    except ProjectionError:
        return None
    return None if is_inside is None else bool(is_inside)


def _median(series):
    values = pd.to_numeric(series, errors="coerce").to_numpy(float, na_value=np.nan)
    finite = values[np.isfinite(values)]
    return float(np.median(finite)) if len(finite) else np.nan


def _contradiction(meant, crs, named, source, has_lines):
    """Which of both is the easting, where only exchanged axes put the points there."""
    y, x = (shortened(name) for name in meant.letters)
    east, north = (y, x) if named == GEODETIC else (x, y)
    return TableError(
        f"'{east}' is the easting as {label_of(crs)} names its axes, and the points "
        "lie in its area only with the two exchanged",
        expected=f"eastings in '{east}', or a word on them",
        remedy=f'Say columns = {{easting = "{north}", northing = "{east}"}} in '
        "block.toml, or correct crs",
        file=source,
        row=1 if has_lines else None,
    )


def _question_of_axes(meant, source, has_lines):
    y, x = (shortened(name) for name in meant.letters)
    if meant.is_by_place:
        return TableError(
            f"the columns have no names: which of '{x}' and '{y}' is the easting? "
            "Nothing here tells",
            expected="a line with their names, or a word on them",
            remedy=f'Say columns = {{easting = "{x}", northing = "{y}"}} in '
            "block.toml, or the other way round",
            file=source,
            row=1 if has_lines else None,
        )
    if meant.language in SOUTHING_IS_X:
        return TableError(
            f"columns '{y}' and '{x}': Czech and Slovak surveyors count them to the "
            "west and to the south, and nothing here tells whether these are so",
            expected="a system, or a word on them",
            remedy="Say crs, such as EPSG:5514 for S-JTSK, which tells it; or columns "
            f'= {{easting = "{y}", northing = "{x}"}} in block.toml for a local one',
            file=source,
            row=1 if has_lines else None,
        )
    return TableError(
        f"columns '{y}' and '{x}': which of them is the easting? Central Europe and "
        "Japan write Y for it, most others X, and nothing else here tells",
        expected="easting and northing by these names, or a word on them",
        remedy=f'Say columns = {{easting = "{y}", northing = "{x}"}} in block.toml, or '
        "the other way round",
        file=source,
        row=1 if has_lines else None,
    )
