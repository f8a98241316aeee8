"""``einschalt explain``: a term, a setting, a finding or a column."""

from typing import Annotated

import typer

from einschalt.interfaces.cli.exits import done_in_work, with_exit_status

EXAMPLES = (
    "einschalt explain Passpunkt",
    "einschalt explain standard_error_total",
    "einschalt explain snoop",
    "einschalt explain claim_that_does_not_stand",
)


@with_exit_status
@done_in_work
def explain(
    term: Annotated[
        str,
        typer.Argument(
            metavar="TERM",
            help="A term in German or English, a column under its own or a usual name, "
            "a setting or one of its values, a name in the JSON of plan, the code of a "
            "finding in assessment.json; 'all' lists them.",
        ),
    ],
):
    """Explain a term of the field, a setting, a finding or a column.

    Terms come from the glossary, columns from the schemas that check the tables, and
    findings, with their remedies, from the texts of the summary.
    """
