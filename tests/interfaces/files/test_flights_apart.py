"""Two flights in one table, which a column tells apart."""

import pandas as pd
import pytest

from einschalt.foundations.errors import TableError
from einschalt.foundations.tables import CONTROL_POINTS, MODEL_POINTS
from einschalt.interfaces.files.block_folder import find_problems
from einschalt.interfaces.files.flights_apart import require_one_flight
from einschalt.interfaces.files.tables_by_suffix import understand_table, write_table
from einschalt.interfaces.files.understood_tables import Said
from einschalt.interfaces.new_block.looked_at import look_at

ROWS = {"model_id": ["1", "2", "1"], "point_id": ["A", "A", "A"], "x": 1.0, "y": 2.0}


def with_column(name, values):
    return pd.DataFrame(ROWS).assign(**{name: values})


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("Flug", ["hoch", "hoch", "tief"]),
        ("flight", ["H", " L", "L"]),
        ("Bildmaßstab", [15000, 15000, 8000]),
        ("Échelle", ["1/8000", "1/8000", "1/15000"]),
        ("Maßstab", ["1:15 012,3", "1:14987.1", "1: 8'000"]),
        ("Flughöhe", ["1200 m", "1210", "2500"]),
        ("Flughöhe", ["hoch", "tief", "tief"]),
        ("Flug", ["10", "10", "11"]),
    ],
)
def test_a_column_of_two_flights_is_told(name, values):
    with pytest.raises(TableError, match=f"column '{name}' has the values .* of two"):
        require_one_flight(with_column(name, values), MODEL_POINTS, "t.csv")


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("Flug", "tief"),
        ("Flug", ["tief", "", None]),
        ("Maßstabszahl", [15012.3, 14987.1, 15012.3]),
        ("Maßstabszahl", [10000.0, 11000.0, 12500.0]),
        ("Flughöhe", ["1200 m", "1200", "1210"]),
        ("Flughöhe", ""),
        ("Bemerkung", ["gut", "gut", "nass"]),
    ],
)
def test_other_columns_are_passed_over(name, values):
    table = with_column(name, values)
    assert require_one_flight(table, MODEL_POINTS, "t.csv") == []
    points = with_column("Flug", ["hoch", "hoch", "tief"])
    # known from either flight
    assert require_one_flight(points, CONTROL_POINTS, "t.csv") == []


@pytest.mark.parametrize(
    ("name", "values", "said"),
    [
        ("mission", ["2024-05-03", "2024-05-04", "2024-05-04"], "2024-05-03, 2024-"),
        ("Mission", ["A", "B", "B"], "A, B"),
        ("Bildflug", ["3.5.2024", "4.5.2024", ""], "3.5.2024, 4.5.2024"),
        ("Bildflug", [2019, 2020, 2020], "2019, 2020"),
        ("Flughöhe", [1, 2, 2], "1, 2"),  # of a list
        ("Flug", ["1", "2", "3"], "1, 2, 3"),  # or strips
        ("Maßstab", [30000, 8000, 15000], "8000, 15000, 30000"),
    ],
)
def test_what_may_be_of_several_flights_is_noted(name, values, said):
    (note,) = require_one_flight(with_column(name, values), MODEL_POINTS, "t.csv")
    assert note.startswith(f"t.csv: column '{name}' has the values {said}")
    assert note.endswith("of several flights, part the rows into a file for each")


def test_check_and_init_give_the_note(small_block):
    low = pd.read_csv(small_block.path / "low_flight.csv", dtype=str)
    low["mission"] = ["a", "b"] * (len(low) // 2) + ["a"] * (len(low) % 2)
    low.to_csv(small_block.path / "low_flight.csv", index=False)
    found = find_problems(small_block.path)
    assert not found.problems
    (table,) = look_at(small_block.path / "low_flight.csv", Said())
    for notes in (found.notes, table.notes):
        assert [n for n in notes if "column 'mission' has the values a, b: if" in n]


def test_init_and_check_tell_it_before_rows_that_stand_twice(small_block):
    low = pd.read_csv(small_block.path / "low_flight.csv", dtype=str)
    both = pd.concat([low.assign(Flug="hoch"), low.assign(Flug="tief")])
    both.to_csv(small_block.path / "low_flight.csv", index=False)
    (problem,) = find_problems(small_block.path).problems
    assert "column 'Flug' has the values hoch, tief, as of two" in problem.found
    assert problem.remedy.startswith("Say where for the table of each flight")
    # rows of neither flight would be lost
    pd.concat([both, low.assign(Flug="")]).to_csv(
        small_block.path / "low_flight.csv", index=False
    )
    said = rf"as of two flights, and is empty in {len(low)} rows.* Fill the empty cells"
    with pytest.raises(TableError, match=said):
        look_at(small_block.path / "low_flight.csv", Said())


@pytest.mark.parametrize(
    ("where", "said"),
    [
        ({"Flugg": "tief"}, "column 'Flugg' of where is missing, found .*Flug"),
        ({"Flug": "tiefe"}, "no row has 'tiefe' in column 'Flug', .*hoch, tief"),
    ],
)
def test_rows_that_are_not_there_are_told(tmp_path, where, said):
    with_column("Flug", ["hoch", "hoch", "tief"]).assign(coverage="1").to_csv(
        tmp_path / "t.csv", index=False
    )
    with pytest.raises(TableError, match=said):
        understand_table(tmp_path / "t.csv", MODEL_POINTS, Said(where=where))
    given = Said(where={"Flug": "hoch"})
    found = understand_table(tmp_path / "t.csv", MODEL_POINTS, given)
    assert found.frame["Flug"].tolist() == ["hoch", "hoch"]
    assert "t.csv: 2 of 3 rows: those with Flug = hoch" in found.notes


@pytest.mark.parametrize("suffix", [".csv", ".xlsx", ".parquet"])
def test_image_points_of_two_flights_are_two_tables(tmp_path, suffix):
    """Photographs of both flights have the same names."""
    rows = {"image_id": ["1", "2"] * 2, "point_id": "A", "x": 1.5, "y": [2.5, 3, 4, 5]}
    table = pd.DataFrame(rows).assign(Flug=[15, 15, 8, 8])
    path = tmp_path / f"t{suffix}"
    if suffix == ".xlsx":
        table.to_excel(path, index=False)
    else:
        write_table(table, path)
    one, two = look_at(path, Said())
    if suffix == ".parquet":  # categories are texts
        table.astype({"Flug": str}).astype({"Flug": "category"}).to_parquet(path)
        one, two = look_at(path, Said())
    assert (one.title, two.title) == (f"t{suffix}, 15", f"t{suffix}, 8")
    assert one.frame["y"].tolist() == [2.5, 3.0]
    assert two.frame["y"].tolist() == [4.0, 5.0]
