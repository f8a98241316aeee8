"""What a value is, said in messages; nothing heavy is imported: help comes at once."""

from numbers import Number
from pathlib import PurePath

from einschalt.foundations.display_names import shortened

MOST_SHOWN = 60
MOST_PARTS = 3
MOST_BITS = 128  # Python refuses to write numbers of more than 4300 digits
PLAIN = (str, bytes, Number, PurePath, type(None))


def described(value):
    """Say what a value is, on one line and short, whatever it holds.

    Numbers, texts and paths as Python writes them; of others the kind and the size.

    >>> described("wide"), described(None), described({"a": 1})
    ("'wide'", 'None', 'a dict of length 1')
    >>> described([1.0] * 12), described(int)
    ('a list of length 12', 'the class int')
    >>> import numpy as np
    >>> described(np.zeros((3, 4)))
    'an ndarray of shape (3, 4)'
    """
    if isinstance(value, type):
        return f"the class {value.__name__}"
    if isinstance(value, int) and value.bit_length() > MOST_BITS:
        return f"a whole number of {value.bit_length()} bits"
    is_short = isinstance(value, (list, tuple)) and len(value) <= MOST_PARTS
    if isinstance(value, PLAIN) or (is_short and all(map(_is_plain, value))):
        return shortened(repr(value), MOST_SHOWN)
    name = type(value).__name__
    is_vowel = name[:1].lower() in "aeiou" or name == "ndarray"
    kind = f"{'an' if is_vowel else 'a'} {name}"
    shape = getattr(value, "shape", None)
    if isinstance(shape, tuple):
        return f"{kind} of shape {shape}"
    if isinstance(value, (list, tuple, dict, set, frozenset)):
        return f"{kind} of length {len(value)}"
    return kind


def _is_plain(value):
    return isinstance(value, PLAIN) and not (
        isinstance(value, int) and value.bit_length() > MOST_BITS
    )
