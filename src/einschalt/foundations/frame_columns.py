"""Some columns of a table, without the detour through an index of their names.

``table[names]`` makes an index of the names first, and looks for each of its columns in
that of the table: half a millisecond, whatever the table's length. A block of sixty
models takes columns many hundred times.
"""

from collections.abc import Iterable

import numpy as np
import pandas as pd

PLAN = ["easting", "northing"]
MODEL = ["coverage", "model_id"]  # of one flight


def columns_of(table: pd.DataFrame, names: Iterable[str]) -> pd.DataFrame:
    """Some columns of a table, as ``table[names]`` gives them.

    Each name stands once in the table.

    >>> columns_of(pd.DataFrame({"x": [1.0], "y": [2.0], "z": [3.0]}), "zx")
         z    x
    0  3.0  1.0
    """
    return table.take([table.columns.get_loc(name) for name in names], axis="columns")


def with_columns(table: pd.DataFrame, **columns) -> pd.DataFrame:
    """A table with further or other columns, as ``table.assign`` gives it.

    All at once, where pandas puts each into its place by itself. Functions of the table
    are no columns here.

    >>> with_columns(pd.DataFrame({"x": [1.0]}), y=2.0, x=[3.0])
         x    y
    0  3.0  2.0
    """
    if len(columns) == 1:
        return table.assign(**columns)
    # copied here, since pandas would put all of them into one block, of which the
    # arrays that are taken from the table later could not be changed
    own = {name: v.copy() if hasattr(v, "copy") else v for name, v in columns.items()}
    if own.keys().isdisjoint(table.columns.tolist()):
        further = pd.DataFrame(own, index=table.index, copy=False)
        return pd.concat([table, further], axis="columns")
    others = {n: v.copy() for n, v in table.items() if n not in own}
    in_order = dict.fromkeys(table.columns)
    return pd.DataFrame(in_order | others | own, index=table.index, copy=False)


def joined(table: pd.DataFrame, others: pd.DataFrame, key: str) -> pd.DataFrame:
    """The rows of two tables with the same key, as ``table.merge(others, on=key)``.

    Tables that name the same in the same rows are put together without a search. Each
    column but the key is in one of them.

    >>> both = pd.DataFrame({"point_id": ["7/8"], "x": [1.0]})
    >>> joined(both, pd.DataFrame({"point_id": ["7/8"], "y": [2.0]}), "point_id")
      point_id    x    y
    0      7/8  1.0  2.0
    """
    own, other = table[key], others[key]
    is_same = own.dtype == other.dtype and own.array.equals(other.array)
    if not (is_same and len(pd.unique(own)) == len(own)):
        return table.merge(others, on=key)
    further = {name: v.array for name, v in others.items() if name != key}
    return with_columns(table.reset_index(drop=True), **further)


def values_of(table: pd.DataFrame, names: Iterable[str]) -> np.ndarray:
    """Numbers of some columns of a table, shape (n_rows, n_names).

    A column after the other in memory, as pandas gives them.

    >>> values_of(pd.DataFrame({"x": [1.0, 2.0], "y": [3, 4]}), "yx").tolist()
    [[3.0, 1.0], [4.0, 2.0]]
    """
    columns = [table[name].to_numpy(dtype=float) for name in names]
    return np.array(columns).T if columns else np.empty((len(table), 0))


def names_not_in(frame, known):
    """Names of the columns that are not among known ones; positions of nameless ones.

    >>> import pandas as pd
    >>> names_not_in(pd.DataFrame(columns=["x", "", "u"]), ["x", "y"])
    ('(column 2)', 'u')
    """
    named = enumerate(map(str, frame.columns), 1)
    return tuple(n.strip() or f"(column {k})" for k, n in named if n not in known)
