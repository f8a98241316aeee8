"""``einschalt demo``: the example blocks, computed."""

from typing import Annotated

from einschalt.interfaces.cli.exits import done_in_work, with_exit_status
from einschalt.interfaces.cli.options import Overwrite, Quiet, output_option

EXAMPLES = ("einschalt demo", "einschalt demo --output somewhere")


@with_exit_status
@done_in_work
def demo(
    output: Annotated[
        str, output_option("Folder in which a folder for each block is written.")
    ] = "out",
    *,
    overwrite: Overwrite = False,
    quiet: Quiet = False,
):
    """Compute the example blocks, simulated and real.

    A simulated block after Kovarik's of 1971, and five photographs of Strasbourg: both
    come with the program. Prints their summaries, and writes their results into the
    folders neukirchen and sxb_strasbourg of the output folder, as densify does.
    """
