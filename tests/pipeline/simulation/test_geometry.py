import numpy as np
import pytest

from einschalt.foundations.areas_of_use import in_extent
from einschalt.foundations.errors import BlockError, ProjectionError, SettingsError
from einschalt.pipeline.simulation.geometry import BlockGeometry


def test_defaults_are_the_layout_of_the_documentation():
    geometry = BlockGeometry()
    assert geometry.neat_model == (0.092, 0.161)
    assert geometry.usable_model == pytest.approx((0.128, 0.220))
    assert (geometry.n_columns, geometry.n_rows) == (35, 34)


def test_exchanged_axes_of_the_default_area_leave_the_area_of_use():
    geometry = BlockGeometry()
    wide, high = geometry.half_extent
    easting = geometry.centre_easting + wide * np.array([-1.0, 1.0])
    northing = geometry.centre_northing + high * np.array([-1.0, 1.0])
    assert in_extent(easting, northing, geometry.crs).all()
    assert not in_extent(northing, easting, geometry.crs).any()


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"width": -1.0}, r"width = -1\.0; expected 100 to 1e\+06 metres\."),
        ({"image_format": 230.0}, r"image_format = 230\.0.*Did you give millimetres\?"),
        ({"n_coverages": 1.5}, r"n_coverages = 1\.5; expected a whole number, 1 to 4"),
        ({"jitter": "wide"}, r"jitter = 'wide'; expected 0 to 0\.49 of the point"),
        ({"control_per_model": 4}, r"control_per_model = 4; expected 5 or 9\."),
        (
            {"measurement": "photos"},
            r"measurement = 'photos'; expected machine or parallaxes or images\.",
        ),
        (
            {"transformation": "shift"},
            r"transformation = 'shift'; expected None or aff",
        ),
        (
            {"width": 500.0},
            r"2 x 34 points lie on 500 x 10200 m; expected at least 3 x 3\. Lower",
        ),
        (
            {"point_spacing": 4.0},
            r"6630000 points lie on the area; expected at most 5000000\. Raise point_s",
        ),
        (
            {"forward_overlap": 0.51},
            r"107\.3 mm along the strip, leave gaps.*forward_overlap to 0\.522 or more",
        ),
        (
            {"side_overlap": 0.0},
            r"220 mm across.*Raise side_overlap to 0\.0435 or more",
        ),
    ],
)
def test_wrong_value_is_said(wrong, message):
    with pytest.raises(SettingsError, match=message):
        BlockGeometry(**wrong)


def test_geographic_system_is_refused():
    with pytest.raises(ProjectionError, match="expected a plane system in metres"):
        BlockGeometry(crs="EPSG:4326")


def test_overlaps_that_are_named_as_the_remedy_are_accepted():
    assert BlockGeometry(forward_overlap=0.522, side_overlap=0.0435)


def test_several_wrong_values_come_together():
    with pytest.raises(BlockError, match="2 problems") as caught:
        BlockGeometry(jitter=2.0, control_per_model=3)
    assert [type(p) for p in caught.value.problems] == [SettingsError] * 2


def test_images_are_fitted_in_space_unless_told_otherwise():
    assert BlockGeometry().transformation_kind == "affine"
    assert BlockGeometry(measurement="images").transformation_kind == "helmert_3d"
    told = BlockGeometry(measurement="images", transformation="helmert")
    assert told.transformation_kind == "helmert"
    assert not told.has_heights
