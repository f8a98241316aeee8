"""After stage 3, if wanted: residuals distributed in triangles of identical points.

For a change of the national frame, or of an old network: every identical point goes
where it was measured, and those between follow, linear in each triangle.
"""

import itertools
from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from einschalt.foundations import typesetting
from einschalt.foundations.arguments import require_choice
from einschalt.foundations.errors import (
    GeometryError,
    SettingsError,
    TableError,
    name_some,
)
from einschalt.foundations.frame_columns import MODEL, values_of
from einschalt.foundations.language import mark, translated
from einschalt.foundations.tables import with_coverage
from einschalt.stages.held_out_points import (
    DIFFERENCES,
    held_out_error,
    said_of_held_out,
    said_of_left_out,
    table_of_differences,
)
from einschalt.stages.stage3_model_transformation import ModelTransformation
from einschalt.stages.transformation_kinds import PLANE, TRANSFORMATION_KINDS
from einschalt.theory.adjustment.significance import GROSS_ERROR_SIGNIFICANCE
from einschalt.theory.triangulation.held_out_points import held_out_differences
from einschalt.theory.triangulation.reversible_net import (
    ReversibleNet,
    is_turned_over,
    make_reversible_net,
    shift_deviations,
)
from einschalt.theory.triangulation.triangle_net import TriangleNet

CORNERS = ["corner_1", "corner_2", "corner_3"]
OUTLIERS = {"keep": None, "set_aside": GROSS_ERROR_SIGNIFICANCE}
CONTRADICTS = "contradicts its neighbours"
SAME_PLACE = "lies where another point lies"
TURNED = "its triangles would be turned over"
NO_TRIANGLE = "is a corner of no triangle"


@dataclass(frozen=True, eq=False, repr=False)
class TriangulatedTransformation(ModelTransformation):
    """Transformations that are linear in the triangles of their identical points.

    Its tables are those of the ModelTransformation that the residuals are of; but
    :meth:`transform` and :meth:`inverse` lead through the triangles, and give NaN
    outside of them.

    Attributes
    ----------
    nets : tuple of TriangleNet or None
        One for each row of ``models``; None where it is not usable.
    left_out : DataFrame
        coverage, model_id, point_id, deviation (of the shift from those of its
        neighbours, in plan) [m], reason: identical points that are no corners, since
        the transformation could not be undone with them.
    n_turned : int
        Triangles that were turned over before points were left out.
    """

    nets: tuple
    left_out: pd.DataFrame
    n_turned: int

    @property
    def triangles(self) -> pd.DataFrame:
        """Their corners: DataFrame of coverage, model_id, corner_1, _2, _3."""
        points = self.observed.rows["point_id"].to_numpy()
        start, keys = self.observed.start, self.models[MODEL].to_numpy()
        parts = [
            pd.DataFrame(points[start[k] + net.corners], columns=CORNERS).assign(
                coverage=keys[k, 0], model_id=keys[k, 1]
            )
            for k, net in enumerate(self.nets)
            if net is not None
        ]
        empty = pd.DataFrame(columns=[*MODEL, *CORNERS])
        return pd.concat(parts or [empty], ignore_index=True)[[*MODEL, *CORNERS]]

    @cached_property
    def held_out(self) -> pd.DataFrame:
        """Identical points, predicted by the triangles of the others: DataFrame.

        coverage, model_id, point_id, difference_easting, difference_northing
        (predicted minus given) [m]; NaN outside of the others' triangles, and for some
        of more than 2000 points.
        """
        start = self.observed.start
        differences = np.full((len(self.observed.rows), 2), np.nan)
        for k, net in enumerate(self.nets):
            if net is not None:
                used = net.used
                differences[start[k] + used] = held_out_differences(
                    net.source[used], net.target[used]
                )
        return table_of_differences(self, differences)

    @cached_property
    def held_out_errors(self) -> NDArray[np.float64]:
        """TOTAL RMS of the held-out points of each model [m], (n_models,)."""
        differences, start = values_of(self.held_out, DIFFERENCES), self.observed.start
        pairs = itertools.pairwise(start)
        return np.array([held_out_error(differences[a:b])[0] for a, b in pairs])

    def _forward(self, place, xyz, _s_0):
        ground = self._through(place, xyz, TriangleNet.apply)
        is_inside = np.isfinite(ground).all(axis=1)
        return ground, np.where(is_inside, self.held_out_errors[place], np.nan)

    def _backward(self, place, ground):
        return self._through(place, ground, TriangleNet.invert)

    def _through(self, place, xy, way):
        found = np.full((len(xy), 2), np.nan)
        for k, net in enumerate(self.nets):
            rows = np.flatnonzero(place == k)
            if net is not None and len(rows):
                found[rows] = way(net, xy[rows])
        return found

    def summary(self) -> str:
        """Add to the summary of the fit what the triangles are like."""
        n_triangles = sum(len(net.corners) for net in self.nets if net is not None)
        message = mark(
            "residuals distributed in {n:triangle|triangles}; outside nothing is "
            "transformed"
        )
        lines = [translated(message, n=n_triangles)]
        error, n_held = held_out_error(self.held_out[DIFFERENCES])
        if n_held:
            lines.append(said_of_held_out(error, n_held))
        if self.n_turned:
            message = mark("{n:triangle|triangles} would have been turned over")
            lines.append(translated(message, n=self.n_turned))
        if len(self.left_out):
            lines.append(said_of_left_out(self.left_out))
        return "\n".join([super().summary(), *lines])


def distribute_in_triangles(
    fit, triangles=None, *, outliers="keep"
) -> TriangulatedTransformation:
    """Distribute the residuals of a transformation in triangles of identical points.

    Parameters
    ----------
    fit : ModelTransformation
        In plan.
    triangles : DataFrame, optional
        The triangles to be used, of one model: the names of their corners in three
        columns; or model_id and point_id, in which three rows have the name of each
        triangle. Delaunay triangles where left out.
    outliers : {"keep", "set_aside"}
        Whether identical points whose shift contradicts those of their neighbours are
        corners as well. They are tested before anything is fitted to them.

    Raises
    ------
    SettingsError
        The transformation is spatial.
    GeometryError
        No triangle is left, or given ones cannot be undone.
    TableError
        The triangles are not what they should be.
    """
    if TRANSFORMATION_KINDS[fit.kind].target != PLANE[1]:
        raise SettingsError(
            f"residuals of {fit.kind} are to be distributed in triangles",
            expected="a transformation in plan: affine, helmert or rigid",
        )
    require_choice("outliers", outliers, OUTLIERS)
    is_usable = fit.models["is_usable"].to_numpy()
    significance = OUTLIERS[outliers]
    if triangles is None:
        made = [
            _made(fit, k, significance) if is_usable[k] else None
            for k in range(len(is_usable))
        ]
    else:
        made = _given(fit, triangles)
    found = [reversible for reversible in made if reversible is not None]
    return TriangulatedTransformation(
        **{each.name: getattr(fit, each.name) for each in fields(ModelTransformation)},
        nets=tuple(one and one.net for one in made),
        left_out=_left_out(fit, made),
        n_turned=sum(one.n_turned for one in found),
    )


def _of_model(fit, k):
    rows = slice(fit.observed.start[k], fit.observed.start[k + 1])
    return fit.observed.source[rows], fit.observed.target[rows]


def _made(fit, k, significance):
    reversible = make_reversible_net(*_of_model(fit, k), significance=significance)
    if len(reversible.net.corners):
        return reversible
    raise GeometryError(
        "no triangle of its identical points leads back to where it came from",
        expected="identical points that lie in the same order in both frames",
        remedy="See whether easting and northing are exchanged in one of them",
        model=fit.models["model_id"].iloc[k],
    )


def _left_out(fit, made):
    parts = [fit.observed.rows.iloc[:0].assign(deviation=0.0, reason="")]
    for k, one in enumerate(made):
        if one is None or not len(one.left_out):
            continue
        rows = fit.observed.rows.iloc[fit.observed.start[k] + one.left_out]
        deviation = one.deviations[one.left_out]
        is_same = np.isinf(deviation)
        reason = np.where(is_same, SAME_PLACE, TURNED if one.n_turned else NO_TRIANGLE)
        is_gross = np.isin(one.left_out, one.contradicting)
        reason = np.where(is_gross, CONTRADICTS, reason)
        known = np.where(is_same, np.nan, deviation)
        parts.append(rows.assign(deviation=known, reason=reason))
    return pd.concat(parts, ignore_index=True)


def _given(fit, triangles):
    """Take the triangles that the user gives."""
    if len(fit.models) != 1 or not fit.is_usable:
        raise TableError(
            f"triangles are given for {typesetting.count(len(fit.models), 'model')}",
            expected="one, that can be transformed",
            remedy="Leave them out: each model gets its own",
        )
    source, target = _of_model(fit, 0)
    names = _corner_names(triangles)
    known = pd.Index(fit.observed.rows["point_id"])
    corners = known.get_indexer(names.ravel()).reshape(-1, 3)
    if (corners < 0).any():
        raise TableError(
            "a corner of a triangle is no identical point",
            expected="names of points that both tables have",
            point=names[corners < 0][0],
        )
    is_turned = is_turned_over(source, target, corners)
    if is_turned.any():
        raise GeometryError(
            f"{typesetting.count(int(is_turned.sum()), 'triangle')} turned over by the "
            f"transformation, first {', '.join(names[np.argmax(is_turned)])}: it could "
            "not be undone",
            expected="triangles that keep their orientation",
            remedy="Leave triangles out, and they are made without such points",
        )
    net = TriangleNet(source, target, corners)
    unused = np.setdiff1d(np.arange(len(source)), net.used)
    deviations = shift_deviations(source, target, corners)
    deviations[unused] = 0.0
    none = np.empty(0, dtype=np.intp)
    return [ReversibleNet(net, 0, unused, deviations, none)]


def with_triangles(fit, triangles, left_out):
    """A TriangulatedTransformation from its own tables, as they were.

    ``fit``: the ModelTransformation, of the same identical points.
    """
    triangles, left_out = (with_coverage(table) for table in (triangles, left_out))
    groups = triangles.groupby(MODEL, sort=False).indices
    nets = []
    for k, key in enumerate(fit.models[MODEL].itertuples(index=False, name=None)):
        rows = slice(fit.observed.start[k], fit.observed.start[k + 1])
        names = pd.Index(fit.observed.rows["point_id"].iloc[rows])
        asked = triangles.iloc[groups.get(key, [])][CORNERS].to_numpy()
        corners = names.get_indexer(asked.ravel()).reshape(-1, 3)
        is_whole = len(corners) and (corners >= 0).all()
        nets.append(TriangleNet(*_of_model(fit, k), corners) if is_whole else None)
    return TriangulatedTransformation(
        **{each.name: getattr(fit, each.name) for each in fields(ModelTransformation)},
        nets=tuple(nets),
        left_out=left_out,
        n_turned=0,
    )


def _corner_names(triangles):
    """Names of the corners, (n_triangles, 3), in either layout."""
    frame = triangles.rename(columns=str)
    if set(CORNERS) <= set(frame):
        frame = frame[CORNERS]
    if "point_id" in frame and "model_id" in frame:
        groups = frame.groupby("model_id", sort=False)["point_id"].agg(list)
        if (groups.str.len() == 3).all():
            return np.array(groups.to_list(), dtype=object).astype(str)
    elif len(frame) and frame.shape[1] == 3:
        return frame.to_numpy().astype(str)
    raise TableError(
        f"the table of triangles has the columns {name_some(frame.columns, 8)}",
        expected="three, with the names of the corners; or model_id and point_id, with "
        "three rows for each triangle",
    )
