"""changes.csv: which points of a block moved, came or went since the run before.

``previous_points.parquet`` beside it holds what they were compared with. Both are read
again by later runs, and by then other programs may have had them: what is damaged
counts as not there.
"""

from einschalt.foundations import tables
from einschalt.foundations.errors import EinschaltError
from einschalt.interfaces.batch.block_state import whole_result
from einschalt.interfaces.files.atomic import write_bytes
from einschalt.interfaces.files.csv_tables import read_csv, write_csv
from einschalt.interfaces.files.output_folder import PREVIOUS
from einschalt.interfaces.files.parquet_tables import read_parquet
from einschalt.interfaces.files.result_folder import CHANGES, DECIMALS
from einschalt.pipeline.batch.block_table import (
    CHANGES_OF_POINTS,
    compare_points,
    largest_move_of,
)

POINTS = "points.parquet"
DECIMALS_OF_CHANGES = {
    "easting": DECIMALS["easting"],
    "northing": DECIMALS["northing"],
    "moved_easting": DECIMALS["difference"],
    "moved_northing": DECIMALS["difference"],
    "moved_total": DECIMALS["difference"],
    "standard_error_total": DECIMALS["standard_error"],
}
POINTS_BEFORE = tables.APPROXIMATE_POINTS
CHANGED_POINTS = tables.Schema(
    "changes",
    (
        tables.POINT_ID,
        tables.Column("change", "choice", choices=CHANGES_OF_POINTS),
        tables.Column("moved_total", unit="metres", may_be_missing=True),
    ),
    key=("point_id",),
)


def system_before(folder):
    """System of the whole result in a folder, as (system,); None without a result."""
    before = whole_result(folder)
    if before is None:
        return None
    facts = before.get("output") or before.get("block")
    return (facts.get("crs") if isinstance(facts, dict) else None,)


def compare_with_previous(points, folder, into):
    """Write what moved since the run before; keep the points it is compared with.

    ``folder`` has the result before, ``into`` gets the new one. A run that is killed
    after it has put these in place finds them again, and writes the same.
    """
    before = whole_result(folder)
    is_whole = before is not None and POINTS in before["outputs"]
    source = folder / (POINTS if is_whole else PREVIOUS)
    previous = _sound(read_parquet, source, POINTS_BEFORE)
    if previous is None:
        return
    write_bytes(into / PREVIOUS, source.read_bytes())
    changes = compare_points(points, previous)
    write_csv(changes, into / CHANGES, decimals=DECIMALS_OF_CHANGES)


def read_changes(folder):
    """Read what moved [m] since the run before; None where nothing was compared."""
    return _sound(read_csv, folder / CHANGES, CHANGED_POINTS)


def read_largest_move(folder):
    """Largest movement of a point since the run before [m]; None if not compared."""
    previous = _sound(read_parquet, folder / PREVIOUS, POINTS_BEFORE)
    if previous is None:
        return None
    points = _sound(read_parquet, folder / POINTS, POINTS_BEFORE)
    return None if points is None else largest_move_of(points, previous)


def _sound(read, path, schema):
    """Read a table of ours, which may have no rows; None where it is not sound."""
    try:
        table = read(path, schema)
    except EinschaltError:
        return None
    if table.empty and set(schema.names) <= {*table.columns, "height"}:
        return table
    checked = tables.check_table(table, schema)
    return None if checked.problems else checked.frame
