"""What a table says, in the words and signs of the program that wrote it.

Every reader passes here what it has read: the names of the columns before the values,
so that numbers are read as such, then the frame. What was understood is said as a note;
what has two meanings is refused with the question, and never guessed.
"""

from dataclasses import dataclass, field

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.compute as pc

from einschalt.foundations.column_words import (
    PLANE,
    columns_by_place,
    columns_meant,
    kind_of,
    translation_note,
)
from einschalt.foundations.decimal_commas import (
    certain_decimal_comma,
    comma_of_two_meanings,
    commas_of_thousands,
    meaning_of_commas,
    point_of_two_meanings,
    with_hyphens,
    with_points,
    without_commas,
    without_groups,
)
from einschalt.foundations.errors import TableError, name_some
from einschalt.foundations.number_parsing import is_number
from einschalt.foundations.tables import ROLES
from einschalt.foundations.typesetting import count
from einschalt.interfaces.files.header_lengths import (
    in_expected_units,
    require_unit_of_heights,
)
from einschalt.interfaces.files.letters_of_axes import with_axes
from einschalt.interfaces.files.lists_without_names import refuse_other_lists
from einschalt.interfaces.files.places_of_images import refuse_places_of_images
from einschalt.interfaces.files.rows_of_no_data import (
    refuse_footer,
    without_count,
    without_fillers,
    without_headers,
    without_rulers,
)
from einschalt.interfaces.files.written_angles import in_degrees, packed_in_degrees

ROLE = "role"
NEW = "new"
COMMA, POINT = ",", "."
MOST_NAMES = 1000  # of columns that are looked at


@dataclass(frozen=True)
class Said:
    """What is said of a table beside its name."""

    columns: dict = field(default_factory=dict)  # name of the schema: that in the file
    sheet: str | None = None  # of a workbook
    layer: str | None = None  # of a file of layers
    decimal: str | None = None  # "," or "."
    crs: str | None = None  # of its coordinates
    unit: str | None = None  # of the models or images of its flight; px of a camera
    degrees_crs: str | None = None  # of longitudes and latitudes, in place of crs
    where: dict = field(default_factory=dict)  # of its rows alone: column and value
    angles: str | None = None  # "degrees" or "D.MMSS", of longitudes and latitudes


NOTHING_SAID = Said()


def answered_elsewhere(error, answers):
    """A question on a table that block.toml does not answer, with another remedy.

    ``answers``: remedies by words of those in whose place they stand; the same error
    where none of them occurs.
    """
    found = (other for words, other in answers.items() if words in (error.remedy or ""))
    other = next(found, None)
    return error if other is None else error.with_facts(remedy=other)


@dataclass(frozen=True, eq=False)
class ReadTable:
    """A table as it was read."""

    frame: pd.DataFrame  # the columns of the schema under their names, and the others
    notes: tuple[str, ...] = ()  # how it was understood
    crs: str | None = None  # of its coordinates, where the file states one
    unit: str | None = None  # of model or image coordinates, where the header has it
    n_beside: int = 0  # other tables in its sheet


def meant_header(names, schema, said, source, row=None, *, usual=None):
    """Understand the names of the columns, as :func:`columns_meant` does.

    ``usual``: of a list without names, what is known beside its two coordinates.
    """
    if usual is not None:
        return columns_by_place(names, usual, schema, said.columns, source=source)
    known = set(schema.names)
    if not said.columns and known.issuperset(names):
        required = {c.name for c in schema.columns if c.is_required}
        if required.issubset(names):  # nothing to understand
            return columns_meant(names, schema)
    return columns_meant(names, schema, said.columns, source=source, row=row)


def understood(
    frame, schema, said, meant, source, *, is_of_cells=False, is_placed=False
) -> ReadTable:
    """Understand values: decimal commas, the axes of Y and X, kinds of points.

    ``is_of_cells``: of a workbook, whose numbers have a point whatever texts have;
    ``is_placed``: coordinates are those of a geometry, whose degrees are decimal ones.
    ``frame`` has the names of ``meant``. A TableError where something has two meanings.
    """
    frame, rulers = without_rulers(frame, schema, source)
    frame, total = without_count(frame, schema, source)
    refuse_footer(frame, source)
    frame, repeated = without_headers(frame, schema, meant, source)
    frame, fillers = without_fillers(frame, schema, source)
    frame, angles = in_degrees(frame, schema, source)
    frame, notes = _with_points(frame, schema, said, source, is_of_cells)
    if angles is None and not is_placed:
        frame, angles = packed_in_degrees(frame, meant, schema, said.angles, source)
    notes[:0] = [rulers, total, repeated, fillers, angles]
    frame, note, unit = in_expected_units(frame, meant, schema, said, source)
    notes.append(note)
    require_unit_of_heights(frame, meant, said.crs, source)
    refuse_other_lists(frame, meant, said, source)
    refuse_places_of_images(frame, meant, schema, said, source)
    hidden = set()  # columns of which another note tells, or none
    if meant.letters is not None:
        frame, note = with_axes(frame, said.crs, meant, source)
        notes.append(note)
        hidden |= set(PLANE)
    if ROLE in schema.names and list(frame.columns).count(ROLE) == 1:
        frame, more = _with_roles(frame, meant, source)
        notes += more
        hidden |= {ROLE} - set(frame.columns)
    notes.insert(0, translation_note(meant, source, hidden))
    return ReadTable(frame, tuple(note for note in notes if note), unit=unit)


def _with_points(frame, schema, said, source, is_of_cells):
    """The frame with decimal points, where it has decimal commas, and notes."""
    names = [
        name
        for name in schema.number_names
        if list(frame.columns).count(name) == 1
        and not pd.api.types.is_numeric_dtype(frame[name])
    ]
    texts = {name: _texts(frame[name]) for name in names}
    ungrouped, note = _without_commas(frame, texts, said, source)
    frame, texts, notes = _without_groups(frame, texts, ungrouped, source)
    notes += [note] if note else []
    if said.decimal == POINT:
        return frame, notes
    commas = meaning_of_commas(_with_commas(texts) if is_of_cells else texts)
    if commas.meaning == "mixed":
        raise _few_points(frame, commas, source)
    if commas.meaning == "open" and said.decimal is None:
        raise _question_of_commas(frame, commas, source)
    if commas.meaning == "decimal" or said.decimal == COMMA:
        _refuse_thousands(frame, texts, source)
    if commas.meaning == "none":
        return frame, notes
    changed = {n: _numbers(with_points(v), frame.index) for n, v in texts.items()}
    notes.append(f"{source}: read with decimal commas")
    return frame.assign(**changed), notes


def _with_commas(texts):
    """Columns in which there are commas; points of the others say nothing of them."""
    return {
        name: values
        for name, values in texts.items()
        if pc.any(pc.match_substring(values, COMMA), min_count=0).as_py()
    }


def _without_commas(frame, texts, said, source):
    """Texts without commas between thousands, where one of them can be nothing else.

    Then all of the table are, and a note tells it of those that could be decimal.
    """
    texts = {name: with_hyphens(values) for name, values in texts.items()}
    found = commas_of_thousands(texts)
    if found is None:
        return texts, None
    decimal = certain_decimal_comma(texts)
    if said.decimal == COMMA or decimal is not None:
        raise _commas_of_both_kinds(frame, found, decimal, source)
    doubtful = comma_of_two_meanings(texts)
    note = None
    if doubtful is not None:
        note = _note_of_thousands(found, doubtful, source)
    return {name: without_commas(values) for name, values in texts.items()}, note


def _note_of_thousands(found, doubtful, source):
    shows, certain = found[0], found[2]
    name, text = doubtful[0], doubtful[2]
    return (
        f"{source}: commas separate thousands, as {shows} '{certain}' shows: "
        f"{name} '{text}' is read as {text.replace(COMMA, '')}"
    )


def _commas_of_both_kinds(frame, found, decimal, source):
    name, place, text = found
    if decimal is None:
        return TableError(
            f"{name} '{text}' has commas between thousands, and the table is said to "
            'have decimal = ","',
            expected="decimal commas, and no others",
            remedy='Take decimal = "," out of block.toml, or correct the number',
            file=source,
            row=_line(frame, place),
        )
    other, _, comma = decimal
    return TableError(
        f"{name} '{text}' has commas between thousands, and {other} '{comma}' a "
        "decimal comma",
        expected="one meaning of commas in a table",
        remedy="Write decimal points, and take the other commas out",
        file=source,
        row=_line(frame, place),
    )


def _without_groups(frame, texts, ungrouped, source):
    """Take out signs between thousands that can be nothing else; minus is a hyphen.

    ``ungrouped``: the texts without commas between thousands.
    """
    plain = {name: without_groups(values) for name, values in ungrouped.items()}
    changed = {n: values for n, values in plain.items() if not values.equals(texts[n])}
    if not changed:
        return frame, texts, []
    numbers = {n: _numbers(values, frame.index) for n, values in changed.items()}
    is_shorter = any(_n_letters(v) < _n_letters(texts[n]) for n, v in changed.items())
    note = f"{source}: read without the signs between thousands"
    return frame.assign(**numbers), plain, [note] if is_shorter else []


def _n_letters(texts):
    return pc.sum(pc.utf8_length(texts)).as_py()


def _texts(series):
    values = pa.array(series, from_pandas=True)
    if isinstance(values, pa.ChunkedArray):
        values = values.combine_chunks()
    return pc.utf8_trim_whitespace(values.cast(pa.string()).fill_null(""))


def _numbers(plain, index):
    """Numbers with decimal points; as text where one of them is none."""
    known = pc.if_else(pc.equal(plain, ""), pa.scalar(None, pa.string()), plain)
    try:
        values = known.cast(pa.float64())
    except pa.ArrowInvalid:  # check_table says which
        values = plain
    return pd.Series(values.to_pandas().to_numpy(), index)


def _refuse_thousands(frame, texts, source):
    """Refuse points that may separate thousands, where commas are decimal."""
    found = point_of_two_meanings(texts)
    if found is None:
        return
    name, place, text = found
    raise TableError(
        f"{name} '{text}': is it {text} or {text.replace(POINT, '')}? The table has "
        "decimal commas, and its points may separate thousands",
        expected="decimal commas alone",
        remedy="Take the points out if they separate thousands; otherwise write commas "
        "for them",
        file=source,
        row=_line(frame, place),
    )


def _few_points(frame, commas, source):
    return TableError(
        f"{commas.column} '{commas.text}' has a point where most numbers of the column "
        f"have decimal commas, in {count(commas.n_points, 'row')}",
        expected="one decimal sign in a column",
        remedy="Write a comma for it, or take it out if it separates thousands",
        file=source,
        row=_line(frame, commas.place),
    )


def _line(frame, place):
    row = frame.index[place]
    return row if isinstance(row, (int, np.integer)) else None


def _question_of_commas(frame, commas, source):
    point, plain = (commas.text.replace(COMMA, sign) for sign in (POINT, ""))
    return TableError(
        f"{commas.column} '{commas.text}': is it {point} or {plain}? No number with a "
        "comma in this table can have one meaning only",
        expected="decimal points, or a word on the commas",
        remedy='Say decimal = "," for the table in block.toml if they are decimal '
        "commas; otherwise take them out",
        file=source,
        row=_line(frame, commas.place),
    )


def _with_roles(frame, meant, source):
    """The frame with roles as they are called here, without new points."""
    words = frame[ROLE].astype(object).where(frame[ROLE].notna(), "").astype(str)
    known = {word: _role(word) for word in words.unique()}
    # our own results call new points so as well
    foreign = {
        word: role
        for word, role in known.items()
        if role and (role == NEW or word.strip() != role)
    }
    is_translated = ROLE in meant.translated
    if is_translated and not any(known.values()):
        # another kind of kind, such as that of the monument
        name = meant.translated[ROLE]
        return frame.rename(columns={ROLE: name}), []
    if not foreign:
        return frame, []
    roles = words.map(lambda word: known[word] or word)
    is_new = (roles == NEW).to_numpy()
    kept = frame.assign(**{ROLE: roles.to_numpy(dtype=object)})[~is_new]
    said = [f"{w.strip()!r} = {r}" for w, r in sorted(foreign.items()) if r != NEW]
    notes = [f"{source}: role {name_some(said, 8)}"] if said else []
    if is_new.any():
        kinds = name_some(sorted({w.strip() for w, r in known.items() if r == NEW}))
        if is_new.all():
            raise TableError(
                f"all points have the role {kinds}; new points are no control",
                expected="control or check points",
                remedy="Give those the role control that are",
                file=source,
            )
        notes.append(
            f"{source}: {count(int(is_new.sum()), 'row')} of role {kinds} left out: "
            "new points are no control. Give those the role control that are"
        )
    return kept, notes


def _role(word):
    """Role of a word for a kind of points; None where it is not known."""
    plain = word.strip()
    return plain if plain in ROLES else kind_of(plain)


def is_header(names, schema):
    """Whether names of columns stand here: no numbers, and some that are known."""
    if len(names) > MOST_NAMES or any(is_number(name) for name in names):
        return False
    try:
        meant = columns_meant(list(names), schema)
    except TableError:  # two that could be meant: names, certainly
        return True
    return bool(meant.translated) or bool(set(names) & set(schema.names))


def is_whole_header(names, schema, said):
    """Whether all columns stand here that the schema requires."""
    known = [name for name in names if name]
    if len(set(known)) < len(known) or len(known) > MOST_NAMES:
        return False
    try:
        meant = columns_meant(known, schema, said.columns)
    except TableError:
        return False
    required = {column.name for column in schema.columns if column.is_required}
    return required <= set(meant.names)
