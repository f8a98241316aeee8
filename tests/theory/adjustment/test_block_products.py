"""Sums of two products in blocks of rows, held against those of scipy."""

import numpy as np
import pytest
from scipy import sparse

from einschalt.theory.adjustment import block_products
from einschalt.theory.adjustment.block_products import Product, sum_of_two

N_ROWS, N_STEPS, N_COLUMNS = 60, (90, 40), 500


def blocks(rng, shape, in_a_row, size, dtype):
    """A bsr_array with so many blocks of a size in each row, at random places."""
    n_rows, n_columns = shape
    places = [rng.choice(n_columns, in_a_row, replace=False) for _ in range(n_rows)]
    data = rng.normal(size=(n_rows * in_a_row, *size)).astype(dtype)
    if dtype is complex:
        data += 1j * rng.normal(size=data.shape)
    given = data, np.concatenate(places), np.arange(n_rows + 1) * in_a_row
    whole = n_rows * size[0], n_columns * size[1]
    return sparse.bsr_array(given, shape=whole)


def product(rng, n_steps, in_a_row, size, dtypes):
    rows = blocks(rng, (N_ROWS, n_steps), in_a_row[0], size, dtypes[0])
    each = size[1], size[1]
    matrix = blocks(rng, (n_steps, N_COLUMNS), in_a_row[1], each, dtypes[1])
    return Product.of(rows, matrix.tocsr() if size[1] == 1 else matrix)


@pytest.mark.parametrize("size", [(2, 1), (3, 1), (4, 2), (7, 3)])
@pytest.mark.parametrize("dtypes", [(float, float), (complex, float)])
def test_sums_are_those_of_scipy(size, dtypes, monkeypatch):
    monkeypatch.setattr(block_products, "WORTH_A_KERNEL", 0)
    rng = np.random.default_rng(5)
    first = product(rng, N_STEPS[0], (30, 7), size, dtypes)
    second = product(rng, N_STEPS[1], (9, 5), size, (float, float))
    found = sum_of_two(first, second)
    expected = first.rows @ first.matrix + second.rows @ second.matrix
    assert found.blocksize == size
    assert found.shape == expected.shape == (N_ROWS * size[0], N_COLUMNS * size[1])
    assert len(found.indices) == len(expected.indices)  # none twice, none is missing
    np.testing.assert_allclose(found.toarray(), expected.toarray(), rtol=0, atol=1e-12)


def test_work_is_what_is_multiplied_and_few_are_left_to_scipy(monkeypatch):
    rng = np.random.default_rng(6)
    first = product(rng, N_STEPS[0], (30, 7), (3, 1), (float, float))
    second = product(rng, N_STEPS[1], (9, 5), (3, 1), (float, float))
    assert (first.work, second.work) == (N_ROWS * 30 * 7, N_ROWS * 9 * 5)
    assert first.work + second.work < block_products.WORTH_A_KERNEL
    monkeypatch.setattr(block_products, "_multiply", None)
    expected = first.formed() + second.formed()
    assert abs(sum_of_two(first, second) - expected).max() == 0.0


def test_rows_without_any_block_add_nothing(monkeypatch):
    monkeypatch.setattr(block_products, "WORTH_A_KERNEL", 0)
    rng = np.random.default_rng(7)
    first = product(rng, N_STEPS[0], (30, 7), (3, 1), (float, float))
    none = Product.of(
        sparse.bsr_array(first.rows.shape, blocksize=(3, 1)), first.matrix
    )
    for both in ((first, none), (none, first)):
        alone = sum_of_two(*both)
        assert abs(alone - first.formed()).max() <= 1e-12
