"""Pairs of photographs that make models, chosen from what was measured in them."""

import numpy as np
import pandas as pd
import pytest

from einschalt.stages.relative_orientation.model_choice import choose_models

DISTANCE_MM, HALF_MM, HEIGHT_M = 153.0, 115.0, 1530.0
SIDE_M = 2 * HALF_MM / DISTANCE_MM * HEIGHT_M  # of an image on the ground


def photographed(centres, turned=(0.0,), n_points=4000, seed=7):
    """Image points of vertical photographs over hills, the strips turned by kappa."""
    rng = np.random.default_rng(seed)
    centres = np.asarray(centres, dtype=float)
    low, high = centres.min(axis=0) - SIDE_M / 2, centres.max(axis=0) + SIDE_M / 2
    ground = rng.uniform(low, high, (n_points, 2))
    relief = rng.uniform(-0.05, 0.05, n_points) * HEIGHT_M
    tables = []
    for k, centre in enumerate(centres):
        kappa = turned[k % len(turned)]
        turn = np.array(
            [[np.cos(kappa), -np.sin(kappa)], [np.sin(kappa), np.cos(kappa)]]
        )
        xy = (ground - centre) @ turn * (DISTANCE_MM / (HEIGHT_M - relief))[:, None]
        is_in = (np.abs(xy) <= HALF_MM).all(axis=1)
        xy = xy[is_in] + rng.normal(0.0, 0.01, (is_in.sum(), 2))
        table = pd.DataFrame(
            {"image_id": f"{k:02d}", "point_id": np.flatnonzero(is_in)}
        )
        tables.append(table.assign(x=xy[:, 0], y=xy[:, 1]))
    return pd.concat(tables, ignore_index=True)


def pairs_of(chosen):
    columns = ["left_image", "right_image"]
    return set(chosen.models[columns].itertuples(index=False, name=None))


def test_a_strip_has_models_of_its_neighbours():
    base = 0.4 * SIDE_M  # 60 % forward overlap
    chosen = choose_models(
        photographed([(k * base, 0.0) for k in range(6)]), DISTANCE_MM
    )
    neighbours = {(f"{k:02d}", f"{k + 1:02d}") for k in range(5)}
    assert neighbours <= pairs_of(chosen)
    is_next = chosen.models["right_image"].astype(int) == 1 + chosen.models[
        "left_image"
    ].astype(int)
    np.testing.assert_allclose(chosen.base_ratio[is_next], base / HEIGHT_M, rtol=0.03)
    # 20 % overlap, twice the base
    np.testing.assert_allclose(
        chosen.base_ratio[~is_next], 2 * base / HEIGHT_M, rtol=0.05
    )
    assert not chosen.alone
    assert set(chosen.models["coverage"]) == {"1"}


def test_strips_flown_to_and_fro_are_tied():
    along, across = 0.4 * SIDE_M, 0.7 * SIDE_M
    centres = [(k * along, strip * across) for strip in range(2) for k in range(4)]
    turned = np.repeat([0.1, 0.1 + np.pi], 4)
    chosen = choose_models(photographed(centres, turned), DISTANCE_MM)
    between = [(a, b) for a, b in pairs_of(chosen) if (int(a) < 4) != (int(b) < 4)]
    assert len(between) >= 2
    bases = {
        pair: np.hypot(*np.subtract(*(centres[int(name)] for name in pair)))
        for pair in pairs_of(chosen)
    }
    expected = [
        bases[a, b] / HEIGHT_M
        for a, b in chosen.models[["left_image", "right_image"]].to_numpy()
    ]
    np.testing.assert_allclose(chosen.base_ratio, expected, rtol=0.1)


def test_a_base_that_gives_no_heights_makes_no_model():
    points = photographed([(0.0, 0.0), (0.02 * SIDE_M, 0.0), (0.4 * SIDE_M, 0.0)])
    assert pairs_of(choose_models(points, DISTANCE_MM)) == {("00", "02"), ("01", "02")}


@pytest.mark.parametrize("n_common", [0, 7])
def test_photographs_with_too_few_common_points_stand_alone(n_common):
    points = photographed([(0.0, 0.0), (0.4 * SIDE_M, 0.0)])
    right = points[points["image_id"] == "01"]
    own = set(points.loc[points["image_id"] == "00", "point_id"])
    is_shared = right["point_id"].isin(own)
    kept = pd.concat([right[~is_shared], right[is_shared].head(n_common)])
    points = pd.concat([points[points["image_id"] == "00"], kept])
    chosen = choose_models(points, DISTANCE_MM)
    assert len(chosen.models) == 0
    assert chosen.alone == ["00", "01"]
    nothing = choose_models(points.head(0), DISTANCE_MM)
    assert len(nothing.models) == 0
    assert nothing.alone == []


def test_models_whose_names_would_be_the_same_are_numbered():
    points = photographed([(0.0, 0.0), (0.4 * SIDE_M, 0.0)])
    two = [
        points.assign(
            image_id=points["image_id"].map(
                dict(zip(("00", "01"), names, strict=True))
            ),
            point_id=points["point_id"].astype(str) + names[0],
        )
        for names in (("a-b", "c"), ("a", "b-c"))
    ]
    chosen = choose_models(pd.concat(two), DISTANCE_MM)
    assert chosen.models["model_id"].tolist() == ["1", "2"]


def test_a_large_block_is_chosen_from_at_once():
    # 10 000 photographs of 60 points: all pairs that share points, no loop over them
    n, each = 100, 8
    centres = np.stack(np.meshgrid(range(n), range(n)), axis=-1).reshape(-1, 2) * 0.4
    offsets = np.stack(np.meshgrid(range(each), range(each)), axis=-1).reshape(-1, 2)
    grid = (2 * centres[:, None, :] / 0.4 + offsets).astype(int)
    xy = (grid - 2 * centres[:, None, :] / 0.4 - 3.5) * 30.0
    points = pd.DataFrame(
        {
            "image_id": np.repeat(np.arange(n * n).astype(str), each * each),
            "point_id": (grid[..., 0] * 10_000 + grid[..., 1]).ravel(),
            "x": xy[..., 0].ravel(),
            "y": xy[..., 1].ravel(),
        }
    )
    chosen = choose_models(points, DISTANCE_MM)
    assert not chosen.alone
    assert n * n <= len(chosen.models) <= 3 * n * n
    assert chosen.n_common.min() >= 8


def around(n_images=16, n_points=1500, seed=3, most_shown=5):
    """Oblique photographs of a ring around one place; the centres, and the ground.

    As a drone makes them: each shows most of the ground, and automatic matching finds a
    point in neighbours rather than from opposite sides.
    """
    rng = np.random.default_rng(seed)
    ground = rng.uniform(-0.5, 0.5, (n_points, 3)) * [1.0, 1.0, 0.05]
    around = np.arange(n_images) * 2 * np.pi / n_images
    centres = np.stack([np.cos(around), np.sin(around), np.ones(n_images)], axis=1)
    centres[:, :2] *= np.tan(np.radians(42.0))
    first = rng.integers(0, n_images, n_points)  # the middle of those that show it
    n_shown = rng.integers(2, most_shown + 1, n_points)
    tables = []
    for k, centre in enumerate(centres):
        axis = -centre / np.linalg.norm(centre)
        right = np.cross(axis, [0.0, 0.0, 1.0])
        right /= np.linalg.norm(right)
        local = (ground - centre) @ np.stack([right, np.cross(axis, right), axis]).T
        xy = local[:, :2] / local[:, 2:] * [1.0, -1.0]
        steps = (k - first) % n_images
        is_in = (np.abs(xy) <= 0.4).all(axis=1) & (steps < n_shown)
        xy = (xy + rng.normal(0.0, 3e-5, xy.shape))[is_in] * DISTANCE_MM
        table = pd.DataFrame(
            {"image_id": f"{k:02d}", "point_id": np.flatnonzero(is_in)}
        )
        tables.append(table.assign(x=xy[:, 0], y=xy[:, 1]))
    return pd.concat(tables, ignore_index=True), centres, ground


def held_by(chosen, points):
    """Points that a chosen pair shows in both photographs."""
    of = points.groupby("image_id")["point_id"].agg(set)
    return set().union(*(of[a] & of[b] for a, b in pairs_of(chosen)))


@pytest.mark.parametrize("seed", [3, 4, 5])
def test_every_point_that_a_pair_can_hold_is_in_one(seed):
    points, _, _ = around(seed=seed)
    chosen = choose_models(points, DISTANCE_MM)
    n_images = points["point_id"].value_counts()
    held = held_by(chosen, points)
    assert {str(name) for name in set(n_images.index[n_images > 1]) - held} == set(
        chosen.unpaired
    )
    assert chosen.n_single == np.count_nonzero(n_images == 1)
    assert not chosen.unpaired
    assert len(held) > 1000


def test_points_that_no_pair_can_hold_are_named():
    points = photographed([(0.0, 0.0), (0.4 * SIDE_M, 0.0), (0.5 * SIDE_M, 2e4)])
    far = points["image_id"] == "02"
    # three points of the first two photographs in the third one: too few for a model
    shared = sorted(
        set(points.loc[points["image_id"] == "00", "point_id"])
        - set(points.loc[points["image_id"] == "01", "point_id"])
    )[:3]
    numbers = points.loc[far, "point_id"].to_numpy(copy=True)
    numbers[:3] = shared
    points.loc[far, "point_id"] = numbers
    chosen = choose_models(points, DISTANCE_MM)
    assert pairs_of(chosen) == {("00", "01")}
    assert sorted(chosen.unpaired) == sorted(map(str, shared))
    n_images = points["point_id"].value_counts()
    assert chosen.n_single == np.count_nonzero(n_images == 1) > 0


def test_the_base_of_convergent_photographs_is_that_of_their_rays():
    points, centres, ground = around()
    chosen = choose_models(points, DISTANCE_MM)
    of = points.groupby("image_id")["point_id"].agg(set)
    expected = []
    for a, b in chosen.models[["left_image", "right_image"]].to_numpy():
        shown = ground[sorted(of[a] & of[b])]
        one, other = (shown - centres[int(name)] for name in (a, b))
        lengths = np.linalg.norm(one, axis=1) * np.linalg.norm(other, axis=1)
        angle = np.median(np.arccos((one * other).sum(axis=1) / lengths))
        expected.append(2.0 * np.tan(angle / 2.0))
    # by the similarity alone it is less than half
    ratio = chosen.base_ratio / expected
    assert 0.9 < np.median(ratio) < 1.15
    assert (np.abs(ratio - 1.0) < 0.3).mean() > 0.9


def test_neighbours_go_before_photographs_from_opposite_sides():
    points, _, _ = around(n_images=12, most_shown=24)
    # nearly as many points are in all photographs: how their rays meet decides
    pairs = pairs_of(choose_models(points, DISTANCE_MM))
    steps = [min((int(b) - int(a)) % 12, (int(a) - int(b)) % 12) for a, b in pairs]
    assert max(steps) <= 3
