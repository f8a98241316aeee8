"""Heights of the terrain below a planned flight."""

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import ArrayLike

from einschalt.foundations.batches import n_cores
from einschalt.foundations.errors import GeometryError
from einschalt.foundations.kept_texts import kept
from einschalt.foundations.projections import label_of
from einschalt.foundations.typesetting import number
from einschalt.pipeline.planning.ground.height_lattice import (
    HeightLattice,
    HeightTriangles,
    spans_a_surface,
)

if TYPE_CHECKING:
    import shapely

LOWEST, HIGHEST = -500.0, 9000.0  # metres: of land on the Earth
LARGEST_ANGLE = 360.0
IN_DEGREES = (
    "These look like degrees: export the heights in a system in metres, such as that "
    "of the plan"
)
FEWEST = 4  # heights in an area
# as far beside an area heights are kept: of its extent, and at least [m]; photographs
# are taken there, and lines lead over it
MARGIN, LEAST_MARGIN = 1.0, 5000.0
MOST_KEPT, PART_BESIDE = 250_000, 0.5
MOST_IN_REACH = 300  # cells of which a mean or a peak is taken
FARTHEST_CELLS = 3.0  # from a place to the next height, in spacings of the heights
PLACES_IN_AREA = 4000  # at which heights are wanted
PLACES_ON_BORDER = 2000
FAR_ABOVE_ZERO = 30.0  # metres: where the land comes down to the sea, some lie between


class CoveredArea(Protocol):
    """The area of which heights are wanted: a FlightArea."""

    shape: "shapely.Polygon | shapely.MultiPolygon"
    crs: str | None

    @property
    def border(self) -> np.ndarray:
        """Easting, northing of its corners (n, 2) [m]."""

    def places(self, n: float) -> np.ndarray:
        """Easting, northing of about ``n`` places over it (…, 2) [m]."""

    def to_local(self, ground: ArrayLike) -> np.ndarray:
        """Bring easting, northing (n, 2) into its axes (n, 2) [m]."""

    def holds(self, local: ArrayLike) -> np.ndarray:
        """Tell which local positions (n, 2) lie in it, (n,)."""


@dataclass(frozen=True, eq=False)
class GroundHeights:
    """Places with a height: a grid, or points; in an area, or anywhere."""

    plane: np.ndarray  # (n, 2): easting, northing [m]
    height: np.ndarray  # (n,): NaN where the file says that there is none [m]
    source: str
    # (n, 2): lowest and highest of those that each height is the mean of; None where
    # every height stands for itself [m]
    extremes: np.ndarray | None = None
    # those near an area: cameras fly over them as well, and heights at its border are
    # interpolated with them; they count for nothing else
    beside: "GroundHeights | None" = None
    at_border: tuple[float, float] | None = None  # lowest and highest, of an area [m]
    # these and those beside, once they were put together
    together: "GroundHeights | None" = None
    # of those in an area, how many are exactly 0 far below all others, and the lowest
    # of these [m]; they may stand for missing ones
    zeros: tuple[int, float] | None = None

    def over(self, area: CoveredArea) -> "GroundHeights":
        """Return what lies in an area, and beside it what lies near.

        GeometryError where no height lies in it, cells have none, or a height is none
        of the Earth's.
        """
        low, high = np.array(area.shape.bounds).reshape(2, 2)
        margin = max(MARGIN * float(np.max(high - low)), LEAST_MARGIN)
        is_near = ((self.plane >= low - margin) & (self.plane <= high + margin)).all(1)
        is_in = np.zeros(len(self.plane), dtype=bool)
        is_in[is_near] = area.holds(area.to_local(self.plane[is_near]))
        found = int(is_in.sum())
        if not found:
            self._refuse_elsewhere(area)
        if found < FEWEST:
            raise GeometryError(
                f"{self.source}: {found} of {len(self.plane)} heights in the area",
                expected="heights of the whole area",
                remedy="Export the heights of the whole area",
            )
        missing = int(np.isnan(self.height[is_in]).sum())
        if missing:
            raise GeometryError(
                f"{self.source}: {missing} of {found} places in the area without a "
                "height (nodata)",
                expected="a height everywhere in the area",
                remedy="Fill the gaps, as QGIS does with 'Fill nodata'",
            )
        self._require_land(self.height[is_in])
        # those beside it only where they are sound
        is_sound = (self.height >= LOWEST) & (self.height <= HIGHEST)
        is_beside = is_near & is_sound & ~is_in
        held, beside = (
            GroundHeights(self.plane[rows], self.height[rows], self.source)
            for rows in (is_in, is_beside)
        )
        if is_in.sum() + is_beside.sum() > MOST_KEPT:
            held = held.at_most((1.0 - PART_BESIDE) * MOST_KEPT)
            beside = beside.at_most(PART_BESIDE * MOST_KEPT)
        beside = beside if is_beside.any() else None
        zeros = _zeros_far_below(self.height[is_in])  # before they are thinned
        found = replace(held, beside=beside, zeros=zeros)
        return found.with_border(area)

    def at_most(self, n: float) -> "GroundHeights":
        """Return the same, in cells where there are more than so many heights."""
        if len(self.plane) <= n:
            return self
        sides = np.ptp(self.plane, axis=0)
        # where they lie in one line, cells are pieces of it
        return self.in_cells(max(float(np.sqrt(sides.prod() / n)), sides.max() / n))

    def with_border(self, area: CoveredArea) -> "GroundHeights":
        """Return the same, which knows what lies on the border of an area."""
        import shapely  # noqa: PLC0415 - loaded when an area is planned

        step = max(area.shape.length / PLACES_ON_BORDER, self.spacing)
        border = shapely.get_coordinates(shapely.segmentize(area.shape, step))
        together = self._anywhere  # between which a surface is laid once
        below = together.lowest_at(border)
        at_border = float(below.min()), float(below.max())
        return replace(self, at_border=at_border, together=together)

    def in_cells(self, side: float) -> "GroundHeights":
        """Return one place for each square of a lattice, ``side`` [m] wide.

        It has the mean of its places and heights, and remembers their extremes: peaks
        count however coarse the lattice is.
        """
        low = self.plane.min(axis=0)
        column, row = np.floor((self.plane - low) / side).astype(np.int64).T
        cell = row * (column.max() + 1) + column
        n_held = np.bincount(cell)
        place = np.cumsum(n_held > 0)[cell] - 1
        n_held = n_held[n_held > 0]
        east, north, height = (
            np.bincount(place, values) / n_held
            for values in (*(self.plane - low).T, self.height)
        )
        lowest, highest = np.full(len(n_held), np.inf), np.full(len(n_held), -np.inf)
        np.minimum.at(lowest, place, self._extremes[:, 0])
        np.maximum.at(highest, place, self._extremes[:, 1])
        return GroundHeights(
            np.column_stack([east, north]) + low,
            height,
            self.source,
            np.column_stack([lowest, highest]),
        )

    @property
    def _extremes(self):
        if self.extremes is not None:
            return self.extremes
        return np.column_stack([self.height, self.height])

    def _refuse_elsewhere(self, area):
        """Say where the heights lie, and where the area does."""
        places = self.plane if len(self.plane) else np.full((1, 2), np.nan)
        (west, south), (east, north) = places.min(axis=0), places.max(axis=0)
        there, system = area.shape.bounds, "the system of the plan"
        if area.crs is not None:
            system = label_of(area.crs)
        raise GeometryError(
            f"{self.source}: none of {len(self.plane)} heights lies in the area: they "
            f"have eastings of {west:.0f} to {east:.0f} m and northings of {south:.0f} "
            f"to {north:.0f} m",
            expected=f"{there[0]:.0f} to {there[2]:.0f} m and {there[1]:.0f} to "
            f"{there[3]:.0f} m, in {system}",
            remedy=IN_DEGREES
            if np.abs(places).max() <= LARGEST_ANGLE
            else "Plan in the system of the heights with --crs, or export the "
            "heights of this area in that of the plan",
        )

    def _require_land(self, height):
        worst = height[np.argmax(np.abs(height - (LOWEST + HIGHEST) / 2.0))]
        if not LOWEST <= worst <= HIGHEST:
            raise GeometryError(
                f"{self.source}: a height of {worst:g} m stands in the area",
                expected=f"{LOWEST:g} to {HIGHEST:g} m",
                remedy="Does it stand for a missing one? Then declare it as nodata, or "
                "leave its line out",
            )

    def said_of_zeros(self) -> str:
        """Say that some are exactly 0, far below all others; "" where none is."""
        if self.zeros is None:
            return ""
        n_zeros, lowest = self.zeros
        message = (
            "{n:height of the terrain is|heights of the terrain are} exactly 0 m, the "
            "others {lowest} m and more: if they stand for missing ones, declare 0 as "
            "nodata and fill the gaps, or leave their lines out."
        )
        return kept(message, n=n_zeros, lowest=f"{np.floor(lowest):.0f}")

    @cached_property
    def _tree(self):
        from scipy.spatial import KDTree  # noqa: PLC0415 - loaded when asked for

        return KDTree(self.plane)

    @property
    def spacing(self) -> float:
        """Usual distance of a height from the next [m]."""
        return float(self._to_others[0])

    @property
    def mesh_size(self) -> float:
        """Side of the square that a height stands for, usually [m].

        Four others are as near: of a lattice exactly, of scattered heights on the
        average, the next of which is only half as far away.
        """
        # three or fewer have no fourth; one place stands for nothing around it
        return float(np.max(self._to_others, where=self._to_others < np.inf, initial=0))

    @cached_property
    def _to_others(self):
        """Usual distances to the next four, infinite where there are none [m]."""
        from scipy.spatial import KDTree  # noqa: PLC0415 - loaded when asked for

        places = np.unique(self.plane, axis=0)  # exports may overlap
        step = max(1, len(places) // 1000)
        away = KDTree(places).query(places[::step], k=5)[0]
        return np.median(away[:, 1:], axis=0)

    def require_cover(self, area: CoveredArea) -> None:
        """Refuse heights that leave the border of an area, or a place in it, bare.

        In the area scattered heights may be as far apart as their number lets expect.
        """
        n_held = max(int(area.holds(area.to_local(self.plane)).sum()), 1)
        expected = float(np.sqrt(area.shape.area / n_held))
        self._require_near(area.border, self.mesh_size)
        self._require_near(area.places(PLACES_IN_AREA), max(self.mesh_size, expected))

    def _require_near(self, ground, spacing):
        away = self._tree.query(ground)[0]
        apart = number(self.mesh_size, 2)
        if away.max() > FARTHEST_CELLS * max(spacing, 1.0):
            east, north = ground[int(np.argmax(away))]
            raise GeometryError(
                f"{self.source}: the nearest height to {east:.0f}, {north:.0f} in the "
                f"area is {number(away.max(), 2)} m away",
                expected=f"heights of the whole area, {apart} m apart",
                remedy="Export the heights of the whole area",
            )

    def mean_around(self, ground: ArrayLike, reach: float) -> np.ndarray:
        """Mean height within a reach [m] of places (n, 2), (n,) [m].

        The nearest where none lies so near.
        """
        heights = self._coarse_for(reach)
        return heights._around(ground, reach, heights.height, _means)

    def highest_around(self, ground: ArrayLike, reach: float) -> np.ndarray:
        """Highest height within a reach [m] of places (n, 2), (n,) [m]."""
        heights = self._coarse_for(reach)
        return heights._around(ground, reach, heights._extremes[:, 1], _maxima)

    def straight_below(self, ground: ArrayLike) -> np.ndarray:
        """Height at places (n, 2), interpolated linearly, (n,) [m].

        The nearest where none lie.

        Of cells the lowest: that is from where a height above ground is measured. Here
        heights beside an area count as well.
        """
        return self._anywhere.lowest_at(np.asarray(ground, dtype=float))

    @cached_property
    def _anywhere(self):
        """All heights together, those beside an area as well."""
        if self.together is not None:
            return self.together
        if self.beside is None:
            return self
        parts = self, self.beside
        plane, height, extremes = (
            np.concatenate(part)
            for part in zip(
                *((p.plane, p.height, p._extremes) for p in parts), strict=True
            )
        )
        return GroundHeights(plane, height, self.source, extremes)

    def at(self, ground: ArrayLike) -> np.ndarray:
        """Height at places (n, 2) [m], as :meth:`straight_below`, of cells the mean."""
        means = self._anywhere
        if means.extremes is not None:
            means = replace(means, extremes=None)
        return means.lowest_at(np.asarray(ground, dtype=float))

    def lowest_at(self, ground: np.ndarray) -> np.ndarray:
        """Height at places (n, 2) by these heights alone, of cells the lowest [m]."""
        if self._surface is None:
            height = np.full(len(ground), np.nan)
        else:
            height = self._surface(ground - self.plane.min(axis=0))
        is_beside = ~np.isfinite(height)
        if is_beside.any():
            nearest = self._tree.query(ground[is_beside])[1]
            height[is_beside] = self._extremes[nearest, 0]
        return height

    @cached_property
    def _surface(self):
        """What gives the height at places, from the least coordinates; or None."""
        plane, lowest = self.plane - self.plane.min(axis=0), self._extremes[:, 0]
        lattice = HeightLattice.of(plane, lowest)
        if lattice is not None:
            return lattice.at
        if not spans_a_surface(plane):
            return None
        return HeightTriangles.of(plane, lowest, self.spacing).at

    def _coarse_for(self, reach):
        """The same in cells of which some hundred lie in a reach."""
        side = reach * np.sqrt(np.pi / MOST_IN_REACH)
        if side <= self.spacing:
            return self
        # flights of one scale over the same area are laid again and again
        if side not in self._of_side:
            self._of_side[side] = self.in_cells(side)
        return self._of_side[side]

    @cached_property
    def _of_side(self):
        return {}

    def _around(self, ground, reach, height, of):
        ground = np.asarray(ground, dtype=float)
        found = height[self._tree.query(ground)[1]]
        held = self._tree.query_ball_point(ground, reach, workers=n_cores())
        n_held = np.fromiter(map(len, held), dtype=np.int64, count=len(held))
        is_any = n_held > 0
        around = np.fromiter(chain.from_iterable(held), np.int64, count=n_held.sum())
        start = np.cumsum(n_held[is_any]) - n_held[is_any]
        if len(start):
            found[is_any] = of(height[around], start, n_held[is_any])
        return found

    @property
    def range(self) -> tuple[float, float]:
        """Lowest and highest, at the border of an area as well [m]."""
        lowest, highest = self._extremes[:, 0].min(), self._extremes[:, 1].max()
        at_border = self.at_border or (np.inf, -np.inf)
        return float(min(lowest, at_border[0])), float(max(highest, at_border[1]))


def _zeros_far_below(height):
    """How many heights are exactly 0, and the lowest of the others; None if near."""
    others = height[height != 0.0]
    n_zeros = len(height) - len(others)
    if not n_zeros or not len(others) or others.min() < FAR_ABOVE_ZERO:
        return None
    return n_zeros, float(others.min())


def _means(values, start, count):
    """Mean of each part, none of which is empty."""
    return np.add.reduceat(values, start) / count


def _maxima(values, start, _):
    return np.maximum.reduceat(values, start)
