"""Files that are missing, unreadable, or in another encoding."""

import hashlib
import os
from pathlib import Path

import pytest

from einschalt.foundations.errors import FileError
from einschalt.interfaces.files import input_files
from einschalt.interfaces.files.input_files import (
    checksum,
    checksum_or_none,
    companions,
    read_text_bytes,
    require_file,
)


def test_byte_order_mark_is_taken_off(tmp_path):
    (tmp_path / "a.csv").write_bytes(b"\xef\xbb\xbfpoint_id\n")
    assert read_text_bytes(tmp_path / "a.csv", "a.csv") == b"point_id\n"


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"", r"a\.csv: the file is empty\. Fill it"),
        (b"\xef\xbb\xbf\r\n", r"a\.csv: the file is empty\. Fill it"),
        ("\u2028\n\x85".encode(), r"a\.csv: the file is empty\. Fill it"),
        (b"PK\x03\x04", "is a workbook or a zip archive; .*Save the sheet as CSV"),
        (b"\xd0\xcf\x11\xe0", "is an old Excel workbook; .*Save the sheet as CSV"),
        (b"PAR1\x15", r"is a Parquet file; .*Give it the suffix \.parquet"),
        (b"\x1f\x8b\x08", "is compressed with gzip; expected UTF-8 text. Unpack it"),
        (b"SQLite format 3\0", "is an SQLite database; .*Export the table as CSV"),
        (b"\xff\xfea\0", r"is UTF-16 text; expected UTF-8 text\. Save it as UTF-8"),
        (b"\xfe\xff\0a", r"is UTF-16 text; expected UTF-8 text\. Save it as UTF-8"),
        (b"a\nb\0c\n", "row 2: holds NUL bytes, so it is no text"),
        (b"a\nB\xe4r,1\n", "row 2: 'Bär,1' is not UTF-8; .*Windows or Latin-1"),
    ],
)
def test_what_is_no_utf8_text_is_refused(tmp_path, data, said):
    (tmp_path / "a.csv").write_bytes(data)
    with pytest.raises(FileError, match=said):
        read_text_bytes(tmp_path / "a.csv", "a.csv")


def test_missing_file_shows_what_is_near(tmp_path):
    (tmp_path / "High_Flight.csv").touch()
    with pytest.raises(FileError, match=r"Did you mean 'High_Flight\.csv'\?$"):
        require_file(tmp_path / "high_fligth.csv", "high_fligth.csv")


def test_a_suffix_alone_makes_no_file_near(tmp_path):
    (tmp_path / "hochflug.csv").touch()
    with pytest.raises(FileError, match=r"Its folder holds hochflug\.csv\.$"):
        require_file(tmp_path / "nofile.csv", "nofile.csv")


def test_missing_file_does_not_suggest_what_another_key_names(tmp_path):
    (tmp_path / "high_flight.csv").touch()
    with pytest.raises(FileError, match=r"Its folder holds high_flight\.csv\.$"):
        require_file(
            tmp_path / "low_flight.csv", "low_flight.csv", taken=["high_flight.csv"]
        )


def test_missing_folder_is_said(tmp_path):
    with pytest.raises(FileError, match="does not exist, nor does its folder"):
        require_file(tmp_path / "data" / "a.csv", "data/a.csv")


def test_file_without_permission(tmp_path, monkeypatch):
    (tmp_path / "a.csv").touch()

    def refuse(_path, _mode):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "open", refuse)
    with pytest.raises(FileError, match=r"cannot be read: permission denied\. See"):
        require_file(tmp_path / "a.csv", "a.csv")


@pytest.mark.skipif(os.name == "nt", reason="names as POSIX has them")
def test_name_that_no_system_takes(tmp_path):
    said = r"AAAA: cannot be read: file name too long\. Correct the name\.$"
    with pytest.raises(FileError, match=said):
        require_file(tmp_path / ("A" * 5000), "A" * 5000)
    (tmp_path / "loop.csv").symlink_to(tmp_path / "loop.csv")
    with pytest.raises(FileError, match=r"too many levels .*Correct the name"):
        require_file(tmp_path / "loop.csv", "loop.csv")


@pytest.mark.skipif(os.name == "nt", reason="pipes of POSIX")
@pytest.mark.parametrize("kind", ["pipe", "device"])
def test_what_never_ends_is_no_file(tmp_path, kind):
    path = Path("/dev/zero")
    if kind == "pipe":
        path = tmp_path / "a.csv"
        os.mkfifo(path)
    with pytest.raises(FileError, match=r"is a device or a pipe; expected a file"):
        read_text_bytes(path, "a.csv")


@pytest.mark.skipif(not hasattr(os, "SEEK_HOLE"), reason="files without holes")
def test_a_file_of_holes_is_neither_read_nor_hashed(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("point_id,easting,northing\n")
    os.truncate(path, 2**40)
    with pytest.raises(
        FileError,
        match=r"is 1100 GB large, most of it holes; .* everything is written",
    ):
        require_file(path, "a.csv")
    assert checksum_or_none(path) is None
    os.truncate(path, 2**20)  # a small one is read as it is
    assert checksum_or_none(require_file(path, "a.csv")) == checksum(path)


def test_a_file_beyond_half_of_the_memory_is_refused(tmp_path, monkeypatch):
    path = tmp_path / "a.csv"
    path.write_text("point_id,easting,northing\n")
    monkeypatch.setattr(input_files, "LARGE_BYTES", 10)
    monkeypatch.setattr(input_files, "allowed_bytes", lambda: 40.0)
    with pytest.raises(FileError, match="at most 2e-08 GB, half of the memory"):
        require_file(path, "a.csv")


def test_folder_that_may_not_be_looked_into(tmp_path, monkeypatch):
    def refuse(_path):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "iterdir", refuse)
    with pytest.raises(FileError, match=r"does not exist\. Its folder holds nothing"):
        require_file(tmp_path / "a.csv", "a.csv")
    monkeypatch.setattr(Path, "stat", lambda path, **_: refuse(path))
    with pytest.raises(FileError, match=r"cannot be read: permission denied\. See to"):
        require_file(tmp_path / "a.csv", "a.csv")


def test_checksum_is_sha256(tmp_path):
    (tmp_path / "a.csv").write_bytes(b"abc")
    assert checksum(tmp_path / "a.csv") == hashlib.sha256(b"abc").hexdigest()


@pytest.mark.parametrize(
    ("name", "data", "beside"),
    [
        ("tracks.shp", b"", ["tracks.dbf", "tracks.shx"]),
        ("tracks_points.csv", b"point_id,x,y\n", []),
        ("tracks.csv", b"point_id,x,y\n", []),
        ("tracks.csv", b"OPENSFM_TRACKS_VERSION_v2\n", ["reconstruction.json"]),
        (
            "tracks.csv",
            b"a.jpg\t7\t3\t0.2\t-3e-05\t1\t2\t3\n",
            ["reconstruction.json"],
        ),
        ("tracks.csv", b"a1\t7\t3\t5000.2\t4000.1\t1\t2\t3\n", []),
        ("part.CSV", b"OPENSFM_TRACKS_VERSION_v1\n", ["reconstruction.json"]),
        ("ground_control_points.json", b"{}", ["reconstruction.json"]),
        ("tracks.csv", None, []),
    ],
)
def test_only_what_is_of_opensfm_has_its_reconstructions(tmp_path, name, data, beside):
    for other in ("reconstruction.json", "tracks.shx", "tracks.dbf"):
        (tmp_path / other).write_bytes(b"[]")
    if data is not None:
        (tmp_path / name).write_bytes(data)
    found = companions(tmp_path / name)
    assert sorted(one.name for one in found) == beside


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="the system has no pipes")
def test_a_pipe_is_not_asked_whether_it_holds_tracks(tmp_path):
    os.mkfifo(tmp_path / "tracks.csv")
    assert companions(tmp_path / "tracks.csv") == []
    assert companions(tmp_path / "tracks\0.csv") == []
