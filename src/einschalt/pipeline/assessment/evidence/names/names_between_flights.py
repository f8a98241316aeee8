"""Two points that have each other's place in the high and in the low flight.

Names of new points that were exchanged in models of the high flight bend none of them,
since these are fitted onto control alone; nor do names that were exchanged in all
models of the low flight that hold them contradict each other there. So the low flight
is fitted without the points that it contradicts, and tells where these are: where a
model of the high flight has each of two at the place of the other, their names are
exchanged in one of the flights. Other models of the high flight, and given coordinates,
tell in which.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from einschalt.foundations import tables
from einschalt.foundations.frame_columns import columns_of, values_of
from einschalt.foundations.key_columns import rows_among
from einschalt.foundations.names import encode_pairs, is_among
from einschalt.pipeline.densification.result_tables import HIGH, LOW
from einschalt.stages.stage3_model_transformation import transform_models
from einschalt.theory.adjustment.significance import FINDING_SIGNIFICANCE

MODEL, PLAN = ["coverage", "model_id"], ["easting", "northing"]
# how much nearer to the other place than to its own, and to what models scatter by
LEAST_RATIO = 5.0
LARGE_M_0 = 3.0  # of the median: models of the low flight that tell nothing
FAR_OFF = 8.0  # times the median distance: of clean blocks nothing is
MOST_POINTS = 12  # of a model, the farthest off: 66 pairs
MOST_MODELS = 200  # those with the points that are farthest off
MOST_SUSPECTS, MOST_ROUNDS = 500, 4


@dataclass(frozen=True)
class CrossedPair:
    """Two points, each where the other flight has the other one."""

    points: tuple[str, str]
    flight: str  # in which the names are exchanged; empty where nothing tells
    # coverage and model_id of the models of the high flight in which they are crossed
    models: tuple[tuple[str, str], ...]
    # distance of both points between the flights, RMS of the models, as measured and
    # with the names put right [m]
    apart: float
    apart_exchanged: float


def find_crossed_pairs(solution) -> tuple[CrossedPair, ...]:
    """Look for pairs of points that have each other's place in both flights.

    Parameters
    ----------
    solution : TwoStepSolution

    Returns
    -------
    tuple of CrossedPair
        None without a high flight. In one model each point lies five times nearer to
        the place of the other than to its own, nearer than chance has any pair that is
        looked at: two of ``n`` pairs of places that agree to a share ``q`` of their
        distance, ``n q^4``.
    """
    if solution.high is None:
        return ()
    places = _places_by_low_flight(solution)
    if len(places) < len(PLAN):
        return ()
    values = _values_of_high_flight(solution, places.index)
    if len(values) < len(PLAN):
        return ()
    values = _Values(values, places)
    one, other = values.crossed()
    of_pair = {}
    for pair in zip(one, other, strict=True):
        of_pair.setdefault(frozenset(values.names[list(pair)]), []).append(pair)
    return tuple(
        _crossed_pair(solution, values, np.array(rows)) for rows in of_pair.values()
    )


def _places_by_low_flight(solution):
    """Median place of each contradicted point by models fitted without any of them.

    DataFrame by point_id: easting, northing, scatter [m]; without rows where nothing is
    contradicted. A point that is far off bends models, so that others seem to be off:
    the worst are left out first, then those that are off without these. Those of which
    measurements were taken out are told as well.
    """
    taken_out = solution.gross_measurements["point_id"].to_numpy(dtype=object)
    known = solution.approximations.drop_duplicates("point_id").set_index("point_id")
    known = columns_of(known, PLAN)
    values, names = solution.first_fit(LOW).own_values, ()
    points = tables.with_coverage(solution.model_points[LOW])
    ground = solution.ground_of(LOW)
    for _ in range(MOST_ROUNDS):
        off, before = _far_off(values, known), names
        names = off[: MOST_POINTS if len(names) == 0 else MOST_SUSPECTS]
        if len(names) == 0 or set(names) == set(before):
            break
        is_off = is_among(points["point_id"], np.concatenate([names, taken_out]))
        points = points[rows_among(points, points[is_off], MODEL)]
        others = ground[~is_among(ground["point_id"], names)]
        if others.empty:  # nothing is left to tell where they are
            return _median_places(values, ())
        kind = solution.block.low_flight.transformation
        values = _good_values(transform_models(points, others, kind), points)
    return _median_places(values, [*names, *taken_out])


def _far_off(values, known):
    """Points that a model has far from where they are known, the farthest first."""
    there = values_of(known.reindex(values["point_id"]), PLAN)
    away = pd.Series(np.hypot(*(values_of(values, PLAN) - there).T))
    away = away.groupby(values["point_id"].to_numpy()).max().dropna()
    away = away[away > FAR_OFF * away.median()]
    return away.sort_values(ascending=False, kind="stable").index.to_numpy()


def _good_values(fit, points):
    """Coordinates of points by the models that fit as most of them do."""
    m_0 = fit.models["m_0"].to_numpy(dtype=float)
    usual = np.nanmedian(m_0) if np.isfinite(m_0).any() else np.nan
    good = tables.with_coverage(fit.models)[m_0 <= LARGE_M_0 * usual]
    values = fit.values(points)
    is_known = values["easting"].notna().to_numpy()
    return values[is_known & rows_among(values, good, MODEL)]


def _median_places(values, names):
    values = values[is_among(values["point_id"], np.asarray(names, dtype=object))]
    of_point = values.groupby("point_id", sort=False)[PLAN]
    there = values_of(of_point.transform("median"), PLAN)
    away = np.hypot(*(values_of(values, PLAN) - there).T)
    scatter = pd.Series(away).groupby(values["point_id"].to_numpy()).max()
    return of_point.median().assign(scatter=scatter)


def _values_of_high_flight(solution, names):
    """Places of points by each usable model of the high flight, a DataFrame."""
    fit = solution.high.transformation
    models = tables.with_coverage(fit.models)
    models = models[models["is_usable"].astype(bool)]
    points = tables.with_coverage(solution.model_points[HIGH])
    points = points[
        is_among(points["point_id"], names) & rows_among(points, models, MODEL)
    ]
    if points.empty:  # of points that are in no usable model there
        return points
    values = tables.with_coverage(fit.values(points))
    return values[values["easting"].notna()].reset_index(drop=True)


class _Values:
    """Values of the high flight, and where the low flight has their points."""

    def __init__(self, values, places):
        self.values = values
        self.names = values["point_id"].to_numpy(dtype=object)
        self.at = values_of(values, PLAN)
        own = places.reindex(self.names)
        self.own, self.scatter = values_of(own, PLAN), own["scatter"].to_numpy()
        self.away = np.hypot(*(self.at - self.own).T)

    def crossed(self):
        """Rows of the two points of each pair that lies crosswise in a model."""
        model = encode_pairs(self.values["coverage"], self.values["model_id"]).codes
        farthest = np.argsort(-self.away, kind="stable")
        worst_first, _ = pd.factorize(model[farthest])
        place = pd.Series(worst_first).groupby(worst_first).cumcount().to_numpy()
        is_tried = (place < MOST_POINTS) & (worst_first < MOST_MODELS)
        rows = np.sort(farthest[is_tried])
        one, other = rows[np.stack(np.nonzero(_are_pairs(model[rows])))]
        least = np.minimum(self.away[one], self.away[other])
        most = np.maximum(self.to(one, other), self.to(other, one))
        scatter = np.maximum(self.scatter[one], self.scatter[other])
        share = np.divide(most, least, out=np.ones(len(most)), where=least > 0.0)
        is_crossed = (LEAST_RATIO * np.maximum(most, scatter) < least) & (
            len(one) * share**4 <= FINDING_SIGNIFICANCE
        )
        return one[is_crossed], other[is_crossed]

    def to(self, rows, others):
        """Distance of rows from where the low flight has the points of others."""
        return np.hypot(*(self.at[rows] - self.own[others]).T)


def _are_pairs(model):
    """Which two rows are of one model, the first of both before, (n, n)."""
    return np.triu(model[:, None] == model, 1)


def _crossed_pair(solution, values, rows):
    """A pair that lies crosswise in some models: its rows in each, (n_models, 2)."""
    one, other = rows.T
    apart = np.sqrt(np.mean(values.away[rows] ** 2))
    put_right = np.hypot(values.to(one, other), values.to(other, one))
    keys = values.values.loc[one, MODEL].to_numpy(dtype=object)
    return CrossedPair(
        points=tuple(sorted(map(str, values.names[rows[0]]))),
        flight=_flight_of(solution, values, rows),
        models=tuple(map(tuple, keys)),
        apart=float(apart),
        apart_exchanged=float(np.sqrt(np.mean(put_right**2) / 2.0)),
    )


def _flight_of(solution, values, rows):
    """Flight in which names are exchanged: given coordinates tell, or other models."""
    one, other = rows[0]
    control = solution.block.control_points
    given = control.drop_duplicates("point_id").set_index("point_id")
    given = values_of(given.reindex(values.names[[one, other]]), PLAN)
    right = np.hypot(*(given - values.own[[one, other]]).T)
    wrong = np.hypot(*(given - values.own[[other, one]]).T)
    if (LEAST_RATIO * right < wrong).any():
        return HIGH
    if (LEAST_RATIO * wrong < right).any():
        return LOW
    is_its = is_among(values.names, values.names[[one, other]])
    is_its[rows.ravel()] = False
    # another model of the high flight has the point where the low flight has it
    distance = np.hypot(*(values.own[one] - values.own[other]).T)
    return HIGH if (LEAST_RATIO * values.away[is_its] < distance).any() else ""
