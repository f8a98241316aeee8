"""Means of a million values in random order by their covariances, point by point.

Ours takes covariances between the values of a point, which models on the same ground
have; the peers add up the information of independent values. Where values are
independent all come to the same.
"""

import numpy as np
import pandas as pd

from benchmarks.racing import Contender, at_least, one_core, peer, race
from einschalt.foundations.batches import segments
from einschalt.stages.value_weights import RIGOROUS, value_weights
from einschalt.theory.double_coverage import mean_of_values

N_VALUES, N_POINTS = 1_000_000, 455_000
ORIGIN = np.array([4.5e6, 5.3e6])  # m
SUMS = """
    with each as (
        select point, easting - {0} as e, northing - {1} as n,
            nn / (ee * nn - en * en) as w_e, ee / (ee * nn - en * en) as w_n,
            -en / (ee * nn - en * en) as w_x
        from given
    ), summed as (
        select point, sum(w_e) as a, sum(w_n) as b, sum(w_x) as c,
            sum(w_e * e + w_x * n) as r, sum(w_x * e + w_n * n) as s
        from each group by point
    )
    select point, {0} + (b * r - c * s) / (a * b - c * c) as easting,
        {1} + (a * s - c * r) / (a * b - c * c) as northing
    from summed
""".format(*ORIGIN)


def run():
    """Race databases.

    Returns
    -------
    list of Race
    """
    values = _values()
    expected = _ours(values)
    peers = []
    for name, make in (("polars", _by_polars), ("duckdb", _by_duckdb)):
        module = peer(name)
        if module is not None:
            mean = make(module, values)
            found = mean().sort_values("point")[["easting", "northing"]]
            np.testing.assert_allclose(found, expected, rtol=0, atol=1e-8)
            bound = at_least(0.05, 2.5)
            peers.append(Contender(f"{name}, one core", mean, N_VALUES, bound))
    with one_core():
        ours = Contender(
            "einschalt, joint covariances, one core", lambda: _ours(values), N_VALUES
        )
        title = f"Mean by covariances of {N_POINTS} points"
        return [race(title, "value", ours, peers)]


def _values():
    rng = np.random.default_rng(1)
    others = rng.integers(0, N_POINTS, N_VALUES - N_POINTS)
    point = rng.permutation(np.concatenate([np.arange(N_POINTS), others]))
    place = ORIGIN + rng.uniform(0.0, 1e5, (N_POINTS, 2))
    variance = rng.uniform(0.03, 0.08, (2, N_VALUES)) ** 2
    covariance = rng.uniform(-0.3, 0.3, N_VALUES) * np.sqrt(variance.prod(axis=0))
    easting, northing = (place[point] + rng.normal(0.0, 0.05, (N_VALUES, 2))).T
    columns = {"point": point, "easting": easting, "northing": northing}
    return pd.DataFrame(columns).assign(ee=variance[0], nn=variance[1], en=covariance)


def _ours(values):
    sort = segments(values["point"].to_numpy(), N_POINTS)
    ee, nn, en = (values[name].to_numpy() for name in ("ee", "nn", "en"))

    def covariances(pairs):
        own = np.column_stack([ee, en, en, nn]).reshape(-1, 2, 2)
        between = np.zeros((len(pairs), 2, 2))
        is_own = np.flatnonzero(pairs[:, 0] == pairs[:, 1])
        between[is_own] = own[pairs[is_own, 0]]
        return between

    weights = value_weights(RIGOROUS, None, sort.order, sort.start, covariances)
    axes = (values[axis].to_numpy() for axis in ("easting", "northing"))
    coordinates = np.column_stack([axis[sort.order] for axis in axes])
    errors = np.ones(N_VALUES)
    return mean_of_values(coordinates, errors, weights.in_mean, sort.start).mean


def _by_polars(polars, values):
    given = polars.from_pandas(values)

    def mean():
        context = polars.SQLContext(given=given, eager=True)
        return context.execute(SUMS).to_pandas()

    return mean


def _by_duckdb(duckdb, values):
    connection = duckdb.connect(config={"threads": 1})
    connection.register("frame", values)
    connection.execute("create table given as select * from frame")
    return lambda: connection.execute(SUMS).df()
