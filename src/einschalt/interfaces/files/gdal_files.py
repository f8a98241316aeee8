"""Files that GDAL reads: from a copy in a folder of its own, and of a known kind.

GDAL guesses at the kind of a file by what stands in it, and some kinds lead to other
files or into the net. So every reader looks at the first bytes before, and gives GDAL a
copy that stands alone, under a plain name.
"""

import tempfile
import warnings
from contextlib import contextmanager
from pathlib import Path

from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import FileError
from einschalt.foundations.library_errors import without_statement

LONGEST_REASON = 200  # characters of what GDAL says
NO_ROOM = (
    "See that the disk has space, raise a limit on the size of files, or choose "
    "another folder"
)
COPIES = "einschalt-copy-"  # begins the name of the folder of a copy
SYSTEM = ".prj"  # beside a shapefile
# every cell as text, no first row taken for a header
AS_TEXT = {
    "OGR_XLSX_HEADERS": "DISABLE",
    "OGR_XLSX_FIELD_TYPES": "STRING",
    "OGR_ODS_HEADERS": "DISABLE",
    "OGR_ODS_FIELD_TYPES": "STRING",
}


@contextmanager
def opened(parts, source, options=AS_TEXT):
    """Give pyogrio and the path of a copy; ``parts``: bytes by suffix, main one first.

    What GDAL cannot read is a FileError that names ``source``.
    """
    # imported when a file is read: GDAL takes its time
    import pyogrio  # noqa: PLC0415

    before = {name: pyogrio.get_gdal_config_option(name) for name in options}
    with (
        tempfile.TemporaryDirectory(prefix=COPIES) as folder,
        warnings.catch_warnings(),
    ):
        warnings.simplefilter("ignore", RuntimeWarning)  # what it leaves out is checked
        paths = [Path(folder) / f"table{suffix}" for suffix in parts]
        for path, data in zip(paths, parts.values(), strict=True):
            path.write_bytes(_in_utf8(data) if path.suffix == SYSTEM else data)
        try:
            pyogrio.set_gdal_config_options(options)
            yield pyogrio, paths[0]
        except (RuntimeError, ValueError) as error:  # the bases of pyogrio's errors
            said = without_statement(str(error)).replace(str(folder), "").split(";")[0]
            raise FileError(
                f"cannot be read: {shortened(said, LONGEST_REASON)}",
                remedy="Export it again, or save the table as CSV",
                file=source,
            ) from error
        finally:
            pyogrio.set_gdal_config_options(before)


@contextmanager
def written(path, errors=(RuntimeError,)):
    """Tell as a FileError what GDAL cannot write, by the base of pyogrio's errors."""
    try:
        yield
    except errors as error:
        reason = without_statement(str(error))
        raise FileError(
            f"cannot be written: {shortened(reason, LONGEST_REASON)}",
            remedy=NO_ROOM,
            file=path,
        ) from error


def _in_utf8(data):
    """Text of a system in UTF-8: names in it may be in the letters of old programs."""
    try:
        data.decode("utf-8")
    except UnicodeDecodeError:  # pyogrio fails at them without an error of its own
        return data.decode("latin-1").encode("utf-8")
    return data
