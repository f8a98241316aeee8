"""Two flights in one table, which a column tells apart."""

import pandas as pd
import pytest

from einschalt.foundations.errors import TableError
from einschalt.foundations.tables import CONTROL_POINTS, MODEL_POINTS
from einschalt.interfaces.files.block_folder import find_problems
from einschalt.interfaces.files.flights_apart import require_one_flight
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
        ("Flug", ["1", "2", "3"]),  # strips
        ("Bemerkung", ["gut", "gut", "nass"]),
    ],
)
def test_other_columns_are_passed_over(name, values):
    require_one_flight(with_column(name, values), MODEL_POINTS, "t.csv")
    points = with_column("Flug", ["hoch", "hoch", "tief"])
    require_one_flight(points, CONTROL_POINTS, "t.csv")  # known from either flight


def test_init_and_check_tell_it_before_rows_that_stand_twice(small_block):
    low = pd.read_csv(small_block.path / "low_flight.csv", dtype=str)
    both = pd.concat([low.assign(Flug="hoch"), low.assign(Flug="tief")])
    both.to_csv(small_block.path / "low_flight.csv", index=False)
    (problem,) = find_problems(small_block.path).problems
    assert "column 'Flug' has the values hoch, tief, as of two" in problem.found
    assert problem.remedy.startswith("Part the rows into a file for each flight")
    with pytest.raises(TableError, match="as of two flights"):
        look_at(small_block.path / "low_flight.csv", Said())
