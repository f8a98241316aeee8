"""plan.json: a plan as other programs and its simulation read it."""

import json
from dataclasses import asdict

import numpy as np
import pandas as pd
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from einschalt.foundations.errors import EinschaltError, FileError
from einschalt.interfaces.files.plan_file import (
    HEIGHTS_FILE,
    PLAN_FILE,
    ROWS_FILE,
    plain,
    read_plan_file,
    write_plan_file,
)
from einschalt.pipeline.planning.area.flight_area import FlightArea
from einschalt.pipeline.planning.area.simulated_plan import PlannedBlock
from einschalt.pipeline.planning.estimate.search import PlanFrame
from einschalt.pipeline.planning.flights.flight_design import FlightDesign
from einschalt.pipeline.planning.ground.ground_heights import GroundHeights

CORNER = np.array([500_000.1 / 3.0, 5_300_000.0 / 7.0])
RING = np.array([(0, 0), (8200, 900), (9000, 5200), (4800, 7600), (600, 6000)], float)
HOLE = np.array([(3000, 3000), (4200, 3000), (4200, 4200), (3000, 4200)], float)
SHAPE = shapely.Polygon(RING + CORNER, [HOLE + CORNER])
DESIGN = FlightDesign(
    scale_number=11_000 / 3.0,
    spacing=100,
    m_g_um=5,
    image_format=(0.068, 0.104),
    high_scale_number=16_500,
    most_work=np.inf,
)
FRAME = PlanFrame(max_height=2000.0, extent=(9000.0, 7000.0, 4e7))


def heights(extremes=None):
    rng = np.random.default_rng(1)
    plane = CORNER + rng.uniform(-100.0, 9000.0, (500, 2))
    return GroundHeights(plane, rng.uniform(300, 400, 500), "dem.tif", extremes)


@settings(max_examples=25)
@given(
    scale=st.floats(3000, 6000),
    m_g_um=st.floats(0.5, 20),
    sides=st.floats(0.06, 0.23) | st.tuples(*[st.floats(0.06, 0.23)] * 2),
    n_coverages=st.integers(1, 4),
    expected=st.floats(1e-4, 1),
    name=st.text(max_size=10).filter(lambda text: text.isprintable()),
    follows=st.booleans(),
)
def test_what_is_written_is_read(
    scale, m_g_um, sides, n_coverages, expected, name, follows, tmp_path_factory
):
    folder = tmp_path_factory.mktemp("plan")
    design = FlightDesign(
        scale_number=scale,
        spacing=30,
        m_g_um=m_g_um,
        image_format=sides,
        n_coverages=n_coverages,
    )
    area = FlightArea(SHAPE, "EPSG:32633")
    planned = PlannedBlock(
        *(design, expected, area), max_height=2000.0, follows=follows, name=name
    )
    write_plan_file(folder, planned, {"cost": np.float64(np.nan)}, FRAME)
    found = read_plan_file(folder)
    assert asdict(found.design) == asdict(design)
    assert (found.expected, found.name) == (expected, name)
    assert (found.max_height, found.follows) == (2000.0, follows)
    assert found.area.crs == "EPSG:32633"
    assert shapely.equals_exact(found.area.shape, SHAPE, tolerance=0.0)
    content = json.loads((folder / PLAN_FILE).read_text("utf-8"))
    assert content["figures"] == {"cost": None}


@pytest.mark.parametrize("has_extremes", [False, True])
def test_heights_come_back_with_all_digits(has_extremes, tmp_path):
    own = heights(np.full((500, 2), [299.0, 401.0]) if has_extremes else None)
    planned = PlannedBlock(DESIGN, 0.05, FlightArea(SHAPE), own)
    write_plan_file(tmp_path, planned, {}, FRAME)
    found = read_plan_file(tmp_path / PLAN_FILE)
    assert found.design.most_work == np.inf
    assert found.area.crs is None
    np.testing.assert_array_equal(found.heights.plane, own.plane)
    np.testing.assert_array_equal(found.heights.height, own.height)
    assert found.heights.range == own.range


def test_a_design_alone_is_read(tmp_path):
    write_plan_file(tmp_path, PlannedBlock(DESIGN, 0.05), {})
    found = read_plan_file(tmp_path)
    assert found.area is None
    assert found.design == DESIGN
    (tmp_path / ROWS_FILE).write_text("scale_number\n8000\n", "utf-8")
    with pytest.raises(EinschaltError, match=r"plans\.csv"):
        read_plan_file(tmp_path, 1)


@pytest.fixture
def written(tmp_path):
    area = FlightArea(SHAPE, "EPSG:32633")
    write_plan_file(tmp_path, PlannedBlock(DESIGN, 0.05, area, heights()), {}, FRAME)
    return tmp_path


@pytest.mark.parametrize(
    ("keys", "value", "says"),
    [
        (("format",), 2, "it has the format 2"),
        (("expected",), None, "expected = None"),
        (("expected",), -1, "expected is -1"),
        (("design",), [], "design = []"),
        (("design", "scale_number"), "many", "scale_number = 'many'"),
        (("design", "scale_number"), 5, "scale_number = 5"),
        (("design", "scale_number"), "8000", "scale_number = '8000'"),
        (("design", "spacing"), True, "spacing = True"),
        (("design", "n_coverages"), 2.6, "n_coverages = 2.6"),
        (("design", "n_coverages"), 9, "n_coverages = 9"),
        (("design", "most_work"), 0, "most_work = 0"),
        (("design", "colour"), 1, "colour is unknown"),
        (("frame", "max_height"), 1, "max_height = 1"),
        (("area", "geometry"), {"type": "Point"}, "the area is no polygon"),
        (("area", "geometry"), {"type": "Point", "coordinates": [0, 0]}, "a Point"),
        (("area", "crs"), "EPSG:99999", "EPSG:99999"),
        (("area", "heights"), "../dem.parquet", "area.heights = '../dem.parquet'"),
        (("area", "follows"), "perhaps", "area.follows = 'perhaps'"),
    ],
)
def test_what_is_damaged_is_told(keys, value, says, written):
    file = written / PLAN_FILE
    content = json.loads(file.read_text("utf-8"))
    part = content
    for key in keys[:-1]:
        part = part[key]
    part[keys[-1]] = value
    file.write_text(json.dumps(content), "utf-8")
    with pytest.raises(EinschaltError) as caught:
        read_plan_file(written)
    assert says in str(caught.value)
    assert caught.value.file == PLAN_FILE


def test_whole_numbers_may_stand_where_others_are_meant(written):
    file = written / PLAN_FILE
    content = json.loads(file.read_text("utf-8"))
    content["design"] |= {"scale_number": 4000, "image_format": [1, 0.1]}
    file.write_text(json.dumps(content), "utf-8")
    design = read_plan_file(written).design
    assert (design.scale_number, design.image_format) == (4000.0, (1.0, 0.1))


GOOD_ROW = {
    "scale_number": 8000,
    "high_scale_number": 15_000,
    "spacing": 300,
    "m_g_um": 5,
    "n_settings": 1,
    "n_coverages": 2,
    "control_per_model": 5,
}


@pytest.fixture
def of_rows(tmp_path):
    """A folder of a plan, whose rows are to be written."""
    write_plan_file(tmp_path, PlannedBlock(DESIGN, 0.05), {}, FRAME)

    def folder(*changes):
        rows = [GOOD_ROW | change for change in changes]
        table = pd.DataFrame(rows, columns=list(GOOD_ROW))
        table.to_csv(tmp_path / ROWS_FILE, index=False)
        return tmp_path

    return folder


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"scale_number": -1}, "is not above 0; expected numbers such as 8000 for 1"),
        ({"spacing": "x"}, "spacing 'x' is not a number; expected metres, above 0"),
        ({"n_coverages": 2.6}, "n_coverages = 2.6; expected a whole number, 1 to 4"),
        ({"n_settings": 0.01}, "n_settings = 0.01; expected a whole number, 1 to 100"),
        ({"control_per_model": 5.5}, "control_per_model = 5.5; expected a whole numb"),
        ({"control_per_model": 7}, "control_per_model = 7; expected 5 or 9"),
        ({"scale_number": 5}, "scale_number = 5; expected 100 to 200000"),
    ],
)
def test_faulty_rows_are_told_with_their_line_and_spare_the_others(
    change, says, of_rows
):
    folder = of_rows({}, change)
    assert read_plan_file(folder, 1).design.scale_number == 8000.0
    with pytest.raises(EinschaltError) as caught:
        read_plan_file(folder, 2)
    assert str(caught.value).startswith("plans.csv, row 3: ")
    assert says in str(caught.value)


def test_missing_rows_and_frames_are_told(of_rows):
    with pytest.raises(FileError, match=r"^plans\.csv: has no plans\. Plan again"):
        read_plan_file(of_rows(), 1)
    with pytest.raises(FileError, match=r"^plans\.csv: has no plan 3; expected 1 to 2"):
        read_plan_file(of_rows({}, {}), 3)
    folder = of_rows({})
    write_plan_file(folder, PlannedBlock(DESIGN, 0.05), {})
    with pytest.raises(FileError, match=r"^plan\.json: has no frame, with which plan"):
        read_plan_file(folder, 1)


@pytest.mark.parametrize("text", ["[]", "{}", "null", "3"])
def test_what_is_missing_is_named(text, tmp_path):
    (tmp_path / PLAN_FILE).write_text(text, "utf-8")
    with pytest.raises(FileError, match="format is missing"):
        read_plan_file(tmp_path)


@pytest.mark.parametrize("text", ["", "{", "[]", "null", "{}", '{"format": 1}', "\0"])
def test_other_files_are_no_plans(text, tmp_path):
    (tmp_path / PLAN_FILE).write_text(text, "utf-8")
    with pytest.raises(FileError) as caught:
        read_plan_file(tmp_path)
    assert caught.value.file == PLAN_FILE


def test_missing_files_are_named(written):
    (written / HEIGHTS_FILE).unlink()
    with pytest.raises(FileError, match=HEIGHTS_FILE):
        read_plan_file(written)
    (written / PLAN_FILE).unlink()
    with pytest.raises(FileError, match=PLAN_FILE):
        read_plan_file(written)


def test_json_holds_no_number_that_is_none():
    given = {"a": np.float64(1), "b": [np.inf, np.int64(2)], 3: (True, None, np.nan)}
    assert plain(given) == {"a": 1.0, "b": [None, 2], "3": [True, None, None]}
    table = pd.Series({"a": np.True_}).to_dict()
    assert plain(table) == {"a": True}
