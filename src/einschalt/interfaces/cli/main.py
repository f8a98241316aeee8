"""The command ``einschalt``: one file per command, each a thin shell on the library.

A command's file is imported when the command is called, and what the command needs
when it runs, so that help comes at once.
"""

import os
import re
import sys
import warnings
from importlib import import_module
from textwrap import wrap
from typing import Annotated, Literal

import typer

from einschalt.foundations.kept_texts import retold
from einschalt.foundations.language import LANGUAGES, mark, mark_each, written_in
from einschalt.foundations.system_errors import reason_of
from einschalt.interfaces.cli.commands import (
    HEADINGS,
    LANGUAGE,
    Command,
    Group,
    language_asked,
)
from einschalt.interfaces.cli.exits import (
    FAULT,
    JSON,
    WRONG,
    open_closed_streams,
    print_error,
)
from einschalt.interfaces.cli.outcome import recorded, report_fault, report_problems

COMPLETION = "_EINSCHALT_COMPLETE"
# each with the first line of its help, so that the list imports none of them
COMMANDS = mark_each(
    {
        "demo": "Compute the example blocks, simulated and real.",
        "init": "Write a first block.toml from the contents of files.",
        "densify": "Compute the points of a block, and their precision.",
        "serve": "Work on a page in the browser, on this computer only.",
        "batch": "Compute every block below a folder, and report the outcome of each.",
        "check": "Report everything that is wrong with a block's input.",
        "plan": "Predict the precision of a flight before it is flown.",
        "convert": "Convert the measurements of another program to plain tables.",
        "simulate": "Simulate a block whose true coordinates are known.",
        "transform": "Fit one transformation per model, and transform points.",
        "export": "Write a result for CAD, Excel, GIS and other adjustments.",
        "explain": "Explain a term of the field, a setting, a finding or a column.",
        "completion": "Print a shell script that completes commands and options.",
        "publish": "Publish a result for PROJ, GDAL and QGIS.",
        "orient": "Orient image pairs, and report those near a dangerous surface.",
    }
)
# the example blocks, Kovarik's own tables, and the present folder
ANSWER_WITHOUT_ARGUMENTS = ("demo", "plan", "serve")
EXAMPLES = mark("Examples:")
MOST_OF_A_LINE = 74  # of 80, which help indents, and the sign that a line goes on
OPTION_AND_VALUE = re.compile(r"(?<=\s)(-\S+) (?!-)(\S+)")
STUCK = "\u00a0"  # in place of a blank at which no line is broken
HELP = {"--help", "-h", "--version"}
WIDER_THAN_HELP = 10_000
HOW = {
    "add_completion": False,
    # plain help: the same on a terminal, in a pipe, and in a log
    "rich_markup_mode": None,
    "pretty_exceptions_enable": False,
    "context_settings": {
        "help_option_names": ["--help", "-h"],
        "max_content_width": 88,
    },
}


class CommandsOnDemand(Group):
    """The commands of the table above, each imported when it is called."""

    def __init__(self, **options):
        super().__init__(**options)
        # their names, for lists and for what a mistaken name may have meant
        self.commands = dict.fromkeys(COMMANDS)

    def main(self, args=None, **options):
        """Run a command; with --json its outcome is one object on standard output."""
        words = sys.argv[1:] if args is None else list(args)
        with written_in(language_asked(words)):
            return self._main(words, **options)

    def _main(self, words, **options):
        if JSON not in words:
            return super().main(args=words, **options)
        with recorded(next(filter(COMMANDS.__contains__, words), "")) as outcome:
            try:
                return super().main(args=words, **options)
            except SystemExit as end:
                status = end.code or 0
                if status == WRONG and not outcome.problems:
                    report_problems("the call is wrong; standard error says why")
                if status or not HELP.intersection(words):
                    print(outcome.as_json(status), flush=True)
                raise
            except Exception as error:
                report_fault(error)
                print(outcome.as_json(FAULT), flush=True)
                raise

    def get_command(self, _context, name):
        """Import a command."""
        if name in COMMANDS and self.commands[name] is None:
            self.commands[name] = _imported(name)
        return self.commands.get(name)

    def format_commands(self, _context, formatter):
        """Write the commands into the help, without importing them."""
        with formatter.section(HEADINGS["Commands"]):
            formatter.write_dl(list(COMMANDS.items()))


def _examples(*calls):
    """Epilog of a help text; the mark keeps it from being wrapped."""
    lines = "\n".join(f"  {line}" for call in calls for line in _lines_of(call))
    return f"\b\n{EXAMPLES}\n{lines}"


def _lines_of(call):
    r"""Lines of a call that has no room in one, broken before options as in a shell.

    >>> _lines_of("einschalt " + "--name value " * 6)[1]
    '    --name value'
    """
    whole = OPTION_AND_VALUE.sub(rf"\1{STUCK}\2", call.strip())
    how = {"break_long_words": False, "break_on_hyphens": False}
    lines = wrap(whole, MOST_OF_A_LINE, subsequent_indent="    ", **how)
    return [line.replace(STUCK, " ") for line in " \\\n".join(lines).split("\n")]


def _imported(name):
    module = import_module(f"einschalt.interfaces.cli.{name}")
    alone = typer.Typer(**HOW)
    alone.command(
        name,
        cls=Command,
        epilog=_examples(*module.EXAMPLES),
        no_args_is_help=name not in ANSWER_WITHOUT_ARGUMENTS,
        context_settings=HOW["context_settings"],
    )(getattr(module, name))
    return typer.main.get_command(alone)


app = typer.Typer(name="einschalt", cls=CommandsOnDemand, no_args_is_help=True, **HOW)


def _print_version(is_asked: bool):
    if is_asked:
        # imported when it is asked for, for a quick start
        from importlib.metadata import version  # noqa: PLC0415

        typer.echo(f"einschalt {version('einschalt')}")
        raise typer.Exit


@app.callback(
    epilog=_examples(
        "einschalt simulate --output out/block",
        "einschalt check out/block",
        "einschalt densify out/block --output out/result",
    )
)
def einschalt(
    _version: Annotated[
        bool,
        typer.Option(
            "--version",
            callback=_print_version,
            is_eager=True,
            help="Print the version and exit.",
        ),
    ] = False,
    _language: Annotated[
        Literal[LANGUAGES] | None,
        # heard before: help is written in it
        typer.Option(
            LANGUAGE,
            show_default="that of the locale",
            help="Language of output, reports and help.",
        ),
    ] = None,
):
    """Photogrammetric densification of control points, with honest precision.

    Exit status: 0 when the work was done (failed models are reported), 1 when a batch
    has failed blocks or no plan reaches its target, 2 when the input or the call is
    wrong, 3 with --strict when something contradicts the stated precision, 130 when
    interrupted, 128 plus the number of the signal when another signal ends it.

    Options for lengths accept units, as in --spacing 250m or --target 5cm; a number
    alone has the unit that the option names. With --json a command prints one JSON
    object (command, status, problems, paths, figures), and its text on standard error.
    """


def run():
    """Run the command line: the entry point of the package."""
    if COMPLETION in os.environ:  # a shell asks, by the script of completion
        from typer.completion import completion_init  # noqa: PLC0415

        # shells read a line for each word: help that is broken would be more words
        os.environ["COLUMNS"] = str(WIDER_THAN_HELP)
        completion_init()
    open_closed_streams()
    # what PROJ_AUX_DB has to do with it is said where a system is unknown
    warnings.filterwarnings("ignore", message="pyproj unable to set PROJ database path")
    for stream in (sys.stdout, sys.stderr):
        # √ and names in any script must not stop a run where a console lacks them
        stream.reconfigure(errors="replace")
    try:
        app()
    except OSError as error:  # help on a full disk
        with written_in(language_asked(sys.argv)):
            print_error(f"einschalt: {retold(reason_of(error))}")
        sys.exit(WRONG)
