"""Two points of a model that were measured under each other's name.

Two exchanged names spoil all residuals of their model, the coverage differences of its
points and every figure of the block. So each model that fits badly, or has a suspect,
is transformed again with every pair of its worst points exchanged, and the pair that
makes it fit is the cause.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from einschalt.foundations import tables
from einschalt.stages.stage3_model_transformation import transform_models

MODEL = ["coverage", "model_id"]
# worst points of a model among which a pair is looked for: 15 pairs
MOST_POINTS = 6
MOST_MODELS = 200
# of the models without suspects: what an exchanged model must come down to
LARGE_M_0 = 3.0
# and by how much it must improve, so that no chance improvement counts
LEAST_IMPROVEMENT = 5.0


@dataclass(frozen=True)
class ExchangedNames:
    """A pair of points that were measured under each other's name in a model."""

    flight: str
    coverage: str
    model_id: str
    points: tuple[str, str]  # the two names
    apart: float  # distance of the two points [m]; NaN where one has no coordinates
    # of the model as it was measured, and with the names put right, TOTAL [m]
    m_0: float
    m_0_exchanged: float
    model_points: tuple[str, ...]  # all points of the model


def find_exchanged_names(solution) -> tuple[ExchangedNames, ...]:
    """Look for exchanged names in all models that fit badly, or have a suspect.

    At most one pair of a model, the pair that is farthest apart first.
    """
    found = [
        exchange
        for name, flight in solution.block.flights.items()
        for exchange in _in_flight(solution, name, flight.transformation)
    ]
    return tuple(sorted(found, key=lambda e: -np.nan_to_num(e.apart)))


def _in_flight(solution, name, kind):
    worst = _worst_points(solution, name)
    if worst.empty:
        return []
    pairs = worst.merge(worst, on=MODEL, suffixes=("", "_other"))
    pairs = pairs[pairs["point_id"] < pairs["point_id_other"]].reset_index(drop=True)
    if pairs.empty:
        return []
    measured = tables.with_coverage(solution.model_points[name])
    ground = solution.ground_of(name)
    as_measured = _variants(measured, worst[MODEL].drop_duplicates())
    before = _m_0(as_measured, ground, kind)
    trials = pairs.assign(
        m_0=_m_0(_variants(measured, pairs), ground, kind),
        before=pairs[MODEL].merge(_by_model(worst, before), on=MODEL)["m_0"],
    )
    trials = trials.dropna(subset="m_0")  # models that no exchange leaves redundancy
    best = trials.loc[trials.groupby(MODEL)["m_0"].idxmin()]
    usual = _usual_m_0(solution, name, worst)
    is_found = (best["m_0"] <= LARGE_M_0 * usual) & (
        best["before"] >= LEAST_IMPROVEMENT * best["m_0"]
    )
    # computed coordinates only where the points are not known on the ground
    known = pd.concat([ground, solution.points]).drop_duplicates("point_id")
    place = known.set_index("point_id")[["easting", "northing"]]
    return [
        _exchange(name, row, place, measured) for row in best[is_found].itertuples()
    ]


def _worst_points(solution, name):
    """Points with the largest residuals of the models that hold something wrong."""
    residuals = solution.residuals[solution.residuals["flight"] == name]
    gross = solution.gross_measurements
    gross = gross[gross["flight"] == name].assign(is_suspect=True)
    misfits = _models_that_fit_badly(solution, name)
    if not (residuals["is_suspect"].any() or len(gross) or len(misfits)):
        return residuals.iloc[:0]
    columns = [*MODEL, "point_id", "residual_easting", "residual_northing"]
    parts = [part for part in (residuals, gross) if len(part)] or [residuals]
    both = pd.concat([part[[*columns, "is_suspect"]] for part in parts])
    # two exchanged points mask each other: a model may fit badly without a suspect
    keys = pd.MultiIndex.from_frame(both[MODEL])
    is_wrong = both.groupby(MODEL)["is_suspect"].transform("any")
    both = both[is_wrong | keys.isin(misfits)]
    miss = np.hypot(both["residual_easting"], both["residual_northing"])
    both = both.assign(miss=miss).sort_values("miss", ascending=False, kind="stable")
    models = both[MODEL].drop_duplicates().head(MOST_MODELS)
    both = both.drop_duplicates([*MODEL, "point_id"]).merge(models, on=MODEL)
    return both.groupby(MODEL).head(MOST_POINTS)[[*MODEL, "point_id"]]


def _models_that_fit_badly(solution, name):
    models = solution.first_models(name)
    is_bad = models["m_0"] > LARGE_M_0 * models["m_0"].median()
    return pd.MultiIndex.from_frame(models.loc[is_bad, MODEL])


def _variants(measured, trials):
    """A copy of its model for each trial, with the names of its pair exchanged."""
    numbered = trials.assign(trial=np.arange(len(trials)).astype(str))
    points = measured.merge(numbered, on=MODEL, suffixes=("", "_one"))
    if "point_id_other" in points:
        one, other = points["point_id_one"], points["point_id_other"]
        name = points["point_id"]
        exchanged = np.where(name == one, other, np.where(name == other, one, name))
        points = points.assign(point_id=exchanged)
    axes = [axis for axis in "xyz" if axis in points]
    return points.assign(model_id=points["trial"])[["model_id", "point_id", *axes]]


def _m_0(variants, ground, kind):
    models = transform_models(variants, ground, kind).models.set_index("model_id")
    order = np.arange(variants["model_id"].nunique()).astype(str)
    return models["m_0"].reindex(order).to_numpy()


def _by_model(worst, m_0):
    return worst[MODEL].drop_duplicates().assign(m_0=m_0)


def _usual_m_0(solution, name, worst):
    """Median m_0 of the models of the flight that hold nothing wrong."""
    models = solution.first_models(name)
    suspect = pd.MultiIndex.from_frame(worst[MODEL])
    is_good = ~pd.MultiIndex.from_frame(models[MODEL]).isin(suspect)
    return float(models.loc[is_good, "m_0"].median())


def _exchange(name, row, place, measured):
    is_in_model = (measured["coverage"] == row.coverage) & (
        measured["model_id"] == row.model_id
    )
    pair = [row.point_id, row.point_id_other]
    return ExchangedNames(
        flight=name,
        coverage=row.coverage,
        model_id=row.model_id,
        points=tuple(pair),
        apart=float(np.hypot(*np.diff(place.reindex(pair).to_numpy(), axis=0)[0])),
        m_0=float(row.before),
        m_0_exchanged=float(row.m_0),
        model_points=tuple(measured.loc[is_in_model, "point_id"]),
    )
