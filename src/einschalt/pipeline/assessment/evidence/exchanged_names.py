"""Points of a model that were measured under each other's name, mostly two.

Two exchanged names spoil all residuals of their model, the coverage differences of its
points and every figure of the block. So each model that fits badly, or has a suspect,
is transformed again with every pair of its worst points exchanged, and the pair that
makes it fit is the cause. Where suspects have no coordinates that their models are
fitted onto, the median of their values takes the place.
"""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from einschalt.foundations import tables
from einschalt.foundations.errors import EinschaltError
from einschalt.foundations.frame_columns import MODEL, columns_of, with_columns
from einschalt.foundations.key_columns import rows_among
from einschalt.foundations.names import encode_pairs, is_among
from einschalt.pipeline.assessment.evidence.control.displacements import (
    Displacement,
    moved_beyond_chance,
)
from einschalt.pipeline.assessment.evidence.names.exchange_trials import (
    PAIR,
    Trials,
)
from einschalt.pipeline.assessment.evidence.names.names_between_flights import (
    find_crossed_pairs,
)
from einschalt.pipeline.assessment.evidence.names.names_in_a_model import (
    OneModel,
    right_order,
)
from einschalt.pipeline.densification.result_tables import HIGH, LOW

PLAN = ("easting", "northing")
LEAST_VALUES = 3  # of a point, whose median one wrong value does not decide
# worst points of a model among which a pair is looked for, of all and of those that it
# is fitted onto, which spoil the others: 15 to 66 pairs
MOST_POINTS = 6
MOST_MODELS = 200
MOST_TIMES = 3  # what names hide of others may be found once they are put right
# of the models without suspects: what an exchanged model must come down to
LARGE_M_0 = 3.0
# and by how much it must improve, so that no chance improvement counts
LEAST_IMPROVEMENT = 5.0


@dataclass(frozen=True)
class ExchangedNames:
    """Points that were measured under each other's name in a model, mostly two."""

    flight: str
    coverage: str
    model_id: str
    points: tuple[str, ...]  # their names
    measured_as: tuple[str, ...]  # the name under which each of them was measured
    # largest distance of a point from the one whose name it has [m]; NaN where one of
    # them has no coordinates
    apart: float
    # of the model as it was measured, and with the names put right, TOTAL [m]
    m_0: float
    m_0_exchanged: float
    model_points: tuple[str, ...]  # all points of the model
    # whether all models of the flight that hold both points have them exchanged, and
    # several do: then they may be exchanged in what these models are fitted onto
    is_everywhere: bool = False
    is_slip: bool = False  # names of rows one after the other, by one row
    # whether the other flight shows it, and not the fit of the model: then both m_0 are
    # the distance of the two points from where it has them, RMS
    is_by_other_flight: bool = False


def find_exchanged_names(solution) -> tuple[ExchangedNames, ...]:
    """Look for exchanged names in all models that fit badly, or have a suspect.

    At most one mistake in a model: a pair; names that have slipped by one row; two or
    three exchanges one after the other. What is farthest apart first.
    """
    found = [
        exchange
        for name, flight in solution.block.flights.items()
        for exchange in _in_flight(solution, name, flight.transformation)
    ]
    found = [
        replace(one, is_everywhere=_is_everywhere(one, found, solution.model_points))
        for one in found
    ]
    found = _with_crossed_pairs(solution, found)
    return tuple(sorted(found, key=lambda e: -np.nan_to_num(e.apart)))


def _with_crossed_pairs(solution, found):
    """What was found in single models, and pairs that lie crosswise in the flights."""
    for pair in find_crossed_pairs(solution):
        alike = [e for e in found if frozenset(e.points) == frozenset(pair.points)]
        if pair.flight == HIGH:  # the low flight is right
            found = [e for e in found if e.flight == HIGH or e not in alike]
        elif alike and not pair.flight:
            # other models of that flight say the same, though none has both points
            found = [replace(e, is_everywhere=True) if e in alike else e for e in found]
            continue
        known = {(e.flight, e.coverage, e.model_id) for e in found}
        found += [
            exchange
            for exchange in _of_crossed_pair(solution, pair)
            if (exchange.flight, exchange.coverage, exchange.model_id) not in known
        ]
    return found


def _of_crossed_pair(solution, pair):
    """A pair as exchanged in the models of the flight that is wrong, or may be.

    In all models of the low flight that hold both where that one is.
    """
    flight = pair.flight or LOW
    points = tables.with_coverage(solution.model_points[flight])
    names = points["point_id"]
    one, other = (points.loc[names == name, MODEL] for name in pair.points)
    both = one[rows_among(one, other, MODEL)].to_numpy(dtype=object)
    models = pair.models if flight == HIGH else map(tuple, both)
    for coverage, model_id in models:
        is_its = (points["coverage"] == coverage) & (points["model_id"] == model_id)
        yield ExchangedNames(
            flight=flight,
            coverage=coverage,
            model_id=model_id,
            points=pair.points,
            measured_as=pair.points[::-1],
            apart=pair.apart,
            m_0=pair.apart,
            m_0_exchanged=pair.apart_exchanged,
            model_points=tuple(names[is_its]),
            is_everywhere=not pair.flight,
            is_by_other_flight=True,
        )


@dataclass(frozen=True, eq=False)
class MeasuredNames:
    """A block of which the names that models have exchanged are put right."""

    corrected: object  # its examination
    moved: Displacement  # the new points by putting them right, beyond chance


def put_measured_names_right(examined) -> MeasuredNames | None:
    """Compute a block again with the names of its models put right.

    None where none are exchanged, of large blocks, of one whose names were put right
    three times, since pairs may be found back and forth, and of flights with
    orientations, whose errors belong to rows of measurements.
    """
    exchanges = examined.exchanged_names
    flights = {exchange.flight for exchange in exchanges}
    n_before = examined.n_times_put_right
    if not (exchanges and examined.is_small) or n_before == MOST_TIMES:
        return None
    if any(examined.block.flights[name].is_oriented_numerically for name in flights):
        return None
    block, oriented = examined.block, dict(examined.all_in_two_steps.solution.flights)
    for name in flights:
        of_flight = [exchange for exchange in exchanges if exchange.flight == name]
        block = replace(block, **{name: _put_right(block.flights[name], of_flight)})
        oriented[name] = _put_right(oriented[name], of_flight)
    try:
        again = examined.computed_again(block, flights=oriented)
    except EinschaltError:  # other models do not hold together
        return None
    vars(again)["n_times_put_right"] = n_before + 1
    return MeasuredNames(again, moved_beyond_chance(examined, again))


def _put_right(measured, exchanges):
    """A flight, or its orientation, with the names of pairs exchanged."""
    points = tables.with_coverage(measured.model_points)
    names = points["point_id"].to_numpy(dtype=object).copy()
    for exchange in exchanges:
        is_in_model = (points["coverage"] == exchange.coverage).to_numpy() & (
            points["model_id"] == exchange.model_id
        ).to_numpy()
        right = dict(zip(exchange.measured_as, exchange.points, strict=True))
        names[is_in_model] = [right.get(name, name) for name in names[is_in_model]]
    return replace(measured, model_points=measured.model_points.assign(point_id=names))


def _is_everywhere(one, found, model_points):
    """Whether no model of the flight holds both points under their own names."""
    alike = [(e.flight, frozenset(e.points)) for e in found]
    n_exchanged = alike.count((one.flight, frozenset(one.points)))
    measured = tables.with_coverage(model_points[one.flight])
    held = [
        encode_pairs(*columns_of(rows, MODEL).to_numpy(dtype=object).T)
        for rows in (measured[measured["point_id"] == name] for name in one.points)
    ]
    n_both = int((held[0].locate(held[1]) >= 0).sum())
    return 1 < n_exchanged == n_both


def _in_flight(solution, name, kind):
    by_values = _known_by_values(solution, name)
    worst = _worst_points(solution, name, by_values)
    if len(worst) < PAIR:
        return []
    trials = Trials.of(worst)
    if not len(trials.pairs):
        return []
    measured = tables.with_coverage(solution.model_points[name])
    ground = solution.ground_of(name)
    if len(by_values):
        places = by_values.drop_duplicates("point_id")[_ground_columns(by_values)]
        ground = pd.concat([ground, places], ignore_index=True)
    before, after = trials.m_0(measured, ground, kind)
    best = trials.best(after)
    usual = _usual_m_0(solution, name, worst)
    is_found = (after[best] <= LARGE_M_0 * usual) & (
        before[best] >= LEAST_IMPROVEMENT * after[best]
    )
    # computed coordinates only where the points are not known on the ground
    known = pd.concat([ground, solution.points])
    place = known.drop_duplicates("point_id").set_index("point_id")
    place = columns_of(place, ("easting", "northing"))
    search = _Search(solution, name, kind, measured, ground, place, usual)
    found = [
        search.exchange(trials.named(k), (before[k], after[k])) for k in best[is_found]
    ]
    left = trials.models_without(best[is_found], before, LARGE_M_0 * usual)
    return [*found, *search.beyond_pairs(left)]


def _known_by_values(solution, name):
    """Values of suspects that the models of a flight are not fitted onto.

    coverage, model_id, point_id, the median of the point's values easting, northing
    [, height], residual_easting, residual_northing (value less median) [m], is_suspect.
    Of points with three values and more: of fewer the median is no place of its own.
    """
    suspects = _suspects(solution, name)
    suspects = suspects[~is_among(suspects, solution.ground_of(name)["point_id"])]
    if not len(suspects):  # values of a country need not be made for nothing
        return pd.DataFrame(columns=[*MODEL, "point_id"])
    values = solution.first_fit(name).own_values
    axes = _ground_columns(values)[1:]
    is_open = is_among(values["point_id"], suspects)
    values = values[is_open & values["easting"].notna().to_numpy()]
    by_point = values.groupby("point_id", sort=False)
    values = values[(by_point["easting"].transform("size") >= LEAST_VALUES).to_numpy()]
    median = values.groupby("point_id", sort=False)[axes].transform("median")
    miss = columns_of(values, PLAN) - columns_of(median, PLAN)
    return columns_of(values, [*MODEL, "point_id"]).assign(
        **median,
        residual_easting=miss["easting"],
        residual_northing=miss["northing"],
        is_suspect=True,
    )


def _suspects(solution, name):
    """Names of the points that residuals, coverages or other models contradict."""
    residuals, gross = solution.residuals, solution.gross_measurements
    return pd.concat(
        [
            residuals.loc[residuals["is_suspect"].astype(bool), "point_id"],
            gross.loc[gross["flight"] == name, "point_id"],
            pd.Series(solution.screening.suspects, dtype=object),
        ]
    ).unique()


def _ground_columns(table):
    """point_id, easting, northing and, where there is one, height."""
    return ["point_id", *(axis for axis in (*PLAN, "height") if axis in table)]


def _worst_points(solution, name, by_values):
    """Points with the largest residuals of the models that hold something wrong."""
    residuals = solution.residuals[solution.residuals["flight"] == name]
    gross = solution.gross_measurements
    gross = gross[gross["flight"] == name].assign(is_suspect=True)
    misfits = _models_that_fit_badly(solution, name)
    own = (gross, by_values)
    if not (residuals["is_suspect"].any() or any(map(len, own)) or len(misfits)):
        return residuals.iloc[:0]
    columns = [*MODEL, "point_id", "residual_easting", "residual_northing"]
    parts = [part for part in (residuals, *own) if len(part)] or [residuals]
    both = pd.concat([columns_of(part, [*columns, "is_suspect"]) for part in parts])
    # two exchanged points mask each other: a model may fit badly without a suspect
    wrong = both[both["is_suspect"].to_numpy(dtype=bool)]
    both = both[rows_among(both, wrong, MODEL) | rows_among(both, misfits, MODEL)]
    miss = np.hypot(both["residual_easting"], both["residual_northing"])
    both = with_columns(both, miss=miss)
    both = both.sort_values("miss", ascending=False, kind="stable")
    both = both.drop_duplicates([*MODEL, "point_id"])
    model = encode_pairs(both["coverage"], both["model_id"]).codes
    both = both[model < MOST_MODELS]  # codes count in the order of the rows
    is_fitted = is_among(both["point_id"], solution.ground_of(name)["point_id"])
    of_each = both.groupby(MODEL).cumcount().to_numpy() < MOST_POINTS
    of_each |= both.groupby([*MODEL, is_fitted]).cumcount().to_numpy() < MOST_POINTS
    return both.loc[of_each, [*MODEL, "point_id"]]


def _models_that_fit_badly(solution, name):
    models = solution.first_models(name)
    is_bad = models["m_0"] > LARGE_M_0 * models["m_0"].median()
    return columns_of(models[is_bad], MODEL)


def _usual_m_0(solution, name, worst):
    """Median m_0 of the models of the flight that hold nothing wrong.

    Of all where none is without a suspect: one model spoils points of the others.
    """
    models = solution.first_models(name)
    is_good = ~rows_among(models, worst, MODEL)
    good = models["m_0"][is_good]
    return float((good if good.notna().any() else models["m_0"]).median())


@dataclass(frozen=True, eq=False)
class _Search:
    """What is known of a flight where names of its models are exchanged."""

    solution: object
    flight: str
    kind: str  # of the transformation
    measured: pd.DataFrame
    ground: pd.DataFrame  # what its models are fitted onto
    place: pd.DataFrame  # coordinates of points, by their names
    usual: float  # m_0 of its models [m]

    def exchange(self, named, m_0, is_slip=False):
        """What was found in a model: ``named`` with points, and as what measured."""
        coverage, model_id, points, measured_as = named
        here, there = (
            self.place.reindex(names).to_numpy() for names in (points, measured_as)
        )
        return ExchangedNames(
            flight=self.flight,
            coverage=coverage,
            model_id=model_id,
            points=tuple(points),
            measured_as=tuple(measured_as),
            apart=float(np.hypot(*(there - here).T).max()),
            m_0=float(m_0[0]),
            m_0_exchanged=float(m_0[1]),
            model_points=tuple(self._of_model(coverage, model_id)["point_id"]),
            is_slip=is_slip,
        )

    def beyond_pairs(self, models):
        """What more than one exchange mends, of models as (coverage, model_id, m_0)."""
        if not models:
            return []
        others = self._by_other_models([model[:2] for model in models])
        found = (self._beyond_a_pair(*model, others) for model in models)
        return [exchange for exchange in found if exchange is not None]

    def _beyond_a_pair(self, coverage, model_id, m_0, others):
        points = self._of_model(coverage, model_id)
        if points["point_id"].duplicated().any():  # whose rows tell of no order
            return None
        model = OneModel(points, self.ground, others, self.kind)
        found = right_order(model, LARGE_M_0 * self.usual)
        if found is None:
            return None
        moved = np.flatnonzero(found.order != np.arange(len(points)))
        named = (model.names[found.order[moved]], model.names[moved])
        return self.exchange(
            (coverage, model_id, *named), (m_0, found.m_0), found.is_slip
        )

    def _of_model(self, coverage, model_id):
        is_its = (self.measured["coverage"] == coverage) & (
            self.measured["model_id"] == model_id
        )
        return self.measured[is_its]

    def _by_other_models(self, bad):
        """Where models of the flight that are not bad have points without ground."""
        values = tables.with_coverage(self.solution.first_fit(self.flight).own_values)
        bad = pd.DataFrame(bad, columns=MODEL)
        is_open = ~is_among(values["point_id"], self.ground["point_id"])
        is_open &= ~rows_among(values, bad, MODEL)
        axes = _ground_columns(values)
        values = values.loc[is_open & values["easting"].notna().to_numpy(), axes]
        return values.groupby("point_id", sort=False).median().reset_index()
