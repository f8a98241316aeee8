"""Points for which two flights have measured different targets.

All models of the low flight that hold such a point agree with each other, and so do
those of the high flight: neither contradicts itself. But the low flight, fitted onto
its other points, finds the point elsewhere. Where it has given coordinates, these tell
which flight has taken another target; otherwise nothing does.
"""

from dataclasses import dataclass

import numpy as np

from einschalt.foundations.batches import segments
from einschalt.foundations.frame_columns import (
    PLAN,
    columns_of,
    values_of,
    with_columns,
)
from einschalt.foundations.names import encode, is_among
from einschalt.pipeline.densification.result_tables import HIGH, LOW
from einschalt.theory.adjustment.multiple_testing import bonferroni
from einschalt.theory.adjustment.significance import FINDING_SIGNIFICANCE

FEWEST_MODELS = 2
# each model by itself contradicts the approximate coordinates with this probability
EACH = 0.01
# what models of one target scatter by, of the distance between both targets
MOST_SCATTER = 0.5
# more points are no mistaken targets: the approximate coordinates are wrong
MOST_SHARE = 0.02
MOST_LEVERAGE = 0.9
RESIDUALS = ["residual_easting", "residual_northing"]


@dataclass(frozen=True)
class OtherTarget:
    """A point that lies elsewhere in one flight than in the other."""

    point_id: str
    distance: float  # between both targets [m]
    n_models: int  # of the low flight that say so
    flight: str  # that has taken the other target; empty where nothing tells
    p_value: float  # of the clearest model, among all residuals (Bonferroni)


def find_other_targets(two_step) -> tuple[OtherTarget, ...]:
    """Find points for which the flights have measured different targets.

    Those farthest apart first; none where there is no high flight, or where so many
    points differ that no targets were mistaken. Beside control that is displaced those
    that are left once it is put right: it parts the flights, where their models reach
    across its edge.
    """
    if any(region.is_of_control for region in two_step.displaced_regions):
        return find_other_targets(two_step.corrected)
    if two_step.high is None:
        return ()
    table = _predictions(two_step.low.residuals)
    names = encode(table["point_id"])
    most = max(1.0, MOST_SHARE * len(names))
    is_clear = _are_clear(table, names)
    # further passes have residuals at points that the high flight does not have
    is_clear &= is_among(names.dictionary, two_step.approximations["point_id"])
    if not is_clear.any():
        return ()
    table = table[is_clear[names.codes]]
    points = table.groupby("point_id", sort=False).agg(
        n_models=("p_value", "size"),
        smallest=("of_all", "min"),
        **{name: (name, "mean") for name in PLAN},
    )
    points = points[_are_of_one_target(two_step, table, points)]
    if len(points) > most:
        return ()
    # what models of the high flight, without the point, miss it by
    missed = _predictions(two_step.high.transformation.residuals)
    missed = missed[missed["point_id"].isin(points.index)]
    in_high_flight = missed.groupby("point_id")[PLAN].mean()
    found = [_target(two_step, point, in_high_flight) for point in points.itertuples()]
    found = [target for target in found if target is not None]
    return tuple(sorted(found, key=lambda target: -target.distance))


def _are_clear(table, names):
    """Points that all models contradict, and one beyond doubt, (n_points,)."""
    if not len(names):
        return np.zeros(0, dtype=bool)
    parts = segments(names.codes, len(names))
    largest, smallest = (
        of_points.reduceat(table[name].to_numpy()[parts.order], parts.start[:-1])
        for of_points, name in ((np.maximum, "p_value"), (np.minimum, "of_all"))
    )
    is_clear = (largest < EACH) & (smallest < FINDING_SIGNIFICANCE)
    return is_clear & (np.diff(parts.start) >= FEWEST_MODELS)


def _predictions(residuals):
    """What each model of a flight, without the point, misses it by."""
    p_value = residuals["p_value"].to_numpy(dtype=float)
    table = with_columns(
        columns_of(residuals, ["point_id", "leverage", *RESIDUALS]),
        p_value=p_value,
        of_all=bonferroni(p_value),
    )
    table = table[np.isfinite(p_value) & (table["leverage"] < MOST_LEVERAGE)]
    missed = values_of(table, RESIDUALS) / (1.0 - values_of(table, ["leverage"]))
    return with_columns(table, **dict(zip(PLAN, missed.T, strict=True)))


def _are_of_one_target(two_step, table, points):
    """Whether the models of each flight agree with each other, (n_points,).

    ``points``: indexed by name, with the mean of what models miss each of them by.
    """
    distance = np.hypot(*values_of(points, PLAN).T)
    rows = table[table["point_id"].isin(points.index)]
    place = points.index.get_indexer(rows["point_id"])
    away = np.hypot(*(values_of(rows, PLAN) - values_of(points, PLAN)[place]).T)
    scatter = np.zeros(len(points))
    np.maximum.at(scatter, place, away)
    approximate = two_step.approximations.set_index("point_id")
    if "spread_total" in approximate:
        spread = approximate["spread_total"].reindex(points.index).to_numpy(dtype=float)
        scatter = np.fmax(scatter, spread)
    return scatter <= MOST_SCATTER * distance


def _target(two_step, point, in_high_flight):
    """A point as another target; None where its given coordinates are wrong instead."""
    approximations = two_step.approximations
    is_its = approximations["point_id"] == point.Index
    place = values_of(approximations[is_its], PLAN)[0]
    in_low = place + [getattr(point, name) for name in PLAN]
    control = two_step.block.control_points
    given = control.loc[control["point_id"] == point.Index, PLAN].to_numpy(dtype=float)
    in_high, flight = place, ""
    distance = float(np.hypot(*(in_high - in_low)))
    if len(given):
        # models that were fitted onto the point have been drawn to it
        if point.Index in in_high_flight.index:
            in_high = given[0] + in_high_flight.loc[point.Index, PLAN].to_numpy()
        from_given = [float(np.hypot(*(at - given[0]))) for at in (in_high, in_low)]
        flight = HIGH if from_given[0] > from_given[1] else LOW
        if np.hypot(*(in_high - in_low)) <= MOST_SCATTER * min(from_given):
            return None
        distance = max(from_given)
    return OtherTarget(
        str(point.Index), distance, point.n_models, flight, point.smallest
    )
