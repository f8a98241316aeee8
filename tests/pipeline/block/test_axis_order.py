"""Which is easting, and which northing: what the area of a system tells."""

import numpy as np
import pandas as pd
import pytest

from einschalt.pipeline.block.axis_order import mirrored_problems, tells_axes


@pytest.mark.parametrize(
    ("crs", "east", "north", "told"),
    [
        ("EPSG:31255", 12_000.0, 240_000.0, True),
        ("EPSG:31287", 412_000.0, 378_000.0, False),  # both in Austria
        ("EPSG:27700", 450_000.0, 300_000.0, False),  # both in Britain
        ("EPSG:27700", 450_000.0, 800_000.0, True),
    ],
)
def test_some_areas_hold_points_with_exchanged_axes_as_well(crs, east, north, told):
    frame = pd.DataFrame({"easting": [east], "northing": [north]})
    assert tells_axes(frame, crs) is told


def photographs(n_images=3, n_points=6, seed=1):
    """Image points of tilted ground from above, and the ground: tables."""
    rng = np.random.default_rng(seed)
    ground = pd.DataFrame(
        {
            "point_id": [str(number) for number in range(n_points)],
            "easting": 600_000.0 + rng.uniform(0.0, 900.0, n_points),
            "northing": 5_300_000.0 + rng.uniform(0.0, 900.0, n_points),
        }
    )
    plan = ground[["easting", "northing"]].to_numpy()
    turn = np.exp(1j * rng.uniform(0.0, 2.0 * np.pi, n_images))
    there = (plan - plan.mean(axis=0)) @ [1.0, 1j]
    here = turn[:, None] * there / 8.0 + rng.normal(0.0, 1.0, (n_images, n_points))
    images = pd.DataFrame(
        {
            "image_id": np.repeat([f"i{n}" for n in range(n_images)], n_points),
            "point_id": np.tile(ground["point_id"], n_images),
            "x": here.real.ravel(),
            "y": here.imag.ravel() + rng.normal(0.0, 1.0, here.size),
        },
        index=np.arange(2, 2 + here.size),  # lines of a file
    )
    return images, ground


def problems_of(images, ground):
    return mirrored_problems(images, ground, "low_flight", ("images.csv", "known.csv"))


def test_photographs_from_above_are_no_mirrors():
    assert not problems_of(*photographs())


@pytest.mark.parametrize("axis", ["x", "y"])
def test_photographs_with_one_axis_the_other_way_are_told(axis):
    images, ground = photographs()
    (problem,) = problems_of(images.assign(**{axis: -images[axis]}), ground)
    assert problem.file == "images.csv"
    assert "3 of 3 photographs" in problem.found
    assert "mirrored against known.csv" in problem.found


def test_both_axes_the_other_way_are_half_a_turn():
    images, ground = photographs()
    assert not problems_of(images.assign(x=-images["x"], y=-images["y"]), ground)


def test_one_photograph_from_above_speaks_for_the_axes():
    """Then it is the others that are wrong, each by itself."""
    images, ground = photographs()
    is_first = images["image_id"] == "i0"
    mixed = images.assign(y=images["y"].where(is_first, -images["y"]))
    assert not problems_of(mixed, ground)


def test_photographs_with_wrong_names_are_no_mirrors():
    """One of four fits the mirror image by chance: the others fit nothing."""
    images, ground = photographs(n_images=4)
    rng = np.random.default_rng(5)
    is_first = images["image_id"] == "i0"
    place = np.concatenate(
        [np.arange(6), *(6 + 6 * k + rng.permutation(6) for k in range(3))]
    )
    mixed = images.assign(
        y=images["y"].where(~is_first, -images["y"]),
        point_id=images["point_id"].to_numpy()[place],
    )
    assert not problems_of(mixed, ground)


def test_a_single_mirrored_photograph_may_have_wrong_names():
    images, ground = photographs(n_images=1)
    (problem,) = problems_of(images.assign(y=-images["y"]), ground)
    assert "or correct the names of points" in problem.remedy
    images, ground = photographs()
    (problem,) = problems_of(images.assign(y=-images["y"]), ground)
    assert "names" not in problem.remedy


def test_few_points_and_points_on_a_line_tell_no_mirror():
    images, ground = photographs(n_points=3)
    assert not problems_of(images.assign(y=-images["y"]), ground)
    images, ground = photographs()
    on_line = ground.assign(northing=ground["northing"].mean() + ground["easting"])
    line = images.merge(on_line, on="point_id")
    x = (line["easting"] - line["easting"].mean()).to_numpy() * np.sqrt(2.0) / 8.0
    assert not problems_of(images.assign(x=x, y=0.0), on_line)
    # the other way beside the line by a hundredth of its length
    beside = np.tile([1.0, -1.0, 0.5, -0.5, 0.0, 0.0], 3)
    aside = 8.0 * beside[:6] / np.sqrt(2.0)
    near = on_line.assign(
        easting=on_line["easting"] - aside, northing=on_line["northing"] + aside
    )
    assert not problems_of(images.assign(x=x, y=-beside), near)


def test_points_that_lie_elsewhere_tell_no_mirror():
    images, ground = photographs()
    names = ground["point_id"].sample(frac=1.0, random_state=3).to_numpy()
    wrong = ground.assign(point_id=names)
    assert not problems_of(images.assign(y=-images["y"]), wrong)
    assert not problems_of(images, ground.assign(point_id="other"))
