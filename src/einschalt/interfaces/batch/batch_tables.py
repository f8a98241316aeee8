"""The table of all blocks of a batch, as CSV, Parquet and HTML."""

from einschalt.interfaces.files.atomic import write_text
from einschalt.interfaces.files.output_folder import InputFiles, Output, write_folder
from einschalt.interfaces.files.result_folder import DECIMALS
from einschalt.interfaces.files.tables_by_suffix import write_in_both_formats
from einschalt.interfaces.files.written_files import (
    BLOCKS,
    MARKS,
    PROVENANCE,
    Source,
    names_of_batch,
)
from einschalt.interfaces.provenance import provenance_of_tables
from einschalt.interfaces.reports.batch_report import render_batch
from einschalt.pipeline.batch.block_table import DONE, UNCHANGED

ERROR = DECIMALS["standard_error"]
DECIMALS_OF_BLOCKS = {
    "standard_error_total": ERROR,
    "standard_error_paper": ERROR,
    "standard_error_internal": ERROR,
    "standard_error_credible": ERROR,
    "largest_move": DECIMALS["difference"],
    "seconds": 3,
}


NAMES = frozenset(("blocks.csv", "blocks.parquet", "blocks.html", PROVENANCE, MARKS))


def output_of_batch(tasks=(), *, overwrite=False) -> Output:
    """Tell what a batch writes into its own folder."""
    folders = frozenset(task.name.partition("/")[0] for task in tasks)
    inputs = InputFiles(file for task in tasks for file in task.files)
    return Output(Source("batch"), NAMES, inputs, overwrite, folders)


def write_tables(table, folder, output):
    """Write blocks.csv, blocks.parquet and blocks.html.

    Where somebody else has put files there meanwhile, into a new folder beside it.
    """

    def write(new):
        write_in_both_formats({"blocks": table}, new, decimals=DECIMALS_OF_BLOCKS)
        write_text(new / "blocks.html", render_batch(table))

    names = names_of_batch(folder).union(_with_result(table))
    facts = {**provenance_of_tables("batch", []), BLOCKS: sorted(names)}
    write_folder(folder, output, facts, write, beside=True)


def _with_result(table):
    """Blocks whose results this batch has written, or found whole."""
    is_there = (table["outcome"] == DONE) | (table["reason"] == UNCHANGED)
    return table.loc[is_there, "block"]
