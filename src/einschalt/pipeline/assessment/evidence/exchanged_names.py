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
from einschalt.foundations.batches import segments
from einschalt.foundations.errors import EinschaltError
from einschalt.foundations.frame_columns import columns_of, with_columns
from einschalt.foundations.key_columns import rows_among
from einschalt.foundations.names import CodedPairs, encode_pairs, is_among
from einschalt.pipeline.assessment.evidence.control.displacements import (
    Displacement,
    moved_beyond_chance,
)
from einschalt.pipeline.assessment.evidence.names.names_in_a_model import (
    OneModel,
    right_order,
)
from einschalt.stages.stage3_model_transformation import transform_models

MODEL = ["coverage", "model_id"]
PLAN = ("easting", "northing")
PAIR = 2
LEAST_VALUES = 3  # of a point, whose median one wrong value does not decide
# worst points of a model among which a pair is looked for, of all and of those that it
# is fitted onto, which spoil the others: 15 to 66 pairs
MOST_POINTS = 6
MOST_MODELS = 200
MOST_ROWS = 1_000_000  # of the trials that are transformed together
MOST_SEARCHED = 10  # models of a flight, for more than a pair
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
    return tuple(sorted(found, key=lambda e: -np.nan_to_num(e.apart)))


@dataclass(frozen=True, eq=False)
class MeasuredNames:
    """A block of which the names that models have exchanged are put right."""

    corrected: object  # its examination
    moved: Displacement  # the new points by putting them right, beyond chance


def put_measured_names_right(examined) -> MeasuredNames | None:
    """Compute a block again with the names of its models put right.

    None where none are exchanged, of large blocks, and of flights with orientations,
    whose errors belong to rows of measurements.
    """
    exchanges = examined.exchanged_names
    flights = {exchange.flight for exchange in exchanges}
    if not (exchanges and examined.is_small):
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
    trials = _Trials.of(worst)
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


@dataclass(frozen=True, eq=False)
class _Trials:
    """Pairs of points whose names are exchanged, each in its model."""

    models: CodedPairs  # coverage and model_id of the models
    model: np.ndarray  # (n_trials,): place of its model
    pairs: np.ndarray  # (n_trials, 2): names of the two points

    @classmethod
    def of(cls, worst):
        """All pairs of the worst points of each model."""
        models = encode_pairs(worst["coverage"], worst["model_id"])
        points, model = worst["point_id"].to_numpy(dtype=object), models.codes
        _, rank = np.unique(points.astype(str), return_inverse=True)
        is_pair = (model[:, None] == model) & (rank[:, None] < rank)
        one, other = np.nonzero(is_pair)
        pairs = np.column_stack([points[one], points[other]])
        return cls(models, model[one], pairs)

    def m_0(self, measured, ground, kind):
        """m_0 of each trial's model, as it was measured and with exchanged names [m].

        NaN without redundancy. Each model is transformed once as it was measured.
        """
        models = encode_pairs(measured["coverage"], measured["model_id"])
        names = measured["point_id"]
        # others change no fit
        is_used = is_among(names, ground["point_id"]) | is_among(names, self.pairs.T[0])
        is_used |= is_among(names, self.pairs.T[1])
        parts = segments(models.codes[is_used], len(models))
        axes = [axis for axis in "xyz" if axis in measured]
        points = columns_of(measured, ["point_id", *axes])[is_used]
        own = np.arange(len(self.models))
        model = models.locate(self.models)[np.concatenate([own, self.model])]
        pairs = np.concatenate([np.full((len(own), PAIR), None), self.pairs])
        n_before = np.cumsum(parts.count[model]) // MOST_ROWS
        chunks = np.split(np.arange(len(model)), np.flatnonzero(np.diff(n_before)) + 1)
        m_0 = np.concatenate(
            [
                _m_0(points, parts, (model[chunk], pairs[chunk]), ground, kind)
                for chunk in chunks
            ]
        )
        return m_0[own][self.model], m_0[len(own) :]

    def best(self, m_0):
        """Trial with the least m_0 of each model, in the order of the models' names."""
        coverage, name = self.models.first[self.model], self.models.second[self.model]
        order = np.lexsort([m_0, name.astype(str), coverage.astype(str)])
        order = order[np.isfinite(m_0[order])]  # no exchange leaves others redundancy
        _, first = np.unique(self.model[order], return_index=True)
        return order[np.sort(first)]

    def named(self, trial):
        """Coverage, model_id, the pair of a trial, and what each was measured as."""
        model, pair = self.model[trial], self.pairs[trial]
        return self.models.first[model], self.models.second[model], pair, pair[::-1]

    def models_without(self, found, m_0, limit):
        """Coverage, model_id and m_0 of models that fit badly, the worst first.

        Without those of trials that were ``found``, at most ``MOST_SEARCHED``; ``m_0``
        of each trial's model as it was measured, ``limit`` what is not bad [m].
        """
        trial = np.unique(self.model, return_index=True)[1]
        trial = trial[~np.isin(self.model[trial], self.model[found])]
        trial = trial[m_0[trial] > limit]
        trial = trial[np.argsort(-m_0[trial], kind="stable")][:MOST_SEARCHED]
        return [(*self.named(k)[:2], m_0[k]) for k in trial]


def _variants(points, parts, model, pairs):
    """Points of a model for each trial, with the names of its pair exchanged.

    ``parts`` are the rows of each model; model_id is the number of the trial.
    """
    rows, start = parts.rows_of(model)
    trial = np.repeat(np.arange(len(model)), np.diff(start))
    variants = points.take(rows)
    names = variants["point_id"].to_numpy(dtype=object)
    one, other = pairs[trial].T
    exchanged = np.where(names == one, other, np.where(names == other, one, names))
    return with_columns(variants, model_id=trial.astype(str), point_id=exchanged)


def _m_0(points, parts, trials, ground, kind):
    """m_0 of each trial, (n_trials,) [m]; NaN of a model without points to fit."""
    m_0 = np.full(len(trials[0]), np.nan)
    variants = _variants(points, parts, *trials)
    if len(variants):
        models = transform_models(variants, ground, kind).models
        m_0[models["model_id"].astype(int)] = models["m_0"]
    return m_0


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
    miss = values[list(PLAN)] - median[list(PLAN)]
    return values[[*MODEL, "point_id"]].assign(
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
    both = pd.concat([part[[*columns, "is_suspect"]] for part in parts])
    # two exchanged points mask each other: a model may fit badly without a suspect
    wrong = both[both["is_suspect"].to_numpy(dtype=bool)]
    both = both[rows_among(both, wrong, MODEL) | rows_among(both, misfits, MODEL)]
    miss = np.hypot(both["residual_easting"], both["residual_northing"])
    both = both.assign(miss=miss).sort_values("miss", ascending=False, kind="stable")
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
