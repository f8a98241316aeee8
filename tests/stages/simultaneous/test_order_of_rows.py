"""The order of the rows of tables decides nothing, not even where errors are drawn."""

from dataclasses import replace

import numpy as np
import pytest

import einschalt as es
from einschalt.pipeline.simulation.simulate_block import BlockGeometry, simulate_block

SIZE = {"width": 2_200.0, "height": 2_200.0, "point_spacing": 275.0}
TABLES = ("model_points", "image_points", "models")
ERRORS = ["standard_error_easting", "standard_error_northing", "covariance_en"]


def shuffled(table, seed):
    return None if table is None else table.sample(frac=1.0, random_state=seed)


def with_rows_in_another_order(block):
    flights = {
        name: replace(
            flight, **{one: shuffled(getattr(flight, one), 2) for one in TABLES}
        )
        for name, flight in block.flights.items()
    }
    control = shuffled(block.control_points, 1)
    return replace(block, control_points=control, **flights)


def grouped(**shared):
    block = simulate_block("demo", seed=3, geometry=BlockGeometry(**SIZE))
    control = block.control_points
    is_east = control["easting"] > control["easting"].median()
    control = control.assign(group=np.where(is_east, "east", "west"))
    return replace(block, control_points=control, **shared)


def of_images(transformation):
    geometry = BlockGeometry(
        **SIZE,
        measurement="images",
        transformation=transformation,
        control_per_model=9,
    )
    return simulate_block("demo", seed=1, geometry=geometry)


GROUPS = {"group_errors_m": {"control_points": 0.1}}
LENGTH = {"correlation_lengths_m": {"control_points": 800.0}}
BLOCKS = {
    "groups": (grouped, GROUPS),
    "groups and a length": (grouped, GROUPS | LENGTH),
    "groups of unknown size": (grouped, {}),
    "plane models from images": (of_images, {"transformation": "affine"}),
    "spatial models from images": (of_images, {"transformation": "helmert_3d"}),
}


@pytest.mark.parametrize("name", BLOCKS)
def test_standard_errors_do_not_depend_on_it(name):
    make, arguments = BLOCKS[name]
    block = make(**arguments)
    kind = "helmert_3d" if name.startswith("spatial") else "affine"
    one, other = (
        es.adjust_block(b, kind=kind).points.set_index("point_id")
        for b in (block, with_rows_in_another_order(block))
    )
    other = other.loc[one.index]
    np.testing.assert_allclose(other["easting"], one["easting"], rtol=0, atol=1e-5)
    errors = one[ERRORS].to_numpy()
    assert np.isfinite(errors).all() or "unknown" in name
    scale = np.nanmax(np.abs(errors), axis=0, initial=0.0)
    away = np.abs(other[ERRORS].to_numpy() - errors)
    assert (away <= 1e-6 * scale)[np.isfinite(errors)].all()
    assert (np.isnan(away) == np.isnan(errors)).all()
