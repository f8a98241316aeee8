"""Relative orientation of image pairs, from table to table and with arrays alone.

``orient_from_images``, and ``orient_pairs`` under it, against scipy's
Levenberg-Marquardt on the coplanarity condition, weighted by its gradient (Sampson),
and against the refinements of PoseLib and pycolmap in C++ where they are installed,
pair by pair. They give the elements and nothing else, and need a start; ours gives
covariance, residuals and, from the table, model coordinates too.

Calls from Python take a part of what PoseLib takes. A loop in C++ would not have them:
so the same calls without any iteration are timed beside it and taken off.
"""

from functools import partial
from statistics import median

import numpy as np
import pandas as pd
from scipy.optimize import least_squares

from benchmarks.racing import (
    ROUNDS,
    Contender,
    Outcome,
    at_least,
    at_most,
    exponent,
    in_unit,
    one_core,
    peer,
    race,
    ratio_of,
    report,
    seconds_of,
)
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
BY_SCIPY = {"orient_from_images": at_least(150), "orient_pairs": at_least(400, 800)}
BY_PYCOLMAP = {"orient_from_images": at_least(12), "orient_pairs": at_least(50)}
LEAST_COMPILED = at_least(1.2, 6)  # times PoseLib without calls from Python
SIZES, MOST_EXPONENT = (1_000, 10_000, 100_000), 1.1
MOST_RMS = 1.005  # of the error of rotation, times that of the best peer
COORDINATES = ["x_left", "y_left", "x_right", "y_right"]
ELEMENTS = ["by", "bz", "omega", "phi", "kappa"]


def run():
    """Race peers, and see how time grows.

    Returns
    -------
    list of Race
    """
    pairs, truth = _generate(N_PAIRS)
    first = list(dict.fromkeys(pairs["model_id"]))[:N_LOOP]
    few = pairs[pairs["model_id"].isin(first)]
    image, start = _arrays(pairs)
    ways = {
        "orient_from_images": lambda: orient_from_images(pairs, PRINCIPAL_DISTANCE),
        "orient_pairs": lambda: orient_pairs(image, start, PRINCIPAL_DISTANCE),
    }
    title = f"Relative orientation of {N_PAIRS} pairs, {len(pairs)} rows"
    with one_core():
        _assert_same(orient_from_images(pairs, PRINCIPAL_DISTANCE), few)
        races = [
            race(
                title,
                "pair",
                Contender(f"einschalt {name}, one core", ours, N_PAIRS),
                [
                    Contender(
                        "scipy least_squares, Sampson, elements only",
                        lambda: _by_scipy(few),
                        N_LOOP,
                        BY_SCIPY[name],
                    ),
                    *_poselib_contenders(few),
                    *_pycolmap_contenders(few, BY_PYCOLMAP[name]),
                ],
            )
            for name, ours in ways.items()
        ]
        races += _against_compiled(ways["orient_pairs"], few, truth)
        return [*races, _growth()]


def _arrays(pairs):
    """Image coordinates sorted by pair, and where each pair begins."""
    n_pairs = pairs["model_id"].nunique()
    names = segments(encode(pairs["model_id"]).codes, n_pairs)
    return pairs[COORDINATES].to_numpy()[names.order], names.start


def _against_compiled(ours, few, truth):
    """PoseLib without what its calls take, and how good both are."""
    poselib = peer("poselib")
    if poselib is None:
        return []
    mine, theirs, calls = [], [], []
    pairs = _prepared(few)
    for _ in range(ROUNDS):
        mine.append(seconds_of(ours) / N_PAIRS)
        theirs.append(seconds_of(lambda: _refined(poselib, pairs)) / N_LOOP)
        calls.append(seconds_of(lambda: _refined(poselib, pairs, 0)) / N_LOOP)
    refined = [a - b for a, b in zip(theirs, calls, strict=True)]
    solved = orient_from_images(few, PRINCIPAL_DISTANCE).parameters
    our_error = _rms_of_rotations(_rotations(solved), truth)
    their_error = _rms_of_rotations(_turns(_by_poselib(poselib, few)), truth)
    return [
        report(
            f"Relative orientation in one compiled loop (unit = pair, {ROUNDS} rounds)",
            [
                Outcome("einschalt orient_pairs, one core", in_unit(median(mine)), 1.0),
                Outcome(
                    "PoseLib refine, arrays prepared",
                    in_unit(median(theirs)),
                    ratio_of(theirs, mine),
                ),
                Outcome(
                    "the same, less its calls without iterations",
                    in_unit(median(refined)),
                    ratio_of(refined, mine),
                    LEAST_COMPILED,
                ),
                Outcome(
                    "RMS error of rotations, times PoseLib's",
                    f"{1e6 * our_error:.1f} µrad",
                    our_error / their_error,
                    at_most(MOST_RMS),
                ),
            ],
        )
    ]


def _growth():
    seconds = {}
    for size in SIZES:
        image, start = _arrays(_generate(size)[0])
        run = partial(orient_pairs, image, start, PRINCIPAL_DISTANCE)
        run()
        seconds[size] = seconds_of(run)
    rows = [
        Outcome(
            f"{size} pairs",
            in_unit(seconds[size]),
            exponent((seconds[SIZES[0]], seconds[size]), (SIZES[0], size)),
            at_most(MOST_EXPONENT) if size == SIZES[-1] else None,
        )
        for size in SIZES[1:]
    ]
    return report("Relative orientation, one core: exponent of time", rows, seconds)


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
    names = [f"{k}/{k + 1}" for k in range(n_pairs)]
    return table, dict(zip(names, rotation_from_angles(*angles.T), strict=True))


def _rotations(parameters):
    angles = parameters[["omega", "phi", "kappa"]].to_numpy()
    return dict(zip(parameters.index, rotation_from_angles(*angles.T), strict=True))


def _rms_of_rotations(found, truth):
    """Root mean square of the angles between rotations and the true ones [rad]."""
    away = [np.trace(truth[name].T @ matrix) for name, matrix in found.items()]
    angles = np.arccos(np.clip((np.array(away) - 1.0) / 2.0, -1.0, 1.0))
    return float(np.sqrt(np.mean(angles**2)))


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
    poselib = peer("poselib")
    if poselib is None:
        return []
    run = partial(_by_poselib, poselib, few)
    _assert_same_angles(run(), few)
    return [Contender("PoseLib refine_relative_pose, pose only", run, N_LOOP)]


def _pycolmap_contenders(few, bound):
    pycolmap = peer("pycolmap")
    if pycolmap is None:
        return []
    run = partial(_by_pycolmap, pycolmap, few)
    run()
    name = "pycolmap refine_relative_pose, pose only"
    return [Contender(name, run, N_LOOP, bound)]


def _by_pycolmap(pycolmap, few):
    """From the normal case, with rays of length 1 in axes of computer vision."""
    poses = {}
    for model_id, part in few.groupby("model_id", sort=False):
        left, right = (
            rays * [1.0, -1.0, -1.0] / np.linalg.norm(rays, axis=1, keepdims=True)
            for rays in _rays(part)
        )
        start = pycolmap.Rigid3d(pycolmap.Rotation3d(), np.array([-1.0, 0.0, 0.0]))
        mask = np.ones(len(left), dtype=bool)
        poses[model_id] = pycolmap.refine_relative_pose(start, left, right, mask)
    return poses


def _by_poselib(poselib, few, most_iterations=100):
    """Poses of camera systems with y downwards and z ahead, from the normal case."""
    return _refined(poselib, _prepared(few), most_iterations)


def _prepared(few):
    """Image coordinates of each pair, as PoseLib takes them."""
    return {
        model_id: tuple(
            part[[f"x_{side}", f"y_{side}"]].to_numpy() * [1.0, -1.0]
            for side in ("left", "right")
        )
        for model_id, part in few.groupby("model_id", sort=False)
    }


def _refined(poselib, pairs, most_iterations=100):
    camera = {
        "model": "PINHOLE",
        "width": 460,
        "height": 460,
        "params": [PRINCIPAL_DISTANCE, PRINCIPAL_DISTANCE, 0.0, 0.0],
    }
    options = {
        "loss_type": "TRIVIAL",
        "max_iterations": most_iterations,
        "gradient_tol": 1e-14,
    }
    poses = {}
    for model_id, (left, right) in pairs.items():
        start = poselib.CameraPose()
        start.t = np.array([-1.0, 0.0, 0.0])
        poses[model_id], _ = poselib.refine_relative_pose(
            left, right, start, camera, camera, options
        )
    return poses


def _turns(poses):
    """Rotations as ours, from axes turned by half a turn about x."""
    flip = np.diag([1.0, -1.0, -1.0])
    return {name: flip @ pose.R @ flip for name, pose in poses.items()}


def _assert_same_angles(poses, few):
    ours = _rotations(orient_from_images(few, PRINCIPAL_DISTANCE).parameters)
    for model_id, turn in _turns(poses).items():
        off = np.abs(ours[model_id] - turn).max()
        assert off < 1e-6, (model_id, off)


def _assert_same(ours, few):
    for model_id, theirs in _by_scipy(few).items():
        error = np.sqrt(np.diag(ours.covariance(model_id).loc[ELEMENTS, ELEMENTS]))
        off = ours.parameters.loc[model_id, ELEMENTS].to_numpy() - theirs.x
        # Sampson's weights are those of the measured, not of the adjusted rays
        assert np.abs(off / error).max() < 0.01, (model_id, off / error)
        sigma_0 = np.sqrt(2.0 * theirs.cost / (len(theirs.fun) - 5))
        np.testing.assert_allclose(ours.sigma_0[model_id], sigma_0, rtol=1e-3)
