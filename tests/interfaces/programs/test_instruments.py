"""Points of Leica's GSI and of Trimble's JobXML."""

import pytest
from fuzz.foreign_files import READ

from einschalt.foundations.errors import EinschaltError
from einschalt.interfaces.programs.recognised import read_foreign


def read(folder, name, text):
    (folder / name).write_text(text)
    return read_foreign(folder / name)


def test_words_of_both_lengths_units_and_kinds_of_points(tmp_path):
    found = read(tmp_path, "a.gsi", READ["a.gsi"][0])
    table = found.tables["control_points"]
    assert table["point_id"].tolist() == ["P7", "1002"]
    assert table["easting"].tolist() == [1.5, 13.826]
    assert table["northing"].tolist() == [-2.25, 3.22]
    assert table["height"].iloc[0] == 3.5
    said = " ".join(found.notes)
    assert "a.gsi: 1 lines without coordinates left out" in said
    assert "without the zeros that lead the names" in said


def test_digits_of_gsi_are_read_exactly(tmp_path):
    word = "81..10+0000000013826180"
    line = f"*110001+0000000000001001 {word} 82..10+0000000323236344\n"
    table = read(tmp_path, "a.gsi", line + line).tables["control_points"]
    assert table.to_numpy().tolist() == [["1001", 13826.18, 323236.344]]  # once


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("81..10+00001500", "81..11+00001500", "row 1: word 81..11.* is in feet"),
        ("81..10+00001500", "81..10+0000150", "row 1: '81..10.0000150' is no word"),
        ("81..10+00001500", "81..10+0000x500", "row 1: .* is no word of GSI"),
        ("81..10+00001500", "81..17+00001500", "row 1: word .* is in feet"),
        ("81..10+00001500", "21.102+00001500", "holds no coordinates: angles"),
        ("110001", "xx0001", "row 1: .* is no word of GSI"),
    ],
)
def test_what_is_no_coordinate_in_metres_is_refused(tmp_path, old, new, said):
    line = "110001+00001001 81..10+00001500 82..10+00002250\n"
    assert len(read(tmp_path, "a.gsi", line).tables["control_points"]) == 1
    with pytest.raises(EinschaltError, match=said):
        read(tmp_path, "a.gsi", line.replace(old, new))


def test_points_without_a_grid_are_counted(tmp_path):
    text = READ["a.jxl"][0]
    found = read(tmp_path, "a.jxl", text)
    table = found.tables["control_points"]
    assert table.to_numpy().tolist() == [["P 1", 1.5, 2.25, 3.5]]
    assert any("a.jxl: 1 points without grid left out" in n for n in found.notes)
    with pytest.raises(EinschaltError, match="'wide' of point P 1 is no number"):
        read(tmp_path, "a.jxl", text.replace("1.5</East>", "wide</East>"))
    with pytest.raises(EinschaltError, match="Choose a coordinate system in the job"):
        read(tmp_path, "a.jxl", text.replace("East", "West"))
    with pytest.raises(EinschaltError, match="a point of the reductions has no name"):
        read(tmp_path, "a.jxl", text.replace("<Name>P2</Name>", ""))
