"""Units that the header of a table states, against those of its flight."""

import pytest

from einschalt.foundations.errors import TableError
from einschalt.foundations.tables import (
    CONTROL_POINTS,
    IMAGE_POINTS,
    MODEL_POINTS,
    Y_PARALLAXES,
)
from einschalt.interfaces.files.csv_tables import understand_csv
from einschalt.interfaces.files.understood_tables import Said

IMAGES = "image_id;point_id;x [{0}];y [{0}]\n7;A;1000;-2000\n"
MODELS = "model_id;point_id;x;y\n;;{0};{0}\n7;A;1000;-2000\n"


def read_text(folder, text, schema, unit=None):
    (folder / "t.csv").write_text(text, encoding="utf-8")
    return understand_csv(folder / "t.csv", schema, Said(unit=unit))


@pytest.mark.parametrize(
    ("unit", "millimetres"),
    [("µm", 1.0), ("μm", 1.0), ("mm", 1e3), ("cm", 1e4), ("m", 1e6)],
)
def test_image_coordinates_become_millimetres(tmp_path, unit, millimetres):
    table = read_text(tmp_path, IMAGES.format(unit), IMAGE_POINTS, "mm")
    assert table.frame[["x", "y"]].to_numpy().tolist() == [
        [millimetres, -2.0 * millimetres]
    ]
    assert any("converted to mm" in note for note in table.notes) == (unit != "mm")


def test_pixels_belong_to_a_camera_and_lengths_do_not(tmp_path):
    table = read_text(tmp_path, IMAGES.format("Pixel"), IMAGE_POINTS, "px")
    assert table.frame["x"].tolist() == [1000.0]
    with pytest.raises(TableError, match="is in pixels, and the flight has no camera"):
        read_text(tmp_path, IMAGES.format("px"), IMAGE_POINTS, "mm")
    with pytest.raises(TableError, match="is in mm, and the flight has a camera"):
        read_text(tmp_path, IMAGES.format("mm"), IMAGE_POINTS, "px")


def test_units_below_the_names_are_those_of_models(tmp_path):
    table = read_text(tmp_path, MODELS.format("[cm]"), MODEL_POINTS)
    assert table.unit == "cm"
    assert table.frame["x"].tolist() == [1000.0]
    with pytest.raises(TableError, match="is in cm, but model_unit of the flight is"):
        read_text(tmp_path, MODELS.format("cm"), MODEL_POINTS, "mm")


def test_parallaxes_are_brought_to_the_unit_of_their_places(tmp_path):
    text = "model_id;point_id;x [mm];y [mm];z [mm];py [µm]\n7;A;1;2;3;40\n"
    table = read_text(tmp_path, text, Y_PARALLAXES, "mm")
    assert table.frame["y_parallax"].tolist() == [0.04]
    assert table.frame["x"].tolist() == [1.0]


def test_what_is_no_number_is_still_said_as_it_stands(tmp_path):
    text = IMAGES.format("um").replace("-2000", "2o")
    assert read_text(tmp_path, text, IMAGE_POINTS).frame["y"].tolist() == ["2o"]


@pytest.mark.parametrize("unit", ["dm", "ft", "px", "gon", "°", "Zoll"])
def test_a_column_that_was_named_is_refused_in_another_unit(tmp_path, unit):
    (tmp_path / "t.csv").write_text(f"point_id;a [{unit}];b [{unit}]\nA;1;2\n")
    said = Said(columns={"easting": f"a [{unit}]", "northing": f"b [{unit}]"})
    with pytest.raises(TableError, match=r"named for easting, is in .*expected metres"):
        understand_csv(tmp_path / "t.csv", CONTROL_POINTS, said)


def test_what_is_no_unit_is_part_of_a_name_that_was_given(tmp_path):
    (tmp_path / "t.csv").write_text("point_id;a [neu];b [cm]\nA;1;2\n")
    said = Said(columns={"easting": "a [neu]", "northing": "b [cm]"})
    with pytest.raises(TableError, match=r"'b \[cm\]' is in cm, .* states no unit"):
        understand_csv(tmp_path / "t.csv", CONTROL_POINTS, said)
    said = Said(columns={"easting": "a [neu]"})
    (tmp_path / "t.csv").write_text("point_id;a [neu];northing\nA;1;2\n")
    table = understand_csv(tmp_path / "t.csv", CONTROL_POINTS, said)
    assert table.frame["easting"].tolist() == [1.0]
    assert "column 'a [neu]' = easting" in table.notes[0]


def test_variances_in_another_unit_are_refused(tmp_path):
    text = "point_id;easting;northing;c [{}]\nA;1;2;3\n"
    said = Said(columns={"covariance_en": "c [mm²]"})
    (tmp_path / "t.csv").write_text(text.format("mm²"), encoding="utf-8")
    with pytest.raises(TableError, match="is in mm2; expected square metres"):
        understand_csv(tmp_path / "t.csv", CONTROL_POINTS, said)
    said = Said(columns={"covariance_en": "c [m²]"})
    (tmp_path / "t.csv").write_text(text.format("m²"), encoding="utf-8")
    frame = understand_csv(tmp_path / "t.csv", CONTROL_POINTS, said).frame
    assert frame["covariance_en"].tolist() == [3.0]
