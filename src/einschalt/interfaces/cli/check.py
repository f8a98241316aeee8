"""``einschalt check``: everything that is wrong with a block's input, at once."""

from einschalt.interfaces.cli.exits import done_in_work, with_exit_status
from einschalt.interfaces.cli.options import Block

EXAMPLES = (
    "einschalt check data_examples/neukirchen",
    "einschalt check BLOCK | grep low_flight.csv",
)


@with_exit_status
@done_in_work
def check(block: Block):
    """Say everything that is wrong with a block's input.

    On a terminal as a table; in a pipe one line for each problem, which begins with
    problem, model (it cannot be used, the others can) or note. The exit status is 2
    where anything is wrong.
    """
