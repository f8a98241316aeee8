"""What ``einschalt export`` does."""

from einschalt.foundations.kept_texts import retold
from einschalt.interfaces import python_api
from einschalt.interfaces.cli.exits import print_out
from einschalt.interfaces.cli.outcome import report
from einschalt.interfaces.files.block_toml import BLOCK_FILE
from einschalt.interfaces.programs.export import each_exported, writer_of


def export(result, more, files, *, overwrite=False):
    """Write the files, and say what is to be known of each."""
    files = [*(files or []), *(more or [])]
    for file in files:  # before the work, which would be lost
        writer_of(file)
    if files and (result / BLOCK_FILE).is_file():
        result = python_api.densify(python_api.read_block(result))
    for written in each_exported(result, *files, overwrite=overwrite):
        report(written.path)
        print_out(written.path)
        for note in written.notes:
            print_out(f"  {retold(note)}")
