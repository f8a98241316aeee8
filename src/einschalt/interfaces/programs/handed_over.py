"""What is handed over to other programs: a result, from memory or from its folder."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path

import numpy as np
import pandas as pd

from einschalt.foundations.errors import FileError
from einschalt.foundations.frame_columns import PLAN
from einschalt.foundations.projections import crs_name
from einschalt.interfaces.files.result_folder import TABLE_NAMES, tables_of
from einschalt.interfaces.files.written_files import PROVENANCE
from einschalt.interfaces.programs.foreign import MOST_FULL
from einschalt.interfaces.provenance import created_now
from einschalt.interfaces.publication.published_results import provenance_in

BY_AXIS = [f"standard_error_{axis}" for axis in (*PLAN, "height")]
BETWEEN_AXES = {
    (0, 1): "covariance_en",
    (0, 2): "covariance_eh",
    (1, 2): "covariance_nh",
}
UNCHANGED = 1.0 + 1e-9  # but for rounding


@dataclass(frozen=True, eq=False)
class HandedOver:
    """The tables of a result, with all that other programs ask of them.

    Attributes
    ----------
    name : str
        Of the block.
    crs : str or None
        System of the coordinates.
    created : str
        When the result was computed: date and time, ISO 8601.
    tables : dict of str to DataFrame
        As they stand in the folder of the results, the empty ones left out.
    covariances : callable or None
        Of the number of coordinates of a point: gives the covariance of all
        coordinates, point after point, (n_points · n, n_points · n) [m²].
    """

    name: str
    crs: str | None
    created: str
    tables: dict
    covariances: Callable | None = None

    @property
    def points(self):
        """Points, one row each."""
        return self.tables["points"]

    def table(self, name):
        """Return a table, or None where the result has none of that name."""
        return self.tables.get(name)

    @property
    def is_spatial(self):
        """Whether the points have heights with standard errors."""
        return {"height", BY_AXIS[2]} <= set(self.points)

    @cached_property
    def coordinates(self):
        """Easting, northing [, height where it has a standard error], (n, 2 or 3)."""
        names = [*PLAN, "height"] if self.is_spatial else PLAN
        return self.points[names].to_numpy(dtype=float)

    @cached_property
    def heights(self):
        """Height of each point, NaN where it has none, (n,)."""
        if "height" not in self.points:
            return np.full(len(self.points), np.nan)
        return self.points["height"].to_numpy(dtype=float)

    @property
    def errors_in_plan(self):
        """Standard error of each point to believe, TOTAL [m], or None (Series)."""
        points = self.points
        return points.get("standard_error_checked", points.get("standard_error_total"))

    @property
    def errors_in_height(self):
        """Standard error of each height to believe [m], or None (Series)."""
        return self.points.get(f"{BY_AXIS[2]}_checked", self.points.get(BY_AXIS[2]))

    @cached_property
    def enlargement(self):
        """How many times larger than propagated errors are, (n, 2 or 3), at least 1.

        As far as measurements exceed the stated precision: by those to believe.
        """
        plan = self._ratio("standard_error_checked", "standard_error_total")
        if not self.is_spatial:
            return np.column_stack([plan, plan])
        return np.column_stack(
            [plan, plan, self._ratio(f"{BY_AXIS[2]}_checked", BY_AXIS[2])]
        )

    def _ratio(self, believed, propagated):
        if not {believed, propagated} <= set(self.points):
            return np.ones(len(self.points))
        sizes = self.points[[believed, propagated]].to_numpy(dtype=float)
        is_known = np.isfinite(sizes).all(axis=1) & (sizes[:, 1] > 0.0)
        ratio = sizes[is_known, 0] / sizes[is_known, 1]
        found = np.ones(len(sizes))
        found[is_known] = np.maximum(ratio, 1.0)
        return found

    @property
    def told_enlargement(self):
        """Notes that errors are enlarged, one or none."""
        largest = float(self.enlargement.max(initial=1.0))
        if not largest > UNCHANGED:
            return []
        note = (
            f"standard errors are enlarged, by up to {largest:.3g} times, since the "
            "measurements exceed the stated precision"
        )
        return [note]

    def covariance_of_points(self):
        """Covariance of each point by itself, (n, 2, 2) or (n, 3, 3) [m²]; or None."""
        names = BY_AXIS if self.is_spatial else BY_AXIS[:2]
        if not {*names, "covariance_en"} <= set(self.points):
            return None
        found = np.zeros((len(self.points), len(names), len(names)))
        for axis, name in enumerate(names):
            found[:, axis, axis] = self.points[name].to_numpy(dtype=float) ** 2
        for (one, two), name in BETWEEN_AXES.items():
            if two < len(names) and name in self.points:
                found[:, one, two] = found[:, two, one] = self.points[name]
        return found

    def covariance(self):
        """Tell the covariance of the coordinates: Covariance.

        The full one where the result is in memory, and not too large; otherwise that of
        each point by itself. With errors to believe: ``enlargement`` on both sides.
        """
        own = self.covariance_of_points()
        if own is None:
            raise FileError(
                "the points have no standard errors of their coordinates",
                expected="a result whose errors were propagated",
                remedy="Give the precision of control and flights in the block",
                file=self.name,
            )
        times = self.enlargement
        own = own * times[:, :, None] * times[:, None, :]
        if self.covariances is None or self.coordinates.size > MOST_FULL:
            return Covariance(own)
        full = self.covariances(self.coordinates.shape[1])
        return Covariance(own, full * np.outer(times, times))


@dataclass(frozen=True, eq=False)
class Covariance:
    """What is known of the errors of all coordinates [m²]."""

    own: np.ndarray  # of each point by itself, (n_points, n, n)
    full: np.ndarray | None = None  # (n_points · n, n_points · n), or None

    def __str__(self):
        """Say how much of it is known."""
        if self.full is not None:
            return "full covariance of all coordinates"
        width = self.own.shape[1]
        return f"covariance of each point by itself ({width} x {width} blocks)"

    def turned(self, jacobian):
        """Covariance of coordinates that come of these by derivatives (n_points, n, n).

        Row the new coordinate, column the old one.
        """
        own = jacobian @ self.own @ np.swapaxes(jacobian, 1, 2)
        if self.full is None:
            return Covariance(own)
        n_points, width, _ = own.shape
        blocks = self.full.reshape(n_points, width, n_points, width)
        # one side after the other: of all four indices at once it takes minutes
        half = np.einsum("iab,ibjc->iajc", jacobian, blocks)
        whole = np.einsum("iajc,jdc->iajd", half, jacobian)
        return Covariance(own, whole.reshape(self.full.shape))


def of_result(result) -> HandedOver:
    """Take a result from memory, with the covariances between its points."""
    # they stay in the system of the block
    can_tell = result.errors is not None and result.output_system is None
    covariances = partial(_full, result.errors) if can_tell else None
    name = None if result.crs is None else crs_name(result.crs)
    tables = tables_of(result)
    return HandedOver(result.block.name, name, created_now(), tables, covariances)


def _full(errors, width):
    """Covariance of all coordinates of the points, symmetric."""
    n_points = len(errors.point_ids)
    one, two = np.triu_indices(n_points)
    between = errors.covariance_at(np.column_stack([one, two]))
    whole = np.empty((n_points, width, n_points, width))
    whole[one, :, two, :] = between[:, :width, :width]
    whole[two, :, one, :] = np.swapaxes(between[:, :width, :width], 1, 2)
    return whole.reshape(n_points * width, n_points * width)


def of_folder(folder) -> HandedOver:
    """Take a result from the folder that ``einschalt densify`` has written."""
    folder = Path(folder)
    facts = provenance_in(folder)
    if "command" in facts:
        raise FileError(
            f"is of einschalt {facts['command']}",
            expected="results of einschalt densify",
            remedy="Name the folder that densify was given as --output",
            file=folder / PROVENANCE,
        )
    tables = {}
    for name in TABLE_NAMES:
        path = folder / f"{name}.parquet"
        if path.exists():
            table = pd.read_parquet(path)
            tables |= {name: table} if len(table) else {}
    if "points" not in tables:
        raise FileError(
            "points.parquet is missing, or has no rows",
            expected="the results of einschalt densify",
            remedy="Compute them again",
            file=folder,
        )
    block = facts.get("block") or {}
    crs = (facts.get("output") or block).get("crs")
    created = str(facts.get("created") or "")
    return HandedOver(block.get("name") or folder.name, crs, created, tables)
