"""Rows of a table that are no data: headers once more, rulers, sums below the points.

Tables that were put together of several repeat their header; one that was printed has a
sum or a mean at its end, which looks like a point where its numbers are plausible.
"""

import re

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.compute as pc

from einschalt.foundations.cell_values import whole_text
from einschalt.foundations.column_words import folded
from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import TableError, name_some
from einschalt.foundations.kept_texts import kept
from einschalt.foundations.tables import LINE

NAMES = ("point_id", "model_id", "image_id")
# a closing line, such as Anzahl Punkte: 157, that counts the rows above it
COUNT = re.compile(r"\D*\d+[^\d.,:;/-]*")
FEWEST_COUNTED, MOST_OF_A_COUNT = 3, 2  # rows with it, and cells of it
HAS_WORD = re.compile(r"[^\W\d_]{3}")
# what stands in a cell for a value that there is not
FILLERS = r"(?i)^([-\x{2013}\x{2014}]+|n[./]?a\.?|k\. ?a\.|null|none|#n/?[av])$"
DASHES = r"^[-=_*~.\x{2500}-\x{257f}]{3,}$"  # a cell of a ruler, of whatever signs
# as column_words.folded writes them
SUMS = {
    *("summe", "gesamt", "gesamtsumme", "zwischensumme", "anzahl", "mittel"),
    *("mittelwert", "durchschnitt", "standardabweichung", "spannweite"),
    *("sum", "total", "subtotal", "count", "mean", "average", "grandtotal"),
    *("stddev", "stdev", "standarddeviation", "somme", "nombre", "moyenne"),
    *("somma", "totale", "media", "suma", "promedio", "soma", "razem", "srednia"),
    *("soucet", "celkem", "prumer", "totaal", "gemiddelde", "osszesen", "atlag"),
    *("skupaj", "povprecje", "ukupno", "prosjek", "summa", "medelvaerde"),
    *("gjennomsnitt", "gennemsnit", "yhteensae", "keskiarvo", "合計", "平均"),
}
AS_WRITTEN = sorted({f"{word}{end}" for word in SUMS for end in ("", ":", ".")})
# which could be names of points, if they do not end the table
FOOTERS = SUMS | {"min", "max", "minimum", "maximum", "median", "std", "rms"}


def without_headers(frame, schema, meant, source):
    """The frame without the rows that repeat its header, and a note or None.

    Such a row makes text of every column of numbers, so that others cost nothing.
    """
    once = [n for n in schema.number_names if list(frame.columns).count(n) == 1]
    if not once or any(pd.api.types.is_numeric_dtype(frame[name]) for name in once):
        return frame, None
    is_header = np.ones(len(frame), dtype=bool)
    for name in once:
        word = str(meant.translated.get(name, name)).strip()
        is_header &= _are(frame[name], word)
        if not is_header.any():  # after the first column, as a rule
            return frame, None
    said = kept("{n:row|rows}", n=int(is_header.sum()))
    return frame[~is_header], f"{source}: {said} repeating the header left out"


def without_rulers(frame, schema, source):
    """The frame without rows in which all cells are dashes, and a note or None.

    Such a row makes text of every column of numbers, so that others cost nothing.
    """
    once = [n for n in schema.number_names if list(frame.columns).count(n) == 1]
    if not once or any(pd.api.types.is_numeric_dtype(frame[name]) for name in once):
        return frame, None
    is_ruler, is_blank = np.ones((2, len(frame)), dtype=bool)
    for place in range(frame.shape[1]):
        texts = _texts_of(frame.iloc[:, place])
        is_empty = pc.equal(texts, "").to_numpy(zero_copy_only=False)
        is_dashes = pc.match_substring_regex(texts, DASHES)
        is_ruler &= is_empty | is_dashes.to_numpy(zero_copy_only=False)
        is_blank &= is_empty
        if not is_ruler.any():  # after the first column, as a rule
            return frame, None
    is_ruler &= ~is_blank
    if not is_ruler.any():
        return frame, None
    rows = name_some(frame.index[is_ruler])
    return frame[~is_ruler], f"{source}: rows of dashes left out: {rows}"


def without_count(frame, schema, source):
    """The frame without a last row that counts those above it, and a note or None.

    Such as ``Anzahl: 157``, in one cell or in two, if there are as many, and cells are
    empty that a row of data needs.
    """
    if len(frame) < FEWEST_COUNTED:
        return frame, None
    last = frame.iloc[-1].tolist()
    cells = ["" if pd.isna(cell) else whole_text(cell).strip() for cell in last]
    needed = {column.name for column in schema.columns if column.is_required}
    pairs = zip(frame.columns, cells, strict=True)
    is_whole = all(cell for name, cell in pairs if name in needed)
    text = " ".join(cell for cell in cells if cell)
    is_short = sum(map(bool, cells)) <= MOST_OF_A_COUNT
    if is_whole or not is_short or not counts(text, len(frame) - 1):
        return frame, None
    return frame.iloc[:-1], f"{source}: the last row, {shortened(text)!r}, left out"


def counts(text, n_rows):
    """Whether a text has words and a number, which is that of the rows.

    >>> counts("Anzahl Punkte: 157", 157), counts("157", 157), counts("P 157", 156)
    (True, False, False)
    """
    is_said = COUNT.fullmatch(text) is not None and HAS_WORD.search(text) is not None
    return is_said and int(re.search(r"\d+", text)[0]) == n_rows


def without_fillers(frame, schema, source):
    """The frame with empty cells for hyphens and the like, and a note or None.

    Of columns in which a value may be missing, such as heights.
    """
    changed, shown = {}, []
    for column in schema.columns:
        name = column.name
        if column.kind != "number" or not column.may_be_missing:
            continue
        if list(frame.columns).count(name) != 1:
            continue
        if pd.api.types.is_numeric_dtype(frame[name]):
            continue
        is_filler = pc.match_substring_regex(_texts_of(frame[name]), FILLERS)
        is_filler = is_filler.to_numpy(zero_copy_only=False)
        if is_filler.any():
            changed[name] = frame[name].where(~is_filler, "")
            shown.append(f"{name} {str(frame[name][is_filler].iloc[0]).strip()!r}")
    if not changed:
        return frame, None
    said = name_some(shown)
    return frame.assign(**changed), f"{source}: taken for missing values: {said}"


def _are(series, word):
    """Whether each text of a column is a word, in capitals or not, blanks aside."""
    texts = pc.utf8_lower(_texts_of(series))
    return pc.equal(texts, word.lower()).to_numpy(zero_copy_only=False)


def _texts_of(series):
    if series.dtype == object:
        series = series.astype("str")
    values = pa.array(series, from_pandas=True)
    if isinstance(values, pa.ChunkedArray):
        values = values.combine_chunks()
    return pc.utf8_trim_whitespace(values.cast(pa.string()).fill_null(""))


def refuse_footer(frame, source):
    """Refuse a row that is called a sum or a mean, or a last one that is an extreme."""
    if not len(frame):
        return
    for name in NAMES:
        if list(frame.columns).count(name) != 1:
            continue
        names = frame[name]
        place = len(frame) - 1
        if folded(names.iloc[-1]) not in FOOTERS:
            place = _place_of_sum(names)
        if place is not None:
            word = shortened(str(names.iloc[place]))
            raise TableError(
                f"a row is called {word!r}: is it a sum or a mean of the rows above?",
                expected="points alone",
                remedy="Delete the row, or rename its point",
                file=source,
                row=int(frame.index[place]) if frame.index.name == LINE else None,
            )


def _place_of_sum(names):
    """Position of the first name that is called a sum or a mean, or None."""
    if not (pd.api.types.is_string_dtype(names) or names.dtype == object):
        return None
    small = pc.utf8_lower(_texts_of(names))  # a tenth of what folding takes
    place = pc.index(pc.is_in(small, value_set=pa.array(AS_WRITTEN)), True).as_py()
    return place if place >= 0 else None
