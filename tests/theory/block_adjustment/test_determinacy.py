"""What is called determined has no free motion in the dense normal equations."""

import numpy as np
import pytest

from einschalt.theory.block_adjustment import determinacy
from einschalt.theory.block_adjustment.block_solution import adjust
from einschalt.theory.block_adjustment.observations import BlockObservations


def random_block(seed, noise):
    """A handful of models with few points, so that most blocks lack something."""
    rng = np.random.default_rng(seed)
    n_models, n_points = int(rng.integers(2, 7)), int(rng.integers(6, 16))
    ground = rng.uniform(0.0, 1000.0, (n_points, 2))
    if seed % 3 == 0:
        ground[: n_points // 2, 1] = 0.5 * ground[: n_points // 2, 0]
    holds = rng.random((n_models, n_points)) < rng.uniform(0.25, 0.7)
    holds[rng.integers(n_models, size=n_points), np.arange(n_points)] = True
    model, point = np.nonzero(holds)
    models, model = np.unique(model, return_inverse=True)
    is_control = rng.random(n_points) < rng.uniform(0.1, 0.6)
    control = np.where(is_control[:, None], ground, np.nan)
    covariance = np.where(is_control[:, None, None], 4e-4 * np.eye(2), 0.0)
    return BlockObservations(
        model=model,
        point=point,
        xy=ground[point] / 8.0 + noise * rng.normal(0.0, 0.005, (len(point), 2)),
        standard_error=np.full(len(model), 0.04),
        is_affine=rng.random(len(models)) < 0.5,
        flight=np.zeros(len(models), dtype=int),
        control=control,
        control_covariance=covariance,
    )


def moves_freely(observations):
    """Models that a null vector of the full design moves, by singular values."""
    xy, n_points = observations.xy - 60.0, observations.n_points
    n_models = observations.n_models
    rows = []
    for (x, y), m, p in zip(xy, observations.model, observations.point, strict=True):
        east = np.zeros(6 * n_models + 2 * n_points)
        north = east.copy()
        at = 6 * m
        if observations.is_affine[m]:
            east[at : at + 3], north[at + 3 : at + 6] = (x, y, 60), (x, y, 60)
        else:
            east[at : at + 4], north[at : at + 4] = (x, -y, 60, 0), (y, x, 0, 60)
        at = 6 * n_models + 2 * p
        east[at] = north[at + 1] = -60.0
        rows += [east, north]
    for p in np.flatnonzero(observations.is_control):
        at = 6 * n_models + 2 * p
        for k in range(2):
            rows.append(np.eye(1, 6 * n_models + 2 * n_points, at + k)[0] * 60.0)
    design = np.array(rows)
    used = np.abs(design).any(axis=0)
    _, singular, vectors = np.linalg.svd(design[:, used])
    rank = int((singular > 1e-7 * singular[0]).sum())
    free = np.zeros(design.shape[1])
    free[used] = np.abs(vectors[rank:]).max(axis=0, initial=0.0)
    return free[: 6 * n_models].reshape(n_models, 6).max(axis=1) > 1e-6


def determined(observations):
    """Models that stay, as the stage goes about it."""
    fine = determinacy.examine(observations).is_fine
    while fine.any():
        part = observations.of_models(fine)
        loose = determinacy.loose_models(adjust(part.observations))
        if not loose.any():
            break
        fine[part.models[loose]] = False
    return fine


@pytest.mark.parametrize("start", range(0, 240, 40))
@pytest.mark.parametrize("noise", [0.0, 1.0])
def test_what_moves_freely_is_given_up_and_hardly_more(start, noise):
    kept = left = 0
    for seed in range(start, start + 40):
        # without noise the null space is exact
        free = moves_freely(random_block(seed, 0.0))
        fine = determined(random_block(seed, noise))
        assert not (fine & free).any(), seed
        kept += fine.sum()
        left += (~free).sum()
    # what is given up beyond that hangs on models with all their ties in a line, or is
    # as good as free
    assert kept >= 0.95 * left > 0


def verdicts(observations):
    return determinacy.examine(observations)


def test_a_part_without_control_is_found(make_block):
    block = make_block("grid", chosen=np.arange(0, 40, 4))
    # cut the block in two: every point in models 6.. gets a name of its own
    far = block.model >= 6
    point = np.where(far, block.point + block.n_points, block.point)
    points, point = np.unique(point, return_inverse=True)
    is_far = points >= block.n_points
    old = np.where(is_far, points - block.n_points, points)
    control = np.where(is_far[:, None], np.nan, block.control[old])
    covariance = np.where(is_far[:, None, None], 0.0, block.control_covariance[old])
    cut = BlockObservations(
        **{
            **vars(block),
            "point": point,
            "control": control,
            "control_covariance": covariance,
        }
    )
    found = verdicts(cut)
    # the last one has too few points that another model holds
    assert list(found.verdict[6:8]) == [determinacy.NO_CONTROL] * 2
    assert found.is_fine[:6].all()
    assert (found.n_control[6:] == 0).all()
    assert found.part[6] == found.part[7] != found.part[0]


def test_a_model_that_hangs_on_one_point_has_too_few_ties(make_block):
    block = make_block("two models", "helmert", every=100)
    both = np.intersect1d(block.point[block.model == 0], block.point[block.model == 1])
    keep = ~((block.model == 1) & np.isin(block.point, both[1:]))
    first = np.flatnonzero(block.model == 0)[:3]
    control = np.full_like(block.control, np.nan)
    control[block.point[first]] = [[0.0, 0.0], [900.0, 0.0], [0.0, 900.0]]
    covariance = np.where(np.isfinite(control[:, :1, None]), 4e-4 * np.eye(2), 0.0)
    # a point of the second model on its own is no tie: the one common point is all
    hinged = BlockObservations(
        model=block.model[keep],
        point=block.point[keep],
        xy=block.xy[keep],
        standard_error=block.standard_error[keep],
        is_affine=block.is_affine,
        flight=block.flight,
        control=control,
        control_covariance=covariance,
    )
    points, point = np.unique(hinged.point, return_inverse=True)
    hinged = BlockObservations(
        **{
            **vars(hinged),
            "point": point,
            "control": control[points],
            "control_covariance": covariance[points],
        }
    )
    assert list(determined(hinged)) == [True, False]
    assert verdicts(hinged).verdict[1] == determinacy.FEW_TIES
    assert verdicts(hinged).n_ties[1] == 1


@pytest.mark.parametrize("n_common", [1, 2])
def test_parts_that_share_one_point_move_like_a_hinge(n_common):
    """Every model has ties enough; only the solution shows that a part can turn."""
    # two models hold what is held by control, two others hang on the last of it
    held = [range(5), range(5), range(5 - n_common, 9), range(5 - n_common, 9)]
    point = np.concatenate([list(points) for points in held])
    model = np.repeat(np.arange(4), [len(points) for points in held])
    ground = np.random.default_rng(3).uniform(0.0, 900.0, (9, 2))
    is_control = np.arange(9) < 2
    block = BlockObservations(
        model=model,
        point=point,
        xy=ground[point] / 8.0,
        standard_error=np.full(len(model), 0.03),
        is_affine=np.zeros(4, dtype=bool),
        flight=np.zeros(4, dtype=int),
        control=np.where(is_control[:, None], ground, np.nan),
        control_covariance=np.where(is_control[:, None, None], 4e-4 * np.eye(2), 0.0),
    )
    assert verdicts(block).is_fine.all()
    assert list(determined(block)) == [True, True, n_common > 1, n_common > 1]


def test_control_on_a_line_does_not_hold_affine_models(make_block):
    block = make_block("grid", "affine")
    on_line = np.column_stack([np.arange(4) * 300.0, np.arange(4) * 100.0])
    control = np.full_like(block.control, np.nan)
    control[:4] = on_line
    covariance = np.where(np.isfinite(control[:, :1, None]), 4e-4 * np.eye(2), 0.0)
    bad = BlockObservations(
        **{**vars(block), "control": control, "control_covariance": covariance}
    )
    assert (verdicts(bad).verdict == determinacy.CONTROL_ON_LINE).all()
    helmert = BlockObservations(
        **{**vars(bad), "is_affine": np.zeros(block.n_models, dtype=bool)}
    )
    assert verdicts(helmert).is_fine.all()
