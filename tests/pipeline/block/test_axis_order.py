"""Which is easting, and which northing: what the area of a system tells."""

import pandas as pd
import pytest

from einschalt.pipeline.block.axis_order import tells_axes


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
