"""Texts that end within their last number: only its decimals tell."""

import numpy as np
import pandas as pd
import pytest

from einschalt.foundations.errors import TableError
from einschalt.foundations.tables import CONTROL_POINTS, MODEL_POINTS
from einschalt.interfaces.files.csv_tables import read_csv, understand_csv
from einschalt.interfaces.files.cut_files import note_on_last_model

HEAD = "model_id,point_id,x,y\n"
XY = np.random.default_rng(1).uniform(-100.0, 100.0, (150, 2))


def read(tmp_path, text, schema=MODEL_POINTS):
    path = tmp_path / "low.csv"
    path.write_bytes(text.encode())
    return read_csv(path, schema)


def rows(form, end="\n", sign=","):
    lines = [
        sign.join(["1/2", str(k), format(x, form), format(y, form)])
        for k, (x, y) in enumerate(XY)
    ]
    return end.join([HEAD.strip().replace(",", sign), *lines, ""])


@pytest.mark.parametrize("form", [".4f", ""])
@pytest.mark.parametrize(("end", "sign"), [("\n", ","), ("\r\n", ";"), ("\n", "\t")])
def test_a_number_that_was_cut_is_refused_with_its_line(tmp_path, form, end, sign):
    whole = rows(form, end, sign)
    assert len(read(tmp_path, whole)) == len(XY)
    # without the last line end, as many programs write it
    assert len(read(tmp_path, whole.removesuffix(end))) == len(XY)
    n_digits = len(whole.rpartition(".")[2].removesuffix(end))
    for n_lost in (n_digits // 2 + 1, n_digits, n_digits + 1):
        with pytest.raises(TableError, match="the file ends within this row") as caught:
            read(tmp_path, whole.removesuffix(end)[:-n_lost])
        assert (caught.value.row, caught.value.file) == (len(XY) + 1, "low.csv")


@pytest.mark.parametrize(
    "text",
    [
        HEAD + "1,A,1.25,2.25\n1,B,3.25,4.2",  # too few to tell
        HEAD + "".join(f"1,{k},1.25,{k / 4:g}\n" for k in range(150)) + "1,X,1.25,7",
        rows(".4f") + '1/2,"X",1.0,2.5',  # quoted
        rows(".4f") + "1/2,X,1.0,2.5\n",
        rows(".4f") + "1/2,X,1.0,2.5\x1a",  # Ctrl-Z
    ],
)
def test_short_numbers_alone_are_no_cut(tmp_path, text):
    assert len(read(tmp_path, text))


def test_a_last_column_of_words_or_without_a_value_is_no_cut(tmp_path):
    text = "point_id,easting,northing,height\n"
    text += "".join(f"{k},1.00,2.00,3.00\n" for k in range(20))
    assert len(read(tmp_path, text + "X,1.00,2.00,", CONTROL_POINTS)) == 21
    text = text.replace("height", "role").replace(",3.00", ",control")
    assert len(read(tmp_path, text + "X,1.00,2.00,check", CONTROL_POINTS)) == 21


def test_a_list_parted_by_blanks_is_looked_at_as_it_was(tmp_path):
    path = tmp_path / "list.txt"
    text = "".join(f"P{k}  100.000 {200 + k}.000 5{k}.25\n" for k in range(40))
    path.write_text("point_id easting northing height\n" + text + "X 1.000 2.000 3.5")
    with pytest.raises(TableError, match=r"'3.5' has fewer decimals \(1\)"):
        understand_csv(path, CONTROL_POINTS)


def in_models(sizes, word="model_id"):
    names = np.repeat([f"{k}/{k + 1}" for k in range(len(sizes))], sizes)
    points = np.concatenate([np.arange(size) for size in sizes])
    return pd.DataFrame({word: names, "point_id": points.astype(str)})


@pytest.mark.parametrize("word", ["model_id", "image_id"])
def test_a_last_model_that_is_cut_short_is_noted(word):
    """Whole rows were lacking, and nothing told it."""
    note = note_on_last_model(in_models([12] * 10 + [5], word), word, "low.csv")
    assert note.startswith(f"low.csv: the last {word[:-3]}, 10/11, has 5 points, every")
    assert "every other one 12 or more: was the file cut off?" in note


@pytest.mark.parametrize(
    "sizes",
    [[12] * 10 + [6], [12] * 9 + [5], [12] * 9 + [5, 4], [12] * 10, [12]],
)
def test_a_small_model_among_others_is_no_cut(sizes):
    assert note_on_last_model(in_models(sizes), "model_id", "low.csv") is None


def test_models_whose_rows_are_scattered_tell_nothing():
    frame = pd.concat([in_models([12] * 12), in_models([3])])
    assert note_on_last_model(frame, "model_id", "low.csv") is None
    assert note_on_last_model(frame[["point_id"]], "model_id", "low.csv") is None
    assert note_on_last_model(frame.head(0), "model_id", "low.csv") is None
    twice = in_models([12] * 10 + [5])[["model_id", "point_id", "model_id"]]
    assert note_on_last_model(twice, "model_id", "low.csv") is None
