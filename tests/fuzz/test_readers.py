"""Hostile files, some hundreds at random, and those that once did harm.

``make fuzz`` runs many more; what it finds is mended and kept in ``corpus``.
"""

import os
import time
from importlib import import_module
from pathlib import Path

import pytest

from einschalt.interfaces.programs import recognised

ROOT = Path(__file__).parents[2]
CORPUS = Path(__file__).parent / "corpus"
N_INPUTS = 1200
FIRST = 10**9  # apart from those of make fuzz


@pytest.fixture(scope="module")
def modules():
    """The modules of fuzz/, which lies beside the package, by their names."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(ROOT)
        yield lambda name: import_module(f"fuzz.{name}")


@pytest.fixture(scope="module")
def all_readers(modules, tmp_path_factory):
    return modules("readers").readers(tmp_path_factory.mktemp("readers"))


@pytest.mark.slow
def test_hostile_files_end_in_a_result_or_a_message(modules, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    said, kept = [], []
    fuzzer = modules("__main__").run(FIRST, N_INPUTS, say=said.append, keep=kept.append)
    assert not fuzzer.found, said
    assert fuzzer.done.total() == N_INPUTS
    assert kept[-1] == FIRST + N_INPUTS
    assert len(fuzzer.done) > 20


def test_the_input_of_a_number_is_always_the_same(modules, tmp_path):
    fuzzer = modules("__main__").Fuzzer(tmp_path)
    inputs = [fuzzer.input_of(number) for number in range(40)]
    assert inputs == [fuzzer.input_of(number) for number in range(40)]
    assert len({data for _, data in inputs}) > 30


def test_every_format_has_a_sound_file(all_readers, tmp_path):
    """A format without a seed is one that no fuzz ever looks at."""
    seen = set()
    for reader in all_readers:
        path = tmp_path / reader.path.name
        for seed in reader.seeds:
            path.write_bytes(seed)
            seen.add(recognised.format_of(path))
    assert seen >= set(recognised.FORMATS)
    names = {
        reader.path.relative_to(reader.folder).as_posix() for reader in all_readers
    }
    folders = {"colmap/cameras.txt", "colmap/images.txt", "colmap/points3D.txt"}
    markers = {"markers.xml", "gcp_list.txt", "gcp.json", "reconstruction.json"}
    layers = {"t.shp", "t.dbf", "t.gpkg", "area.gpkg", "area.geojson"}
    pairs = {"Pastisa.tif/b.tif.txt"}
    assert names >= folders | markers | layers | pairs | {"heights.tif", "heights.xyz"}


@pytest.mark.slow
def test_every_kind_of_table_and_every_sound_file_is_read(all_readers, modules):
    """The seeds are sound: what is found is due to what was changed."""
    for reader in all_readers:
        for seed in reader.seeds:
            assert modules("readers").verdict(reader, seed) == "", reader.name
    read = {reader.path.suffix for reader in all_readers}
    assert read >= {".toml", ".csv", ".tsv", ".parquet", ".json", ".xlsx", ".gpkg"}


@pytest.fixture
def judged(modules, tmp_path):
    """What is said of a reader that ends in some way."""
    readers = modules("readers")

    def call(read, name="t.csv", data=b""):
        reader = readers.Reader("r", tmp_path, tmp_path / name, (), read, 1.0)
        return readers.verdict(reader, data)

    return call


def test_the_harness_sees_tracebacks_and_bad_messages(judged, modules):
    error = modules("readers").EinschaltError

    def breaks(path):
        raise KeyError(path.name)

    def babbles(path):
        raise error("x" * 30_000, file=path.name)

    def hides(_path):
        raise error("something is wrong")

    assert judged(breaks) == "KeyError: 't.csv'"
    assert "a message of 30008 characters" in judged(babbles)
    assert "does not name the file" in judged(hides)
    assert judged(hides, "block.toml") == ""


def test_the_harness_sees_files_elsewhere(judged, tmp_path):
    elsewhere = tmp_path.parent / "elsewhere.csv"
    elsewhere.write_text("x")
    named = f"file = '{os.path.relpath(elsewhere, tmp_path)}'".encode()

    def reads(_path):
        elsewhere.read_bytes()

    def writes(_path):
        elsewhere.write_text("y")

    def removes(_path):
        elsewhere.unlink(missing_ok=True)

    assert judged(reads).endswith("reads " + str(elsewhere))
    assert judged(reads, "block.toml", named) == ""
    assert judged(writes, "block.toml", named).endswith("writes " + str(elsewhere))
    assert judged(removes, "block.toml", named).endswith("writes " + str(elsewhere))


def _waits(*_):
    time.sleep(600)


def _turns(*_):
    while True:
        pass


@pytest.mark.slow
@pytest.mark.parametrize(
    ("limit", "hangs"), [("WAIT_SECONDS", _waits), ("HANG_SECONDS", _turns)]
)
def test_the_harness_sees_what_hangs(modules, tmp_path, monkeypatch, limit, hangs):
    main = modules("__main__")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(main, limit, 1)
    monkeypatch.setattr(main, "verdict", hangs)
    said = []
    fuzzer = main.run(FIRST, 1, say=said.append)
    assert "hangs: no end after" in said[0]
    assert len(fuzzer.found) == 1


@pytest.mark.parametrize("file", sorted(CORPUS.iterdir()), ids=lambda file: file.name)
def test_what_once_did_harm(file, all_readers, modules):
    name = file.name.split("-", 1)[1]
    readers = [reader for reader in all_readers if reader.path.name == name]
    assert readers
    for reader in readers:
        assert modules("readers").verdict(reader, file.read_bytes()) == "", reader.name
