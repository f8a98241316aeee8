"""SIMA, in which Japanese survey programs exchange coordinates and parcels.

Lines of values between commas, the first one a code: ``A01,1,T-1,X,Y,Z,`` is a point
with its number and name. X is the northing and Y the easting of the plane rectangular
systems; the file does not say of which zone. Parcels (``D00``, ``B01``) and routes are
left out. Text is Shift-JIS, or UTF-8 of newer programs.
"""

import numpy as np

from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import FileError
from einschalt.foundations.kept_texts import kept
from einschalt.interfaces.files.damaged_files import damaged
from einschalt.interfaces.programs.foreign import (
    METRES,
    Foreign,
    is_finite,
    points_on_ground,
    unseen,
)

POINT = "A01"
HEADS = (b"G00,", b"Z00,", b"A00,", b"A01,")
ENCODINGS = ("utf-8-sig", "cp932")
EXPECTED = "A01, number, name, X (northing), Y (easting) [, height]"
LEAST_CELLS = 5


def is_sima(head):
    """Whether the first bytes of a file look so."""
    return head.removeprefix(b"\xef\xbb\xbf").lstrip().startswith(HEADS)


def read_sima(file) -> Foreign:
    """Read the points of a file: names, northings, eastings, heights where given."""
    names, places, n_others = [], [], 0
    for row, line in enumerate(_text_of(file).splitlines(), 1):
        cells = [cell.strip().strip('"') for cell in line.split(",")]
        if cells[0] != POINT:
            n_others += cells[0] not in ("", "G00", "Z00", "A00", "A99")
            continue
        words = cells[3:5] + [cell for cell in cells[5:6] if cell]
        is_whole = len(cells) >= LEAST_CELLS and all(map(is_finite, words))
        if not is_whole or not (cells[2] or cells[1]):
            said = f"{shortened(line.strip(), 60)!r} is no point"
            raise damaged(file.source, said, EXPECTED, row)
        north, east, *height = map(float, words)
        names.append(cells[2] or cells[1])
        places.append((east, north, height[0] if height else np.nan))
    if not names:
        raise FileError(
            "holds no points",
            expected=EXPECTED,
            remedy="Export the coordinates as well",
            file=file.source,
        )
    table = points_on_ground(names, places)
    notes = [f"{file.source}: X is northing, Y is easting", unseen(file.source)]
    if n_others:
        left_out = kept("{n:line|lines} of parcels and routes left out", n=n_others)
        notes.append(f"{file.source}: {left_out}")
    tables = {"control_points": table.dropna(axis=1, how="all")}
    return Foreign(tables, None, tuple(notes), unit=METRES, unit_m=1.0)


def _text_of(file):
    for encoding in ENCODINGS:
        try:
            return file.data.removesuffix(b"\x1a").decode(encoding)
        except UnicodeDecodeError:
            continue
    raise FileError(
        "is neither Shift-JIS nor UTF-8 text",
        expected="text of one of these encodings",
        remedy="Export it again",
        file=file.source,
    )
