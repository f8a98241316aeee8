"""The dictionary of columns says what its page says, and no word has two meanings."""

import re
from collections import Counter
from pathlib import Path

import pytest

from einschalt.foundations.column_words import (
    COLUMN_WORDS,
    KINDS,
    columns_meant,
    folded,
    kind_of,
)
from einschalt.foundations.errors import TableError
from einschalt.foundations.tables import CONTROL_POINTS, MEASURED_MODEL_POINTS

PAGE = Path(__file__).parents[2] / "docs" / "tables.md"


def rows_of(heading):
    """Cells of the table below a heading of the page."""
    text = PAGE.read_text(encoding="utf-8").partition(f"## {heading}\n")[2]
    lines = text.partition("\n## ")[0].splitlines()
    table = [line.strip("|").split("|") for line in lines if line.startswith("| ")]
    return table[1:]


def words_of(cells):
    parts = (part for cell in cells for part in re.split(r"[,;]", cell))
    return [part.strip() for part in parts if part.strip()]


def test_every_word_of_the_page_is_known():
    rows = rows_of("Names of columns")
    assert len(rows) > 10
    for first, *cells in rows:
        names = re.findall(r"`(\w+)`", first)
        for word in words_of(cells):
            own = [folded(name) for name in names]
            known = any((name, folded(word)) in COLUMN_WORDS for name in names)
            assert known or folded(word) in own, word


def test_every_kind_of_point_on_the_page_is_known():
    rows = rows_of("Kinds of points")
    assert len(rows) == len(KINDS)
    for first, *cells in rows:
        role = next(kind for kind in reversed(KINDS) if kind in first)
        assert {kind_of(word) for word in words_of(cells)} == {role}


def test_no_kind_has_two_roles():
    words = [
        w for languages in KINDS.values() for v in languages.values() for w in v.split()
    ]
    assert [word for word, n in Counter(words).items() if n > 1] == []


@pytest.mark.parametrize("schema", [CONTROL_POINTS, MEASURED_MODEL_POINTS])
def test_names_of_the_project_are_never_translated(schema):
    names = [*schema.names, "Punktnummer", "Rechtswert", "remark"]
    assert columns_meant(names, schema).names == tuple(names)


def test_a_number_of_a_point_is_not_its_northing():
    names = columns_meant(["N°", "E", "N"], CONTROL_POINTS).names
    assert names == ("point_id", "easting", "northing")


@pytest.mark.parametrize("number", ["Nr", "Nummer", "No"])
def test_a_number_and_a_name_could_both_be_the_point(number):
    names = [number, "Name", "E", "N"]
    with pytest.raises(TableError, match=f"columns '{number}' and 'Name' could both"):
        columns_meant(names, CONTROL_POINTS)
    meant = columns_meant(names, CONTROL_POINTS, {"point_id": "Name"})
    assert meant.translated["point_id"] == "Name"
    meant = columns_meant(["Id", *names[1:]], CONTROL_POINTS)
    assert meant.translated["point_id"] == "Id"  # as DBAT has them
    meant = columns_meant(["Pt", *names], CONTROL_POINTS)
    assert meant.translated["point_id"] == "Pt"


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (["Nr", "P", "E", "N", "H"], "Nr"),
        (["P", "No", "E", "N"], "No"),
        (["Name", "P", "E", "N"], "Name"),
        (["P", "E", "N", "H"], "P"),
    ],
)
def test_p_names_points_where_nothing_else_does(names, expected):
    """A weight or a code beside Nr; such tables were refused."""
    assert columns_meant(names, CONTROL_POINTS).translated["point_id"] == expected


def test_a_number_beside_a_name_is_a_question_that_p_is_not_in():
    with pytest.raises(TableError, match="'Nr' and 'Name' could both be point_id"):
        columns_meant(["Nr", "Name", "P", "E", "N"], CONTROL_POINTS)
