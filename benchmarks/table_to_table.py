"""From shuffled tables with names to tables: the whole way that a user has.

``transform_models`` against a merge and ``numpy.linalg.lstsq`` in ``groupby.apply``,
both for parameters, covariance, s_0, and a table of residuals with leverages. The peer
takes a part of the models; what it takes for one hardly depends on how many. A join of
the same tables, without any computation, shows what finding points by name takes.
"""

import numpy as np
import pandas as pd

import einschalt as es
from benchmarks.model_generator import generate
from benchmarks.racing import Contender, at_least, one_core, peer, race

N_MODELS, N_LOOP = 20_000, 1000
GROUND_PER_ROW = 0.45  # a ground point lies in somewhat more than two models


def run():
    """Race a loop over models, and a join.

    Returns
    -------
    list of Race
    """
    model, ground = _tables(N_MODELS)
    few, few_ground = _tables(N_LOOP)
    fit = es.transform_models(few, few_ground)
    _assert_same(fit, _by_pandas(few, few_ground))
    by_pandas = Contender(
        "pandas merge, groupby.apply(lstsq)",
        lambda: _by_pandas(few, few_ground),
        N_LOOP,
        at_least(45, 60),
    )
    title = f"Table to table, affine of {N_MODELS} models, {len(model)} rows"
    with one_core():
        races = [race(title, "model", _ours(model, ground, "one core"), [by_pandas])]
    joins = _joins(model, ground)
    return [*races, race(title, "model", _ours(model, ground, "all cores"), joins)]


def _ours(model, ground, name):
    def run():
        return es.transform_models(model, ground)

    return Contender(f"einschalt.transform_models, {name}", run, N_MODELS)


def _joins(model, ground):
    polars = peer("polars")
    if polars is None:
        return []
    tables = [polars.from_pandas(table) for table in (model, ground)]

    def join():
        return tables[0].join(tables[1], on="point_id", maintain_order="left")

    assert join().height == len(model)
    return [
        Contender("polars join alone, all cores", join, N_MODELS, at_least(0.2, 0.5))
    ]


def _tables(n_models):
    """Shuffled rows; every model holds a run of the ground points."""
    models = generate(n_models, seed=1)
    rng = np.random.default_rng(2)
    counts = np.diff(models.start)
    n_rows = int(models.start[-1])
    n_ground = int(GROUND_PER_ROW * n_rows)
    en = np.array([4.5e6, 5.3e6]) + rng.uniform(0.0, 1e5, (n_ground, 2))
    first = rng.integers(0, n_ground - 200, n_models)
    within = np.arange(n_rows) - np.repeat(models.start[:-1], counts)
    point = np.repeat(first, counts) + within
    xy = (en[point] - [4.5e6, 5.3e6]) / 8.0 + rng.normal(0.0, 0.02, (n_rows, 2))
    model = pd.DataFrame(xy, columns=["x", "y"])
    model["model_id"] = [f"m{k}" for k in np.repeat(np.arange(n_models), counts)]
    model["point_id"] = [f"P{k:07d}" for k in point]
    ground = pd.DataFrame(en, columns=["easting", "northing"])
    ground["point_id"] = [f"P{k:07d}" for k in range(n_ground)]
    return (
        model.sample(frac=1.0, random_state=3, ignore_index=True),
        ground.sample(frac=1.0, random_state=4, ignore_index=True),
    )


def _by_pandas(model, ground):
    merged = model.merge(ground, on="point_id")
    fits = []
    columns = ["model_id", "point_id", "x", "y", "easting", "northing"]
    residuals = merged.groupby("model_id")[columns].apply(_affine, fits)
    models = pd.DataFrame(fits, columns=["model_id", "parameters", "covariance", "s_0"])
    return models.set_index("model_id"), residuals


def _affine(part, fits):
    xy, en = part[["x", "y"]].to_numpy(), part[["easting", "northing"]].to_numpy()
    design = np.column_stack([np.ones(len(xy)), xy - xy.mean(axis=0)])
    observed = en - en.mean(axis=0)
    parameters, *_ = np.linalg.lstsq(design, observed)
    misfit = design @ parameters - observed
    s_0 = np.sqrt(np.sum(misfit**2) / (2 * len(xy) - 6))
    cofactors = np.linalg.inv(design.T @ design)
    leverage = np.einsum("ni,ij,nj->n", design, cofactors, design)
    fits.append((part["model_id"].iloc[0], parameters, s_0**2 * cofactors, s_0))
    return pd.DataFrame(
        {
            "point_id": part["point_id"],
            "residual_easting": misfit[:, 0],
            "residual_northing": misfit[:, 1],
            "leverage": leverage,
        }
    )


def _assert_same(fit, theirs):
    models, residuals = theirs
    models = models.loc[fit.parameters.index]
    np.testing.assert_allclose(fit.models["s_0"], models["s_0"], rtol=1e-7)
    linear = np.stack(models["parameters"])[:, 1:]
    np.testing.assert_allclose(
        fit.parameters[["a1", "a2"]], linear[:, :, 0], rtol=0, atol=1e-10
    )
    keys = ["model_id", "point_id"]
    residuals = residuals.reset_index().sort_values(keys)
    ours = fit.residuals.sort_values(keys)
    for name in ("residual_easting", "residual_northing", "leverage"):
        np.testing.assert_allclose(ours[name], residuals[name], rtol=1e-8, atol=5e-9)
