"""What ``einschalt demo`` does."""

from pathlib import Path

from einschalt.foundations.errors import FileError
from einschalt.interfaces.cli.outcome import figures_under
from einschalt.interfaces.cli.work.densify import densify

BLOCKS = ("neukirchen", "sxb_strasbourg")


def demo(output, *, overwrite=False, quiet=False):
    """Compute every example block, and print its summary."""
    examples = examples_folder()
    for name in BLOCKS:
        with figures_under(name):
            densify(
                examples / name,
                Path(output) / name,
                {},
                overwrite=overwrite,
                quiet=quiet,
            )


def examples_folder():
    """Folder of the example blocks: in the package, or beside the sources of it."""
    package = Path(__file__).parents[3]
    places = package / "data_examples", package.parents[1] / "data_examples"
    for place in places:
        if (place / BLOCKS[0] / "block.toml").exists():
            return place
    raise FileError(
        "the example blocks are missing",
        expected=f"them in {places[0]}",
        remedy="Install the package again",
    )
