"""Results in plain values, for files that other programs read."""

import math
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from enum import Enum

import numpy as np
import pandas as pd

# of a field; arrays of drawn errors are no result, a figure is made of them
IS_PLAIN = "is_plain"


def plain(value):
    """Turn a value into dicts, lists, numbers, texts and None, as strict JSON has them.

    Dataclasses become dicts, tables lists of rows, enumerations their values; numbers
    that are not finite become None. Fields whose metadata have IS_PLAIN false are left
    out.

    Examples
    --------
    >>> plain({"size": float("nan"), "names": ("7/8", "8/9")})
    {'size': None, 'names': ['7/8', '8/9']}
    """
    if type(value) is float:  # most are, and there are ten thousands
        return value if math.isfinite(value) else None
    if value is None or isinstance(value, (bool, np.bool_)):
        return None if value is None else bool(value)
    if isinstance(value, Enum):
        return plain(value.value)
    if isinstance(value, str):
        return str(value)
    if isinstance(value, (int, np.integer)):
        return int(value)
    if isinstance(value, (float, np.floating)):
        return float(value) if np.isfinite(value) else None
    return _plain_collection(value)


def _plain_collection(value):
    if is_dataclass(value):
        shown = (f for f in fields(value) if f.metadata.get(IS_PLAIN, True))
        return {f.name: plain(getattr(value, f.name)) for f in shown}
    if isinstance(value, pd.DataFrame):
        return [plain(row) for row in value.to_dict("records")]
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple, np.ndarray)):
        return [plain(item) for item in value]
    raise TypeError(type(value).__name__)
