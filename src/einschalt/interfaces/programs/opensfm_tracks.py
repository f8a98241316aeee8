"""Tracks of OpenSfM: points that it found itself in several images.

``tracks.csv`` counts from the middle of an image in units of its longer side; the
sizes stand in ``reconstruction*.json`` beside it. Millions of rows are usual. Files of
before 2019 begin without a line of their version.
"""

import codecs
import re

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from pyarrow import csv as arrow_csv

from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import TableError, raise_problems
from einschalt.foundations.tables import listed
from einschalt.interfaces.files.damaged_files import damaged
from einschalt.interfaces.files.input_files import (
    OPENSFM_TRACKS,
    are_opensfm_tracks,
    reconstructions,
)
from einschalt.interfaces.files.opensfm_images import image_sizes, unsized
from einschalt.interfaces.files.text_encodings import read_table_text
from einschalt.interfaces.programs.foreign import Foreign

# of each version, as OpenSfM itself demands; 0 is that without a line of it
N_COLUMNS = {"0": 8, "1": 9, "2": 11}
OLD, MOST_SHOWN = "0", 60
IMAGE, TRACK, X, Y = "0", "1", "3", "4"
READ = [IMAGE, TRACK, X, Y]
BLANKS = b" \t\r\n" + codecs.BOM_UTF8
LINE_END = re.compile(rb"\r\n|\r|\n")
NUMBER = r"^[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?$"
LARGEST_BLOCK = 2**31 - 1  # of pyarrow


def is_tracks(head):
    """Whether the first bytes of a file look so."""
    return are_opensfm_tracks(head)


def read_tracks(file) -> Foreign:
    """Read image points, in pixels from the upper left corner."""
    data = read_table_text(file, file.source)[0]
    n_columns, start = _begun(data, file.source)
    expected = (
        f"{n_columns} columns parted by tabs: image, track, feature, x y in units of "
        "the longer side, and more"
    )
    nothing = damaged(file.source, "holds no point of a track", expected)
    # which pyarrow refuses in words of its own
    if not data[start:].strip(BLANKS):
        raise nothing
    first_row = 2 if start else 1
    table, rows, torn = _parted(pa.py_buffer(data).slice(start), n_columns, first_row)
    places, is_bad = _numbers(table)
    bad = np.sort(np.append(rows[is_bad], torn))
    _refuse_rows(bad, data, expected, file.source)
    if not table.num_rows:
        raise nothing
    points, notes = _in_pixels(table, places, file)
    return Foreign({"image_points": points}, None, notes)


def _begun(data, source):
    """Number of columns, and where rows begin: behind the version, if it is said."""
    end = LINE_END.search(data)
    first, start = (data[: end.start()], end.end()) if end else (data, len(data))
    said = first.decode("utf-8").strip()
    version = said.removeprefix(OPENSFM_TRACKS.decode())
    if version != said:
        if version not in set(N_COLUMNS) - {OLD}:
            found = f"tracks of version {version!r}"
            raise damaged(source, found, "version 1 or 2", 1)
        return N_COLUMNS[version], start
    if not are_opensfm_tracks(data):
        said = shortened(said.replace("\t", " "), MOST_SHOWN)
        found = f"begins with {said!r}, and not with a version"
        expected = (
            f"{OPENSFM_TRACKS.decode()}1 or 2, or the {N_COLUMNS[OLD]} columns of "
            "older tracks, parted by tabs: image, track, feature, x y, colour"
        )
        raise damaged(source, found, expected, 1)
    return N_COLUMNS[OLD], 0


def _parted(lines, n_columns, first_row):
    """Image, track, x and y as text; the lines they stand in, and those of no columns.

    ``first_row`` is the number of the first of them; empty ones are left out.
    """
    skipped, torn = [], []

    def skip(line):
        skipped.append(line.number + first_row - 1)
        if line.text.strip():
            torn.append(line.number + first_row - 1)
        return "skip"

    table = arrow_csv.read_csv(
        pa.BufferReader(lines),
        read_options=arrow_csv.ReadOptions(
            column_names=[str(k) for k in range(n_columns)],
            # no line is longer, and without threads lines have their numbers
            block_size=min(len(lines) + 1, LARGEST_BLOCK),
            use_threads=False,
        ),
        parse_options=arrow_csv.ParseOptions(
            delimiter="\t",
            quote_char=False,
            ignore_empty_lines=False,
            invalid_row_handler=skip,
        ),
        convert_options=arrow_csv.ConvertOptions(
            column_types=dict.fromkeys(READ, pa.string()), include_columns=READ
        ),
    )
    columns = [pc.utf8_trim_whitespace(table[name]) for name in READ]
    rows = np.arange(table.num_rows + len(skipped)) + first_row
    rows = np.delete(rows, np.array(skipped, int) - first_row)
    is_empty = [pc.equal(column, "").to_numpy() for column in columns]
    is_said = ~np.all(is_empty, axis=0)
    table = pa.table(columns, names=READ).filter(pa.array(is_said))
    return table, rows[is_said], np.array(torn, int)


def _numbers(table):
    """Place x y in each row, (n_rows, 2), and whether it lacks a name or a number."""
    texts = [table[name] for name in (X, Y)]
    texts = [
        pc.if_else(pc.match_substring_regex(one, NUMBER), one, "nan") for one in texts
    ]
    places = np.column_stack([one.cast(pa.float64()).to_numpy() for one in texts])
    is_bad = ~np.isfinite(places).all(axis=1)
    for name in (IMAGE, TRACK):
        is_bad |= pc.equal(table[name], "").to_numpy()
    return places, is_bad


def _refuse_rows(rows, data, expected, source):
    """Name all lines that have other columns, or something else than numbers."""
    if not len(rows):
        return
    lines = LINE_END.split(data)

    def problem(row):
        words = lines[row - 1].decode("utf-8").split("\t")
        return TableError(
            f"{shortened(' '.join(words), MOST_SHOWN)!r} cannot be read",
            expected=expected,
            remedy="Correct the line, or export the file again",
            file=source,
            row=row,
        )

    raise_problems(listed(rows, problem, "so are the lines"))


def _in_pixels(table, places, file):
    """Image points, by the sizes of the images beside the tracks, and notes."""
    images = table[IMAGE].combine_chunks().dictionary_encode()
    names = images.dictionary.to_pylist()
    sizes = image_sizes(reconstructions(file.path))
    unknown, notes = unsized(names, sizes, file.source)
    of_names = np.array([sizes.get(name, (np.nan, np.nan)) for name in names])
    sides = of_names[images.indices.to_numpy()]
    pixels = places * sides.max(axis=1)[:, None] + (sides - 1.0) / 2.0
    points = pa.table([table[IMAGE], table[TRACK]], names=["image_id", "point_id"])
    points = points.to_pandas().assign(x=pixels[:, 0], y=pixels[:, 1])
    if unknown:
        points = points[np.isfinite(sides[:, 0])].reset_index(drop=True)
    return points, notes
