"""Whether tables can be those of one block, before anything is asked about it.

What stands in the files themselves is told first: names that match nothing, degrees,
pixels. An answer to a question would not help.
"""

from dataclasses import replace

import numpy as np

from einschalt.foundations.errors import TableError, name_some
from einschalt.foundations.header_units import METRES_PER_LENGTH
from einschalt.foundations.names import is_among
from einschalt.foundations.names_as_numbers import (
    lacks_zeros,
    pair_made_or_typed,
    remedy,
)
from einschalt.foundations.near_words import pair_meant, told_apart
from einschalt.pipeline.block.facts import RANGES

USUAL_SCALE_NUMBER = 10_000.0
# widths of images: of no film as many millimetres, of no sensor as many pixels
WIDEST_FILM_MM, WIDEST_SENSOR = 500.0, 40_000.0
PLANE, GEOGRAPHIC = ("easting", "northing"), ("longitude", "latitude")
LARGEST_ANGLES = 180.0, 90.0


def require_cameras_of_pixels(flights):
    """Refuse image points that look like pixels, where no file holds their camera."""
    for tables in flights:
        points = tables.get("image_points")
        if points is None or "camera" in tables:
            continue
        xy = points.frame.groupby("image_id", sort=False)[["x", "y"]]
        widest = (xy.max() - xy.min()).to_numpy(dtype=float).max()
        if WIDEST_FILM_MM < widest <= WIDEST_SENSOR:
            raise TableError(
                f"image points extend over {widest:.6g}: these look like pixels, and "
                "nothing tells of their camera",
                expected="millimetres from the principal point, or pixels and a camera",
                remedy="Write a camera.toml and name it after --from: convention = "
                '"mm", c = principal distance in mm, pixel_size_um, width and height '
                "of the images in pixels",
                file=points.title,
            )


def require_possible_scales(known, scales, scales_on, *, has_pixels):
    """Refuse control points against which no flight has a possible scale.

    Where degrees or metres, or a power of ten, make all scales possible, that is the
    unit that they have. ``scales_on``: scales of the flights against other points.
    """
    numbers = _numbers(scales)
    if not len(numbers) or _are_possible(numbers).any():
        return
    shown = ", ".join(f"1:{number:g}" for number in numbers)
    _require_angles(known, scales_on, shown)
    could = {u: numbers * metres for u, metres in METRES_PER_LENGTH.items()}
    could = {unit: ones for unit, ones in could.items() if _are_possible(ones).all()}
    if not could:
        return
    unit = min(could, key=lambda u: abs(np.log(could[u].mean() / USUAL_SCALE_NUMBER)))
    if has_pixels:
        raise TableError(
            f"the photographs have scales of {shown} against these points",
            expected=f"scale numbers of {RANGES['scale_number']}",
            remedy="Correct the size of the pixels, or give the points in metres",
            file=known.title,
        )
    raise TableError(
        f"the models have scales of {shown} against these points, as if their "
        f"coordinates were in {unit}",
        expected="coordinates in metres, or a unit behind the names of their columns",
        remedy=f"Write the unit behind the names, as in 'easting [{unit}]', or give "
        "metres; state the unit of model coordinates likewise if that is wrong",
        file=known.title,
    )


def _require_angles(known, scales_on, shown):
    """Refuse degrees under the names of metres, and metres under those of degrees."""
    own = GEOGRAPHIC if GEOGRAPHIC[0] in known.frame else PLANE
    names = {one: [*known.frame[one]] for one in own}
    sizes = np.abs([names[one] for one in own]).max(axis=1)
    if own == PLANE and not (sizes <= LARGEST_ANGLES).all():
        return
    other = PLANE if own == GEOGRAPHIC else GEOGRAPHIC
    frame = known.frame.rename(columns=dict(zip(own, other, strict=True)))
    numbers = _numbers(scales_on(replace(known, frame=frame)))
    if not len(numbers) or not _are_possible(numbers).all():
        return
    if own == PLANE:
        raise TableError(
            f"the models have scales of {shown} against these points, as if their "
            "coordinates were degrees",
            expected="eastings and northings in metres, or longitudes and latitudes of "
            "a system that the file states",
            remedy="Give the layer its geographic system, such as EPSG:4326, and "
            "export it again, or transform the points to metres",
            file=known.title,
        )
    raise TableError(
        f"the models have scales of {shown} against these points, as if their "
        "longitudes and latitudes were metres",
        expected="degrees, or the system of these coordinates",
        remedy="Give the layer its system in a GIS, and export it again",
        file=known.title,
    )


def _numbers(scales):
    return np.array([scale.value for scale in scales if scale is not None])


def _are_possible(numbers):
    possible = RANGES["scale_number"]
    return (numbers >= possible.low) & (numbers <= possible.high)


def require_shared_names(ground, flights):
    """Refuse flights of whose points nothing is known, before anything is asked.

    A question for the scale number would have an answer, and the block no point. The
    low flight may have points of the high one alone.
    """
    known, rest = list(ground.values()), [_points_of(tables) for tables in flights]
    rest = [table for table in rest if table is not None]
    while rest:
        joined = [t for t in rest if any(_share_a_name(one, t) for one in known)]
        if not joined:
            raise _nothing_shared(known, rest[0])
        known += joined
        rest = [table for table in rest if table not in joined]


def require_same_names(values, known, named):
    """Refuse names that are written otherwise in two tables, where no scale is found.

    Of three tables one pair may share names, and the third be lost.
    """
    before = [known]
    for name, tables in named.items():
        table = _points_of(tables)
        if table is None:
            continue
        if values.get((name, "scale_number")) is None:
            for other in before:
                _require_alike(other, table)
        before.append(table)


def _points_of(tables):
    return tables.get("model_points", tables.get("image_points"))


def _share_a_name(one, other):
    return bool(is_among(*map(_point_names, (one, other))).any())


def _point_names(table):
    return table.frame["point_id"].astype(str)


def _nothing_shared(others, table):
    """What is wrong where a table has none of the names of the others."""
    for other in others:
        pair = _pair_of_one_point(other, table)
        if pair is not None:
            return _written_otherwise(other, table, pair)
    one = others[0]
    names, own = (name_some(_point_names(o).unique(), 3) for o in (one, table))
    return TableError(
        f"{table.title} holds none of the points of {one.title}: its points are "
        f"called {own}, those of {one.title} {names}",
        expected="the same point under the same name in both",
        remedy="Rename the points in one of them, or name the files that belong "
        "together after --from",
    )


def _require_alike(one, other):
    if _share_a_name(one, other):
        return
    pair = _pair_of_one_point(one, other)
    if pair is not None:
        raise _written_otherwise(one, other, pair)


def _pair_of_one_point(one, other):
    """Names of a point in tables that write it otherwise; None where they do not."""
    names = _point_names(one), _point_names(other).unique()
    files = one.path.name, other.path.name
    return pair_meant(*names) or pair_made_or_typed(*names, files)


def _written_otherwise(one, other, pair):
    written = told_apart(*pair)
    is_of_numbers = lacks_zeros(*pair) or lacks_zeros(*pair[::-1])
    alike = "Write them alike, or export one of the files anew"
    return TableError(
        f"{one.title} has '{written[0]}', {other.title} has '{written[1]}', and "
        "they share no name",
        expected="the same names in both",
        remedy=remedy(*pair) if is_of_numbers else alike,
    )
