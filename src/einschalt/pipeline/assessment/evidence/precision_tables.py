"""Tables of precision that a result gives on request.

Sources of error, neighbours, control points left out, ellipses.
"""

from functools import cached_property

import numpy as np
import pandas as pd

from einschalt.foundations.errors import SettingsError, TableError
from einschalt.foundations.frame_columns import (
    PLAN,
    columns_of,
    values_of,
    with_columns,
)
from einschalt.foundations.names import is_among
from einschalt.foundations.neighbours import neighbour_pairs
from einschalt.foundations.units import RADIANS_PER_GON
from einschalt.pipeline.assessment.evidence.leave_one_out import left_out_table
from einschalt.stages.stage4_error_propagation import (
    obstacle_to_propagation,
    untold_sizes,
)
from einschalt.theory.adjustment.ellipses import confidence_ellipses

NEIGHBOUR_COLUMNS = [
    *("distance", "standard_error_easting", "standard_error_northing", "covariance_en"),
    *("standard_error_total", "standard_error_distance", "standard_error_across"),
    "standard_error_if_independent",
]
ELLIPSE_COLUMNS = ["semi_major", "semi_minor", "azimuth_gon", "confidence"]


class PrecisionTables:
    """What follows from the propagated errors of a solution.

    It has ``block``, ``settings``, ``points``, ``judged`` (these with the figure to
    believe), ``errors`` and ``left_out_control``; where the errors could not be
    propagated (``errors`` is None), the tables have no rows. Ellipses need only the
    covariance of each point, which its row has.
    """

    @cached_property
    def error_sources(self):
        """Standard error of every point from each source of error alone, a DataFrame.

        point_id, standard_error_total, standard_error_control,
        standard_error_high_flight, standard_error_low_flight (of the measurements)
        [, standard_error_orientation], all TOTAL [m]: their squares add up;
        largest_source.
        """
        if self.errors is None:
            return _without_rows(["standard_error_total"], "largest_source")
        variances = self._variances_by_source()
        errors = {f"standard_error_{n}": _root(v) for n, v in variances.items()}
        total = {"standard_error_total": _root(sum(variances.values()))}
        table = pd.DataFrame({"point_id": self.errors.point_ids, **total, **errors})
        largest = np.argmax(np.column_stack(list(variances.values())), axis=1)
        return table.assign(largest_source=np.array(list(variances))[largest])

    @cached_property
    def block_error_sources(self):
        """What each source contributes to the error of the new points, a DataFrame.

        source, standard_error_total (root mean square over the new points, over all
        where there are none) [m], share (of the variance); the largest first.
        """
        if self.errors is None:
            return pd.DataFrame(columns=["source", "standard_error_total", "share"])
        new = self.points.loc[self.points["role"] == "new", "point_id"]
        is_new = is_among(self.errors.point_ids, new)
        rows = is_new if is_new.any() else ~is_new
        mean = {n: np.mean(v[rows]) for n, v in self._variances_by_source().items()}
        variance = np.array(list(mean.values()))
        whole = variance.sum()
        share = variance / whole if whole > 0.0 else variance
        columns = {"standard_error_total": _root(variance), "share": share}
        table = pd.DataFrame({"source": list(mean), **columns})
        table = table.sort_values("share", ascending=False, kind="stable")
        return table.reset_index(drop=True)

    def _variances_by_source(self):
        """Variance σ_E² + σ_N² of each point from each source [m²]."""
        return {n: p[:, 0, 0] + p[:, 1, 1] for n, p in self.errors.parts.items()}

    @cached_property
    def neighbours(self):
        """Precision of coordinate differences between neighbours, a DataFrame.

        :meth:`neighbour_precision` of all neighbours.
        """
        return self.neighbour_precision()

    def neighbour_precision(self, pairs=None):
        """Precision of the coordinate differences between points.

        Parameters
        ----------
        pairs : sequence of (str, str), or DataFrame with two columns, optional
            point_id of the points of each pair. The default is all neighbours: points
            without a third one in the circle over their distance.

        Returns
        -------
        DataFrame
            point_id, neighbour_id, distance, then of the difference of their
            coordinates standard_error_easting, standard_error_northing,
            covariance_en, standard_error_total (TOTAL), standard_error_distance,
            standard_error_across (along the line and at right angles to it), and
            standard_error_if_independent (TOTAL, if the points shared no error) [m].
            No rows where the errors were not propagated.

        Raises
        ------
        TableError
            A point is not among the densified points.
        """
        if self.errors is None:
            return _without_rows(NEIGHBOUR_COLUMNS).assign(neighbour_id="")
        if pairs is None:
            places = neighbour_pairs(values_of(self.points, PLAN))
        else:
            places = _places(self.points["point_id"], pairs)
        return self._differences(places)

    def _differences(self, places):
        one, two = places.T
        between = self.errors.covariance_at(places)[:, :2, :2]
        own = self.errors.covariance[:, :2, :2]
        alone = own[one] + own[two]
        covariance = alone - between - np.swapaxes(between, 1, 2)
        xy = values_of(self.points, PLAN)
        line = xy[two] - xy[one]
        distance = np.hypot(*line.T)
        with np.errstate(invalid="ignore"):  # two points at one place have no direction
            along = line / distance[:, None]
        across = along[:, ::-1] * [1.0, -1.0]
        names = self.points["point_id"].to_numpy(dtype=object)
        east, north = covariance[:, 0, 0], covariance[:, 1, 1]
        columns = (
            *(distance, _root(east), _root(north), covariance[:, 0, 1]),
            _root(east + north),
            *(_root(_form(covariance, way)) for way in (along, across)),
            _root(alone[:, 0, 0] + alone[:, 1, 1]),
        )
        table = pd.DataFrame({"point_id": names[one], "neighbour_id": names[two]})
        return with_columns(table, **dict(zip(NEIGHBOUR_COLUMNS, columns, strict=True)))

    def covariance_between(self, pairs):
        """Covariances between the coordinates of two points.

        In the system of the block, whatever ``output_crs`` is: it is not turned.

        Parameters
        ----------
        pairs : sequence of (str, str), or DataFrame with two columns
            point_id of the points of each pair.

        Returns
        -------
        ndarray, shape (n_pairs, 2, 2)
            Easting and northing of the first point in the rows, of the second in the
            columns [m²]. Of a point with itself it is its covariance matrix.

        Raises
        ------
        TableError
            A point is not among the densified points.
        SettingsError
            The errors of the block were not propagated.
        """
        self._require_errors()
        places = _places(self.points["point_id"], pairs)
        return self.errors.covariance_at(places)[:, :2, :2]

    @cached_property
    def control_left_out(self):
        """Control points predicted from all the others, a DataFrame.

        See :func:`einschalt.pipeline.assessment.evidence.leave_one_out.left_out_table`.
        """
        return left_out_table(self.left_out_control, self.settings.significance)

    @cached_property
    def ellipses(self):
        """Confidence ellipses of the level that the settings ask for, a DataFrame."""
        return self.confidence_ellipses()

    def confidence_ellipses(self, confidence=None):
        """Confidence ellipses of all points, those to believe.

        Each has the shape of the propagated covariance, and its axes are enlarged as
        ``standard_error_checked`` of ``points`` is against ``standard_error_total``:
        where measurements exceed the stated precision. Where the figure is a lower
        bound, the ellipse is one as well. ``covariance_en`` is not enlarged.

        Parameters
        ----------
        confidence : float, optional
            Probability that the true point lies inside; 0.393 is the mean error
            ellipse. The default is that of the settings.

        Returns
        -------
        DataFrame
            point_id, easting, northing, semi_major, semi_minor [m], azimuth_gon (of
            the major axis, clockwise from north, 0 to 200), confidence; of all points
            that have standard errors, in two steps as in one adjustment.

        Raises
        ------
        SettingsError
            The level is no probability.
        """
        level = self.settings.confidence if confidence is None else confidence
        if not 0.0 < level < 1.0:
            raise SettingsError(
                f"confidence = {level!r}", expected="a probability above 0 and below 1"
            )
        covariance = _covariance_in_plan(self.points)
        if covariance is None:
            return _without_rows([*PLAN, *ELLIPSE_COLUMNS])
        found, larger = (
            confidence_ellipses(covariance, level),
            _enlargement(self.judged),
        )
        azimuth = found.azimuth / RADIANS_PER_GON
        columns = (larger * found.semi_major, larger * found.semi_minor, azimuth, level)
        table = columns_of(self.points, ["point_id", *PLAN])
        table = with_columns(table, **dict(zip(ELLIPSE_COLUMNS, columns, strict=True)))
        is_known = np.isfinite(covariance).all(axis=(1, 2))
        return table[is_known].reset_index(drop=True)

    def _require_errors(self):
        if self.errors is None:
            raise SettingsError(
                "the errors of this block were not propagated: "
                f"{obstacle_to_propagation(self.block) or untold_sizes(self.block)}",
                expected="control and flights with errors of known size",
            )


def _covariance_in_plan(points):
    """Covariance of easting and northing (n_points, 2, 2) [m²], or None."""
    if "covariance_en" not in points:
        return None
    names = ["standard_error_easting", "standard_error_northing", "covariance_en"]
    east, north, both = values_of(points, names).T
    return np.stack([east**2, both, both, north**2], axis=1).reshape(-1, 2, 2)


def _enlargement(points):
    """How many times the propagated error that to believe is, at least 1, (n_points,).

    1 where either is not known.
    """
    names = ["standard_error_checked", "standard_error_total"]
    checked, total = values_of(points, names).T
    is_known = np.isfinite(checked) & (total > 0.0)
    ratio = np.divide(checked, total, out=np.ones(len(points)), where=is_known)
    return np.maximum(ratio, 1.0)


def _places(point_ids, pairs):
    """Places of the points of each pair, shape (n_pairs, 2)."""
    asked = np.asarray(pairs, dtype=object)
    if asked.shape == (0,):  # a list of no pairs
        asked = asked.reshape(0, 2)
    if asked.ndim != 2 or asked.shape[1] != 2:
        raise TableError(
            f"pairs of the shape {asked.shape}",
            expected="two names for each pair of points",
        )
    names = [str(name) for name in asked.ravel()]
    places = pd.Index(point_ids).get_indexer(names)
    if (places < 0).any():
        raise TableError(
            "it is not among the densified points",
            expected="a point_id of result.points",
            point=names[int(np.argmax(places < 0))],
        )
    return places.reshape(asked.shape)


def _without_rows(numbers, *texts):
    """Build a table that has columns only."""
    columns = {name: pd.Series(dtype=float) for name in numbers}
    names = {name: pd.Series(dtype=str) for name in ("point_id", *texts)}
    return pd.DataFrame({"point_id": names["point_id"], **columns, **names})


def _form(matrices, vectors):
    return np.einsum("ni,nij,nj->n", vectors, matrices, vectors)


def _root(variance):
    """Square root; a vanishing variance may come out as a little less than 0."""
    return np.sqrt(np.where(variance > 0.0, variance, variance * 0.0))
