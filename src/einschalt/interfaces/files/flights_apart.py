"""Two flights in one table: a column that no table of a block has tells them apart.

Models of both flights often have the same names. Where they have not, the table looks
like that of one flight, whose models have two scales. The values of the column decide:
scales that are nearly the same are of one flight, dates may be of one as well. Where
each flight has one value, ``where`` of its table in block.toml takes its rows.
"""

import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pandas as pd

from einschalt.foundations.column_words import folded
from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import TableError, name_some
from einschalt.foundations.typesetting import count

# what has one name in a flight
OF_FLIGHTS = {
    *("flight", "flightname", "flightno", "flightid"),
    *("flug", "flugname", "flugnr", "flugnummer", "bildflug"),
    *("vol", "nomduvol", "volo", "vuelo", "voo", "lot", "vlucht", "flygning"),
}
# what has nearly one size in a flight
OF_SIZES = {
    *("flyingheight", "scale", "imagescale", "photoscale", "scalenumber"),
    *("flughoehe", "massstab", "bildmassstab", "massstabszahl", "bildmassstabszahl"),
    *("hauteurdevol", "echelle", "quotadivolo", "scala", "escala", "alturadevuelo"),
    *("skala", "meritko", "schaal", "merilo", "mjerilo", "mittakaava"),
}
OF_MISSIONS = {"mission"}  # of which a flight may have several
N_FLIGHTS = 2
# of sizes in a flight from one to the next, and below which they are numbers of a list
MOST_OF_ONE_FLIGHT, LEAST_SIZE = 1.2, 10.0
SIZE = re.compile(r"(?:1\s*[:/]\s*)?(\d[\d\s'’]*(?:[.,]\d+)?)\s*m?")
# sizes of a flight from one to another, as where has them
SPAN = re.compile(rf"(?P<low>{SIZE.pattern}) to (?P<high>{SIZE.pattern})")
DATE = re.compile(
    r"\d{4}[-/.]\d\d?[-/.]\d\d?([ T].*)?|\d\d?[-/.]\d\d?[-/.]\d{2,4}"
    r"|(19|20)\d\d(\d{4})?"
)


class TwoFlightsError(TableError):
    """A table of two flights; ``parts``: what each has in a column, if that is all."""

    parts: tuple = ()


def chosen_rows(table, where, source):
    """The rows of a table that have a value in a column, and a note.

    ``where``: value by column. A TableError where there is no such column or row.
    """
    frame = table.frame
    for name, value in where.items():
        called = shortened(name)
        if list(frame.columns).count(name) != 1:
            raise TableError(
                f"column '{called}' of where is missing, found "
                f"{name_some(map(str, frame.columns), 8)}",
                expected="a column that the file has once",
                remedy="Correct where in block.toml",
                file=source,
            )
        texts = _texts(frame[name])
        is_meant = _are_meant(texts, value)
        if not is_meant.any():
            raise TableError(
                f"no row has {shortened(value)!r} in column '{called}', as where says",
                expected=name_some(map(shortened, sorted(texts.unique())), 8),
                remedy="Correct where in block.toml",
                file=source,
            )
        frame = frame[is_meant]
    said = name_some(f"{shortened(n)} = {shortened(v)}" for n, v in where.items())
    kept = f"{source}: {len(frame)} of {len(table.frame)} rows: those with {said}"
    return replace(table, frame=frame, notes=(*table.notes, kept))


def _are_meant(texts, value):
    """Which texts are a value, or sizes from one to another: ``7900 to 8300``."""
    is_same = texts == value
    span = SPAN.fullmatch(value)
    if is_same.any() or span is None:
        return is_same
    low, high = (_size(span[name]) for name in ("low", "high"))
    sizes = texts.map(_size)
    return (sizes >= low) & (sizes <= high)


def _size(text):
    """Number of a scale or a flying height; NaN of another text."""
    found = SIZE.fullmatch(text)
    return np.nan if found is None else _number(found[1])


def _texts(column):
    """Values of a column as text, without blanks around them; empty where none is."""
    return column.map(lambda value: "" if pd.isna(value) else str(value).strip())


def tells_flights(name):
    """Whether a column of this name may tell flights apart.

    >>> tells_flights("Flug-Nr."), tells_flights("Bemerkung")
    (True, False)
    """
    return folded(name) in OF_FLIGHTS | OF_SIZES | OF_MISSIONS


def require_one_flight(frame, schema, source):
    """Refuse a table of models or photographs that has a column of two flights.

    Gives notes on columns that may be of several.
    """
    if not {"model_id", "image_id"}.intersection(schema.key):
        return []
    notes = []
    for name in frame.columns:
        word = folded(name)
        is_known = name in schema.names or list(frame.columns).count(name) != 1
        if is_known or not tells_flights(name):
            continue
        given = {str(value).strip() for value in frame[name].dropna().unique()}
        given, n_flights, is_sure = _flights(word, sorted(given - {""}))
        values = name_some([shortened(value) for value in given])
        if n_flights == N_FLIGHTS and is_sure:
            texts = _texts(frame[name])
            values_of = _spans(given) if word in OF_SIZES else given
            is_whole = texts.isin(given).all()
            parts = [{str(name): one} for one in values_of] if is_whole else []
            raise _two_flights(
                str(name), values, parts, source, int((texts == "").sum())
            )
        if n_flights >= N_FLIGHTS:
            notes.append(
                f"{source}: column '{shortened(str(name))}' has the values {values}: "
                "if they are of several flights, part the rows into a file for each"
            )
    return notes


def _flights(word, given):
    """Values of a column in order, how many flights they tell, and whether surely."""
    if word not in OF_SIZES:
        is_sure = word in OF_FLIGHTS and not all(map(DATE.fullmatch, given))
        return given, len(given), is_sure
    found = [SIZE.fullmatch(value) for value in given]
    if not all(found):
        return given, len(given), True
    sizes = {v: _number(part[1]) for v, part in zip(given, found, strict=True)}
    given = sorted(given, key=sizes.get)
    steps = pairwise(given)
    n_steps = sum(sizes[b] > MOST_OF_ONE_FLIGHT * sizes[a] for a, b in steps)
    return given, n_steps + bool(given), not given or sizes[given[0]] >= LEAST_SIZE


def _spans(given):
    """What where says of each flight: a size, or those from its first to its last.

    ``given``: sizes as text, in their order; as they are where one is none.
    """
    sizes = [_size(text) for text in given]
    if not np.isfinite(sizes).all():
        return given
    starts = [
        k
        for k, pair in enumerate(pairwise(sizes), 1)
        if pair[1] > MOST_OF_ONE_FLIGHT * pair[0]
    ]
    edges = pairwise([0, *starts, len(given)])
    return [
        given[a] if b == a + 1 else f"{given[a]} to {given[b - 1]}" for a, b in edges
    ]


def _number(text):
    return float(re.sub(r"[\s'’]", "", text).replace(",", "."))


def _two_flights(name, values, parts, source, n_empty):
    is_parted = len(parts) == N_FLIGHTS
    found = f"column '{shortened(name)}' has the values {values}, as of two flights"
    remedy = (
        "Part the rows into a file for each flight; rename the column if it tells "
        "other things apart"
    )
    if is_parted:
        remedy = (
            "Say where for the table of each flight in block.toml, as in where = "
            '{Flug = "tief"}, or part its rows into files; rename the column if it '
            "tells other things apart"
        )
    elif n_empty:
        found = (
            f"column '{shortened(name)}' has the values {values}, as of two flights, "
            f"and is empty in {count(n_empty, 'row')}"
        )
        remedy = (
            "Fill the empty cells with the flight of their row; rename the column if "
            "it tells other things apart"
        )
    error = TwoFlightsError(
        found, expected="one flight in each table", remedy=remedy, file=source
    )
    error.parts = tuple(parts) if is_parted else ()
    return error
