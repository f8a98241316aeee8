"""Heights of the terrain below a planned flight."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from einschalt.foundations.errors import GeometryError
from einschalt.foundations.typesetting import count, number

LOWEST, HIGHEST = -500.0, 9000.0  # metres: of land on the Earth
FEWEST = 4  # heights in an area
MARGIN = 0.15  # of the area's extent, in which heights beside it are kept
MOST_KEPT = 250_000
FARTHEST_CELLS = 3.0  # from a place to the next height, in spacings of the heights


@dataclass(frozen=True, eq=False)
class GroundHeights:
    """Places with a height: a grid, or points."""

    plane: np.ndarray  # (n, 2): easting, northing [m]
    height: np.ndarray  # (n,): NaN where the file says that there is none [m]
    source: str

    def over(self, area) -> "GroundHeights":
        """Return what lies in an area; a sentence where something is missing there.

        GeometryError where no height lies in it, cells have none, or a height is none
        of the Earth's.
        """
        low, high = np.array(area.shape.bounds).reshape(2, 2)
        margin = MARGIN * (high - low)
        is_near = ((self.plane >= low - margin) & (self.plane <= high + margin)).all(1)
        is_in = np.zeros(len(self.plane), dtype=bool)
        is_in[is_near] = area.holds(area.to_local(self.plane[is_near]))
        found = int(is_in.sum())
        if found < FEWEST:
            raise GeometryError(
                f"{self.source}: {found or 'none'} of "
                f"{count(len(self.plane), 'height')} lies in the area",
                expected="heights of the whole area, in its system",
                remedy="Export the heights of this area in the system of the plan",
            )
        missing = int(np.isnan(self.height[is_in]).sum())
        if missing:
            raise GeometryError(
                f"{self.source}: {missing} of {count(found, 'place')} in the area have "
                "no height (nodata)",
                expected="a height everywhere in the area",
                remedy="Fill the gaps, as QGIS does with 'Fill nodata'",
            )
        self._require_land(self.height[is_in])
        # those beside it as well, where they are sound: cameras look there, too
        is_sound = (self.height >= LOWEST) & (self.height <= HIGHEST)
        kept = np.flatnonzero(is_in | (is_near & is_sound))
        kept = kept[:: max(1, len(kept) // MOST_KEPT)]
        return GroundHeights(self.plane[kept], self.height[kept], self.source)

    def _require_land(self, height):
        worst = height[np.argmax(np.abs(height - (LOWEST + HIGHEST) / 2.0))]
        if not LOWEST <= worst <= HIGHEST:
            raise GeometryError(
                f"{self.source}: a height of {worst:g} m stands in the area",
                expected=f"{LOWEST:g} to {HIGHEST:g} m",
                remedy="Does it stand for a missing one? Then declare it as nodata",
            )

    @cached_property
    def _tree(self):
        from scipy.spatial import KDTree  # noqa: PLC0415 - loaded when asked for

        return KDTree(self.plane)

    @cached_property
    def spacing(self) -> float:
        """Usual distance of a height from the next [m]."""
        step = max(1, len(self.plane) // 1000)
        return float(np.median(self._tree.query(self.plane[::step], k=2)[0][:, 1]))

    def require_cover(self, ground):
        """Refuse heights that leave places (n, 2) of the area without any near."""
        away = self._tree.query(ground)[0]
        most = FARTHEST_CELLS * max(self.spacing, 1.0)
        apart = number(self.spacing, 2)
        if away.max() > most:
            east, north = ground[int(np.argmax(away))]
            raise GeometryError(
                f"{self.source}: the nearest height to {east:.0f}, {north:.0f} in the "
                f"area is {number(away.max(), 2)} m away",
                expected=f"heights of the whole area, {apart} m apart",
                remedy="Export the heights of the whole area",
            )

    def mean_around(self, ground, reach):
        """Mean height within a reach [m] of places (n, 2); the nearest where none."""
        return self._around(ground, reach, np.mean)

    def highest_around(self, ground, reach):
        """Highest height within a reach [m] of places (n, 2)."""
        return self._around(ground, reach, np.max)

    def _around(self, ground, reach, of):
        from scipy.spatial import KDTree  # noqa: PLC0415 - loaded when asked for

        ground = np.asarray(ground, dtype=float)
        nearest = self.height[self._tree.query(ground)[1]]
        # so many that some hundred lie in reach
        step = max(1, int(np.pi * reach**2 / max(self.spacing, 1e-3) ** 2 / 300))
        tree, height = KDTree(self.plane[::step]), self.height[::step]
        held = tree.query_ball_point(ground, reach)
        return np.array(
            [
                of(height[around]) if around else alone
                for around, alone in zip(held, nearest, strict=True)
            ]
        )

    @property
    def range(self):
        """Lowest and highest [m]."""
        return float(self.height.min()), float(self.height.max())
