"""What commands write that read single tables, or none: a folder, or one file."""

import os
import shutil
import stat
from pathlib import Path

from einschalt.foundations.errors import OutputError
from einschalt.interfaces.files.atomic import (
    hidden_name,
    make_folder,
    remove_leftovers,
    require_writable,
    said_as_file_error,
)
from einschalt.interfaces.files.input_files import checksum, checksum_or_none
from einschalt.interfaces.files.output_folder import (
    InputFiles,
    Output,
    refuse_input,
    require_free,
    said_of,
    write_folder,
)
from einschalt.interfaces.files.written_files import Source
from einschalt.interfaces.provenance import digest, provenance_of_tables


def output_of_tables(command, files, names, folder, *, overwrite=False):
    """Tell what a command writes that reads tables, and refuse a folder at once.

    Results of the same files may replace each other.
    """
    files = tuple(file for file in files if file is not None)
    inputs = digest(str(checksum_or_none(file)) for file in files)
    source = Source(command, ", ".join(f.name for f in files), files, inputs)
    output = Output(source, frozenset(names), InputFiles(files), overwrite)
    require_free(folder, output)
    require_writable(folder)
    return output


def output_of_question(command, asked, names=(), files=(), *, overwrite=False):
    """Tell what a command writes whose results come from its options.

    Only the same ones, in ``asked``, give the same results.
    """
    said = digest(f"{name} = {value}" for name, value in sorted(asked.items()))
    source = Source(command, said)
    return Output(source, frozenset(names), InputFiles(files), overwrite)


def write_tables_of(output, folder, write):
    """Write all files of a command, or a new folder beside one that is refused."""
    facts = provenance_of_tables(output.source.command, output.inputs.signed())
    write_folder(folder, output, facts, write, beside=True)


def require_file_place(path):
    """Refuse a file that cannot be made, before the work for it is done."""
    folder = Path(path).parent
    # as a folder for results, that of a file is made where it is not there
    require_writable(folder, file=path if os.path.lexists(folder) else None)


def write_file(path, output, write):
    """Write a single file; an older one stays, unless it is equal or given up.

    Its folder is made where there is none.
    """
    path = Path(path)
    refuse_input(path, output)
    folder = Path(os.path.realpath(make_folder(path.parent)))
    staging = folder / hidden_name("new")
    with said_as_file_error(path):
        remove_leftovers(folder)
        staging.mkdir(mode=0o700)
    try:
        whole = staging / path.name
        with said_of(path.parent, staging):
            write(whole)
        is_taken = not output.overwrite and os.path.lexists(path)
        if is_taken and not _is_equal(path, whole):
            raise OutputError(
                "there is a file of this name, which would be lost",
                expected="a new name",
                remedy="Name another file, or give --overwrite (in Python "
                "overwrite=True)",
                file=path,
            )
        with said_as_file_error(path):
            whole.replace(folder / path.name)
    finally:
        shutil.rmtree(staging, ignore_errors=True)


def _is_equal(path, whole):
    is_file = stat.S_ISREG(path.lstat().st_mode)
    return is_file and checksum(path) == checksum(whole)
