"""Sizes of the ground and of the models, and whether they fit each other.

A wrong unit is seen here before it becomes a coordinate: model points on the ground,
divided by the scale number, must have the size of an image.
"""

from numbers import Real

import numpy as np

from einschalt.foundations import tables
from einschalt.foundations.batches import segment_centred, segment_sum, segments_present
from einschalt.foundations.errors import ConsistencyError
from einschalt.foundations.frame_columns import values_of
from einschalt.foundations.given_digits import LEAST_SHARE, resolution_of
from einschalt.foundations.key_columns import row_codes
from einschalt.foundations.names import encode
from einschalt.foundations.typesetting import number
from einschalt.foundations.units import METRES_PER_UM, METRES_PER_UNIT
from einschalt.pipeline.block.ways_between_systems import standard_errors_of
from einschalt.stages.relative_orientation.image_units import unit_fault
from einschalt.stages.transformation_kinds import is_spatial
from einschalt.theory.adjustment.least_squares import SQRT2
from einschalt.theory.adjustment.tilted_planes import off_planes

MODEL_KEY = ("coverage", "model_id")
SMALLEST_IMAGE_M, LARGEST_IMAGE_M = 0.004, 0.8
SHARE_OF_IMAGE = 0.1
LARGEST_COORDINATE_M = 1e8
METRES_PER_DEGREE = 111_000.0  # of latitude; of longitude it is less
AXES = ("easting", "northing")
LARGEST_DIGIT_M = 1.0
OF_A_DIGIT = np.sqrt(2.0 / 12.0)  # what rounding leaves of it in plan, TOTAL
STEPS = (2, 5)  # of a grid, in the last digit
LARGEST_MODEL_MM = 5000.0
SMALLEST_MODEL_MM = 2.0
# known points of which one height is no chance, and relief that no error of z is
FEWEST_EQUAL = 4
LEAST_RELIEF = 1e-3
USUAL_MODEL_MM = (20.0, 2000.0)
MM_PER_UNIT = {unit: metres * 1e3 for unit, metres in METRES_PER_UNIT.items()}
PIXELS = (
    "Are they pixels? Name their camera: camera = 'camera.toml', a file with "
    "convention = 'mm', c (principal distance in mm), pixel_size_um, width and height "
    "(in pixels); otherwise give millimetres"
)
UNIT_WORDS = {
    "mm": "millimetres",
    "um": "micrometres",
    "m": "metres",
    "cm": "centimetres",
}


def extent_problems(frame, key, unit, file):
    """Say of the widest model or image that it cannot have the unit that is named."""
    keys = [frame[name] for name in ("coverage", key) if name in frame]
    extents, first = _extents(keys, values_of(frame, ["x", "y"]))
    # single points have no extent, so the flight is judged by its largest model
    widest = extents.max()
    place = int(first[extents == widest].min())
    extent = widest * MM_PER_UNIT[unit]
    if SMALLEST_MODEL_MM <= extent <= LARGEST_MODEL_MM or not extent > 0:
        return []
    facts = tables.row_location(frame, place)
    return [
        ConsistencyError(
            f"the widest {key.removesuffix('_id')} extends over {extent:.6g} mm",
            expected=f"{SMALLEST_MODEL_MM:g} to {LARGEST_MODEL_MM:g} mm",
            remedy=_remedy_of_one(float(np.median(extents)) * MM_PER_UNIT[unit])
            or _unit_remedy(widest, key == "model_id"),
            file=file,
            row=facts["row"],
            model=facts["model"],
        )
    ]


def lost_image_points(flight, is_lost, file):
    """Say of image points that they lie where no camera sees anything.

    ``is_lost`` (n_points,): of ``flight.image_points``.
    """
    points = flight.image_points

    def problem(place):
        column, row = points[["x", "y"]].iloc[place]
        return ConsistencyError(
            f"x {column:g}, y {row:g} lies where the distortion has no inverse",
            expected="a point within the image of the camera",
            remedy="Check the point, and the coefficients of the camera",
            file=file,
            **tables.row_location(points, place),
        )

    return tables.listed(np.flatnonzero(is_lost), problem, "so it is")


def image_size_problems(frame, distance, file):
    """Say of image coordinates that they are far too large or small for their camera.

    ``distance``: principal distance [mm], if that is a number.
    """
    problems = extent_problems(frame, "image_id", "mm", file)
    is_known = isinstance(distance, (int, float)) and 0.0 < distance < np.inf
    if problems or not is_known:  # which is said elsewhere
        return problems
    fault = unit_fault(values_of(frame, ["x", "y"]), distance)
    if fault is None:
        return []
    remedy = PIXELS if fault.are_pixels else fault.remedy
    facts = {"expected": fault.expected, "remedy": remedy, "file": file}
    return [ConsistencyError(fault.found, **facts)]


def _remedy_of_one(median_mm):
    """What to do where the others have the unit that is named; empty otherwise."""
    smallest, largest = USUAL_MODEL_MM
    if not smallest <= median_mm <= largest:
        return ""
    return (
        f"Half of the others extend over {median_mm:.4g} mm and more: is this one in "
        "another unit? Convert it"
    )


def _unit_remedy(widest, has_unit):
    """Guess in which unit the widest model was given."""
    smallest, largest = USUAL_MODEL_MM
    for unit, words in UNIT_WORDS.items():
        if smallest <= widest * MM_PER_UNIT[unit] <= largest:
            mend = f"Set model_unit = '{unit}'" if has_unit else "Give millimetres"
            return f"Did you give {words}? {mend}"
    return "Convert the coordinates to millimetres" if has_unit else PIXELS


def coordinate_problems(frame, file):
    """Ground coordinates that no plane system reaches."""
    plan = values_of(frame, ["easting", "northing"])
    places = np.flatnonzero((np.abs(plan) > LARGEST_COORDINATE_M).any(axis=1))
    return [
        ConsistencyError(
            f"easting {plan[place, 0]:g}, northing {plan[place, 1]:g}",
            expected=f"metres, at most {LARGEST_COORDINATE_M:g}",
            remedy="Correct the value",
            file=file,
            row=_row(frame, place),
            point=frame["point_id"].iloc[place],
        )
        for place in places[:1]
    ]


def scale_problems(name, flight, table, ground, file):
    """Models whose ground points cannot lie in one image of that scale.

    The median model is judged, so that a single wrong point does not stop a block.
    """
    names = encode(table["point_id"])
    # a table of points has each name once: its row is its place among them
    row = encode(ground["point_id"]).locate(names)[names.codes]
    is_placed = row >= 0
    if not is_placed.any():
        return []
    keys = [table[name][is_placed] for name in MODEL_KEY]
    plan = values_of(ground, ["easting", "northing"])[row[is_placed]]
    extent, _ = _extents(keys, plan)
    extent = extent[extent > 0.0]
    if not len(extent):
        return []
    typical = float(np.median(extent))
    scale_number, smallest = flight.scale_number, _smallest_image(flight)
    size = typical / scale_number
    if smallest <= size <= LARGEST_IMAGE_M:
        return []
    return [
        ConsistencyError(
            f"[{name}] the points of a model extend over {typical:.3g} m on the "
            f"ground, which is {size * 1e3:.3g} mm in an image 1:{scale_number:g}",
            expected=f"{smallest * 1e3:.2g} to {LARGEST_IMAGE_M * 1e3:g} mm",
            remedy="Correct scale_number, or give the coordinates in metres",
            file=file,
        )
    ]


def _smallest_image(flight):
    """Least that known points of a model can extend over in an image [m].

    Sensors are 6 mm wide, and models are parts of them: so for images it is a share of
    the photographs themselves.
    """
    if flight.image_points is None:
        return SMALLEST_IMAGE_M
    images = flight.image_coordinates()
    images = images[images["x"].notna()]
    if not len(images):
        return SMALLEST_IMAGE_M
    extent, _ = _extents([images["image_id"]], values_of(images, ["x", "y"]))
    share = SHARE_OF_IMAGE * float(np.median(extent)) / MM_PER_UNIT["m"]
    return min(SMALLEST_IMAGE_M, share) if share > 0.0 else SMALLEST_IMAGE_M


def _extents(keys, values):
    """Larger extent of each model along the axes, and its first row."""
    parts = segments_present(row_codes(keys))
    values, start = values[parts.order], parts.start[:-1]
    widest = np.fmax.reduceat(values, start) - np.fmin.reduceat(values, start)
    return widest.max(axis=1), parts.order[start]


def equal_height_problems(name, table, ground, file):
    """One height at all known points, where spatial models show relief: left out.

    Relief is what is left of z in the median model beside its tilt, by its width.
    """
    heights = ground["height"].dropna().to_numpy(dtype=float)
    if len(heights) < FEWEST_EQUAL or np.ptp(heights) > 0.0:
        return []
    known = table[table["point_id"].isin(ground["point_id"])]
    if known.empty or np.median(_reliefs(known)) < LEAST_RELIEF:
        return []
    return [
        ConsistencyError(
            f"all {len(heights)} points have height {heights[0]:g}, and the models of "
            f"the {name.replace('_', ' ')} show relief",
            expected="the height of each point",
            remedy="Give the heights; without them, set another transformation, such "
            "as 'affine'",
            file=file,
        )
    ]


def _reliefs(points):
    """Relief of each model by its width; 0 of what has too few points to tell."""
    parts = segments_present(row_codes([points[k] for k in MODEL_KEY if k in points]))
    xyz = values_of(points, ["x", "y", "z"])[parts.order]
    plan, z = xyz[:, :2], xyz[:, 2]
    left = off_planes(plan, z, parts.start)
    widths = np.abs(segment_centred(plan, parts.start)).max(axis=1)
    width = np.maximum.reduceat(widths, parts.start[:-1])
    relief = np.sqrt(segment_sum(left**2, parts.start) / parts.count)
    can_tell = (parts.count >= FEWEST_EQUAL) & (width > 0.0)
    return np.where(can_tell, relief / np.where(can_tell, width, 1.0), 0.0)


def _row(frame, place):
    label = frame.index[place]
    return int(label) if isinstance(label, (int, np.integer)) else None


def coarse_digits(frame, error, file, *, in_degrees=False):
    """Note points whose last digit is coarse beside their stated errors.

    Parameters
    ----------
    frame : DataFrame
        easting, northing as they were given.
    error : array_like or None
        TOTAL standard errors of the points, or of all of them [m].
    file : str
        Of the points.
    in_degrees : bool
        Whether these are longitude and latitude.

    Returns
    -------
    list of str
        One note, or none: a digit leaves 1/√12 of it in each coordinate.
    """
    stated = np.atleast_1d(np.asarray(np.nan if error is None else error, dtype=float))
    digit_of = resolution_of if in_degrees else _last_digit
    digits = np.array([digit_of(frame[axis]) for axis in AXES])
    sizes = digits
    if in_degrees:
        shrunk = np.cos(np.radians(np.nanmedian(frame["northing"])))
        sizes = METRES_PER_DEGREE * digits * [shrunk, 1.0]
    rounding = OF_A_DIGIT * np.hypot(*sizes) / SQRT2
    coarse = int(np.argmax(sizes))
    if in_degrees:
        shown = np.format_float_positional(digits[coarse], trim="-")
        what = f"coordinates have no digits below {shown} degrees"
    elif digits.min() == digits.max():
        what = f"coordinates have no digits below {digits[coarse]:.7g} m"
    else:
        what = f"{AXES[coarse]} has no digits below {digits[coarse]:.7g} m"
    return [
        f"{file}: {what}: rounding makes {rounding:.2g} m (total), beside a standard "
        f"error of {size:.2g} m: give more digits, or standard errors of {least:.2g} m"
        for size, least in _enlarged(stated, rounding)
    ]


def coarse_heights(frame, error, file):
    """As :func:`coarse_digits`, of the heights; ``error`` as there, of plan.

    With standard_error_height, where the points have it.
    """
    if "height" not in frame:
        return []
    stated = frame.get("standard_error_height")
    if stated is None:
        stated = np.nan if error is None else np.asarray(error, dtype=float) / SQRT2
    stated = np.atleast_1d(np.asarray(stated, dtype=float))
    digit = _last_digit(frame["height"])
    # a digit leaves 1/√12 of it
    rounding = digit * OF_A_DIGIT / SQRT2
    return [
        f"{file}: heights have no digits below {digit:.7g} m: rounding makes "
        f"{rounding:.2g} m, beside a standard error of {size:.2g} m: give more digits, "
        f"or standard_error_height of {least:.2g} m"
        for size, least in _enlarged(stated, rounding)
    ]


def _enlarged(stated, rounding):
    """Yield a stated error without rounding and with it, if rounding is larger."""
    stated = stated[np.isfinite(stated) & (stated > 0.0)]
    # an error that is as large may have rounding in it
    if stated.size and rounding > np.median(stated):
        size = float(np.median(stated))
        yield size, float(np.hypot(size, rounding))


def _last_digit(values):
    """Last digit of measured values [m]; 0 where they are places of a plan."""
    digit = resolution_of(values)
    return 0.0 if _step_of(values, digit) > LARGEST_DIGIT_M else digit


def _step_of(values, digit):
    """What nearly all of an axis are multiples of: last digits, or steps of a grid."""
    if digit == 0.0:
        return 0.0
    steps = values.dropna().to_numpy() / digit
    among = [
        times
        for times in STEPS
        if np.mean(np.abs(steps - times * np.round(steps / times)) < 0.5) > LEAST_SHARE
    ]
    return digit * max(among, default=1)


def _coarse_film_digits(frame, unit, m_g_um, file):
    """Note measured x, y whose last digit is coarse beside m_g: one note, or none.

    Of models in metres, which may have the size of the ground, nothing is said.
    """
    # other problems are told of what is no word, and no number
    is_known = isinstance(unit, str) and isinstance(m_g_um, Real)
    if not is_known or unit not in UNIT_WORDS or unit == "m":
        return []
    digit = min(resolution_of(frame[axis]) for axis in "xy") * METRES_PER_UNIT[unit]
    rounding = digit * OF_A_DIGIT / METRES_PER_UM
    if not rounding > m_g_um:
        return []
    digit = number(digit / METRES_PER_UM, 3)
    note = (
        f"{file}: coordinates have no digits below {digit} µm: rounding makes "
        f"{number(rounding)} µm (total), beside an m_g_um of {m_g_um:g}: give more "
        "digits"
    )
    return [note]


def digit_notes(block, checked, is_sound, file_of):
    """Note the tables of a block whose last digit is coarse beside stated errors.

    Parameters
    ----------
    block : Block
        With approximate_m_0_m.
    checked : dict
        Its parts, as they were checked.
    is_sound, file_of : callable
        Whether a table, by its name, has no faults; and the name of its file.

    Returns
    -------
    list of str
    """
    notes, m_0_m = [], getattr(block, "approximate_m_0_m", None)
    flights = (checked.get(name) for name in ("high_flight", "low_flight"))
    has_heights = any(map(is_spatial, flights))
    for name in ("control_points", "approximate_points"):
        if is_sound(name):
            known = None if name == "control_points" else m_0_m
            error = standard_errors_of(checked[name], known)
            error = None if isinstance(error, str | bool) else error
            notes += coarse_digits(checked[name], error, file_of(name))
            if has_heights:
                notes += coarse_heights(checked[name], error, file_of(name))
    for name in ("high_flight", "low_flight"):
        flight = checked.get(name)
        for part in ("model_points", "image_points"):
            if is_sound(f"{name}.{part}"):
                # of images as they were measured: with a camera in pixels, or distorted
                is_film = part == "model_points" or flight.camera is None
                unit = flight.model_unit if part == "model_points" else "mm"
                frame, file = getattr(flight, part), file_of(f"{name}.{part}")
                kind = flight.transformation
                if is_film and isinstance(kind, str | None) and kind != "rigid":
                    notes += _coarse_film_digits(frame, unit, flight.m_g_um, file)
    return notes
