"""Residuals in grids: ellipses hold what they say, wrong points are named."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy import stats
from tests.simulated_shifts import simulated_shifts

import einschalt as es

FINLAND = Path(__file__).parents[2] / "data_examples" / "fi_ykj_tm35fin"
SQUARE = {"extent": 5e3, "reach": 800.0, "signal": 0.3, "noise": 0.03}
COUNTRY = {"extent": 3e5, "reach": 2e4, "signal": 0.5, "noise": 0.05}
SETS = {
    "square": (3000, {**SQUARE, "wrong": 0.05}),
    "square with tails": (
        3000,
        {**SQUARE, "freedom": 3.0, "clusters": 100, "wrong": 0.05},
    ),
    "country with tails": (4000, {**COUNTRY, "freedom": 4.0, "wrong": 0.05}),
    "country without wrong ones": (4000, COUNTRY),
}
LIMIT = -2.0 * np.log(0.05)
TURNED = np.array([[0.8, -0.6], [0.6, 0.8]]) * 1.0001


def tables(xy, shifts):
    """Model points and ground points of one model."""
    names = [f"P{k}" for k in range(len(xy))]
    model = pd.DataFrame(xy, columns=["x", "y"]).assign(model_id="1", point_id=names)
    target = xy @ TURNED.T + np.array([5e5, 5.2e6]) + shifts
    ground = pd.DataFrame(target, columns=["easting", "northing"])
    return model, ground.assign(point_id=names)


def within(points, ground):
    """Whether each point lies within its 95 % ellipse."""
    away = (points[["easting", "northing"]] - ground).to_numpy()
    east, north, both = (
        points[["standard_error_easting", "standard_error_northing", "covariance_en"]]
        .to_numpy()
        .T
    )
    squares = (
        (away[:, 0] * north) ** 2
        - 2.0 * both * away[:, 0] * away[:, 1]
        + (away[:, 1] * east) ** 2
    )
    return squares <= LIMIT * ((east * north) ** 2 - both**2)


@pytest.fixture(scope="module", params=SETS)
def held_out(request):
    """A distribution of most points of a set, and what it makes of the others."""
    n_points, options = SETS[request.param]
    rng = np.random.default_rng(11)
    xy, shifts, is_wrong = simulated_shifts(rng, n_points, **options)
    model, ground = tables(xy, shifts)
    is_held = rng.random(n_points) < 0.3
    fit = es.transform_models(model[~is_held], ground)
    found = fit.distributed(method="collocation")
    points = found.transform(model[is_held & ~is_wrong])
    truth = ground.loc[is_held & ~is_wrong, ["easting", "northing"]]
    return found, points, truth.set_axis(points.index), set(model["point_id"][is_wrong])


def test_ellipses_hold_as_many_held_out_points_as_they_say(held_out):
    _, points, truth, _ = held_out
    # what the known points tell of the tails is as uncertain as the held-out ones
    spread = 3.0 * np.sqrt(2.0) * stats.binom.std(len(points), 0.95) / len(points)
    assert within(points, truth).mean() == pytest.approx(0.95, abs=spread)
    away = np.hypot(*(points[["easting", "northing"]] - truth).to_numpy().T)
    assert np.sqrt(np.mean(away**2)) < 1.3 * np.sqrt(np.mean(points["m_t"] ** 2))


def test_wrong_points_are_left_out_by_name(held_out):
    found, _, _, is_wrong = held_out
    named, known = set(found.left_out["point_id"]), set(found.observed.rows["point_id"])
    sure = {row.point_id for row in found.left_out.itertuples() if row.deviation > 1.0}
    assert len(sure - is_wrong) <= 0.002 * len(known)
    assert len(named - is_wrong) <= 0.01 * len(known)
    assert len((is_wrong & known) - named) <= 0.15 * len(is_wrong & known)
    assert set(found.left_out["reason"]) <= {"contradicts its neighbours"}


def test_every_point_comes_back(held_out):
    found, points, _, _ = held_out
    back = found.inverse(points[["model_id", "point_id", "easting", "northing"]])
    again = found.transform(back)
    columns = ["easting", "northing"]
    np.testing.assert_allclose(again[columns], points[columns], atol=1e-6, rtol=0)


@pytest.mark.slow
def test_finland_is_predicted_better_than_by_triangles():
    old, new = (
        pd.read_csv(FINLAND / f"{name}.csv")
        for name in ("model_points", "ground_points")
    )
    part = np.random.default_rng(12).permutation(len(old)) % 5
    inside, away = [], {"collocation": [], "triangles": []}
    for k in range(5):
        fit = es.transform_models(old[part != k], new)
        truth = old[part == k].merge(new, on="point_id")[["easting", "northing"]]
        for method, found in away.items():
            points = fit.distributed(method=method).transform(old[part == k])
            found.append(points[["easting", "northing"]].to_numpy() - truth.to_numpy())
            if method == "collocation":
                inside.append(within(points, truth.set_axis(points.index)))
    assert 0.93 <= np.concatenate(inside).mean() <= 0.97
    smooth, linear = (np.hypot(*np.concatenate(found).T) for found in away.values())
    common = np.isfinite(linear)  # within the triangles
    rms = [np.sqrt(np.mean(each[common] ** 2)) for each in (smooth, linear)]
    assert rms[0] < 0.09
    assert rms[0] < 0.8 * rms[1]


@pytest.mark.slow
def test_natural_neighbours_go_through_the_points_and_know_their_error():
    rng = np.random.default_rng(13)
    xy, shifts, _ = simulated_shifts(rng, 600, **{**SQUARE, "noise": 0.0})
    model, ground = tables(xy, shifts)
    is_held = rng.random(600) < 0.3
    fit = es.transform_models(model[~is_held], ground)
    found = fit.distributed(method="natural_neighbour", cell=20.0)
    own = found.transform(model[~is_held])[["easting", "northing"]].to_numpy()
    given = ground.loc[~is_held, ["easting", "northing"]].to_numpy()
    missed = np.sqrt(np.mean(np.sum((own - given) ** 2, axis=1)))
    said = found.distribution.iloc[0]
    # a point is a kink, where interpolation in cells is at its worst
    assert missed < said["interpolation_error_largest"] < 0.2
    points = found.transform(model[is_held])
    truth = ground.loc[is_held, ["easting", "northing"]].set_axis(points.index)
    assert within(points, truth).mean() == pytest.approx(0.95, abs=0.04)


def test_ellipses_know_what_cells_lose_between_their_nodes():
    rng = np.random.default_rng(18)
    fine = {**SQUARE, "noise": 0.005}
    xy, shifts, _ = simulated_shifts(rng, 2500, **fine)
    model, ground = tables(xy, shifts)
    is_held = rng.random(2500) < 0.3
    fit = es.transform_models(model[~is_held], ground)
    found = fit.distributed(method="collocation", cell=150.0)
    points = found.transform(model[is_held])
    truth = ground.loc[is_held, ["easting", "northing"]].set_axis(points.index)
    assert 0.93 < within(points, truth).mean() < 0.97  # without that 0.91


def test_the_share_of_all_held_out_points_is_said_beside_that_of_the_good(held_out):
    found, *_ = held_out
    said, n_out = found.distribution.iloc[0], len(found.left_out)
    assert said["within"] == pytest.approx(0.95, abs=1e-3)
    n_all = len(found.observed.rows)
    # who is left out lies outside
    expected = 0.95 * (n_all - n_out) / n_all
    assert said["within_all"] == pytest.approx(expected, abs=3e-3)
    line = f"95 % ellipses hold {said['within']:.1%} of them, which makes their size"
    line += f"; {said['within_all']:.1%} with those left out" if n_out else "\n"
    assert line in f"{found.summary()}\n"


def test_wrong_points_that_are_kept_make_ellipses_that_hold_them_too():
    rng = np.random.default_rng(14)
    xy, shifts, _ = simulated_shifts(rng, 1500, **{**SQUARE, "wrong": 0.05})
    model, ground = tables(xy, shifts)
    fit = es.transform_models(model, ground)
    sure, kept = (
        fit.distributed(method="collocation", outliers=word)
        for word in ("set_aside", "keep")
    )
    assert not len(kept.left_out)
    assert kept.transform(model)["m_t"].median() > 3.0 * (
        sure.transform(model)["m_t"].median()
    )


def test_points_that_change_places_do_not_fold_the_grid():
    rng = np.random.default_rng(15)
    xy, shifts, _ = simulated_shifts(rng, 400, **{**SQUARE, "noise": 0.001})
    model, ground = tables(xy, shifts)
    first, second = ground.loc[[7, 300], ["easting", "northing"]].to_numpy()
    ground.loc[[7, 300], ["easting", "northing"]] = second, first
    fit = es.transform_models(model, ground)
    found = fit.distributed(method="natural_neighbour", outliers="keep", cell=50.0)
    assert {"P7", "P300"} <= set(found.left_out["point_id"])
    assert found.left_out["reason"].str.startswith("strains").any()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"method": "colocation"}, 'Write method="collocation"'),
        ({"method": "collocation", "outliers": "drop"}, "outliers = 'drop' is unknown"),
        ({"cell": 5.0}, "cell is given"),
        ({"method": "collocation", "triangles": pd.DataFrame()}, "triangles is given"),
        ({"method": "collocation"}, "9 identical points .* expected 10 or more"),
    ],
)
def test_what_cannot_be_distributed_is_said(options, said):
    xy = np.random.default_rng(16).uniform(0.0, 100.0, (9, 2))
    fit = es.transform_models(*tables(xy, np.zeros((9, 2))))
    with pytest.raises(es.EinschaltError, match=said):
        fit.distributed(**options)


@pytest.mark.parametrize("cell", [0.0, -5.0, np.nan, 1e-4])
def test_cells_that_no_grid_has_are_refused(cell):
    xy = np.random.default_rng(17).uniform(0.0, 100.0, (30, 2))
    fit = es.transform_models(*tables(xy, 0.01 * xy))
    with pytest.raises(es.EinschaltError, match=r"cell = .* expected more than 0\.02"):
        fit.distributed(method="collocation", cell=cell)


def test_points_on_a_line_are_refused():
    along = np.linspace(0.0, 2e3, 40)[:, None] * [0.6, 0.8]
    noise = 0.02 * np.random.default_rng(19).normal(size=(40, 2))
    for shifts in (np.zeros((40, 2)), noise):
        fit = es.transform_models(*tables(along, shifts), kind="helmert")
        with pytest.raises(es.EinschaltError, match="lie on a line, and collocation"):
            fit.distributed(method="collocation")


def test_the_error_of_wide_cells_is_that_of_the_grid_not_of_the_method():
    xy, shifts, _ = simulated_shifts(np.random.default_rng(5), 1500, **SQUARE)
    model, ground = tables(xy, shifts)
    is_held = np.arange(len(model)) % 4 == 0
    fit = es.transform_models(model[~is_held], ground)
    errors = []
    for cell in (100.0, 1200.0):
        found = fit.distributed(method="collocation", cell=cell)
        away = found.transform(model[is_held])[["easting", "northing"]].to_numpy()
        away -= ground.loc[is_held, ["easting", "northing"]].to_numpy()
        away = away[np.isfinite(away).all(axis=1)]
        error, _ = found.held_out_error()
        assert f"{error:.4f} m" in found.summary()
        errors.append(error)
        rms = np.sqrt((away**2).sum(axis=1).mean())
        assert error == pytest.approx(rms, rel=0.2)
    assert errors[1] > 1.5 * errors[0]
