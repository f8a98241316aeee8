"""What is said of a file that another program has not written so."""

from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import FileError

MOST_SAID = 200  # characters of what a file is found to say


def damaged(source, found, expected="whole data", row=None):
    """FileError of a file that another program has not written so."""
    return FileError(
        shortened(found, MOST_SAID),
        expected=expected,
        remedy="Export it again",
        file=source,
        row=row,
    )
