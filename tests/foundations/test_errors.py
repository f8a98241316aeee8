"""Messages: where, what was found, what was expected, and how to mend it."""

import pickle
from pathlib import Path

import pytest

from einschalt.foundations.errors import (
    BlockError,
    EinschaltError,
    FileError,
    TableError,
    name_some,
    raise_problems,
)

FACTS = {
    "expected": "metres",
    "remedy": "Give a value or delete the row",
    "file": "low_flight.csv",
    "row": 214,
    "point": 1043,
    "model": "7/8",
}
TEXT = (
    "low_flight.csv, row 214, point 1043, model 7/8: northing 'n/a' is not a number; "
    "expected metres. Give a value or delete the row."
)


def problem(file, row):
    return TableError("x is missing", file=file, row=row)


def test_text_is_made_of_the_facts():
    error = TableError("northing 'n/a' is not a number", **FACTS)
    assert str(error) == TEXT
    assert (error.file, error.row, error.point) == ("low_flight.csv", 214, "1043")


@pytest.mark.parametrize(
    ("facts", "text"),
    [
        ({}, "Broken."),
        ({"remedy": "Did you give metres?"}, "Broken. Did you give metres?"),
        (
            {"expected": "1 to 5.", "remedy": "Mend it."},
            "Broken; expected 1 to 5. Mend it.",
        ),
        ({"row": 3}, "row 3: Broken."),
    ],
)
def test_sentences_end_once(facts, text):
    assert str(EinschaltError("Broken", **facts)) == text


def test_facts_can_be_added():
    error = TableError("northing 'n/a' is not a number", expected="metres", row=2)
    fuller = error.with_facts(file="a.csv", row=3)
    assert type(fuller) is TableError
    assert str(fuller).startswith("a.csv, row 3: northing 'n/a' is not")
    assert (error.file, error.row) == (None, 2)


def test_errors_survive_a_process_border():
    error = TableError("northing 'n/a' is not a number", **FACTS)
    assert str(pickle.loads(pickle.dumps(error))) == TEXT
    several = BlockError([error, problem("a.csv", 2)])
    back = pickle.loads(pickle.dumps(several))
    assert str(back) == str(several)
    assert back.problems[0].row == 214


def test_nothing_one_or_all_are_raised():
    raise_problems([])
    with pytest.raises(TableError, match=r"a\.csv, row 2: x is missing"):
        raise_problems([problem("a.csv", 2)])
    with pytest.raises(BlockError, match="2 problems:\n"):
        raise_problems([problem("a.csv", 2), problem("a.csv", 3)])


def test_at_most_five_are_named():
    error = BlockError([problem("a.csv", row) for row in range(2, 12)])
    lines = str(error).splitlines()
    assert lines[0] == "10 problems:"
    assert [line.split(":")[0] for line in lines[1:6]] == [
        f"  a.csv, row {row}" for row in range(2, 7)
    ]
    assert lines[6:] == ["  and 5 more"]


def test_every_file_has_its_turn():
    """A table with a thousand faults does not hide the one fault of another."""
    many = [problem("a.csv", row) for row in range(2, 1002)]
    error = BlockError([*many, problem("b.csv", 7), problem("c.csv", 1)])
    named = [line.split(":")[0].strip() for line in str(error).splitlines()[1:6]]
    assert named == ["a.csv, row 2", "a.csv, row 3", "a.csv, row 4", "b.csv, row 7",
                     "c.csv, row 1"]  # fmt: skip
    assert str(error).endswith("\n  and 997 more")


def test_a_path_is_a_fact_as_well():
    error = FileError("it cannot be read").with_facts(file=Path("folder", "a.csv"))
    assert str(error).startswith(f"{Path('folder', 'a.csv')}: it cannot be read")
    assert error.file == str(Path("folder", "a.csv"))


def test_counted_faults_are_counted():
    rest = TableError("x is wrong in 9900 more rows", file="a.csv", stands_for=9900)
    error = BlockError([*(problem("a.csv", row) for row in range(100)), rest])
    assert str(error).startswith("10000 problems:\n")
    assert str(error).endswith("\n  and 9995 more")


def test_some_names():
    assert name_some(["a", "b"]) == "a, b"
    assert name_some([1, 2, 3, 4, 5, 6, 7]) == "1, 2, 3, 4, 5 and 2 more"
