"""A million rows into CSV and Parquet, and points into a GeoPackage.

Ours writes whole files or none: below another name, forced to the disk and renamed.
The peers do not.
"""

from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import pandas as pd
import shapely

from benchmarks.racing import Contender, at_least, peer, race
from benchmarks.reading import N_ROWS, measured_table
from einschalt.interfaces.files.geopackage import write_layers
from einschalt.interfaces.files.map_layers import Layer
from einschalt.interfaces.files.tables_by_suffix import write_table

N_POINTS = 200_000
BY_POLARS = {".csv": at_least(0.2, 0.8), ".parquet": at_least(0.5, 0.8)}
BY_PANDAS = {".csv": at_least(2.5, 10), ".parquet": None}


def run():
    """Race writers of tables and of maps.

    Returns
    -------
    list of Race
    """
    table = measured_table()
    with TemporaryDirectory() as folder:
        tables = [_tables(table, Path(folder), suffix) for suffix in BY_POLARS]
        return [*tables, _map(table.iloc[:N_POINTS], Path(folder))]


def _tables(table, folder, suffix):
    ours, other = folder / f"ours{suffix}", folder / f"other{suffix}"
    by_pandas = {
        ".csv": lambda: table.to_csv(other, index=False),
        ".parquet": lambda: table.to_parquet(other, index=False),
    }[suffix]
    peers = [Contender("pandas", by_pandas, N_ROWS, BY_PANDAS[suffix])]
    polars = peer("polars")
    if polars is not None:
        given = polars.from_pandas(table)
        write = {".csv": given.write_csv, ".parquet": given.write_parquet}[suffix]
        bound = BY_POLARS[suffix]
        peers.append(Contender("polars", partial(write, other), N_ROWS, bound))
    write_table(table, ours)
    read = {".csv": pd.read_csv, ".parquet": pd.read_parquet}[suffix]
    assert (read(ours)[["x", "y"]].to_numpy() == table[["x", "y"]].to_numpy()).all()
    mine = Contender("einschalt", lambda: write_table(table, ours), N_ROWS)
    return race(f"{N_ROWS} rows as {suffix}, written", "row", mine, peers, rounds=3)


def _map(table, folder):
    import geopandas  # noqa: PLC0415 - of the extra "notebook"

    path, other = folder / "ours.gpkg", folder / "other.gpkg"
    layer = Layer("points", table, _as_wkb(table), "Point", "measured points")
    places = geopandas.points_from_xy(table["x"], table["y"])
    frame = geopandas.GeoDataFrame(table, geometry=places, crs="EPSG:31256")

    def ours():
        write_layers([layer], "EPSG:31256", path)

    def theirs():
        other.unlink(missing_ok=True)
        frame.to_file(other, layer="points", driver="GPKG")

    ours()
    assert len(geopandas.read_file(path)) == N_POINTS
    return race(
        f"{N_POINTS} points as GeoPackage, written",
        "point",
        Contender("einschalt", ours, N_POINTS),
        [Contender("geopandas", theirs, N_POINTS, at_least(1.5, 2))],
        rounds=3,
    )


def _as_wkb(table):
    import pyarrow as pa  # noqa: PLC0415 - takes its time

    return pa.array(shapely.to_wkb(shapely.points(table[["x", "y"]].to_numpy())))
