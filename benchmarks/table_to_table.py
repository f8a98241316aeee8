"""From shuffled tables with names to tables: the whole way that a user has.

``transform_models`` against a merge and ``numpy.linalg.lstsq`` in ``groupby.apply``.
The peer takes a part of the models; what it takes for one hardly depends on how many.
"""

import numpy as np
import pandas as pd

import einschalt as es
from benchmarks.model_generator import generate
from benchmarks.racing import Contender, one_core, race

N_MODELS, N_LOOP = 20_000, 1000
GROUND_PER_ROW = 0.45  # a ground point lies in somewhat more than two models


def run():
    """Run the race.

    Returns
    -------
    bool
        Whether every floor is kept.
    """
    model, ground = _tables(N_MODELS)
    few, few_ground = _tables(N_LOOP)
    fit = es.transform_models(few, few_ground)
    theirs = _by_pandas(few, few_ground).loc[fit.parameters.index]
    ours = fit.models.set_index("model_id")
    np.testing.assert_allclose(ours["s_0"], theirs["s_0"], rtol=1e-7)
    for name in ("a1", "a2", "b1", "b2"):
        np.testing.assert_allclose(
            fit.parameters[name], theirs[name], rtol=0, atol=1e-10
        )
    with one_core():
        return race(
            f"Table to table, affine of {N_MODELS} models, {len(model)} rows",
            "model",
            Contender(
                "einschalt.transform_models, one core",
                lambda: es.transform_models(model, ground),
                N_MODELS,
            ),
            [
                Contender(
                    "pandas merge, groupby.apply(lstsq)",
                    lambda: _by_pandas(few, few_ground),
                    N_LOOP,
                    floor=60,
                )
            ],
        )


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
    return merged.groupby("model_id")[["x", "y", "easting", "northing"]].apply(_affine)


def _affine(part):
    xy, en = part[["x", "y"]].to_numpy(), part[["easting", "northing"]].to_numpy()
    design = np.column_stack([np.ones(len(xy)), xy - xy.mean(axis=0)])
    observed = en - en.mean(axis=0)
    parameters, *_ = np.linalg.lstsq(design, observed)
    misfit = design @ parameters - observed
    s_0 = np.sqrt(np.sum(misfit**2) / (2 * len(xy) - 6))
    east, north = parameters[:, 0], parameters[:, 1]
    values = [east[1], east[2], north[1], north[2], s_0]
    return pd.Series(values, index=["a1", "a2", "b1", "b2", "s_0"])
