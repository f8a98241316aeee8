"""Transformed points with twice the digits of a float.

Where little control holds a large block, its weak motions amplify the rounding of the
residuals, and the residuals are small differences of coordinates of thousands of
metres. So products and sums are carried as a value and its rounding error (Dekker
1971), and the block is as exact as its parameters can be written down.
"""

import numpy as np

from einschalt.foundations.kernels import compiled

SPLITTER = 134217729.0  # 2^27 + 1


def transform_exactly(design, model, parameters):
    """Multiply the design of each observation with the unknowns of its model.

    Two arrays, (n_rows, d, n_right), whose sum is the product.
    ``design`` (n_rows, d, n_unknowns) is float or complex, ``parameters`` are
    (n_models, n_unknowns, n_right).
    """
    shape = (*design.shape[:2], parameters.shape[2])
    high, low = np.empty(shape, design.dtype), np.empty(shape, design.dtype)
    parts = 2 if np.iscomplexobj(design) else 1
    _transform(
        _as_parts(high, parts),
        _as_parts(low, parts),
        _as_parts(design, parts),
        model,
        _as_parts(np.ascontiguousarray(parameters, dtype=design.dtype), parts),
    )
    return high, low


def _as_parts(array, parts):
    """Real and imaginary parts along a last axis."""
    return array.view(np.float64).reshape(*array.shape, parts)


@compiled(inline="always")
def _add_product(high, low, a, b):
    """Add a b to high + low; returns both."""
    product = a * b
    a_high = SPLITTER * a
    a_high = a_high - (a_high - a)
    a_low = a - a_high
    b_high = SPLITTER * b
    b_high = b_high - (b_high - b)
    b_low = b - b_high
    lost = a_low * b_low - (
        ((product - a_high * b_high) - a_low * b_high) - a_high * b_low
    )
    total = high + product
    part = total - high
    lost += (high - (total - part)) + (product - part)
    return total, low + lost


@compiled
def _transform(high, low, design, model, parameters):
    n_rows, d, u, parts = design.shape
    for row in range(n_rows):
        m = model[row]
        for c in range(d):
            for r in range(high.shape[2]):
                real, rest = 0.0, 0.0
                imaginary, lost = 0.0, 0.0
                for a in range(u):
                    g, p = design[row, c, a, 0], parameters[m, a, r, 0]
                    real, rest = _add_product(real, rest, g, p)
                    if parts == 2:
                        h, q = design[row, c, a, 1], parameters[m, a, r, 1]
                        real, rest = _add_product(real, rest, -h, q)
                        imaginary, lost = _add_product(imaginary, lost, g, q)
                        imaginary, lost = _add_product(imaginary, lost, h, p)
                high[row, c, r, 0], low[row, c, r, 0] = real, rest
                if parts == 2:
                    high[row, c, r, 1], low[row, c, r, 1] = imaginary, lost
