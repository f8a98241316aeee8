"""After stage 3, if wanted: residuals distributed by a grid of shifts.

For many identical points of two frames, some of them wrong: what their neighbours share
is distributed, noise is not, and every point between has an ellipse that held-out
points confirm.
"""

from collections.abc import Iterable
from dataclasses import dataclass, fields

import numpy as np
import pandas as pd

from einschalt.foundations import typesetting
from einschalt.foundations.arguments import require_choice
from einschalt.foundations.errors import GeometryError, SettingsError
from einschalt.foundations.frame_columns import values_of
from einschalt.foundations.kept_texts import kept
from einschalt.foundations.language import figure, mark, mark_each, translated
from einschalt.stages.held_out_points import (
    DIFFERENCES,
    held_out_error,
    said_of_held_out,
    said_of_left_out,
    table_of_differences,
)
from einschalt.stages.stage3_model_transformation import ModelTransformation
from einschalt.stages.transformation_kinds import PLANE, TRANSFORMATION_KINDS

METHODS = ("collocation", "natural_neighbour")
DISTRIBUTED = mark_each(
    {
        "collocation": "residuals distributed by collocation, in grids of shifts",
        "natural_neighbour": "residuals distributed by natural neighbour, in grids of "
        "shifts",
    }
)
OUTLIERS = ("set_aside", "keep")
ERRORS = ["standard_error_easting", "standard_error_northing", "covariance_en"]
LEAST_WIDTH = 1e-6  # of a set of points, by its length
CONTRADICTS = "contradicts its neighbours"
STRAINS = "strains the grid so that it could not be undone"


@dataclass(frozen=True, eq=False, repr=False)
class GriddedTransformation(ModelTransformation):
    """Transformations with shifts that a grid holds, on top of an affine one.

    Its tables are those of the ModelTransformation that the residuals are of; but
    :meth:`transform` and :meth:`inverse` lead through the grids, and give NaN outside
    of them. Points that were transformed have an ellipse each:
    standard_error_easting, standard_error_northing, covariance_en [m, m²].

    Attributes
    ----------
    method : str
        "collocation" or "natural_neighbour".
    outliers : str
    grids : tuple of GriddedShifts or None
        One for each row of ``models``; None where it is not usable.
    left_out : DataFrame
        coverage, model_id, point_id, deviation (from what the others predict, in plan)
        [m], reason: identical points that are not distributed.
    """

    method: str
    outliers: str
    grids: tuple
    left_out: pd.DataFrame

    @property
    def distribution(self) -> pd.DataFrame:
        """What was distributed: a DataFrame with a row for each model.

        coverage, model_id, method, outliers, cell [m], n_rows, n_columns, noise (of a
        point by itself, per coordinate) [m], half_range (at which covariance has
        fallen to half) [m], freedom (of Student's t: small for long tails), n_left_out,
        share_wrong (of all points, as their tails say), within (share of the good
        held-out points in their 95 % ellipses, from which these have their size),
        within_all (of all, with those that were left out), interpolation_error (RMS,
        between nodes, against the method itself), interpolation_error_largest [m].
        """
        rows = [
            {"method": self.method, "outliers": self.outliers, **_facts(one)}
            for one in self.grids
        ]
        keys = self.models[["coverage", "model_id"]].reset_index(drop=True)
        return keys.join(pd.DataFrame(rows))

    @property
    def held_out(self) -> pd.DataFrame:
        """Identical points, each predicted from the others: DataFrame.

        coverage, model_id, point_id, difference_easting, difference_northing
        (predicted minus given) [m]; NaN for some that natural neighbours do not reach.
        """
        differences = np.full((len(self.observed.rows), 2), np.nan)
        for k, one in enumerate(self.grids):
            if one is not None:
                differences[_rows(self, k)] = one.differences
        return table_of_differences(self, differences)

    @property
    def held_out_good(self) -> pd.DataFrame:
        """The table :attr:`held_out`, NaN for points that were left out."""
        table = self.held_out
        for k, one in enumerate(self.grids):
            if one is not None:
                rows = np.arange(len(table))[_rows(self, k)]
                table.loc[rows[~one.trusted], DIFFERENCES] = np.nan
        return table

    def held_out_error(self, models: Iterable[int] | None = None) -> tuple[float, int]:
        """TOTAL RMS of good held-out points through the grid [m], and their number.

        Of all models, or of some (their rows). The points are predicted by the method
        itself; what the grid is off by from it comes on top.
        """
        models = range(len(self.grids)) if models is None else models
        differences = values_of(self.held_out_good, DIFFERENCES)
        squares, n_held = 0.0, 0
        for k in models:
            if self.grids[k] is not None:
                error, n = held_out_error(differences[_rows(self, k)])
                off = self.grids[k].interpolation_square
                squares += n * (error**2 + off) if n else 0.0
                n_held += n
        return (float(np.sqrt(squares / n_held)) if n_held else np.nan), n_held

    def _forward(self, place, xyz, _s_0):
        errors = self._ellipses(place, xyz)
        m_t = np.hypot(errors[ERRORS[0]], errors[ERRORS[1]])
        return self._through(place, xyz, "apply", 2), m_t

    def _backward(self, place, ground):
        return self._through(place, ground, "invert", 2)

    def _ellipses(self, place, xyz):
        covariances = self._through(place, xyz, "covariances", (2, 2))
        east, north = covariances[:, 0, 0], covariances[:, 1, 1]
        values = np.sqrt(east), np.sqrt(north), covariances[:, 0, 1]
        return dict(zip(ERRORS, values, strict=True))

    def _through(self, place, xy, way, shape):
        """What the grid of its model gives for each point."""
        found = np.full((len(xy), *np.atleast_1d(shape)), np.nan)
        order = np.argsort(place, kind="stable")
        start = np.searchsorted(place[order], np.arange(len(self.grids) + 1))
        for k, one in enumerate(self.grids):
            rows = order[start[k] : start[k + 1]]
            if one is not None and len(rows):
                found[rows] = getattr(one.grid, way)(xy[rows])
        return found

    def summary(self) -> str:
        """Add to the summary of the fit how its residuals are distributed."""
        lines = [translated(DISTRIBUTED[self.method])]
        table = self.distribution.dropna(subset="cell")
        for row in table.itertuples(index=False):
            name = "" if len(table) == 1 else f"{row.model_id}: "
            cells = translated(
                "cells of {cell} m ({rows} × {columns} nodes), between them {error} "
                "mm from the method itself (RMS; at most {largest})",
                cell=figure(row.cell, "g"),
                rows=f"{row.n_rows:.0f}",
                columns=f"{row.n_columns:.0f}",
                error=figure(row.interpolation_error * 1e3, ".2g"),
                largest=figure(row.interpolation_error_largest * 1e3, ".2g"),
            )
            lines.append(f"{name}{cells}")
        lines.append(said_of_held_out(*self.held_out_error()))
        lines.append(self._ellipses_hold())
        if len(self.left_out):
            lines.append(said_of_left_out(self.left_out))
        return "\n".join([super().summary(), *lines])

    def _ellipses_hold(self):
        known = [one.ellipses for one in self.grids if one is not None]
        good, each = (
            np.average([getattr(one, name) for one in known], weights=_n_held(known))
            for name in ("within", "within_all")
        )
        message = mark("{level} ellipses hold {share} of them, which makes their size")
        if len(self.left_out):
            message = mark(
                "{level} ellipses hold {share} of them, which makes their size; {each} "
                "with those left out"
            )
        shares = {"share": figure(good, ".1%"), "each": figure(each, ".1%")}
        return translated(message, level=typesetting.per_cent(0.95), **shares)


def _n_held(ellipses):
    return [one.n_held_out for one in ellipses]


def _rows(fit, k):
    return slice(fit.observed.start[k], fit.observed.start[k + 1])


def _facts(one):
    if one is None:
        return {}
    grid, covariance = one.grid, one.collocation.covariance
    n_rows, n_columns = grid.variances.shape
    return {
        "cell": grid.cell,
        "n_rows": n_rows,
        "n_columns": n_columns,
        "noise": np.sqrt(covariance.nugget),
        "half_range": covariance.half_range,
        "freedom": one.ellipses.tails.freedom,
        "n_left_out": int((~one.trusted).sum()),
        "share_wrong": one.ellipses.tails.share_wrong,
        "within": one.ellipses.within,
        "within_all": one.ellipses.within_all,
        "interpolation_error": one.interpolation[0],
        "interpolation_error_largest": one.interpolation[1],
    }


def distribute_in_grid(
    fit, method, *, outliers="set_aside", cell=None
) -> GriddedTransformation:
    """Distribute the residuals of a transformation by a grid of shifts.

    Parameters
    ----------
    fit : ModelTransformation
        In plan. Weights of its points do not count here.
    method : {"collocation", "natural_neighbour"}
    outliers : {"set_aside", "keep"}
        Whether identical points that contradict their neighbours are left out. Kept
        ones count in the ellipses like all others.
    cell : float or ndarray, optional
        Width of the cells [m], of each model; chosen where left out.

    Raises
    ------
    SettingsError
        The transformation is spatial, or a word is unknown.
    GeometryError
        A model has too few points, or no grid of it leads back.
    """
    require_choice("method", method, METHODS)
    require_choice("outliers", outliers, OUTLIERS)
    if TRANSFORMATION_KINDS[fit.kind].target != PLANE[1]:
        raise SettingsError(
            f"residuals of {fit.kind} are to be distributed by {method}",
            expected="a transformation in plan: affine, helmert or rigid",
        )
    is_usable = fit.models["is_usable"].to_numpy()
    cells = np.broadcast_to(cell, len(is_usable)) if cell is not None else None
    grids = tuple(
        _made(fit, k, method, outliers, None if cells is None else float(cells[k]))
        if is_usable[k]
        else None
        for k in range(len(is_usable))
    )
    return GriddedTransformation(
        **{each.name: getattr(fit, each.name) for each in fields(ModelTransformation)},
        method=method,
        outliers=outliers,
        grids=grids,
        left_out=_left_out(fit, grids),
    )


def _made(fit, k, method, outliers, cell):
    # compiled code and scipy.optimize, for which nobody else shall wait
    from einschalt.theory.residual_distribution.gridded_shifts import (  # noqa: PLC0415
        LEAST_POINTS,
        gridded_shifts,
    )

    rows = _rows(fit, k)
    source, target = fit.observed.source[rows], fit.observed.target[rows]
    model = fit.models["model_id"].iloc[k]
    if len(source) < LEAST_POINTS:
        found = kept("{n:identical point|identical points}", n=len(source))
        raise GeometryError(
            f"{found} to be distributed by {method}",
            expected=f"{LEAST_POINTS} or more: fewer do not tell how alike neighbours "
            "are",
            remedy="Distribute them in triangles",
            model=model,
        )
    if any(_is_line(points) for points in (source, target)):
        raise GeometryError(
            f"its identical points lie on a line, and {method} needs an area",
            expected="points off the line as well",
            remedy="Take the transformation without distribution (none), or add points",
            model=model,
        )
    made = gridded_shifts(
        source, target, method, keep_wrong=outliers == "keep", cell=cell
    )
    if made is not None:
        return made
    raise GeometryError(
        "no grid of its residuals leads back to where it came from",
        expected="identical points that lie in the same order in both frames",
        remedy="See whether easting and northing are exchanged in one of them, or take "
        "wider cells",
        model=model,
    )


def _is_line(points):
    """Whether points (n, 2) are so near to a line that nothing across it is known."""
    extent = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return extent[1] <= LEAST_WIDTH * extent[0]


def _left_out(fit, grids):
    parts = [fit.observed.rows.iloc[:0].assign(deviation=0.0, reason="")]
    for k, one in enumerate(grids):
        if one is None:
            continue
        places = np.flatnonzero(~one.trusted)
        parts.append(
            fit.observed.rows.iloc[fit.observed.start[k] + places].assign(
                deviation=np.hypot(*one.differences[places].T),
                reason=np.where(one.straining[places], STRAINS, CONTRADICTS),
            )
        )
    return pd.concat(parts, ignore_index=True)


def with_grids(fit, distribution):
    """A GriddedTransformation again, from its table ``distribution``.

    ``fit``: the ModelTransformation, of the same identical points.
    """
    first = distribution.dropna(subset="cell").iloc[0]
    cells = distribution["cell"].to_numpy(dtype=float)
    return distribute_in_grid(
        fit, first["method"], outliers=first["outliers"], cell=cells
    )
