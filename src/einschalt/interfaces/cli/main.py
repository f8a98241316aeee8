"""The command ``einschalt``: one file per command, each a thin shell on the library.

Nothing heavy is imported before a command runs, so that help comes at once.
"""

import sys
from typing import Annotated

import typer

from einschalt.interfaces.cli.batch import batch
from einschalt.interfaces.cli.check import check
from einschalt.interfaces.cli.densify import densify
from einschalt.interfaces.cli.examples import examples
from einschalt.interfaces.cli.exits import WRONG, open_closed_streams, print_error
from einschalt.interfaces.cli.orient import orient
from einschalt.interfaces.cli.plan import plan
from einschalt.interfaces.cli.simulate import simulate
from einschalt.interfaces.cli.transform import transform

COMMANDS = {
    densify: (
        "einschalt densify data_examples/neukirchen --output out/neukirchen",
        "einschalt densify BLOCK --output out --coverage-mean most_central",
        "einschalt densify BLOCK --output out --weighting weighted --quiet",
    ),
    batch: (
        "einschalt batch data_examples --output out/all",
        "einschalt batch BLOCKS --output out --workers 8 --memory 4",
        "einschalt batch BLOCKS --output out --resume",
        "einschalt batch BLOCKS --output out --scheduler tcp://10.0.0.5:8786",
    ),
    check: (
        "einschalt check data_examples/neukirchen",
        "einschalt check BLOCK | grep low_flight.csv",
    ),
    plan: (
        "einschalt plan",
        "einschalt plan --scale-number 6000:12000:1000 --spacing 200,300 --m-0 0.10",
        "einschalt plan --camera ultracam_eagle --edge lattice --output plan.csv",
        "einschalt plan --target 0.05 --spacing 300 --output out/plan",
        "einschalt plan --expect --scale-number 8000 --spacing 300 --output out/plan",
        "einschalt plan --scale-number 6000,8000 --terrain heights.csv",
    ),
    simulate: (
        "einschalt simulate --output out/simulated",
        "einschalt simulate --output out/simulated --preset demo --seed 7",
        "einschalt simulate --output out/blunders --gross-errors 0.01",
        "einschalt simulate --output out/truth --repeat 20 --high-scale 12000",
        "einschalt simulate --output out/film --film-affinity 2e-4 --n-check 50",
    ),
    transform: (
        "einschalt transform model_points.csv ground_points.csv --output out",
        "einschalt transform old.csv new.csv --kind helmert --output out",
        "einschalt transform old.csv new.csv --output out --apply more_points.csv",
    ),
    orient: (
        "einschalt orient y_parallaxes.csv --base 92 --output out",
        "einschalt orient image_pairs.csv --principal-distance 153 --output out",
        (
            "einschalt orient --terrain heights.csv --principal-distance 152 "
            "--scale-number 8000 --output out"
        ),
    ),
}

app = typer.Typer(
    name="einschalt",
    no_args_is_help=True,
    add_completion=False,
    # plain help: the same on a terminal, in a pipe, and in a log
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["--help", "-h"], "max_content_width": 88},
)


def _print_version(is_asked: bool):
    if is_asked:
        # imported when it is asked for, for a quick start
        from importlib.metadata import version  # noqa: PLC0415

        typer.echo(f"einschalt {version('einschalt')}")
        raise typer.Exit


@app.callback(
    epilog=examples(
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
):
    """Photogrammetric densification of control points, with honest precision.

    Exit status: 0 when the work was done (models that failed are said), 1 when a batch
    has failed blocks, 2 when the input or the call is wrong, 130 when interrupted.
    """


for _command, _examples in COMMANDS.items():
    # planning has an answer where nothing is asked: Kovarik's own tables
    app.command(epilog=examples(*_examples), no_args_is_help=_command is not plan)(
        _command
    )


def run():
    """Run the command line: the entry point of the package."""
    open_closed_streams()
    for stream in (sys.stdout, sys.stderr):
        # √ and names in any script must not stop a run where a console lacks them
        stream.reconfigure(errors="replace")
    try:
        app()
    except OSError as error:  # help on a full disk
        print_error(f"einschalt: {error.strerror or error}")
        sys.exit(WRONG)
