"""Columns of names compared as a whole, by their integer codes."""

import numpy as np

from einschalt.foundations.names import Coded, encode

LARGEST_CODE = 2**62


def is_among(names, known):
    """Whether each name occurs among others.

    >>> is_among(["0012", "12"], ["12", "7/8"]).tolist()
    [False, True]
    """
    coded = encode(names)
    return (encode(known).locate(coded) >= 0)[coded.codes]


def row_codes(columns):
    """Code each distinct row of some columns of names, coded or not, by one integer.

    >>> row_codes([["1", "1", "2"], ["A", "A", "A"]]).tolist()
    [0, 0, 1]
    """
    coded = [c if isinstance(c, Coded) else encode(c) for c in columns]
    codes = np.zeros(len(coded[0].codes), dtype=np.int64)
    for part in coded:
        n_names = max(len(part), 1)
        if codes.max(initial=0) >= LARGEST_CODE // n_names:
            codes = np.unique(codes, return_inverse=True)[1]
        codes = codes * n_names + part.codes
    return codes
