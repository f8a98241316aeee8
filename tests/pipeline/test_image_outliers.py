"""Gross errors of image coordinates in a block: said, taken out, given less weight."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from einschalt.pipeline.block.block import Block, plain_fields
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def faulty():
    """A block from image coordinates with three blunders across the base."""
    geometry = replace(PRESETS["demo"].geometry, measurement="images")
    block = simulate_block("demo", seed=5, geometry=geometry)
    points = block.low_flight.image_points.copy()
    rows = points.index[[10, 200, 400]]
    points.loc[rows, "y"] += 0.5
    fields = {**plain_fields(block), "low_flight": None}
    low = replace(block.low_flight, image_points=points)
    wrong = points.loc[rows, "point_id"].tolist()
    return Block(**{**only_block(fields), "low_flight": low}), block.truth, wrong


@pytest.fixture(scope="module")
def densified(faulty):
    """The block by what is done about outliers, computed once."""
    return cache(lambda outliers: densify(faulty[0], Settings(outliers=outliers)))


def only_block(fields):
    names = Block.__dataclass_fields__
    return {name: value for name, value in fields.items() if name in names}


def rms(result, truth):
    columns = ["easting", "northing"]
    order = result.solution.points["point_id"]
    true = truth.set_index("point_id").loc[order, columns].to_numpy()
    error = result.solution.points[columns].to_numpy() - true
    return np.sqrt(np.mean(np.sum(error**2, axis=1)))


def test_blunders_are_named_with_their_points(faulty, densified):
    _, _, wrong = faulty
    result = densified("keep")
    rows = result.orientation_residuals
    assert set(rows["flight"]) == {"high_flight", "low_flight"}
    said = " ".join(result.summary().split())
    assert "that contradict their pair, worst first (flight, model, point):" in said
    assert 'or set outliers = "snoop"' in said
    suspects = set(rows.loc[rows["is_suspect"], "point_id"])
    assert suspects & set(wrong)


@pytest.mark.parametrize(
    ("outliers", "remedy"),
    [("snoop", "They were taken out of the"), ("tukey", "They have less weight in")],
)
def test_blunders_do_no_harm(faulty, densified, outliers, remedy):
    _, truth, wrong = faulty
    kept, mended = densified("keep"), densified(outliers)
    assert rms(mended, truth) < rms(kept, truth)
    said = " ".join(mended.summary().split())
    assert remedy in said
    rows = mended.orientation_residuals
    suspects = rows[rows["is_suspect"] & rows["point_id"].isin(wrong)]
    assert len(suspects) >= len(wrong)
    if outliers == "snoop":
        assert suspects["weight"].isna().all()
    else:
        assert (suspects["weight"] < 0.1).all()


def test_summary_says_what_images_say_of_m_g(densified):
    result = densified("snoop")
    said = " ".join(result.summary().split())
    assert "m_g of the low flight: given 5.0 µm; the image residuals show" in said
    errors = result.orientations[["m_g_intersection_um", "m_g_orientation_um"]]
    assert (errors.astype(float) > 0.0).all(axis=None)
