"""Ranges of what a planner may ask for."""

import numpy as np
import pytest

from einschalt.foundations.errors import SettingsError
from einschalt.interfaces.cli.plan_values import sides_and_distance
from einschalt.pipeline.planning.flights.arguments import RANGES
from einschalt.pipeline.planning.flights.flight_design import LEAST_POINTS_PER_MODEL
from einschalt.pipeline.simulation.geometry import RANGES as BLOCK_RANGES
from einschalt.theory.planning.leverage import LEAST_POINTS
from einschalt.theory.transformation import affine, helmert, rigid


@pytest.mark.parametrize(
    ("asked", "laid_out"),
    [
        ("spacing", "point_spacing"),
        ("scale_number", "low_scale_number"),
        ("scale_number", "high_scale_number"),
        ("image_format", "image_format"),
        ("image_format", "image_format_across"),
        ("principal_distance", "principal_distance"),
    ],
)
def test_what_may_be_asked_for_is_what_layouts_take(asked, laid_out):
    ranges = RANGES[asked], BLOCK_RANGES[laid_out]
    assert len({(one.low, one.high) for one in ranges}) == 1


@pytest.mark.parametrize("name", ["image_format", "principal_distance"])
def test_the_command_line_takes_the_same_lengths_in_millimetres(name):
    def read(value):
        given = dict.fromkeys(("image_format", "principal_distance"))
        given[name] = f"{value:g}" if name == "image_format" else value
        return sides_and_distance(given)

    for metres in (RANGES[name].low, RANGES[name].high):
        found = read(1e3 * metres)[name == "principal_distance"]
        assert np.min(found) in RANGES[name]
    for beyond in (0.9 * RANGES[name].low, 1.1 * RANGES[name].high):
        with pytest.raises(SettingsError, match="expected 2 to 1000 millimetres"):
            read(1e3 * beyond)


def test_models_of_layouts_have_more_points_than_transformations_need():
    needed = {"affine": affine, "helmert": helmert, "rigid": rigid}
    assert {name: one.LEAST_POINTS for name, one in needed.items()} == LEAST_POINTS
    assert max(LEAST_POINTS.values()) + 1 == LEAST_POINTS_PER_MODEL == 4
    assert LEAST_POINTS_PER_MODEL in BLOCK_RANGES["least_points_per_model"]
