"""Errors in the design matrix move a block; against the mean of simulated blocks."""

from dataclasses import replace

import numpy as np
import pytest

from einschalt.theory.block_adjustment.block_solution import adjust
from einschalt.theory.block_adjustment.errors_in_variables import displacement_by_design
from einschalt.theory.block_adjustment.observations import BlockObservations

N_MODELS, ALONG, ACROSS = 40, 5, 5
SPACING, SCALE, ERROR = 100.0, 8000.0, 0.2


def strip(is_affine):
    """True model coordinates of a strip, with exact control at its beginning."""
    columns = 2 * N_MODELS + ALONG
    truth = np.stack(np.mgrid[:columns, :ACROSS], axis=-1).reshape(-1, 2) * SPACING
    first = 2 * ACROSS * np.arange(N_MODELS)
    point = (first[:, None] + np.arange(ALONG * ACROSS)).ravel()
    used = np.unique(point)
    truth = truth[used]
    is_control = truth[:, 0] < 2 * SPACING
    return truth, BlockObservations(
        model=np.repeat(np.arange(N_MODELS), ALONG * ACROSS),
        point=point,
        xy=truth[point] / SCALE,
        standard_error=np.full(len(point), ERROR),
        flight=np.zeros(N_MODELS, dtype=np.int64),
        is_affine=np.full(N_MODELS, is_affine),
        control=np.where(is_control[:, None], truth, np.nan),
        control_covariance=np.tile(np.eye(2) * 0.01**2, (len(truth), 1, 1)),
    )


@pytest.mark.parametrize("is_affine", [True, False])
def test_it_is_what_blocks_are_displaced_by_in_the_mean(is_affine):
    """Of a strip that hangs on its beginning; ε and −ε halve what there is to average.

    The measured coordinates are true but for errors that are drawn; the mean error of
    the end is compared with the mean of what is said block by block.
    """
    truth, exact = strip(is_affine)
    rng = np.random.default_rng(3)
    errors, said = [], []
    for _ in range(30):
        e = rng.normal(0.0, ERROR / SCALE, exact.xy.shape)
        pair = [adjust(replace(exact, xy=exact.xy + k * e), ()) for k in (1, -1)]
        errors.append(np.mean([s.points[-3] for s in pair], axis=0) - truth[-3])
        said.append(displacement_by_design(pair[0])[-3])
    mean, scatter = np.mean(errors, axis=0), np.std(errors, axis=0) / np.sqrt(30)
    assert mean[0] < -0.5  # it becomes shorter
    found = np.mean(said, axis=0)
    assert np.abs(found - mean)[0] < 0.05 * abs(mean[0]) + 4.0 * scatter[0]
    assert abs(found[1]) < 0.2 * abs(mean[0])


def test_with_control_at_both_ends_there_is_next_to_nothing():
    truth, exact = strip(is_affine=True)
    is_control = exact.is_control | (truth[:, 0] > truth[:, 0].max() - 2 * SPACING)
    held = replace(exact, control=np.where(is_control[:, None], truth, np.nan))
    rng = np.random.default_rng(4)
    measured = held.xy + rng.normal(0.0, ERROR / SCALE, held.xy.shape)
    solution = adjust(replace(held, xy=measured), ())
    moved = displacement_by_design(solution)
    claimed = np.sqrt(solution.point_cofactors[:, 0, 0].max())
    assert np.abs(moved).max() < 0.1 * claimed
