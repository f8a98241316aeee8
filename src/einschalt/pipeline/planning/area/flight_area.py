"""The area that a flight plan covers, in the axes of its strips."""

import re
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from einschalt.foundations.arguments import described
from einschalt.foundations.errors import GeometryError
from einschalt.foundations.language import figure, mark, translated
from einschalt.foundations.projections import degrees_of, label_of, read_crs
from einschalt.foundations.typesetting import number
from einschalt.pipeline.simulation.layout import turn

if TYPE_CHECKING:
    import shapely

LONGEST = 500_000.0  # metres
FARTHEST = 1e8  # metres from the origin: beyond it numbers are no coordinates
LEAST_AREA = 1.0  # m²
M2_PER_KM2 = 1e6
AS_LONG = 1e-6  # of a side: sides of a square differ by less
PLACE = re.compile(r"\[(\S+) (\S+)\]")  # what GEOS writes behind what is faulty
MOST_PLACES = 250_000  # of a lattice over the rectangle around an area


@dataclass(frozen=True, eq=False)
class FlightArea:
    """A polygon, or several, in a plane system [m].

    Strips run along the longer side of the narrowest rectangle around it. *Local* is:
    from the centre of that rectangle, along the strips and to the left of them.
    """

    shape: "shapely.Polygon | shapely.MultiPolygon"
    crs: str | None = None
    # what was done to it before, in sentences
    notes: tuple[str, ...] = ()

    def __post_init__(self):
        """Check what no flight can be planned over."""
        if self.crs is not None:
            read_crs(self.crs)
        _check(self.shape, self.crs)

    @cached_property
    def _frame(self):
        """Centre (2,), direction of the strips [rad], half extent (2,)."""
        import shapely  # noqa: PLC0415 - loaded when an area is planned

        # far from the origin the rectangle would be some millimetres away
        low = np.array(self.shape.bounds[:2])
        near = shapely.transform(self.shape, lambda places: places - low)
        around = shapely.minimum_rotated_rectangle(near)
        corners = shapely.get_coordinates(around)[:4]
        sides = np.diff(corners[:3], axis=0)
        lengths = np.hypot(*sides.T)
        directions = np.arctan2(*sides[:, ::-1].T)
        # the same strips, flown from the west or from the south
        directions = (directions + np.pi / 2 - 1e-9) % np.pi - np.pi / 2 + 1e-9
        direction = float(directions[np.argmax(lengths)])
        if np.ptp(lengths) <= AS_LONG * lengths.max():
            # its last digits do not choose: of a square the side nearer to the east
            direction = float(min(directions, key=_from_the_east))
        half = np.array([lengths.max(), lengths.min()]) / 2.0
        return corners.mean(axis=0) + low, direction, half

    @property
    def direction(self) -> float:
        """Direction of the strips, from the east to the left [rad]."""
        return self._frame[1]

    @property
    def azimuth(self) -> float:
        """Direction of the strips, from the north to the right [degrees]."""
        return float(np.degrees(np.pi / 2 - self.direction) % 360.0)

    @property
    def extent(self) -> tuple[float, float]:
        """Length along the strips, and width across them [m]."""
        length, width = (2.0 * self._frame[2]).tolist()
        return length, width

    @property
    def square_km(self) -> float:
        """Size [km²]."""
        return float(self.shape.area) / M2_PER_KM2

    @cached_property
    def local_shape(self) -> "shapely.Polygon | shapely.MultiPolygon":
        """The polygon in local axes [m]."""
        import shapely  # noqa: PLC0415 - loaded when an area is planned

        return shapely.transform(self.shape, self.to_local)

    @property
    def border(self) -> np.ndarray:
        """Easting, northing of its corners (n, 2) [m]."""
        import shapely  # noqa: PLC0415 - loaded when an area is planned

        return shapely.get_coordinates(self.shape)

    def places(self, n: float) -> np.ndarray:
        """Easting, northing of about ``n`` places, evenly spread over it (…, 2) [m]."""
        length, width = self.extent
        step = np.sqrt(max(self.shape.area / n, length * width / MOST_PLACES))
        axes = [
            (np.arange(np.ceil(side / step)) + 0.5) * side / np.ceil(side / step)
            - side / 2.0
            for side in self.extent
        ]
        local = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
        return self.to_ground(local[self.holds(local)])

    def to_local(self, ground: ArrayLike) -> np.ndarray:
        """Bring easting, northing (n, 2) into local axes (n, 2) [m]."""
        centre, direction, _ = self._frame
        return turn(np.asarray(ground, dtype=float) - centre, -direction)

    def to_ground(self, local: ArrayLike) -> np.ndarray:
        """Bring local positions (n, 2) to easting, northing (n, 2) [m]."""
        centre, direction, _ = self._frame
        return turn(np.asarray(local, dtype=float), direction) + centre

    def holds(self, local: ArrayLike) -> np.ndarray:
        """Tell which local positions (n, 2) lie in the area or on its border, (n,)."""
        import shapely  # noqa: PLC0415 - loaded when an area is planned

        shapely.prepare(self.local_shape)
        return shapely.intersects_xy(self.local_shape, *np.asarray(local).T)

    def _place(self):
        """Where it lies, as text: a look at it shows that coordinates are exchanged.

        None where its system is not known, or is none of the Earth's.
        """
        if self.crs is None:
            return None
        # of one part a point inside, of several the middle of them all
        is_one = self.shape.geom_type == "Polygon"
        there = self.shape.representative_point() if is_one else self.shape.centroid
        degrees = degrees_of(there.x, there.y, read_crs(self.crs))
        if not np.isfinite(degrees).all():
            return None
        longitude, latitude = (figure(one, ".3f") for one in degrees)
        message = mark("about latitude {latitude}°, longitude {longitude}°")
        return translated(message, latitude=latitude, longitude=longitude)

    def describe(self) -> str:
        """Say how large it is, where, and what it is made of."""
        import shapely  # noqa: PLC0415 - loaded when an area is planned

        parts = shapely.get_parts(self.shape)
        n_holes = int(shapely.get_num_interior_rings(parts).sum())
        length, width = self.extent
        sides = number(length, 3), number(width, 3)
        said = [
            translated("Area of {area} km²", area=number(self.square_km, 3)),
            translated("within {length} x {width} m", length=sides[0], width=sides[1]),
        ]
        if (place := self._place()) is not None:
            said.insert(1, place)
        if len(parts) > 1:
            said.append(translated("in {n:part|parts}", n=len(parts)))
        if n_holes:
            message = mark("with {n:hole|holes} where no point is wanted")
            said.append(translated(message, n=n_holes))
        return translated(
            "{area}; strips at an azimuth of {azimuth}°.",
            area=", ".join(said),
            azimuth=f"{self.azimuth:.0f}",
        )


def _from_the_east(direction):
    """How far a direction is from the east; of two alike the one to its left."""
    return round(abs(direction), 6), -direction


def _check(shape, crs):
    import shapely  # noqa: PLC0415 - loaded when an area is planned

    if not isinstance(shape, shapely.Geometry):
        found = described(shape)
    else:
        found = "empty" if shape.is_empty else f"a {shape.geom_type}"
    if found not in {"a Polygon", "a MultiPolygon"}:
        raise GeometryError(
            f"the area is {found}",
            expected="a polygon, or several",
            remedy="Draw the border of the area as a polygon",
        )
    xy = shapely.get_coordinates(shape)
    if not np.isfinite(xy).all() or np.abs(xy).max() > FARTHEST:
        raise GeometryError(
            "the area has corners that are no coordinates in metres",
            expected=f"numbers up to {FARTHEST:g} m",
            remedy="Export the area again",
        )
    if not shape.is_valid:
        raise GeometryError(
            _fault_of(shapely.is_valid_reason(shape), crs),
            expected="rings that neither cross nor touch themselves",
            remedy="Mend it in QGIS with 'Fix geometries', or draw it again",
        )
    longest = float(np.ptp(xy, axis=0).max())
    if longest > LONGEST:
        raise GeometryError(
            f"the area is {number(longest / 1e3, 3)} km long",
            expected=f"at most {LONGEST / 1e3:g} km",
            remedy="Plan it in parts; or is its system another one?",
        )
    if shape.area < LEAST_AREA:
        raise GeometryError(
            f"the area is {number(shape.area, 2)} m² large",
            expected="an area for several photographs, in metres",
            remedy="Is it in kilometres or degrees? Export it with its system",
        )


def _fault_of(reason, crs):
    """Say it in words of the field; GEOS says "Self-intersection[4.5 2.25]"."""
    place = PLACE.search(reason)
    if place is None:
        return "the border of the area is faulty"
    east, north = (f"{float(one):.2f}" for one in place.groups())
    # a file in degrees was brought into a zone of UTM, whose coordinates it has not
    where = f"{east}, {north}" + ("" if crs is None else f" ({label_of(crs)})")
    if "self-intersection" in reason.lower():
        return f"the border of the area crosses or touches itself at {where}"
    return f"the border of the area is faulty at {where}"
