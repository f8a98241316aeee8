"""Results as DXF: points with their numbers, ellipses, residual vectors, on layers.

Each point is a block reference with attributes (NUMBER, ERROR and, where it has one,
HEIGHT), as CAD programs of surveyors read and write them; its height is its z as well,
and its layer says what kind it is.
"""

from contextlib import contextmanager

import numpy as np
from scipy.spatial import cKDTree

from einschalt.foundations.extras import imported
from einschalt.foundations.units import RADIANS_PER_GON
from einschalt.interfaces.files.map_layers import exaggeration
from einschalt.interfaces.programs.drawing_points import POINTS

COLOURS = {"new": 7, "control": 30, "check": 5}
NUMBER, HEIGHT, ERROR = "NUMBER", "HEIGHT", "ERROR"
BLOCK = "EINSCHALT_POINT"
TEXT_SHARE, WIDTH_SHARE = 0.15, 0.8  # height and width, of the distance of points
WIDTH_OF_LETTER = 0.9  # of its height, in the fonts of CAD programs
LONG_NAMES = 0.9  # quantile of the lengths of names, and of distances to the nearest
# of points that lie at random in their area, nine of ten have the nearest within 0.86
# of its mean distance
FROM_NEAREST, LEAST_OF_EVEN = 1.5, 0.1
# of that distance, within which points are one that is given twice
NEXT_TO_NOTHING = 0.01


def write_dxf(handed, path):
    """Write the points, their numbers, ellipses and residual vectors; gives notes.

    Ellipses and vectors are drawn so much larger that they are seen: the factor stands
    in the name of their layer.
    """
    ezdxf = imported("ezdxf", "DXF")
    with _same_file_each_time(ezdxf):
        document = ezdxf.new("R2010", units=6)  # metres
        document.header["$MEASUREMENT"] = 1
        space = document.modelspace()
        _add_points(document, space, handed)
        notes = [
            _add_ellipses(document, space, handed),
            *handed.told_enlargement,
            _add_residuals(document, space, handed),
        ]
        _order_classes(document)
        document.saveas(path)
    return [note for note in notes if note]


@contextmanager
def _same_file_each_time(ezdxf):
    before = ezdxf.options.write_fixed_meta_data_for_testing
    ezdxf.options.write_fixed_meta_data_for_testing = True
    try:
        yield
    finally:
        ezdxf.options.write_fixed_meta_data_for_testing = before


def _order_classes(document):
    """Put the classes of the file in order: the library keeps them in a set."""
    document.classes.add_required_classes(document.dxfversion)
    found = document.classes.classes
    document.classes.classes = dict(sorted(found.items()))


def _add_points(document, space, handed):
    for role, colour in COLOURS.items():
        document.layers.add(f"{POINTS}{role.upper()}", color=colour)
    document.layers.add("NUMBERS", color=7)
    size = _text_height(handed.coordinates[:, :2], handed.points["point_id"])
    block = document.blocks.new(BLOCK)
    # a circle alone: with a point beside it OGR, and so QGIS, would make a collection
    # of each reference, which nobody can draw
    block.add_circle((0, 0), size / 4)
    offset = (size / 2, size / 2)
    block.add_attdef(NUMBER, offset, dxfattribs={"height": size, "layer": "NUMBERS"})
    hidden = {"height": size, "flags": 1}  # invisible
    for tag in (HEIGHT, ERROR):
        block.add_attdef(tag, (0, 0), dxfattribs=hidden)
    points = handed.points
    errors = handed.errors_in_plan
    errors = np.full(len(points), np.nan) if errors is None else errors.to_numpy(float)
    places = np.column_stack([handed.coordinates[:, :2], np.nan_to_num(handed.heights)])
    columns = points["point_id"], points["role"], handed.heights, errors, places
    for name, role, height, error, place in zip(*columns, strict=True):
        layer = {"layer": f"{POINTS}{str(role).upper()}"}
        one = space.add_blockref(BLOCK, place, dxfattribs=layer)
        at = (place[0] + offset[0], place[1] + offset[1], place[2])
        shown = {"height": size, "layer": "NUMBERS"}
        one.add_attrib(NUMBER, str(name), at, dxfattribs=shown)
        for tag, value in ((HEIGHT, height), (ERROR, error)):
            if np.isfinite(value):
                said = {**layer, **hidden}
                one.add_attrib(tag, f"{value:.4f}", place, dxfattribs=said)


def _text_height(xy, names):
    """Height of numbers that leaves most of them apart [m], however long they are."""
    distance = _distance_of_neighbours(xy)
    longest = float(np.quantile([len(str(name)) for name in names], LONG_NAMES))
    most = WIDTH_SHARE / (WIDTH_OF_LETTER * max(longest, 1.0))
    return min(TEXT_SHARE, most) * distance


def _distance_of_neighbours(xy):
    """Distance at which points lie [m]: of their area, or less where they lie in rows.

    A road across its rectangle, or villages apart, fill little of the area.
    """
    area = float(np.prod(np.maximum(np.ptp(xy, axis=0), 1.0)))
    # double points have the nearest at nothing, and cover each other anyway
    cells = np.round(xy / (NEXT_TO_NOTHING * np.sqrt(area / len(xy))))
    xy = xy[np.unique(cells, axis=0, return_index=True)[1]]
    even = float(np.sqrt(area / len(xy)))
    if len(xy) < 2:
        return even
    nearest = cKDTree(xy).query(xy, k=2)[0][:, 1]
    close = FROM_NEAREST * float(np.quantile(nearest, LONG_NAMES))
    return float(np.clip(close, LEAST_OF_EVEN * even, even))


def _add_ellipses(document, space, handed):
    table = handed.table("ellipses")
    if table is None:
        return None
    axes = table[["semi_major", "semi_minor"]].to_numpy(dtype=float)
    xy = table[["easting", "northing"]].to_numpy(dtype=float)
    factor = exaggeration(xy, axes * [1.0, 0.0])
    layer = f"ELLIPSES_X{factor:g}"
    document.layers.add(layer, color=3)
    azimuth = table["azimuth_gon"].to_numpy(dtype=float) * RADIANS_PER_GON
    for place, (major, minor), along in zip(xy, axes, azimuth, strict=True):
        if not major > 0.0:
            continue
        way = factor * major * np.array([np.sin(along), np.cos(along), 0.0])
        ratio = float(np.clip(minor / major, 1e-6, 1.0))
        space.add_ellipse((*place, 0.0), way, ratio, dxfattribs={"layer": layer})
    level = float(table["confidence"].iloc[0])
    return f"ellipses of {level:.3g} drawn {factor:g} times as large, layer {layer}"


def _add_residuals(document, space, handed):
    table = handed.table("residuals")
    if table is None:
        return None
    points = handed.points.set_index("point_id")[["easting", "northing"]]
    start = points.reindex(table["point_id"]).to_numpy(dtype=float)
    columns = ["residual_easting", "residual_northing"]
    shift = table[columns].to_numpy(dtype=float)
    factor = exaggeration(handed.coordinates[:, :2], shift)
    is_whole = np.isfinite(start).all(axis=1) & np.isfinite(shift).all(axis=1)
    for flight in table["flight"].unique():
        layer = f"RESIDUALS_{flight.upper()}_X{factor:g}"
        document.layers.add(layer, color=1 if flight == "low_flight" else 8)
        is_in = is_whole & (table["flight"] == flight).to_numpy()
        ends = start[is_in] + factor * shift[is_in]
        for one, two in zip(start[is_in], ends, strict=True):
            space.add_line(one, two, dxfattribs={"layer": layer})
    drawn = int(is_whole.sum())
    note = f"{drawn} residual vectors drawn {factor:g} times as long"
    n_left = len(table) - drawn
    return f"{note}; {n_left} of points without a place left out" if n_left else note
