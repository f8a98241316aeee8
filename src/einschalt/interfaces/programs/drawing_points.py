"""Points of a DXF: block references with attributes, and points.

Each number and height of a point may stand in an attribute of its block reference; the
height as well, or instead, as z.
"""

import logging
import re
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd

from einschalt.foundations.column_words import COLUMN_WORDS, folded
from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import TableError, name_some
from einschalt.foundations.extras import imported
from einschalt.foundations.kept_texts import kept
from einschalt.interfaces.files.damaged_files import damaged
from einschalt.interfaces.files.gdal_files import COPIES
from einschalt.interfaces.programs.foreign import Foreign, is_finite, numbered

NUMBERS = {"NUMBER", "PUNKTNUMMER", "PUNKTNR", "PKTNR", "NR", "NAME", "PT", "POINT_ID"}
NUMBERS |= {"NUMERO", "MATRICULE", "ID", "NUM"}
POINTS = "POINTS_"  # layers of what is written here
ROLES = ("new", "control", "check")
UNITS = {1: "inches", 2: "feet", 4: "millimetres", 5: "centimetres", 7: "kilometres"}
UNITS |= {14: "decimetres", 21: "US survey feet"}  # of $INSUNITS
METRES = (0, 6)  # not said, or so
MOST_POINTS = 2**22
# what the library lets through of files that it does not expect
ERRORS = (OSError, ArithmeticError, LookupError, ValueError, TypeError, RuntimeError)
ERRORS = (*ERRORS, AttributeError, AssertionError, StopIteration, EOFError)
LINE = re.compile(r"line[: ]+(\d+)")
DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+")
COLUMNS = ["point_id", "easting", "northing", "height", "role"]
EXPECTED = "a drawing with points, or with block references that bear point numbers"


@dataclass
class _Doubts:
    """What is told of attributes."""

    commas: list = field(default_factory=list)  # heights as they are written
    no_numbers: list = field(default_factory=list)


def read_dxf(file) -> Foreign:
    """Read the points of a drawing: block references with numbers, and points.

    Points without a number are numbered in their order.
    """
    document = _document(file)
    rows, doubts = [], _Doubts()
    for entity in document.modelspace():
        kind = entity.dxftype()
        if kind == "INSERT":
            row = _of_reference(entity, doubts, file.source)
            rows += [row] if row is not None else []
        elif kind == "POINT":
            place = entity.dxf.location
            rows.append((None, place.x, place.y, place.z or np.nan, None))
        if len(rows) > MOST_POINTS:
            raise damaged(file.source, f"has more than {MOST_POINTS} points", EXPECTED)
    is_placed = np.isfinite([row[1:3] for row in rows]).all()
    if not rows or not is_placed:
        found = "a point has no place" if rows else "holds no points with a place"
        raise damaged(file.source, found, EXPECTED)
    table = pd.DataFrame(rows, columns=COLUMNS)
    n_unnamed = int(table["point_id"].isna().sum())
    table["point_id"] = numbered([row[0] for row in rows])
    said = kept("{n:point|points}", n=n_unnamed)
    notes = [f"{file.source}: {said} without a number, numbered"]
    notes = notes if n_unnamed else []
    notes += [*_told(doubts, file.source), *_told_unit(document, file.source)]
    table = table.dropna(axis=1, how="all")
    return Foreign({"control_points": table}, None, tuple(notes))


def _told(doubts, source):
    """Notes on heights that are attributes."""
    notes = []
    if doubts.commas:
        said = kept("{n:height|heights}", n=len(doubts.commas))
        notes.append(
            f"{source}: {said} with a decimal comma, such as {doubts.commas[0]!r}"
        )
    if doubts.no_numbers:
        some = name_some(map(repr, doubts.no_numbers), 4)
        notes.append(f"{source}: heights that are no number left out: {some}")
    return notes


def _told_unit(document, source):
    """Note where a drawing states another unit than metres, which many do by chance."""
    unit = document.header.get("$INSUNITS", 0)
    if unit in METRES:
        return []
    said = UNITS.get(unit, f"number {unit}")
    note = (
        f"{source}: its unit is {said} ($INSUNITS); the numbers are read as metres. If "
        "they are in that unit, scale the drawing to metres"
    )
    return [note]


def _document(file):
    """Drawing of a file, as strictly as the library reads it.

    It would mend what is broken as well, and guess at numbers then.
    """
    ezdxf = imported("ezdxf", "DXF")
    with tempfile.TemporaryDirectory(prefix=COPIES) as folder:
        copy = Path(folder) / "drawing.dxf"
        copy.write_bytes(file.data)
        logging.getLogger("ezdxf").setLevel(logging.CRITICAL)  # errors say it
        try:
            return ezdxf.readfile(copy)
        except (ezdxf.DXFError, *ERRORS) as error:
            raise _broken(error, file) from error


def _broken(error, file):
    said = str(error)
    line = LINE.search(said)
    said = said if not isinstance(error, OSError) else "is no DXF"
    found = f"is no whole DXF: {shortened(said, 80)}" if said else "is no whole DXF"
    return damaged(file.source, found, EXPECTED, int(line[1]) if line else None)


def _of_reference(entity, doubts, source):
    """Row of a block reference; None where it has no place for a number."""
    said = {one.dxf.tag.upper(): one.dxf.text.strip() for one in entity.attribs}
    numbers = [said[tag] for tag in said if tag in NUMBERS]
    if not numbers:
        return None
    number = next(filter(None, numbers), None)
    place = entity.dxf.insert
    height = _height(said, place.z, doubts, number, source)
    role = entity.dxf.layer.removeprefix(POINTS).casefold()
    return number, place.x, place.y, height, role if role in ROLES else None


def _height(said, z, doubts, number, source):
    """Height of a point by its attributes and its z; NaN where it has none.

    A z of 0 is none, unless an attribute says it. Those that contradict each other are
    refused: nobody knows which one is right.
    """
    stated = {tag: word for tag, word in said.items() if word and _is_height(tag)}
    values = {}
    for tag, word in stated.items():
        plain = word
        if DECIMAL_COMMA.fullmatch(word):
            plain = word.replace(",", ".")
            doubts.commas.append(word)
        if not is_finite(plain):
            doubts.no_numbers.append(word)
            continue
        values[tag] = float(plain), _last_digit(plain)
    if not values:
        return z or np.nan
    if z:
        values["z"] = z, 0.0
    (first, (height, digit)), *others = values.items()
    for tag, (value, other_digit) in others:
        if abs(value - height) > 1.01 * max(digit, other_digit):
            raise TableError(
                f"point {shortened(number or '?')} has the height {height:.12g} in "
                f"{first} and {value:.12g} in {tag}",
                expected="one height",
                remedy="Correct one of them, or delete it",
                file=source,
            )
    return height


def _is_height(tag):
    return ("height", folded(tag)) in COLUMN_WORDS or folded(tag) == "height"


def _last_digit(word):
    """Unit of the last digit: an attribute is rounded or cut there."""
    decimals = len(word.partition(".")[2]) if "e" not in word.casefold() else 0
    return 10.0**-decimals
