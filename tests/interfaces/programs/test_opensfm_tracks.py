"""Tracks of OpenSfM as image points, by the sizes of the images beside them."""

import json
import tracemalloc

import pytest

from einschalt.foundations.errors import EinschaltError
from einschalt.interfaces.programs.recognised import read_foreign

V1 = "a.jpg\t7\t3\t0.25\t-0.125\t0.002\t1\t2\t3\n"
V2 = "a b.jpg\t8\t3\t-0.5\t0.5\t0.002\t1\t2\t3\t-1\t-1\n"
V0 = "a.jpg\t7\t3\t0.25\t-0.125\t1\t2\t3\n"  # of before 2019
HEADS = {
    V0: "",
    V1: "OPENSFM_TRACKS_VERSION_v1\n",
    V2: "OPENSFM_TRACKS_VERSION_v2\n",
}


def written(folder, text, sizes=((4000, 3000), (3000, 4000))):
    cameras = dict(zip(("a.jpg", "a b.jpg"), sizes, strict=True))
    part = {
        "cameras": {n: {"width": w, "height": h} for n, (w, h) in cameras.items()},
        "shots": {name: {"camera": name} for name in cameras},
    }
    (folder / "reconstruction.json").write_text(json.dumps([part]))
    path = folder / "tracks.csv"
    path.write_text(text)
    return path


@pytest.mark.parametrize(
    ("row", "expected"),
    [  # (w - 1) / 2 + x max(w, h), and so for y
        (V0, ["a.jpg", "7", 1999.5 + 1000.0, 1499.5 - 500.0]),
        (V1, ["a.jpg", "7", 1999.5 + 1000.0, 1499.5 - 500.0]),
        (V2, ["a b.jpg", "8", 1499.5 - 2000.0, 1999.5 + 2000.0]),
    ],
)
def test_places_become_pixels(tmp_path, row, expected):
    found = read_foreign(written(tmp_path, HEADS[row] + row))
    assert found.tables["image_points"].to_numpy().tolist() == [expected]
    assert not found.notes


def test_images_that_no_reconstruction_has_are_left_out_and_named(tmp_path):
    text = HEADS[V1] + V1.replace("a.jpg", "c.jpg") + V1 + V1.replace("a.jpg", "d.jpg")
    found = read_foreign(written(tmp_path, text))
    assert found.tables["image_points"]["image_id"].tolist() == ["a.jpg"]
    assert found.notes == (
        "tracks.csv: 2 images that no reconstruction has, left out: c.jpg, d.jpg",
    )


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (HEADS[V1] + V1 + "a.jpg\t7\t3\t0.25\n", r"row 3: 'a\.jpg 7 3 0\.25' cannot"),
        (HEADS[V1] + V1.replace("0.25", "nan"), "row 2: .* cannot be read"),
        (HEADS[V1] + V1.replace("a.jpg", "c.jpg"), "size of image c.jpg is unknown"),
        (HEADS[V1], "holds no point of a track"),
        (HEADS[V1] + "\ufeff", "holds no point of a track"),
        (V0 + "a.jpg\t7\t3\t0.25\n", r"row 2: 'a\.jpg 7 3 0\.25' cannot"),
        (V0 + "\n" + V0.replace("-0.125", "nan"), "row 3: .* cannot be read"),
        ("OPENSFM_TRACKS_VERSION_v0\n" + V1, "row 1: tracks of version '0'"),
        ("OPENSFM_TRACKS_VERSION_v9\n" + V1, "row 1: tracks of version '9'"),
    ],
)
def test_damaged_tracks_are_refused_with_their_line(tmp_path, text, told):
    with pytest.raises(EinschaltError, match=rf"tracks\.csv.*{told}"):
        read_foreign(written(tmp_path, text))


def test_a_file_that_is_said_to_be_tracks_is_not_told_of_a_version(tmp_path):
    path = written(tmp_path, "point_id\teasting\tnorthing\n7\t1.5\t2.5\n")
    with pytest.raises(EinschaltError) as refused:
        read_foreign(path, "opensfm-tracks")
    said = str(refused.value)
    assert "begins with 'point_id easting northing', and not with a version" in said
    assert "OPENSFM_TRACKS_VERSION_v1 or 2, or the 8 columns of older tracks" in said


def test_a_last_line_without_an_end_is_noted(tmp_path):
    found = read_foreign(written(tmp_path, HEADS[V1] + V1.rstrip("\n")))
    assert "is its last line whole?" in found.notes[0]


# as JSON may have them
SIDES = ["0", "-5", "0.5", '"nan"', '"inf"', "1e400", "1" + "0" * 400]


@pytest.mark.parametrize("side", SIDES, ids=lambda side: side[:8])
@pytest.mark.parametrize("place", [0, 1])
def test_sizes_that_no_image_has_are_refused(tmp_path, side, place):
    size = [4000, 3000]
    size[place] = 7777
    path = written(tmp_path, HEADS[V1] + V1, (size, (3000, 4000)))
    beside = path.with_name("reconstruction.json")
    beside.write_text(beside.read_text().replace("7777", side))
    with pytest.raises(EinschaltError, match=r"n\.json: the size of image a\.jpg is"):
        read_foreign(path)


@pytest.mark.parametrize("line_end", ["\n", "\r\n", "\r"])
def test_bad_lines_are_all_named_where_they_stand(tmp_path, line_end):
    bad = [
        V1.replace("0.25", "1_0"),
        V1.replace("-0.125", "1e999"),
        V1.replace("a.jpg", " "),
        V1.replace("\t7\t", "\t\t"),
        V1.rstrip("\n") + "\t3\n",
        "\u2028" + V1.replace("0.25", ""),
    ]
    lines = [HEADS[V1], V1, "\n", *bad[:3], "  \n", V1, *bad[3:], V1]
    path = written(tmp_path, "")
    path.write_bytes("".join(lines).replace("\n", line_end).encode())
    with pytest.raises(EinschaltError) as caught:
        read_foreign(path)
    assert [one.row for one in caught.value.problems] == [4, 5, 6, 9, 10, 11]
    assert "expected 9 columns parted by tabs: image, track" in str(caught.value)


@pytest.mark.parametrize("rest", ["", "\n", "\n \n\t\n"])
def test_tracks_of_no_line_are_refused(tmp_path, rest):
    path = written(tmp_path, HEADS[V1].rstrip("\n") + rest)
    with pytest.raises(EinschaltError, match="holds no point of a track"):
        read_foreign(path)


def test_tracks_of_lines_that_say_nothing_are_refused(tmp_path):
    path = written(tmp_path, HEADS[V2] + "\u3000\n" + "\t" * 10 + "\n")
    with pytest.raises(EinschaltError, match="holds no point of a track"):
        read_foreign(path)


def test_blanks_signs_and_quotes_are_read_as_before(tmp_path):
    row = ' a.jpg \t"7\t3\t +.25\t-1.25e-1 \t0.002\t1\t2\t3\n'
    path = written(tmp_path, HEADS[V1] + "\n\t\t\t\t\t\t\t\t\n" + row)
    found = read_foreign(path).tables["image_points"]
    assert found.to_numpy().tolist() == [["a.jpg", '"7', 2999.5, 999.5]]


def test_lines_longer_than_a_block_of_the_reader_are_named(tmp_path):
    text = HEADS[V1] + V1 + "x" * 2**21 + "\n"
    with pytest.raises(EinschaltError, match=r"row 3: 'xxx.*cannot be read"):
        read_foreign(written(tmp_path, text))


def test_nothing_is_done_row_by_row(tmp_path):
    """Rows are no objects of Python: of 10^5 there are few more than of one."""
    path = written(tmp_path, HEADS[V1] + V1 * 100_000)
    tracemalloc.start()
    found = read_foreign(path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert len(found.tables["image_points"]) == 100_000
    assert peak < 30e6  # 150 MB as lists of words
