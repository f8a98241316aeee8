"""Names of points and models as integer codes.

Names are text, kept as given. They are dictionary-encoded once (pyarrow), and from
there on only the codes travel: strings are never sorted or compared again.
"""

import weakref
from dataclasses import dataclass
from functools import cached_property
from itertools import count

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

TEXT = pa.large_string()  # a column of names may be longer than 2 GiB
MANY = 10_000  # rows of a column whose codes are worth keeping
# by the identity of an Arrow column, which cannot change: itself, weakly, and its codes
_kept = {}


@dataclass(frozen=True, eq=False)
class Coded:
    """A column of names as integer codes."""

    codes: np.ndarray  # (n_rows,): position of each row's name in ``names``
    dictionary: pa.Array  # the distinct names in order of first appearance

    def __len__(self):
        """Return the number of distinct names."""
        return len(self.dictionary)

    @cached_property
    def names(self):
        """The distinct names, ndarray of object, shape (n_names,)."""
        return self.dictionary.to_numpy(zero_copy_only=False).astype(object)

    def locate(self, other):
        """Position here of each distinct name of another; -1 where it is not there."""
        found = pc.index_in(other.dictionary, value_set=self.dictionary)
        return found.fill_null(-1).to_numpy(zero_copy_only=False).astype(np.int64)


@dataclass(frozen=True, eq=False)
class CodedPairs:
    """Two columns of names as one integer code for each distinct pair."""

    codes: np.ndarray  # (n_rows,): position of each row's pair among the distinct pairs
    # names of the distinct pairs, in order of first appearance, (n_pairs,)
    first: np.ndarray
    second: np.ndarray

    def __len__(self):
        """Return the number of distinct pairs."""
        return len(self.first)

    @cached_property
    def names(self):
        """The distinct pairs as tuples, ndarray of object, shape (n_pairs,)."""
        names = np.empty(len(self), dtype=object)
        names[:] = list(zip(self.first, self.second, strict=True))
        return names

    def locate(self, other):
        """Position here of each distinct pair of others; -1 where it is not there."""
        # each pair of both is there once, so that its code is its first position
        together = encode_pairs(
            np.concatenate([self.first, other.first]),
            np.concatenate([self.second, other.second]),
        )
        place = together.codes[len(self) :]
        return np.where(place < len(self), place, -1)


def ranks(*columns):
    """Places of rows in the order of their names, by the first column first, (n_rows,).

    >>> ranks(["b", "a", "b"], ["9", "1", "10"]).tolist()
    [2, 0, 1]
    """
    named = {str(k): _text(names) for k, names in enumerate(columns)}
    table = pa.table(named)
    order = pc.sort_indices(table, sort_keys=[(name, "ascending") for name in named])
    places = np.empty(len(table), dtype=np.int64)
    places[order.to_numpy()] = np.arange(len(table))
    return places


def free_numbers(stated):
    """Numbers from 1 on, as names of points that have none: those that none has.

    >>> from itertools import islice
    >>> list(islice(free_numbers({"2"}), 2))
    ['1', '3']
    """
    return (number for number in map(str, count(1)) if number not in stated)


def encode(names) -> Coded:
    """Dictionary-encode a column of names; ValueError where one is missing.

    Codes of a long column of a table are kept as long as the column is.

    >>> coded = encode(["7/8", "0012", "7/8"])
    >>> coded.codes.tolist(), coded.names.tolist()
    ([0, 1, 0], ['7/8', '0012'])
    """
    column = _long_column(names)
    coded = _encoded(names) if column is None else _kept_codes(column)
    indices = coded.indices.to_numpy(zero_copy_only=False)
    return Coded(indices.astype(np.int64), coded.dictionary)


def _encoded(names):
    texts = _text(names)
    if texts.null_count:
        raise ValueError(f"{texts.null_count} of {len(texts)} names are missing")
    return texts.dictionary_encode()


def _long_column(names):
    """The column of Arrow behind a long one of pandas, the same each time, or None."""
    if len(names) < MANY:
        return None
    inside = arrow_inside(names)
    if not hasattr(inside, "__arrow_array__"):
        return None
    column = inside.__arrow_array__()
    return column if isinstance(column, pa.ChunkedArray) else None


def _kept_codes(column):
    key = id(column)
    own, coded = _kept.get(key, (None, None))
    if own is None or own() is not column:
        coded = _encoded(column)
        # it goes before another column can have the identity
        _kept[key] = weakref.ref(column, lambda _: _kept.pop(key, None)), coded
    return coded


class CodedColumns(dict):
    """Columns of names of a table as codes, each made when it is first asked for."""

    def __init__(self, frame):
        """Encode none yet."""
        super().__init__()
        self._frame = frame

    def __missing__(self, name):
        """Encode a column."""
        self[name] = encode(self._frame[name])
        return self[name]


def encode_pairs(first, second) -> CodedPairs:
    """Code the distinct pairs of two columns of names.

    >>> encode_pairs(["1", "2", "1"], ["7/8", "7/8", "7/8"]).codes.tolist()
    [0, 1, 0]
    """
    return pair_up(encode(first), encode(second))


def pair_up(one, two) -> CodedPairs:
    """Code the distinct pairs of two coded columns.

    Models are told apart by coverage and model_id together, since the two coverages
    of a flight may count their models alike.
    """
    pairs = pa.array(one.codes * len(two) + two.codes).dictionary_encode()
    kept = pairs.dictionary.to_numpy()
    codes = pairs.indices.to_numpy().astype(np.int64)
    n_second = max(len(two), 1)
    return CodedPairs(codes, one.names[kept // n_second], two.names[kept % n_second])


def rows_of_names(names, known):
    """Row of each name among known ones, each of which is there once; -1 if it is not.

    All are looked up in one table, which takes three fifths of coding both first.

    >>> rows_of_names(["7/8", "0012", "7/8"], ["0012", "13"]).tolist()
    [-1, 0, -1]
    """
    together = pa.concat_arrays([_text(known), _text(names)]).dictionary_encode()
    found = together.indices[len(known) :].to_numpy().astype(np.int64)
    found[found >= len(known)] = -1
    return found


def is_among(names, others):
    """Whether each name is one of others, ndarray of bool.

    >>> is_among(["7/8", "0012"], ["0012", "13"]).tolist()
    [False, True]
    """
    found = pc.is_in(_text(names), value_set=_text(others))
    return found.to_numpy(zero_copy_only=False)


def arrow_inside(column):
    """The array of a column of pandas, of Arrow or numpy, or else the column.

    Arrow asks the column for a dozen attributes before it comes to its array.
    """
    array = getattr(column, "array", column)
    if hasattr(array, "__arrow_array__"):
        return array
    is_numpy = array is not column and isinstance(column.dtype, np.dtype)
    return array.to_numpy() if is_numpy else column


def _text(names):
    if len(names) == 0:  # of any kind: pandas makes empty columns float
        return pa.array([], TEXT)
    if isinstance(names, (pa.Array, pa.ChunkedArray)):
        array = names.cast(TEXT)
    else:
        array = pa.array(arrow_inside(names), TEXT, from_pandas=True)
    return array.combine_chunks() if isinstance(array, pa.ChunkedArray) else array
