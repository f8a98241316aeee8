"""Blocks of spatial models of which nobody says whether their ground is curved."""

from dataclasses import replace

import numpy as np
import pytest

from einschalt.foundations.projections import EARTH_RADIUS
from einschalt.pipeline.assessment.evidence.ground.flat_ground import (
    bend_without_system,
)
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings


@pytest.fixture(scope="module")
def without_system(spatial_block):
    return densify(replace(spatial_block, crs=None))


def codes(result):
    return {found.code for found in result.assessment.findings}


def test_models_are_bent_as_the_sphere_is_beside_their_tilt(without_system):
    examined = without_system.examination
    points = without_system.points.set_index("point_id")[["easting", "northing"]]
    found = []
    for flight in examined.block.flights.values():
        left = []
        table = flight.model_table().join(points, on="point_id").dropna()
        for _, model in table.groupby(["coverage", "model_id"]):
            plan = model[["easting", "northing"]].to_numpy()
            plan = (plan - plan.mean(axis=0)) / 1000.0
            falls = 1e6 * (plan**2).sum(axis=1) / (2.0 * EARTH_RADIUS)
            design = np.column_stack([np.ones(len(plan)), plan])
            solved, *_ = np.linalg.lstsq(design, falls, rcond=None)
            left += [falls - design @ solved]
        found.append(np.sqrt(np.mean(np.concatenate(left) ** 2)))
    assert bend_without_system(examined) == pytest.approx(max(found), rel=1e-6)
    assert max(found) > 0.02  # metres: a matter of centimetres


def test_it_is_said_where_it_matters_and_nobody_knows(without_system, spatial_result):
    assert "curvature_untold" in codes(without_system)
    assert "crs = " in without_system.summary()
    assert "curvature_untold" not in codes(spatial_result)


@pytest.mark.slow
def test_ground_that_is_said_to_be_plane_is_believed(spatial_block):
    plane = replace(spatial_block, crs=None)
    result = densify(plane, Settings(earth_curvature="ignored"))
    assert "curvature_untold" not in codes(result)


@pytest.mark.slow
def test_plane_models_have_no_heights_to_bend(demo_block):
    assert "curvature_untold" not in codes(densify(replace(demo_block, crs=None)))
