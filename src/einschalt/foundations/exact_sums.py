"""Sums of products with twice the digits of a float.

Where little control holds a large block, its weak motions amplify the rounding of the
residuals, and the residuals are small differences of coordinates of thousands of
metres. So products and sums are carried as a value and its rounding error (Dekker
1971), and the block is as exact as its parameters can be written down.
"""

from einschalt.foundations.kernels import compiled

SPLITTER = 134217729.0  # 2^27 + 1


@compiled(forceinline=True)
def add_product(high, low, a, b):
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
