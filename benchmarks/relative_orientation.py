"""Relative orientation of image pairs, from table to table and with arrays alone.

``orient_from_images``, and ``orient_pairs`` under it, against scipy's
Levenberg-Marquardt on the coplanarity condition, weighted by its gradient (Sampson),
and against PoseLib's refinement in C++ where it is installed, pair by pair. Both give
the elements and nothing else, and need a start; ours gives covariance, residuals and,
from the table, model coordinates too.
"""

from functools import partial

import numpy as np
import pandas as pd
from scipy.optimize import least_squares

from benchmarks.racing import Contender, one_core, race
from einschalt.foundations.batches import segments
from einschalt.foundations.names import encode
from einschalt.foundations.rotations import rotation_from_angles
from einschalt.stages.relative_orientation.orient_from_images import orient_from_images
from einschalt.theory.relative_orientation.coplanarity import orient_pairs

N_PAIRS, N_LOOP = 10_000, 200
PRINCIPAL_DISTANCE = 153.0  # mm
HALF_BASE, HALF_WIDTH = 46.0, 115.0  # mm in the image: 60 % overlap of 23 cm
NOISE = 5e-3  # mm
TILT = 0.03  # rad
FLOOR = {"orient_from_images": 150, "orient_pairs": 200}
COORDINATES = ["x_left", "y_left", "x_right", "y_right"]
ELEMENTS = ["by", "bz", "omega", "phi", "kappa"]


def run():
    """Run the race.

    Returns
    -------
    bool
        Whether the floors are kept.
    """
    pairs = _generate(N_PAIRS)
    first = list(dict.fromkeys(pairs["model_id"]))[:N_LOOP]
    few = pairs[pairs["model_id"].isin(first)]
    names = segments(encode(pairs["model_id"]).codes, N_PAIRS)
    image = pairs[COORDINATES].to_numpy()[names.order]
    ways = (
        ("orient_from_images", lambda: orient_from_images(pairs, PRINCIPAL_DISTANCE)),
        ("orient_pairs", lambda: orient_pairs(image, names.start, PRINCIPAL_DISTANCE)),
    )
    with one_core():
        _assert_same(orient_from_images(pairs, PRINCIPAL_DISTANCE), few)
        kept = [
            race(
                f"Relative orientation of {N_PAIRS} pairs, {len(pairs)} rows",
                "pair",
                Contender(f"einschalt {name}, one core", ours, N_PAIRS),
                [
                    Contender(
                        "scipy least_squares, Sampson, elements only",
                        lambda: _by_scipy(few),
                        N_LOOP,
                        floor=FLOOR[name],
                    ),
                    *_poselib_contenders(few),
                ],
            )
            for name, ours in ways
        ]
    return all(kept)


def _generate(n_pairs, seed=7):
    """Pairs of 8 to 40 points, relief of a tenth of the flying height."""
    rng = np.random.default_rng(seed)
    counts = rng.integers(8, 41, n_pairs)
    pair = np.repeat(np.arange(n_pairs), counts)
    n = len(pair)
    base = 2.0 * HALF_BASE / PRINCIPAL_DISTANCE  # for a flying height of 1
    xyz = np.column_stack(
        [
            rng.uniform(base - HALF_WIDTH / 153.0, HALF_WIDTH / 153.0, n),
            rng.uniform(-HALF_WIDTH / 153.0, HALF_WIDTH / 153.0, n),
            -rng.uniform(0.9, 1.1, n),
        ]
    )
    angles = rng.normal(0.0, TILT, (n_pairs, 3))
    centre = base * np.column_stack(
        [np.ones(n_pairs), rng.normal(0.0, TILT, (n_pairs, 2))]
    )
    turned = np.einsum(
        "nij,nj->ni", rotation_from_angles(*angles.T)[pair], xyz - centre[pair]
    )
    images = [
        -PRINCIPAL_DISTANCE * rays[:, :2] / rays[:, 2:] + rng.normal(0.0, NOISE, (n, 2))
        for rays in (xyz, turned)
    ]
    table = pd.DataFrame(np.hstack(images), columns=COORDINATES)
    table["model_id"] = [f"{k}/{k + 1}" for k in pair]
    table["point_id"] = [f"P{k}" for k in range(n)]
    return table


def _sampson(elements, left, right):
    """Coplanarity of each point over the length of its gradient [mm]."""
    by, bz, *angles = elements
    matrix = rotation_from_angles(*angles)
    turned = right @ matrix
    base = np.array([1.0, by, bz])
    across_right = np.cross(turned, base)
    condition = np.einsum("ni,ni->n", left, across_right)
    by_right = np.cross(base, left) @ matrix.T
    squares = np.sum(across_right[:, :2] ** 2, axis=1)
    squares += np.sum(by_right[:, :2] ** 2, axis=1)
    return condition / np.sqrt(squares)


def _rays(part):
    distance = np.full(len(part), -PRINCIPAL_DISTANCE)
    return (
        np.column_stack([part["x_left"], part["y_left"], distance]),
        np.column_stack([part["x_right"], part["y_right"], distance]),
    )


def _by_scipy(pairs):
    return {
        model_id: least_squares(_sampson, np.zeros(5), method="lm", args=_rays(part))
        for model_id, part in pairs.groupby("model_id", sort=False)
    }


def _poselib_contenders(few):
    try:
        import poselib  # noqa: PLC0415
    except ImportError:
        print("\nPoseLib is not installed (extra: bench): it does not take part")
        return []
    run = partial(_by_poselib, poselib, few)
    _assert_same_angles(run(), few)
    return [Contender("PoseLib refine_relative_pose, pose only", run, N_LOOP)]


def _by_poselib(poselib, few):
    """Poses of camera systems with y downwards and z ahead, from the normal case."""
    camera = {
        "model": "PINHOLE",
        "width": 460,
        "height": 460,
        "params": [PRINCIPAL_DISTANCE, PRINCIPAL_DISTANCE, 0.0, 0.0],
    }
    options = {"loss_type": "TRIVIAL", "max_iterations": 100, "gradient_tol": 1e-14}
    poses = {}
    for model_id, part in few.groupby("model_id", sort=False):
        start = poselib.CameraPose()
        start.t = np.array([-1.0, 0.0, 0.0])
        left, right = (
            part[[f"x_{side}", f"y_{side}"]].to_numpy() * [1.0, -1.0]
            for side in ("left", "right")
        )
        poses[model_id], _ = poselib.refine_relative_pose(
            left, right, start, camera, camera, options
        )
    return poses


def _assert_same_angles(poses, few):
    ours = orient_from_images(few, PRINCIPAL_DISTANCE)
    flip = np.diag([1.0, -1.0, -1.0])
    for model_id, pose in poses.items():
        angles = ours.parameters.loc[model_id, ["omega", "phi", "kappa"]].to_numpy()
        # axes turned by half a turn about x; their rotation goes from left to right
        turn = flip @ rotation_from_angles(*angles) @ flip
        assert np.abs(turn - pose.R).max() < 1e-6, (model_id, turn - pose.R)


def _assert_same(ours, few):
    for model_id, theirs in _by_scipy(few).items():
        error = np.sqrt(np.diag(ours.covariance(model_id).loc[ELEMENTS, ELEMENTS]))
        off = ours.parameters.loc[model_id, ELEMENTS].to_numpy() - theirs.x
        # Sampson's weights are those of the measured, not of the adjusted rays
        assert np.abs(off / error).max() < 0.01, (model_id, off / error)
        sigma_0 = np.sqrt(2.0 * theirs.cost / (len(theirs.fun) - 5))
        np.testing.assert_allclose(ours.sigma_0[model_id], sigma_0, rtol=1e-3)
