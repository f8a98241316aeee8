"""What follows from tables: which flight is the high one, units, scales, systems.

Every guess has its reason, which is shown to the user.
"""

from dataclasses import dataclass

import numpy as np

from einschalt.foundations.errors import ProjectionError
from einschalt.foundations.kept_texts import kept
from einschalt.foundations.language import mark_each
from einschalt.foundations.likely_systems import systems_over, systems_that_hold
from einschalt.foundations.points_elsewhere import islands_of
from einschalt.foundations.projections import read_source_crs
from einschalt.foundations.units import METRES_PER_UNIT
from einschalt.interfaces.new_block.looked_at import PITCH

# smallest and largest extent of a model that is usual [mm]: 6 cm to 46 cm wide
USUAL_MODEL_MM = (30.0, 700.0)
HIGH_WORDS = ("high", "hoch", "haut", "alto", "alta", "oben")
LOW_WORDS = ("low", "tief", "nieder", "bas", "unten")
ROUND = 0.005  # a scale number as near as that to one of two figures is meant to be it
LEAST_SHARED = 2  # points of a model that have a scale
MOST_ROWS = 200_000  # of a flight that are looked at
MM = 1e-3
A, E_SQUARED = 6_378_137.0, 0.00669438  # of WGS 84
AGAINST_GROUND = mark_each(
    {
        "model_id": "{n:model|models} against the ground: 1:{scale}",
        "image_id": "{n:image|images} against the ground: 1:{scale}",
    }
)


@dataclass(frozen=True)
class Guess:
    """A value, and why it is that."""

    value: object
    reason: str


def unit_of(frame):
    """Unit of model coordinates, by the extent of the widest model."""
    keys = [name for name in ("coverage", "model_id") if name in frame]
    groups = frame.groupby(keys, sort=False)[["x", "y"]]
    widest = float((groups.max() - groups.min()).max(axis=1).max())
    low, high = USUAL_MODEL_MM
    for unit in ("mm", "cm", "m", "um"):
        if low <= widest * METRES_PER_UNIT[unit] / MM <= high:
            return Guess(unit, f"the widest model extends over {widest:.4g} {unit}")
    return Guess("mm", f"the widest model extends over {widest:.4g} of them")


def scale_of(frame, ground, unit, key="model_id"):
    """Scale number by distances in the models and on the ground; None if there is none.

    ``ground``: point_id, easting, northing [m].
    """
    keys = [name for name in ("coverage", key) if name in frame]
    columns = [*keys, "point_id", "x", "y"]
    points = frame[columns].head(MOST_ROWS)
    placed = points.merge(ground[["point_id", "easting", "northing"]], on="point_id")
    ratios = _ratios(placed, keys, ("x", "y"), ("easting", "northing"))
    if not len(ratios):
        return None
    number = float(np.median(ratios)) / METRES_PER_UNIT[unit]
    said = kept(AGAINST_GROUND[key], n=len(ratios), scale=f"{number:.0f}")
    return Guess(rounded(number), said)


def on_a_plane(known):
    """Ground points with eastings and northings, local ones if they have degrees [m].

    Distances of 10 km are right within some 10 cm, as scales need them.
    """
    ground = known.frame
    if "easting" in ground:
        one = _of_one_system(ground)
        metres = _metres_per_unit(known.crs or known.said.crs)
        return one.assign(**{n: one[n] * metres for n in ("easting", "northing")})
    longitude, latitude = (np.radians(ground[n]) for n in ("longitude", "latitude"))
    middle = latitude.median()
    w = 1.0 - E_SQUARED * np.sin(middle) ** 2
    across, along = A / np.sqrt(w), A * (1.0 - E_SQUARED) / w**1.5
    return ground.assign(
        easting=across * np.cos(middle) * (longitude - longitude.median()),
        northing=along * (latitude - middle),
    )


def _metres_per_unit(crs):
    """Length of the unit of plane coordinates [m]; 1 where nothing tells it."""
    try:
        system = None if crs is None else read_source_crs(crs)
    except ProjectionError:  # said where the system is read
        return 1.0
    is_plane = system is not None and system.is_projected
    return system.axis_info[0].unit_conversion_factor if is_plane else 1.0


def _of_one_system(ground):
    """The points without islands in another system, of which check tells."""
    plan = ground[["easting", "northing"]].to_numpy(dtype=float)
    if not np.isfinite(plan).all():
        return ground
    islands = islands_of(plan, None)
    return ground if islands is None else ground[islands.number == islands.main]


def scale_beside(frame, unit, other, other_unit, other_scale):
    """Scale number of a flight by points that it shares with another one."""
    keys = ["coverage", "model_id"]
    one = frame[[*(k for k in keys if k in frame), "point_id", "x", "y"]]
    two = other.drop_duplicates("point_id") if "model_id" not in other else other
    first = two.groupby("point_id", sort=False)[["model_id", "x", "y"]].first()
    pairs = one.head(MOST_ROWS).merge(first, on="point_id", suffixes=("", "_other"))
    names = [name for name in (*keys, "model_id_other") if name in pairs]
    ratios = _ratios(pairs, names, ("x", "y"), ("x_other", "y_other"))
    if not len(ratios):
        return None
    metres = METRES_PER_UNIT[other_unit] / METRES_PER_UNIT[unit]
    number = float(np.median(ratios)) * metres * other_scale
    message = "{n:pair|pairs} of models of both flights: 1:{scale}"
    said = kept(message, n=len(ratios), scale=f"{number:.0f}")
    return Guess(rounded(number), said)


def _ratios(pairs, keys, small, large):
    """Size of each group in one system over that in another."""
    groups = pairs.groupby(keys, sort=False)
    spread = groups[[*small, *large]].var(ddof=0)
    n_points = groups.size()
    one = np.sqrt(spread[list(small)].sum(axis=1))
    other = np.sqrt(spread[list(large)].sum(axis=1))
    is_usable = (n_points >= LEAST_SHARED) & (one > 0.0) & (other > 0.0)
    return (other / one)[is_usable].to_numpy()


def rounded(number):
    """A scale number as flights have it: 15 000 for 15 012; less than 1 stays.

    >>> rounded(15_012.3), rounded(14_340.0), rounded(0.128)
    (15000.0, 14340.0, 0.128)
    """
    if number < 1.0:  # of degrees, say
        return number
    for figures in (2, 3):
        step = 10.0 ** (np.floor(np.log10(number)) - figures + 1)
        near = float(np.round(number / step) * step)
        if abs(near - number) <= ROUND * number / 10 ** (figures - 2):
            return near
    return float(np.round(number))


def flight_named(title):
    """Flight that the name of a file says; None where it says none."""
    small = title.casefold()
    is_high, is_low = (any(w in small for w in ws) for ws in (HIGH_WORDS, LOW_WORDS))
    if is_high == is_low:
        return None
    return "high_flight" if is_high else "low_flight"


def systems_of(ground):
    """Reference systems in which the middle of the points lies in the area of use."""
    is_plane = "easting" in ground
    axes = ["easting", "northing"] if is_plane else ["longitude", "latitude"]
    middle = ground[axes].median().to_numpy(dtype=float)
    return (systems_that_hold if is_plane else systems_over)(*middle)


def scale_of_pixels(table, camera, known, pitch):
    """Scale number of image points in pixels; None where their size is unknown."""
    pitch = camera.camera.get(PITCH, pitch)
    if not isinstance(pitch, (int, float)) or not pitch > 0.0:
        return None
    frame = table.frame.assign(x=table.frame["x"] * pitch, y=table.frame["y"] * pitch)
    return scale_of(frame, on_a_plane(known), "um", "image_id")
