"""Transformers to geocentric coordinates, which threads make quickly."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pyproj
import pytest

from einschalt.foundations.projections import (
    _by_its_steps,
    from_geocentric,
    read_crs,
    to_geocentric,
)

# transverse, axes to the north first, oblique, azimuthal, of an ensemble of datums
SYSTEMS = {
    "EPSG:25832": (500_000.0, 5_300_000.0),
    "EPSG:31467": (3_500_000.0, 5_400_000.0),
    "EPSG:2193": (1_600_000.0, 5_400_000.0),
    "EPSG:2056": (2_600_000.0, 1_200_000.0),
    "EPSG:3035": (4_300_000.0, 3_000_000.0),
    "EPSG:32718": (500_000.0, 8_000_000.0),
}


@pytest.mark.parametrize("name", SYSTEMS)
def test_steps_give_what_the_systems_give(name):
    crs = read_crs(name)
    points = np.array([[*SYSTEMS[name], 120.0], [*SYSTEMS[name], -30.0]])
    points[1, :2] += (12_345.6, -6_543.2)
    geocentric = pyproj.CRS.from_json_dict(
        {
            **crs.geodetic_crs.to_3d().to_json_dict(),
            "type": "GeodeticCRS",
            "coordinate_system": pyproj.crs.GeocentricCRS().to_json_dict()[
                "coordinate_system"
            ],
        }
    )
    there = pyproj.Transformer.from_crs(crs.to_3d(), geocentric, always_xy=True)
    back = pyproj.Transformer.from_crs(geocentric, crs.to_3d(), always_xy=True)
    expected = np.column_stack(there.transform(*points.T))
    expected_back = np.column_stack(back.transform(*expected.T))
    with ThreadPoolExecutor(1) as other_thread:
        found, _ = other_thread.submit(to_geocentric, points, crs).result()
        found_back = other_thread.submit(from_geocentric, found, crs).result()
    np.testing.assert_array_equal(found, expected)
    np.testing.assert_array_equal(found_back, expected_back)


@pytest.mark.parametrize(
    ("name", "of_greenwich", "place"),
    [
        ("EPSG:27561", 4275, (600_000.0, 200_000.0)),  # Paris, in grads
        ("EPSG:31282", 4312, (0.0, 5_200_000.0)),  # Ferro
    ],
)
def test_x_points_to_greenwich(name, of_greenwich, place):
    """A datum that counts from Paris put points 172 km to the west of theirs."""
    crs = read_crs(name)
    points = np.array([[*place, 120.0], [place[0] + 50_000.0, place[1] + 9_000.0, 5.0]])
    way = pyproj.Transformer.from_crs(crs, of_greenwich, always_xy=True)
    degrees = np.array(way.transform(*points.T[:2]))
    axes = crs.ellipsoid
    cart = f"+proj=cart +a={axes.semi_major_metre!r} +rf={axes.inverse_flattening!r}"
    to_xyz = pyproj.Transformer.from_pipeline(cart)
    expected = np.column_stack(to_xyz.transform(*degrees, points[:, 2]))
    found, jacobian = to_geocentric(points, crs)
    # PROJ's own way takes 2°20'14.025" for the 2.5969213 gon of Paris: 0.24 mm
    np.testing.assert_allclose(found, expected, rtol=0, atol=3e-4)
    step = np.array([100.0, 200.0, 300.0])
    moved, _ = to_geocentric(points + step, crs)
    np.testing.assert_allclose(moved - found, jacobian @ step, rtol=0, atol=0.02)
    np.testing.assert_allclose(from_geocentric(found, crs), points, rtol=0, atol=1e-5)


def test_a_way_that_depends_on_the_place_stays_as_it_is():
    several = pyproj.Transformer.from_crs(31467, 4326, always_xy=True)
    assert _by_its_steps(several) is several
