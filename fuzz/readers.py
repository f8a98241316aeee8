"""The readers that are fuzzed, each with the sound files that are changed.

A reader takes the path of a changed file. What it raises must be an EinschaltError,
whose text must be short, writable as UTF-8, and name the file; what it gives back must
pass the check of its table. Commands must end with a status and without a traceback.
"""

import json
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import ezdxf  # noqa: F401 - reads its own settings when it is first imported
import pandas as pd

from einschalt.foundations import tables
from einschalt.foundations.errors import EinschaltError
from einschalt.interfaces.batch.batch_run import MARKS, plan_batch
from einschalt.interfaces.batch.block_run import row_of_result
from einschalt.interfaces.batch.block_state import FAILURE, look_at
from einschalt.interfaces.batch.changes_file import (
    CHANGES,
    PREVIOUS,
    compare_with_previous,
)
from einschalt.interfaces.files.block_toml import read_block_toml
from einschalt.interfaces.files.camera_toml import read_camera
from einschalt.interfaces.files.input_files import checksum, companions, read_once
from einschalt.interfaces.files.plan_file import read_plan_file
from einschalt.interfaces.files.result_folder import PROVENANCE
from einschalt.interfaces.files.tables_by_suffix import understand_table
from einschalt.interfaces.programs.block_tables import find_problems, read_block
from einschalt.interfaces.reports.problem_list import problem_lines
from einschalt.pipeline.batch.block_table import blocks_table
from einschalt.pipeline.densify import densify
from einschalt.stages.relative_orientation.dangerous_surface import TERRAIN_HEIGHTS
from einschalt.stages.transformation_kinds import TRANSFORMATION_KINDS, ground_schema
from fuzz import foreign_files
from fuzz.commands import command
from fuzz.foreign_readers import (
    of_foreign_files,
    of_shapefiles,
    of_terrain,
    write_beside,
)
from fuzz.judges import judge_error, judge_text, watched
from fuzz.sound_files import (
    BLOCK,
    CAMERAS,
    IMAGES,
    PARALLAXES,
    PLANS,
    TABLES,
    as_geoparquet,
    as_map_or_workbook,
    as_parquet,
    write_tables,
)

BLOCKS = (BLOCK, IMAGES, PARALLAXES)
RESULT = "result"
# files that are read alone, so that every message is about them
NAMED = {"camera.toml", "plan.json", "t.csv", "t.tsv", "t.parquet"}
NAMED |= {"t.xlsx", "t.ods", "t.gpkg", "t.geojson"}
NAMED |= {"a.tif", "area.gpkg", "area.geojson", "heights.tif", "heights.xyz"}
NAMED |= {"tracks.csv", "markers.xml", "gcp_list.txt", "b.tif.txt"}
NAMED |= set(foreign_files.READ) | set(foreign_files.MORE)
PARQUET = {
    "low_flight.csv": {"compression": "none", "dtype": str},
    "high_flight.csv": {"compression": "zstd", "use_dictionary": False},
    "control_points.csv": {"separator": ";"},
    "y_parallaxes.csv": {"compression": "gzip"},
    "image_points.csv": {"data_page_version": "2.0"},
    "heights.csv": {"compression": "none"},
}
SCHEMAS = {
    "control_points.csv": tables.CONTROL_POINTS,
    "approximate_points.csv": tables.APPROXIMATE_POINTS,
    "low_flight.csv": tables.MODEL_POINTS,
    "high_flight.csv": tables.MODEL_POINTS,
    "y_parallaxes.csv": tables.Y_PARALLAXES,
    "bases.csv": tables.MODEL_BASES,
    "image_pairs.tsv": tables.IMAGE_PAIRS,
    "image_points.csv": tables.IMAGE_POINTS,
    "models.csv": tables.IMAGE_MODELS,
    "ground_points.csv": ground_schema(TRANSFORMATION_KINDS["affine"]),
    "heights.csv": TERRAIN_HEIGHTS,
}


@dataclass(frozen=True)
class Reader:
    """One way to read a kind of file.

    Attributes
    ----------
    name : str
    folder : Path
        With the files that go with it; it opens no others.
    path : Path
        Where the changed file is put.
    seeds : tuple of bytes
        Sound files.
    read : callable
        Takes the path.
    weight : float
        How often it has its turn.
    """

    name: str
    folder: Path
    path: Path
    seeds: tuple[bytes, ...]
    read: Callable
    weight: float


def readers(folder):
    """Make all readers.

    Parameters
    ----------
    folder : Path
        An empty one, in which each reader gets its own.

    Returns
    -------
    list of Reader
    """
    made = []
    for name, file, seeds, read, weight in (
        *(*_of_files(), *_of_programs(), *of_foreign_files()),
        *(*of_shapefiles(_table(tables.APPROXIMATE_POINTS)), *of_terrain()),
        *(*_of_blocks(), *_commands()),
    ):
        own = folder / f"{len(made):02d}"
        write_tables(own)
        # what stands here where another file of the block is the hostile one
        (own / "block.toml").write_text(BLOCK, encoding="utf-8")
        write_beside(file, own)
        if file.startswith(RESULT):
            _write_result(own / RESULT)
            data = ((own / file).read_bytes(),)
        else:
            data = tuple(s if isinstance(s, bytes) else s.encode() for s in seeds)
        made.append(Reader(name, own, own / file, data, read, weight))
    return made


def _of_files():
    """Readers of one file."""
    yield "block.toml", "block.toml", BLOCKS, _toml, 50
    yield "camera.toml", "camera.toml", CAMERAS, _camera, 30
    yield "plan.json", "plan.json", PLANS, read_plan_file, 4
    for name, schema in SCHEMAS.items():
        yield name, f"t{Path(name).suffix}", (TABLES[name],), _table(schema), 4
    for name, options in PARQUET.items():
        packed = as_parquet(TABLES[name], **options)
        yield f"{name}, Parquet", "t.parquet", (packed,), _table(SCHEMAS[name]), 4


def _of_programs():
    """Readers of sheets and layers."""
    for suffix in (".xlsx", ".ods", ".gpkg", ".geojson"):
        seed = as_map_or_workbook(TABLES["approximate_points.csv"], suffix)
        read = _table(tables.APPROXIMATE_POINTS)
        yield f"points{suffix}", f"t{suffix}", (seed,), read, 1
    packed = as_geoparquet(TABLES["approximate_points.csv"])
    yield "points, GeoParquet", "t.parquet", (packed,), read, 1


def _of_blocks():
    """Readers of a whole block, and of what an earlier batch has left."""
    yield "block", "block.toml", BLOCKS, _block, 1
    yield "densify block.toml", "block.toml", BLOCKS, _densify, 0.15
    yield "state", "block.toml", BLOCKS, _state, 2
    for name in ("control_points.csv", "low_flight.csv", "high_flight.csv"):
        yield f"block, {name}", name, (TABLES[name],), _block, 0.15
        yield f"densify {name}", name, (TABLES[name],), _densify, 0.05
    for name, read in (
        (PROVENANCE, _state_of_result),
        (FAILURE, _state_of_result),
        (CHANGES, _state_of_result),
        (MARKS, _plan),
        (PREVIOUS, _comparison),
    ):
        yield f"earlier {name}", f"{RESULT}/{name}", (), read, 0.5


def _commands():
    """Commands, with all that they compute."""
    seeds = {"block.toml": (BLOCK,), "camera.toml": CAMERAS}
    for file, weight, call in (
        ("block.toml", 0.2, "check FOLDER"),
        ("low_flight.csv", 0.1, "check FOLDER"),
        ("block.toml", 0.1, "batch FOLDER --dry-run --output OUT"),
        ("block.toml", 0.005, "densify FOLDER --output OUT"),
        ("y_parallaxes.csv", 0.03, "orient FILE --base 92 --output OUT"),
        ("bases.csv", 0.03, "orient FOLDER/y_parallaxes.csv --base FILE -o OUT"),
        ("image_pairs.tsv", 0.03, "orient FILE --principal-distance 153 -o OUT"),
        ("camera.toml", 0.03, "orient FOLDER/image_pairs.tsv --camera FILE -o OUT"),
        ("heights.csv", 0.03, "plan --terrain FILE --scale-number 8000"),
        ("low_flight.csv", 0.03, "transform FILE FOLDER/ground_points.csv -o OUT"),
        ("ground_points.csv", 0.03, "transform FOLDER/low_flight.csv FILE -o OUT"),
    ):
        texts = seeds.get(file) or (TABLES[file],)
        yield f"{call} ({file})", file, texts, command(*call.split()), weight


def _table(schema):
    def read_and_check(path):
        beside = [read_once(one, one.name) for one in companions(path)]
        table = understand_table(path, schema, beside=beside).frame
        checked = tables.check_table(table, schema, source=path.name)
        for problem in checked.problems:
            judge_error(problem, path.name)
        for note in checked.notes:
            judge_text(note)

    return read_and_check


def _toml(path):
    for problem in read_block_toml(path).problems:
        judge_error(problem, path.name)


def _camera(path):
    read_camera(path, path.name)


def _block(path):
    found = find_problems(path.parent)
    for line in problem_lines(found):
        judge_text(line)
    for problem in (*found.problems, *found.model_problems):
        judge_error(problem)


def _densify(path):
    judge_text(densify(read_block(path.parent)).summary())


def _state(path):
    look_at("block", path.parent, path.parent / RESULT)


def _state_of_result(path):
    folder = path.parent
    state = look_at("block", folder.parent, folder)
    if state.provenance is not None:
        blocks_table([row_of_result(state.task, "done", state.provenance)])


def _plan(path):
    folder = path.parent
    plan_batch([folder.parent], folder, which="unfinished", overwrite=True)


def _comparison(path):
    points = pd.read_csv(path.with_name("points.csv"), dtype={"point_id": str})
    compare_with_previous(points, path.parent, path.parent)


def _write_result(folder):
    """What an earlier batch has left of the block in the folder above."""
    folder.mkdir(exist_ok=True)
    points = TABLES["approximate_points.csv"]
    (folder / "points.csv").write_text(points, encoding="utf-8")
    (folder / PREVIOUS).write_bytes(as_parquet(points, dtype={"point_id": str}))
    (folder / CHANGES).write_text(
        "point_id,change,moved_total\n7/8,moved,0.25\n14,new,\n", encoding="utf-8"
    )
    signature = look_at("block", folder.parent, folder).task.signature
    inputs = signature["inputs"].items()
    provenance = {
        **signature,
        "inputs": [{"table": t, "file": t, "sha256": s} for t, s in inputs],
        "outputs": {"points.csv": checksum(folder / "points.csv")},
        "figures": {"n_points": 9, "mean_total": 0.05, "n_suspects": 0},
        "seconds": 0.25,
    }
    failure = {
        **dict.fromkeys(("stage", "reason", "remedy"), "reading"),
        "is_final": True,
        "signature": signature,
    }
    marks = {"schema": 1, "blocks": {folder.parent.name: None}}
    for name, content in ((PROVENANCE, provenance), (FAILURE, failure), (MARKS, marks)):
        (folder / name).write_text(json.dumps(content), encoding="utf-8")


def verdict(reader, data):
    """Read a changed file, and say what is wrong with how that ends.

    Parameters
    ----------
    reader : Reader
    data : bytes

    Returns
    -------
    str
        Empty where it ends as it should.
    """
    reader.path.write_bytes(data)
    try:
        with watched(reader.folder, data), warnings.catch_warnings():
            warnings.simplefilter("error", RuntimeWarning)
            _read(reader)
    except Exception as fault:  # noqa: BLE001 - any other error is what we look for
        return f"{type(fault).__name__}: {fault}"
    return ""


def _read(reader):
    try:
        reader.read(reader.path)
    except EinschaltError as error:
        # where a whole block is read, another file of it may be at fault
        is_alone = reader.read is not _block and reader.path.name in NAMED
        judge_error(error, reader.path.name if is_alone else "")
