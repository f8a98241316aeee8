"""Headers once more, and sums below the points."""

import pytest

from einschalt.foundations.errors import EinschaltError
from einschalt.foundations.tables import CONTROL_POINTS, MODEL_POINTS
from einschalt.interfaces.files.tables_by_suffix import understand_table

HEAD = "Punktnr;Rechtswert;Hochwert;Höhe\n"
TWO = "A;4500000,50;5300000,25;400,5\nB;4500100,50;5300100,25;401,5\n"
THIRD = "C;4500200,50;5300000,25;402,5\n"


def read(tmp_path, text, schema=CONTROL_POINTS):
    file = tmp_path / "t.csv"
    file.write_text(text, encoding="utf-8")
    return understand_table(file, schema)


def test_a_header_in_the_middle_is_left_out_and_said(tmp_path):
    found = read(tmp_path, HEAD + TWO + HEAD.replace(";", " ; ") + THIRD)
    assert found.frame["point_id"].tolist() == ["A", "B", "C"]
    assert found.frame["easting"].tolist() == [4500000.5, 4500100.5, 4500200.5]
    assert "t.csv: 1 row repeating the header left out" in found.notes
    plain = read(tmp_path, HEAD + TWO + THIRD)
    assert found.frame["height"].tolist() == plain.frame["height"].tolist()
    assert not any("repeating" in note for note in plain.notes)


def test_rows_behind_a_repeated_header_keep_their_numbers(tmp_path):
    text = "model_id,point_id,x,y\n1,A,10.5,20.5\nmodel_id,point_id,x,y\n2,A,1.5,2.5\n"
    found = read(tmp_path, text, MODEL_POINTS)
    assert found.frame.index.tolist() == [2, 4]
    assert found.frame["x"].astype(float).tolist() == [10.5, 1.5]


def test_a_header_of_another_order_is_not_passed_over(tmp_path):
    other = "Punktnr;Hochwert;Rechtswert;Höhe\n"
    found = read(tmp_path, HEAD + TWO + other + THIRD)
    assert found.frame["easting"].tolist()[2] == "Hochwert"  # check_table refuses it


@pytest.mark.parametrize(
    ("row", "name"),
    [
        ("Summe;13500301,50;15900100,75;1204,5\n", "Summe"),
        ("Mittelwert;4500050,5;5300050,25;401\n", "Mittelwert"),
        ("Anzahl:;3;;\n", "Anzahl:"),
        ("Total;2;3;4\n", "Total"),
        ("Durchschnitt;2;3;4\n", "Durchschnitt"),
        ("Min;2;3;4\n", "Min"),
        ("Max.;2;3;4\n", "Max."),
        ("Summe;2;3;4\nC;2;3;4\n", "Summe"),
        ("MEAN;2;3;4\nMin;2;3;4\nRange;2;3;4\n", "MEAN"),
    ],
)
def test_a_sum_below_the_points_is_no_point(tmp_path, row, name):
    said = f"row 4: a row is called '{name}'.*Delete the row, or rename"
    with pytest.raises(EinschaltError, match=said):
        read(tmp_path, HEAD + TWO + row)


def test_a_sum_below_model_points_stands_where_the_model_does(tmp_path):
    text = "model_id,point_id,x,y\n1,A,10.5,20.5\n1,B,11.5,20.5\nTotal,2,22.0,41.0\n"
    with pytest.raises(EinschaltError, match="row 4: a row is called 'Total'"):
        read(tmp_path, text, MODEL_POINTS)


def test_points_may_be_called_as_extremes_are(tmp_path):
    text = HEAD + TWO + "Max;4500200,50;5300000,25;402,5\n" + THIRD
    assert read(tmp_path, text).frame["point_id"].tolist() == ["A", "B", "Max", "C"]


@pytest.mark.parametrize("again", [HEAD.upper(), HEAD.lower()])
def test_a_header_in_other_letters_is_left_out_as_well(tmp_path, again):
    found = read(tmp_path, HEAD + TWO + again + THIRD)
    assert found.frame["point_id"].tolist() == ["A", "B", "C"]
    assert "t.csv: 1 row repeating the header left out" in found.notes
