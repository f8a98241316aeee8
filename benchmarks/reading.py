"""A million rows from a file, with all checks, against polars, which checks nothing.

CPU time on one core, least of twelve: Parquet 94 ms, polars 46. On two cores: 62 to 67
ms, polars 28 to 31 of files of many groups of rows, 42 of one group as pandas writes.
CSV takes 1.2 to 1.75 times polars' time, most of it pyarrow's reading, in one part for
each core: 135 of 195 ms, where polars takes 130 for everything; checks of names and
keys take 15, the file and looks at its bytes 20, tables of pandas 6.

Of Parquet's time, unpacking (Zstandard) takes 32 ms, which polars needs as well, and
pyarrow's reading with it 50: more than polars takes for everything. Copying the file
into memory takes 2 to 6, writing codes out 9, looking at names and keys 13, tables of
pandas and numbers 10. So 1.5 times polars' time would need a decoder of its own.
"""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pandas as pd

from benchmarks.racing import Contender, at_least, peer, race
from einschalt.foundations.tables import MEASURED_MODEL_POINTS, check_table
from einschalt.interfaces.files.tables_by_suffix import read_table, write_table

N_ROWS, N_OF_MODEL = 10**6, 50
NAMES = ("coverage", "model_id", "point_id")
BOUNDS = {".csv": at_least(0.5, 0.67), ".parquet": at_least(0.25, 0.67)}


def run():
    """Run the races.

    Returns
    -------
    list of Race
    """
    with TemporaryDirectory() as folder:
        files = [Path(folder) / f"model_points{suffix}" for suffix in BOUNDS]
        for file in files:
            write_table(measured_table(), file)
        return [_race(file) for file in files]


def _race(file):
    polars, peers = peer("polars"), []
    if polars is not None:
        kinds = dict.fromkeys(NAMES, polars.String)
        bare = {
            ".csv": lambda: polars.read_csv(file, schema_overrides=kinds),
            ".parquet": lambda: polars.read_parquet(file),
        }[file.suffix]
        assert bare().height == len(_checked(file))
        peers = [Contender("polars, read", bare, N_ROWS, BOUNDS[file.suffix])]
    ours = Contender("einschalt, read and check", lambda: _checked(file), N_ROWS)
    title = f"{N_ROWS} rows of {file.suffix}, read and checked"
    return race(title, "row", ours, peers)


def measured_table():
    """Measured points of many models, as they are read from files."""
    rng = np.random.default_rng(1)
    model = np.repeat(np.arange(N_ROWS // N_OF_MODEL), N_OF_MODEL)
    first = rng.integers(0, 450_000, len(model) // N_OF_MODEL)
    point = np.repeat(first, N_OF_MODEL) + np.arange(N_ROWS) % N_OF_MODEL
    xy = rng.uniform(-100.0, 100.0, (N_ROWS, 2)).round(4)
    table = pd.DataFrame({"coverage": (1 + model % 2).astype(str)})
    table["model_id"] = [f"m{k}" for k in model]
    table["point_id"] = [f"P{k:06d}" for k in point]
    return table.assign(x=xy[:, 0], y=xy[:, 1])


def _checked(file):
    table = read_table(file, MEASURED_MODEL_POINTS)
    checked = check_table(table, MEASURED_MODEL_POINTS, source=file.name)
    assert not checked.problems
    return checked.frame
