"""The same ground points, however their control is given: systems, axes and units."""

import numpy as np
import pandas as pd
import pyproj
import pytest
from tests.moved_block import CONTROL, PLANE, moved_block

import einschalt as es

SALZBURG, LUCERNE, NEW_YORK = (13.5, 47.3), (8.0, 47.0), (-73.0, 40.7)
FOOT = {"type": "LinearUnit", "name": "foot", "conversion_factor": 0.3048}


def in_feet(code):
    """A system like another one, but in feet."""
    content = pyproj.CRS(code).to_json_dict()
    content.pop("id")
    content["name"] += " in feet"
    for axis in content["coordinate_system"]["axis"]:
        axis["unit"] = FOOT
    return pyproj.CRS.from_json_dict(content).to_wkt()


# system of the block, of the control, place, accuracy of the way between them [m]
CASES = {
    "4258": ("EPSG:25833", "EPSG:4258", SALZBURG, 0.0),
    "4258, another datum": ("EPSG:31255", "EPSG:4258", SALZBURG, 1.5),
    "31255": ("EPSG:31255", "EPSG:31255", SALZBURG, 0.0),
    "31255, another datum": ("EPSG:25833", "EPSG:31255", SALZBURG, 1.5),
    "31287": ("EPSG:31255", "EPSG:31287", SALZBURG, 0.0),
    "25833": ("EPSG:31255", "EPSG:25833", SALZBURG, 1.5),
    "2056": ("EPSG:25832", "EPSG:2056", LUCERNE, 0.1),
    "US survey feet": ("EPSG:32118", "EPSG:2263", NEW_YORK, 0.0),
    "feet": ("EPSG:31255", in_feet("EPSG:31255"), SALZBURG, 0.0),
}


@pytest.fixture(scope="module", params=CASES)
def case(request, make_block, tmp_path_factory):
    """Results of control in the block's system, and a block with it in another.

    The columns of that have the names and the order of the authority.
    """
    crs, own, place, accuracy = CASES[request.param]
    folder = tmp_path_factory.mktemp("systems")
    plain = make_block(folder / "plain")
    moved_block(plain, crs, place)
    block = make_block(folder / "other")
    moved_block(block, crs, place, own, settings="crs_accuracy_m = 2.0")
    axes = pyproj.CRS(own).axis_info
    names = [axis.abbrev for axis in axes]
    table = pd.read_csv(block.path / CONTROL, dtype={"point_id": str})
    east, north = table.columns[1:]
    of_axis = {"east": table[east], "north": table[north]}
    as_listed = np.column_stack([of_axis[axis.direction] for axis in axes])
    ids = table[["point_id"]]
    ids.join(pd.DataFrame(as_listed, columns=names)).to_csv(
        block.path / CONTROL, index=False
    )
    exchanged = make_block(folder / "exchanged")
    exchanged.write("block.toml", block.read("block.toml"))
    ids.join(pd.DataFrame(as_listed[:, ::-1], columns=names)).to_csv(
        exchanged.path / CONTROL, index=False
    )
    return es.densify(es.read_block(plain.path)), block, exchanged, accuracy


def test_results_are_the_same_within_the_stated_accuracy(case):
    expected, block, _, accuracy = case
    found = es.densify(es.read_block(block.path))
    points, others = found.solution.points, expected.solution.points
    apart = (points[PLANE] - others[PLANE]).to_numpy()
    # there and back by the same operation; between datums it takes all heights for 0,
    # which leaves a millimetre. The wrong one of two feet would be decimetres
    assert np.hypot(*apart.T).max() < (2e-3 if accuracy else 1e-6)
    ours, alone = (one["standard_error_total"] for one in (points, others))
    np.testing.assert_allclose(ours, np.hypot(alone, accuracy), rtol=1e-2)


def test_exchanged_axes_never_become_results_in_silence(case):
    *_, exchanged, _ = case
    if "31287" not in exchanged.read("block.toml"):
        with pytest.raises(es.EinschaltError, match="with the two exchanged"):
            es.read_block(exchanged.path)
        return
    # Austria's Lambert system holds the place either way: the models tell
    found = es.densify(es.read_block(exchanged.path))
    assert "all models are mirrored: easting and northing exchanged?" in found.summary()
    assert found.solution.block.axes_told == {"control_points": False}


def test_feet_of_a_site_are_tied_to_no_other_system(make_block, tmp_path):
    site = pyproj.CRS(
        'ENGCRS["site",EDATUM["site"],CS[Cartesian,2],AXIS["x",east],'
        'AXIS["y",north],LENGTHUNIT["foot",0.3048]]'
    ).to_wkt(pretty=False)
    block = make_block(tmp_path / "site")
    moved_block(block, "EPSG:31255", SALZBURG)
    text = block.read("block.toml")
    block.write(
        "block.toml", text.replace(f'"{CONTROL}"', f"\"{CONTROL}\"\ncrs = '{site}'")
    )
    with pytest.raises(es.EinschaltError, match="site is a system of one site"):
        es.read_block(block.path)
    block.write("block.toml", text.replace('"EPSG:31255"', f"'{site}'"))
    with pytest.raises(es.EinschaltError, match="has axes in foot"):
        es.read_block(block.path)
