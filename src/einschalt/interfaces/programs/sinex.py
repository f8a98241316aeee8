"""Points with their covariances as SINEX 2.02, geocentric, and back.

Blocks SITE/ID, SOLUTION/ESTIMATE (STAX, STAY, STAZ) and SOLUTION/MATRIX_ESTIMATE (lower
triangle, covariances). A station has four characters there: the points are numbered,
and their names stand in SITE/ID. Heights are taken for heights above the ellipsoid.
"""

from datetime import datetime
from textwrap import wrap

import numpy as np
import pandas as pd

from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import FileError
from einschalt.foundations.projections import read_crs, to_geocentric
from einschalt.interfaces.files.damaged_files import damaged
from einschalt.interfaces.programs.foreign import (
    MOST_FULL,
    Foreign,
    is_finite,
    lines_of,
)

AXES = ("STAX", "STAY", "STAZ")
DIGITS = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZ"
MOST_NAME = 22
AGENCY = "EIN"  # of files that are written here
HEAD, KIND = "%", "kind of "
MATRIX = "SOLUTION/MATRIX_ESTIMATE"
EXPECTED = "SINEX with SITE/ID, SOLUTION/ESTIMATE and SOLUTION/MATRIX_ESTIMATE L COVA"
PER_LINE = 3
WIDTH = 78  # of comments


def write_sinex(handed, path):
    """Write all points; says how much covariance there is, and what heights mean."""
    if handed.crs is None or not handed.is_spatial:
        found = "no reference system" if handed.crs is None else "no heights"
        raise FileError(
            f"the result has {found}, and SINEX has geocentric coordinates",
            expected="a system, and heights with standard errors (helmert_3d)",
            remedy="Write .gkf, which has coordinates in the plane",
            file=path.name,
        )
    system = read_crs(handed.crs)
    if system.is_compound:
        raise FileError(
            f"the heights are those of {system.name}, and SINEX has ellipsoidal ones",
            expected="heights above the ellipsoid",
            remedy="Write .gkf, which has coordinates in the plane",
            file=path.name,
        )
    xyz, jacobian = to_geocentric(handed.coordinates, system)
    covariance = handed.covariance()
    said = str(covariance)
    covariance = covariance.turned(jacobian)
    n = len(xyz)
    errors = np.sqrt(covariance.own[:, [0, 1, 2], [0, 1, 2]]).ravel()
    epoch = _epoch(handed.created)
    lines = [
        f"%=SNX 2.02 EIN {epoch} EIN {epoch} {epoch} P {3 * n:05d} 2 S",
        "+FILE/COMMENT",
        f" {handed.name[:60]}: densified points, {said}",
        *(f" {part}" for note in handed.told_enlargement for part in wrap(note, WIDTH)),
        f" datum of {handed.crs}; heights are taken for heights above its ellipsoid",
        "-FILE/COMMENT",
        *_sites(handed.points["point_id"], path),
        *_estimates(xyz, errors, epoch),
        *_matrix(covariance),
        "%ENDSNX",
    ]
    path.write_text("\n".join([*lines, ""]), encoding="utf-8", newline="\n")
    notes = [said, *handed.told_enlargement]
    return [*notes, "heights are taken for heights above the ellipsoid of the system"]


def _epoch(created):
    """Year, day of the year and second of the day, as SINEX has them."""
    if not created:
        return "00:000:00000"
    when = datetime.fromisoformat(created)
    seconds = when.hour * 3600 + when.minute * 60 + when.second
    return f"{when:%y}:{when:%j}:{seconds:05d}"


def code_of_station(number):
    """Four characters for a point by its number.

    >>> code_of_station(0), code_of_station(37)
    ('0000', '0011')
    """
    code = ""
    for _ in range(4):
        number, digit = divmod(number, len(DIGITS))
        code = DIGITS[digit] + code
    return code


def _sites(names, path):
    lines = ["+SITE/ID"]
    for number, name in enumerate(map(str, names)):
        if len(name) > MOST_NAME or not name.isprintable():
            raise FileError(
                f"the name {name[:30]!r} has {len(name)} characters",
                expected=f"at most {MOST_NAME}, as SINEX holds",
                remedy="Rename the point, or write .gkf",
                file=path.name,
            )
        lines.append(f" {code_of_station(number)}  A           P {name}")
    return [*lines, "-SITE/ID"]


def _estimates(xyz, errors, epoch):
    lines = ["+SOLUTION/ESTIMATE"]
    for place, (value, error) in enumerate(zip(xyz.ravel(), errors, strict=True)):
        code = code_of_station(place // 3)
        lines.append(
            f" {place + 1:5d} {AXES[place % 3]:<6} {code}  A    1 {epoch} m    2 "
            f"{value:21.14E} {error:11.5E}"
        )
    return [*lines, "-SOLUTION/ESTIMATE"]


def _matrix(covariance):
    """Lines of the lower triangle; between points where that is known."""
    lines = [f"+{MATRIX} L COVA"]
    for row, first, values in _lower(covariance):
        for start in range(0, len(values), PER_LINE):
            part = values[start : start + PER_LINE]
            said = " ".join(f"{value:21.14E}" for value in part)
            lines.append(f" {row + 1:5d} {first + start + 1:5d} {said}")
    return [*lines, f"-{MATRIX} L COVA"]


def _lower(covariance):
    """Number of each row, the first column of it that is known, and its values."""
    if covariance.full is not None:
        for row, values in enumerate(covariance.full):
            yield row, 0, values[: row + 1]
        return
    for point, own in enumerate(covariance.own):
        for axis in range(3):
            yield 3 * point + axis, 3 * point, own[axis, : axis + 1]


def read_sinex(file) -> Foreign:
    """Read the stations, geocentric, with the standard errors of their coordinates."""
    table, covariance = read_covariance(file)
    errors = np.sqrt(np.diag(covariance)).reshape(-1, 3)
    for axis, error in zip("xyz", errors.T, strict=True):
        table[f"standard_error_{axis}"] = error
    note = f"{file.source}: geocentric coordinates; covariances are left out"
    return Foreign({"stations": table}, None, (note,))


def read_covariance(file):
    """Stations (point_id, x, y, z) and their full covariance [m²].

    A station is named by its code, and by its solution where it has several; those of
    files written here by what stands in SITE/ID.
    """
    blocks = _blocks(file)
    is_own = AGENCY in blocks[HEAD][0].words
    names = {one.words[0]: one for one in blocks.get("SITE/ID", ())} if is_own else {}
    stations, places, errors = {}, {}, {}
    for line in blocks.get("SOLUTION/ESTIMATE", ()):
        if len(line.words) < 10 or line.words[1] not in AXES:
            continue
        station, axis = tuple(line.words[2:5]), line.words[1]
        try:
            places[int(line.words[0])] = (station, axis)
            stations.setdefault(station, {})[axis] = _number(line.words[8])
            errors[station, axis] = _number(line.words[9])
        except ValueError as error:
            raise damaged(file.source, str(error), EXPECTED, line.row) from error
    is_whole = stations and all(set(AXES) == set(one) for one in stations.values())
    if not is_whole:
        raise damaged(file.source, "lacks coordinates of a station", EXPECTED)
    codes = [code for code, _, _ in stations]
    rows = [
        (_name(names, key, codes), *(one[axis] for axis in AXES))
        for key, one in stations.items()
    ]
    order = [(station, axis) for station in stations for axis in AXES]
    place = {pair: k for k, pair in enumerate(order)}
    of_number = {number: place[pair] for number, pair in places.items()}
    own = np.array([errors[pair] for pair in order])
    table = pd.DataFrame(rows, columns=["point_id", "x", "y", "z"])
    return table, _covariance(blocks, of_number, own, file.source)


def _number(word):
    """A finite number; float takes nan for one, and 1_0."""
    if not is_finite(word):
        raise ValueError(f"{shortened(word)!r} is no number")
    return float(word)


def _blocks(file):
    """Lines of each block by its name; the first line of the file as HEAD."""
    lines = lines_of(file, comments=("*",))
    blocks, block = {HEAD: lines[:1]}, None
    for line in lines:
        if line.text.startswith("+"):
            block = line.text[1:].strip().partition(" ")[0]
            # with the kind of a matrix, such as L COVA
            blocks[block], blocks[KIND + block] = [], line.words[1:]
        elif line.text.startswith("-") and block and block in line.text:
            block = None
        elif block is not None:
            blocks[block].append(line)
    if not lines or lines[-1].text != "%ENDSNX":
        row = lines[-1].row if lines else None
        raise damaged(file.source, "does not end with %ENDSNX", EXPECTED, row)
    return blocks


def _name(names, key, codes):
    """Name of a station: what follows its technique in SITE/ID, or its code."""
    code, _, solution = key
    if code in names:
        text = names[code].text
        return text[text.find(" P ") + 3 :].strip()[:MOST_NAME].strip() or code
    return code if codes.count(code) == 1 else f"{code}_{solution}"


def _covariance(blocks, of_number, errors, source):
    """Covariance of all coordinates; of their standard errors where there is none."""
    kind = blocks.get(f"{KIND}{MATRIX}", [])
    if MATRIX not in blocks:  # nothing between coordinates
        _require_size(errors, source)
        return np.diag(errors**2)
    if kind[-1:] not in (["COVA"], ["CORR"]):
        raise damaged(source, f"its matrix is {' '.join(kind)}", "COVA or CORR")
    _require_size(errors, source)
    whole = np.zeros((len(errors), len(errors)))
    for line in blocks[MATRIX]:
        try:
            one, start = int(line.words[0]), int(line.words[1])
            values = [_number(word) for word in line.words[2:]]
        except (ValueError, IndexError) as error:
            raise damaged(source, str(error), EXPECTED, line.row) from error
        for offset, value in enumerate(values):
            if one in of_number and start + offset in of_number:
                i, j = of_number[one], of_number[start + offset]
                whole[i, j] = whole[j, i] = value
    if kind[-1] == "CORR":  # with standard errors in its diagonal
        sizes = np.diag(whole).copy()
        np.fill_diagonal(whole, 1.0)
        whole *= np.outer(sizes, sizes)
    if not (np.isfinite(whole).all() and (np.diag(whole) > 0.0).all()):
        raise damaged(source, "a coordinate has no variance in its matrix", EXPECTED)
    return whole


def _require_size(errors, source):
    if len(errors) > MOST_FULL:
        found = f"has {len(errors)} coordinates, and as many covariances of each"
        raise damaged(source, found, f"at most {MOST_FULL} coordinates")
