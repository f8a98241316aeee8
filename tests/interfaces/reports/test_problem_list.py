"""Problems of a block's input as lines and as a table."""

import io
from types import SimpleNamespace

import pytest
from rich.console import Console

from einschalt.foundations.errors import ConsistencyError, TableError
from einschalt.interfaces.reports.problem_list import (
    conclusion,
    problem_lines,
    problem_tables,
)


@pytest.fixture
def found():
    return SimpleNamespace(
        problems=(
            TableError(
                "northing 'n/a' is not a number",
                expected="metres",
                remedy="Give a value or delete the row",
                file="low_flight.csv",
                row=214,
                point="[red]1043",
                model="7/8",
            ),
        ),
        model_problems=(ConsistencyError("no common\npoints", model="12/13"),),
        notes=("low_flight.csv: ignored column colour",),
    )


def test_each_line_is_one_whole_message(found):
    assert "row 214, point [red]1043, model 7/8" in problem_lines(found)[0]
    assert problem_lines(found) == [
        f"problem: {found.problems[0]}",
        "model: model 12/13: no common points.",
        "note: low_flight.csv: ignored column colour",
    ]


def printed(found, width):
    console = Console(file=io.StringIO(), width=width)
    console.print(problem_tables(found))
    return console.file.getvalue()


def test_table_shows_names_that_look_like_markup(found):
    assert "│ point [red]1043 │" in printed(found, 200)


@pytest.mark.parametrize("width", [50, 80, 120])
def test_narrow_tables_fold_and_cut_nothing(found, width):
    narrow, wide = printed(found, width), printed(found, 250)
    assert sorted(filter(str.isalnum, narrow)) == sorted(filter(str.isalnum, wide))
    assert max(map(len, narrow.split("\n"))) <= width


def test_conclusion_counts(found):
    assert conclusion(found) == "1 problem, 1 model that cannot be used"
    nothing = SimpleNamespace(problems=(), model_problems=(), notes=("x",))
    assert conclusion(nothing) == "nothing wrong"
