"""The table of all blocks of a batch, as CSV, Parquet and HTML."""

from einschalt.interfaces.files.atomic import write_text
from einschalt.interfaces.files.csv_tables import write_csv
from einschalt.interfaces.files.parquet_tables import write_parquet
from einschalt.interfaces.files.result_folder import DECIMALS
from einschalt.interfaces.reports.batch_report import render_batch

ERROR = DECIMALS["standard_error"]
DECIMALS_OF_BLOCKS = {
    "standard_error_total": ERROR,
    "standard_error_paper": ERROR,
    "standard_error_internal": ERROR,
    "largest_move": DECIMALS["difference"],
    "seconds": 3,
}


def write_tables(table, folder):
    """Write blocks.csv, blocks.parquet and blocks.html.

    Parameters
    ----------
    table : DataFrame
        Of :func:`einschalt.pipeline.batch.block_table.blocks_table`.
    folder : Path

    Raises
    ------
    FileError
        The folder cannot be written.
    """
    write_csv(table, folder / "blocks.csv", decimals=DECIMALS_OF_BLOCKS)
    write_parquet(table, folder / "blocks.parquet")
    write_text(folder / "blocks.html", render_batch(table))
