"""Points not where they should lie: axes exchanged, another system, another place."""

import numpy as np

from einschalt.foundations import tables
from einschalt.foundations.areas_of_use import in_extent
from einschalt.foundations.batches import (
    segment_centred,
    segment_sum,
    segments_present,
)
from einschalt.foundations.coordinate_operations import system_label
from einschalt.foundations.errors import ConsistencyError, ProjectionError, name_some
from einschalt.foundations.frame_columns import PLAN, values_of
from einschalt.foundations.names import encode
from einschalt.foundations.points_elsewhere import (
    lost_point_problems,
    other_system_problems,
)
from einschalt.foundations.projections import read_crs
from einschalt.pipeline.block.places import place_problems
from einschalt.theory.block_adjustment.common_parameters import COMPLEX

FEWEST_IN_A_PHOTOGRAPH = 4  # known points, of which two give turn and scale
# of what is left of the mirror image: below it chance does not make the one fit better
LEAST_APART = 0.1
ON_A_LINE = 0.02  # less is left of points within a tenth of their extent beside a line


def where_problems(frame, crs, source, measured):
    """Points that lie elsewhere than the others, or not where their system is used.

    Problems, and notes of how many points lie outside; ``source`` is the file, and
    ``measured`` gives the names that models hold.
    """
    try:
        system = read_crs(crs) if crs else None
    except ProjectionError:  # said by check_facts
        system = None
    if system is not None and system.is_geographic:
        return own_axis_problems(frame, system, source)
    given = frame, system, source, measured
    problems, notes = other_system_problems(*given), []
    if not problems and system is not None:
        problems, notes = own_axis_problems(frame, system, source)
    if not problems:
        problems = lost_point_problems(*given)
    return problems, [] if problems else notes


def own_axis_problems(frame, system, source):
    """Points that do not lie where their system is used, most often exchanged axes.

    Problems, and notes of how many points lie outside either way. Longitude and
    latitude of a geographic system stand as easting and northing.
    """
    axes = ("longitude", "latitude") if system.is_geographic else PLAN
    east, north = (frame[name].to_numpy() for name in PLAN)
    label, is_inside = system_label(system), in_extent(east, north, system)
    is_outside = is_swapped = np.zeros(len(frame), dtype=bool)
    if is_inside is not None:
        is_outside = ~is_inside
        is_swapped = is_outside & in_extent(north, east, system)

    def problem(place):
        return ConsistencyError(
            f"{axes[0]} {east[place]:.3f}, {axes[1]} {north[place]:.3f} lies outside "
            f"the area of {label}, and inside with the two exchanged",
            expected=f"{axes[0]}, {axes[1]} in this order",
            remedy="Exchange the two columns, or correct crs",
            file=source,
            **tables.row_location(frame, place),
        )

    rest = f"{axes[0]} and {axes[1]} are exchanged"
    problems = tables.listed(np.flatnonzero(is_swapped), problem, rest)
    if not problems:
        problems = place_problems(east, north, system, source)
    far = np.flatnonzero(is_outside & ~is_swapped)
    if problems or not len(far) or "point_id" not in frame:
        return problems, []
    said = (
        f"{source}: {len(far)} of {len(frame)} points lie outside the area of use of "
        f"{label}: {name_some(frame['point_id'].iloc[far])}"
    )
    return problems, [said]


def mirrored_problems(images, ground, name, files):
    """Photographs that all show the ground as a mirror does; one problem, or none.

    Seen from above, points lie in a photograph as they do on the map, turned and
    smaller. Where only their mirror image fits the map, y of the image points grows
    downwards, or eastings and northings are exchanged.

    Parameters
    ----------
    images : DataFrame
        image_id, point_id, x, y of the flight ``name``.
    ground : DataFrame
        point_id, easting, northing.
    files : tuple of str
        Of the image points, and of the ground.
    """
    names = encode(images["point_id"])
    place = encode(ground["point_id"]).locate(names)[names.codes]
    is_known = (place >= 0) & images["x"].notna().to_numpy()
    if not is_known.any():
        return []
    parts = segments_present(encode(images["image_id"][is_known]).codes)
    there = values_of(ground, PLAN)[place[is_known]][parts.order] @ COMPLEX
    here = values_of(images, ["x", "y"])[is_known][parts.order] @ COMPLEX
    here, there = (segment_centred(one, parts.start) for one in (here, there))
    size = segment_sum(abs(here) ** 2, parts.start)
    size = size * segment_sum(abs(there) ** 2, parts.start)
    is_told = (parts.count >= FEWEST_IN_A_PHOTOGRAPH) & (size > 0.0)
    size = np.where(is_told, size, 1.0)
    # what a turn and a scale leave of the positions, of the image and of its mirror
    # image: a share of them
    left, left_mirrored = (
        1.0 - abs(segment_sum(one * there, parts.start)) ** 2 / size
        for one in (here.conj(), here)
    )
    is_mirrored = is_told & (left_mirrored < LEAST_APART * left) & (left > ON_A_LINE)
    is_upright = is_told & (left < LEAST_APART * left_mirrored)
    # names of points that are wrong make a photograph fit by chance
    n_mirrored, n_told = is_mirrored.sum(), is_told.sum()
    if not n_mirrored or is_upright.any() or 2 * n_mirrored < n_told:
        return []
    return [_mirrored_problem(name, n_mirrored, n_told, *files)]


def _mirrored_problem(name, n_mirrored, n_told, photographs, table):
    remedy = (
        "Change the sign of y of the image points, or exchange eastings and northings"
    )
    if n_mirrored == 1:
        remedy = (
            "Change the sign of y of the image points, or exchange eastings and "
            "northings; or correct the names of points, if those of one photograph "
            "or of the table are wrong"
        )
    return ConsistencyError(
        f"[{name}] {n_mirrored} of {n_told} photographs with enough known points are "
        f"mirrored against {table}, and none stands upright",
        expected="x to the right, y upwards; eastings to the east, northings to the "
        "north",
        remedy=remedy,
        file=photographs,
    )


def tells_axes(frame, system):
    """Whether a system tells easting from northing: exchanged, points lie outside.

    Of Austria's Lambert system, or Britain's grid, the area holds many points either
    way. ``frame``: as for :func:`own_axis_problems`.
    """
    east, north = (frame[name].to_numpy() for name in PLAN)
    is_inside = in_extent(north, east, system)
    return is_inside is not None and not is_inside.all()
