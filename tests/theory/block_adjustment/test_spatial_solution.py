"""Blocks of spatial models against scipy's least squares with every unknown."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation
from tests.theory.block_adjustment.independent_errors import without_gross_errors

from einschalt.theory.block_adjustment.block_tests import (
    judge_control,
    judge_observations,
)
from einschalt.theory.block_adjustment.gross_errors import (
    ContradictedModelError,
    downweight,
    examine_control,
)
from einschalt.theory.block_adjustment.spatial_observations import SpatialObservations
from einschalt.theory.block_adjustment.spatial_solution import (
    NoConvergenceError,
    adjust_spatially,
)

NANOMETRE = 1e-9
RELATIVE = 1e-9
GRID = [(700.0 * i, 800.0 * j) for i in range(3) for j in range(3)]
LAYOUTS = {
    "one model": [(0.0, 0.0)],
    "two models": [(0.0, 0.0), (900.0, 0.0)],
    "grid": GRID,
    "strip": [(700.0 * i, 40.0 * (i % 2)) for i in range(6)],
}
CASES = {
    "grid": {},
    "grid, steep tilts": {"tilt": 0.4},
    "grid, correlated control": {"control": "correlated"},
    "grid, control held": {"control": "held"},
    "grid, some known in plan": {"control": "correlated", "in_plan": 3},
    "grid, held in plan": {"control": "held", "in_plan": 3},
    "strip, many known in plan": {"layout": "strip", "every": 2, "in_plan": 2},
    "one model": {"layout": "one model"},
    "two models": {"layout": "two models"},
    "strip": {"layout": "strip"},
    "flat ground": {"relief": 0.0},
}


def a_block(layout="grid", *, seed=0, tilt=0.03, relief=80.0, control="even", **more):
    """Spatial models at 1:8000 in mm, with errors of 3 cm in plan and 5 in height."""
    rng = np.random.default_rng(seed)
    centres = np.array(LAYOUTS[layout])
    low, high = centres.min(axis=0) - 560.0, centres.max(axis=0) + 560.0
    n = more.get("n_points", int(np.prod(high - low) / 300.0**2))
    ground = np.column_stack(
        [rng.uniform(low, high, (n, 2)), rng.uniform(0.0, relief + 1e-9, n)]
    )
    if "valley" in more:  # of this depth, along the middle of the block
        across = (ground[:, 0] - low[0]) / (high - low)[0] - 0.5
        ground[:, 2] += 4.0 * more["valley"] * across**2
    away = np.abs(ground[None, :, :2] - centres[:, None]).max(axis=2)
    model, point = np.nonzero(away < 560.0)
    kept, point = np.unique(point, return_inverse=True)
    ground, n_models = ground[kept], len(centres)
    angles = np.column_stack(
        [rng.normal(0.0, tilt, (n_models, 2)), rng.uniform(-3.0, 3.0, n_models)]
    )
    turned = Rotation.from_euler("xyz", angles)[model].apply(
        ground[point] - np.column_stack([centres, np.full(n_models, 40.0)])[model]
    )
    sigma = np.tile([0.03, 0.03, 0.05], (len(model), 1))
    noise = more.get("noise", 1.0) * sigma * rng.standard_normal(sigma.shape)
    given, covariance = np.full_like(ground, np.nan), np.zeros((len(ground), 3, 3))
    chosen = np.arange(0, len(ground), more.get("every", 4))
    given[chosen] = ground[chosen] + rng.normal(0.0, 0.02, (len(chosen), 3))
    root = rng.standard_normal((len(chosen), 3, 3)) * 0.02
    covariance[chosen] = {
        "even": np.diag([4e-4, 4e-4, 4e-4]),
        "correlated": root @ np.swapaxes(root, 1, 2) + 1e-4 * np.eye(3),
        "held": np.zeros((3, 3)),
    }[control]
    if "in_plan" in more:
        some = chosen[:: more["in_plan"]]
        given[some, 2] = np.nan
        covariance[some, 2], covariance[some, :, 2] = 0.0, 0.0
    origin = np.array(more.get("origin", (0.0, 0.0, 0.0)))
    observations = SpatialObservations(
        model=model,
        point=point,
        xyz=(turned + noise) / 8.0 + [300.0, -120.0, 50.0],
        standard_error=sigma,
        flight=np.zeros(n_models, dtype=np.int64),
        control=given + origin,
        control_covariance=covariance,
    )
    return observations, ground + origin


def turned_by(angles, xyz):
    """R_x(ω) R_y(φ) R_z(κ) xyz, written out; complex angles for exact derivatives."""
    omega, phi, kappa = angles.T
    x, y, z = xyz.T
    x, y = x * np.cos(kappa) - y * np.sin(kappa), x * np.sin(kappa) + y * np.cos(kappa)
    x, z = x * np.cos(phi) + z * np.sin(phi), z * np.cos(phi) - x * np.sin(phi)
    y, z = y * np.cos(omega) - z * np.sin(omega), y * np.sin(omega) + z * np.cos(omega)
    return np.column_stack([x, y, z])


class Dense:
    """Every parameter te, tn, th, scale, ω, φ, κ and every point an unknown.

    Shifts are counted from the centroid of the model, to keep digits. Errors are those
    of the measured coordinates, in the scale and the axes that models have where they
    are ``found``; without that those on the ground.
    """

    def __init__(self, observations, found=None):
        o = self.given = observations
        self.found = None if found is None else found.placement
        self.origin = np.nanmean(o.control, axis=0)
        self.is_free = ~(o.is_fixed[:, None] & np.isfinite(o.control))
        self.n_given = np.isfinite(o.control).sum(axis=1)
        count = np.bincount(o.model)[:, None]
        self.centroid = (
            np.column_stack([np.bincount(o.model, c) for c in o.xyz.T]) / count
        )
        self.xyz = o.xyz - self.centroid[o.model]
        self.observed = np.flatnonzero(o.is_control & ~o.is_fixed)
        self.roots = [
            np.linalg.inv(np.linalg.cholesky(o.control_covariance[k, :d, :d]))
            for k, d in zip(self.observed, self.n_given[self.observed], strict=True)
        ]

    def unpacked(self, x):
        n = self.given.n_models
        points = np.zeros((self.given.n_points, 3), dtype=x.dtype)
        points[~self.is_free] = (self.given.control - self.origin)[~self.is_free]
        points[self.is_free] = x[7 * n :]
        return x[: 7 * n].reshape(n, 7), points

    def residuals(self, x):
        o = self.given
        models, points = self.unpacked(x)
        own = models[o.model]
        turned = own[:, 3:4] * turned_by(own[:, 4:], self.xyz)
        v = own[:, :3] + turned - points[o.point]
        if self.found is not None:
            each = np.eye(3)[:, None] + np.zeros((o.n_models, 1))
            axes = [turned_by(models[:, 4:], axis) for axis in each]
            back = self.found.rotation @ np.stack(axes, axis=1)
            back *= (self.found.scale / models[:, 3])[:, None, None]
            v = np.einsum("nij,nj->ni", back[o.model], v)
        v = v / o.standard_error
        given = (o.control - self.origin)[self.observed]
        control = [
            root @ (points[k] - c)[: len(root)]
            for root, k, c in zip(self.roots, self.observed, given, strict=True)
        ]
        return np.concatenate([v.ravel(), *control])

    def jacobian(self, x):
        columns = []
        for k in range(len(x)):
            z = x.astype(complex)
            z[k] += 1e-30j
            columns.append(self.residuals(z).imag / 1e-30)
        return np.column_stack(columns)

    def solve(self, found):
        """Start away from the solution, and end where Gauss-Newton stands still."""
        models = found.parameters.copy()
        shift = found.parameters[:, :3] - self.origin
        arm = models[:, 3:4] * turned_by(models[:, 4:], self.centroid)
        models[:, :3] = shift + arm
        start = np.concatenate(
            [models.ravel(), (found.points - self.origin)[self.is_free]]
        )
        rng = np.random.default_rng(1)
        size = np.maximum(np.abs(start), 1e-3)
        away = start + 1e-3 * size * rng.standard_normal(len(start))
        x = least_squares(
            self.residuals, away, jac=self.jacobian, x_scale="jac", method="trf"
        ).x
        for _ in range(8):
            x = x - np.linalg.lstsq(self.jacobian(x), self.residuals(x))[0]
        return x


@pytest.mark.parametrize("name", CASES)
def test_equals_scipy_with_every_unknown(name):
    observations, _ = a_block(**CASES[name])
    found = adjust_spatially(observations)
    dense = Dense(observations, found)
    x = dense.solve(found)
    models, points = dense.unpacked(x)
    np.testing.assert_allclose(
        found.points, points + dense.origin, rtol=0, atol=NANOMETRE
    )
    v = dense.residuals(x)
    n_rows = len(observations.xyz)
    own = v[: 3 * n_rows].reshape(-1, 3) * observations.standard_error
    np.testing.assert_allclose(found.residuals, own, rtol=0, atol=NANOMETRE)
    assert found.redundancy == len(v) - len(x)
    assert found.sum_of_squares == pytest.approx(v @ v, rel=RELATIVE)
    np.testing.assert_allclose(found.parameters[:, 3:], models[:, 3:], atol=1e-10)
    jacobian = dense.jacobian(x)
    size = np.linalg.norm(jacobian, axis=0)
    q, r = np.linalg.qr(jacobian / size)
    root = np.linalg.inv(r)
    cofactors = root @ root.T / np.outer(size, size)
    n = 7 * observations.n_models
    expected = np.zeros((*dense.is_free.shape, *dense.is_free.shape))
    free = np.nonzero(dense.is_free)
    expected[(*(f[:, None] for f in free), *free)] = cofactors[n:, n:]
    for p in np.unique(free[0]):
        axes = np.flatnonzero(dense.is_free[p])
        own = np.ix_(axes, axes)
        assert_close(found.point_cofactors[p][own], expected[p, :, p][own])
    is_given = np.isfinite(observations.control)
    held = np.where(dense.is_free, found.points - observations.control, 0.0)
    np.testing.assert_allclose(
        found.control_residuals, np.where(is_given, held, np.nan), atol=NANOMETRE
    )
    for m in range(observations.n_models):
        assert_close(
            found.parameter_cofactors[m][3:, 3:],
            cofactors[7 * m + 3 : 7 * m + 7, 7 * m + 3 : 7 * m + 7],
            1e-8,
        )
    hat = (q**2).sum(axis=1)
    np.testing.assert_allclose(
        found.leverage, hat[: 3 * n_rows].reshape(-1, 3), rtol=1e-8, atol=1e-11
    )


def assert_close(actual, expected, relative=RELATIVE):
    error = np.sqrt(np.diag(expected))
    assert np.abs((actual - expected) / np.outer(error, error)).max() < relative


def test_shifts_have_their_cofactors():
    """Parameters at the origin of the model coordinates, by brute differences."""
    observations, _ = a_block("two models")
    found = adjust_spatially(observations)
    step = np.zeros((2, 7, 7))
    for m in range(2):
        for k in range(7):
            moved = found.parameters[m].astype(complex)
            moved[k] += 1e-30j
            centre = found.placement.centroid[m][None]
            at = moved[:3] + moved[3] * turned_by(moved[None, 4:], centre)[0]
            step[m, :3, k] = at.imag / 1e-30
        step[m, 3:, 3:] = np.eye(4)
    at_centroid = step @ found.parameter_cofactors @ np.swapaxes(step, 1, 2)
    x = Dense(observations, found)
    jacobian = x.jacobian(x.solve(found))
    cofactors = np.linalg.inv(jacobian.T @ jacobian)
    for m in range(2):
        expected = cofactors[7 * m : 7 * m + 7, 7 * m : 7 * m + 7]
        error = np.sqrt(np.diag(expected))
        difference = (at_centroid[m] - expected) / np.outer(error, error)
        assert np.abs(difference).max() < 1e-6


def test_coordinates_far_from_the_origin_lose_nothing():
    far = (5e6, 5.3e6, 4000.0)
    near, distant = (
        adjust_spatially(a_block(origin=origin)[0]) for origin in ((0, 0, 0), far)
    )
    # the given coordinates themselves are rounded to 1e-9 m there
    np.testing.assert_allclose(
        distant.points - far, near.points, rtol=0, atol=8 * np.spacing(5.3e6)
    )
    assert distant.s_0 == pytest.approx(near.s_0, rel=1e-6)


def test_without_noise_the_truth_comes_out():
    observations, truth = a_block(noise=0.0)
    exact = replace(
        observations,
        control=np.where(np.isfinite(observations.control), truth, np.nan),
    )
    found = adjust_spatially(exact)
    np.testing.assert_allclose(found.points, truth, rtol=0, atol=NANOMETRE)
    assert found.s_0 < 1e-8


def test_claimed_covariances_are_those_of_the_errors():
    squares, degrees, factors = 0.0, 0, []
    for seed in range(60):
        observations, truth = a_block(seed=seed)
        found = adjust_spatially(observations)
        error = found.points - truth
        inverse = np.linalg.inv(found.point_cofactors)
        squares += np.einsum("ni,nij,nj->", error, inverse, error)
        degrees += error.size
        factors.append(found.sum_of_squares / found.redundancy)
    # points of one block are correlated and count for less than their number
    assert squares / degrees == pytest.approx(1.0, abs=0.05)
    f = 60 * found.redundancy
    assert np.mean(factors) == pytest.approx(1.0, abs=4.0 * np.sqrt(2.0 / f))


@pytest.fixture
def spoilt():
    """A block with three gross errors of 0.6 m, one of them in height alone."""
    observations, _ = a_block(seed=3, n_points=240)
    holders = np.bincount(observations.point)
    rows = np.flatnonzero(holders[observations.point] >= 3)[[5, 40, 90]]
    xyz = observations.xyz.copy()
    xyz[rows] += [[0.07, 0.0, 0.0], [0.0, 0.05, 0.05], [0.0, 0.0, 0.09]]
    return observations, replace(observations, xyz=xyz), rows


def test_gross_errors_are_found_where_they_are(spoilt):
    _, bad, rows = spoilt
    cleaned = without_gross_errors(adjust_spatially(bad))
    assert list(np.flatnonzero(cleaned.is_out)) == list(np.sort(rows))


@pytest.mark.parametrize("norm", ["huber", "tukey"])
def test_robust_weights_hold_the_points_in_place(spoilt, norm):
    good, bad, _ = spoilt
    truth = adjust_spatially(good).points
    plain = adjust_spatially(bad)
    robust = downweight(without_gross_errors(plain), bad, norm).solution
    worse = np.abs(plain.points - truth).max()
    assert np.abs(robust.points - truth).max() < 0.5 * worse


def test_wrong_control_is_named_with_its_error():
    observations, _ = a_block(seed=2)
    control = observations.control.copy()
    wrong = np.flatnonzero(observations.is_control)[4]
    control[wrong] += [0.0, 0.0, 0.5]
    solution = adjust_spatially(replace(observations, control=control))
    found = examine_control(solution, 0.001)
    assert list(np.flatnonzero(found.is_suspect)) == [wrong]
    # the block knows the point by σ √((1 − r)/r), and itself was given with σ
    r = 1.0 - solution.control_leverage[wrong]
    away = (found.error[wrong] - [0.0, 0.0, 0.5]) / (0.02 / np.sqrt(r))
    assert np.abs(away).max() < 4.0


def test_wrong_control_without_a_height_is_named_with_its_error_in_plan():
    observations, _ = a_block(seed=2, in_plan=2)
    control = observations.control.copy()
    in_plan = observations.is_control & np.isnan(control[:, 2])
    wrong = np.flatnonzero(in_plan)[2]
    control[wrong] += [0.4, 0.0, 0.0]
    solution = adjust_spatially(replace(observations, control=control))
    found = examine_control(solution, 0.001)
    assert list(np.flatnonzero(found.is_suspect)) == [wrong]
    assert np.isnan(found.error[wrong, 2])
    assert np.isnan(solution.control_leverage[wrong, 2])
    r = 1.0 - solution.control_leverage[wrong, :2]
    away = (found.error[wrong, :2] - [0.4, 0.0]) / (0.02 / np.sqrt(r))
    assert np.abs(away).max() < 4.0
    assert found.without.redundancy == solution.redundancy - 2


def test_tests_of_control_without_heights_are_uniform():
    """Those of two coordinates, beside those of three."""
    p = []
    for seed in range(40):
        found = adjust_spatially(a_block(seed=seed, in_plan=2)[0])
        in_plan = found.observations.is_control & np.isnan(
            found.observations.control[:, 2]
        )
        own = judge_control(found).p_value[in_plan]
        p.append(own[np.isfinite(own)][::4])
    assert stats.kstest(np.concatenate(p), "uniform").pvalue > 0.01


def test_p_values_of_good_points_are_uniform():
    p = []
    for seed in range(40):
        found = adjust_spatially(a_block(seed=seed)[0])
        own = judge_observations(found, found.observations).p_value
        p.append(own[np.isfinite(own)][::25])
    assert stats.kstest(np.concatenate(p), "uniform").pvalue > 0.01


def test_steps_that_are_no_numbers_are_no_solution():
    """They are not smaller than any limit, and not larger either."""
    observations, _ = a_block()
    start = adjust_spatially(observations).placement
    xyz = observations.xyz.copy()
    xyz[5, 0] = np.nan
    with pytest.raises(NoConvergenceError, match="the last step was nan m"):
        adjust_spatially(replace(observations, xyz=xyz), start)


@pytest.mark.filterwarnings("error")
def test_a_model_without_measurements_stays_where_it_is():
    """All of them may be taken out as wrong; 0 / 0 was told beside the result."""
    observations, _ = a_block(seed=1)
    whole, all_models = adjust_spatially(observations), np.arange(9)
    rows = np.flatnonzero(observations.model != 0)
    alone = whole.adjusted_anew(observations.of_rows(rows, all_models).observations)
    of_others = observations.of_models(all_models != 0).observations
    expected = adjust_spatially(of_others).parameters
    assert alone.parameters[1:] == pytest.approx(expected, rel=1e-9, abs=1e-6)
    assert alone.parameters[0] == pytest.approx(whole.parameters[0], abs=1e-6)


def with_control_exchanged(observations, apart=1):
    """Two control points under each other's name."""
    control = observations.control.copy()
    known = np.flatnonzero(observations.is_control)
    one, other = known[0], known[apart]
    control[[one, other]] = control[[other, one]]
    return replace(observations, control=control)


def with_a_model_of_chance(observations, seed):
    """Points of the first model anywhere in it, as after a wrong orientation."""
    rng = np.random.default_rng(seed)
    xyz = observations.xyz.copy()
    first = observations.model == 0
    xyz[first] = xyz[first].mean(axis=0) + 60.0 * rng.standard_normal((first.sum(), 3))
    return replace(observations, xyz=xyz)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("spoil", [with_control_exchanged, with_a_model_of_chance])
def test_large_residuals_end_in_a_minimum(seed, spoil):
    """Where no step leads down, and not where linear steps grow."""
    observations = spoil(a_block(seed=seed)[0], seed + 3)
    found, dense = adjust_spatially(observations), Dense(observations)
    models = found.parameters.copy()
    arm = models[:, 3:4] * turned_by(models[:, 4:], dense.centroid)
    models[:, :3] += arm - dense.origin
    points = (found.points - dense.origin)[dense.is_free]
    x = np.concatenate([models.ravel(), points.ravel()])
    v = dense.residuals(x)
    assert v @ v == pytest.approx(found.sum_of_squares, rel=1e-6)
    best = least_squares(dense.residuals, x, jac=dense.jacobian, x_scale="jac")
    # errors are large: what is left to gain is nothing beside their square
    assert found.sum_of_squares - 2.0 * best.cost < 1e-3 * found.s_0**2


@pytest.mark.parametrize("seed", range(3))
def test_a_model_that_contradicts_is_named(seed):
    """Of its measurements, each wrong in its own way, a few would place it."""
    observations, _ = a_block(seed=seed, n_points=240)
    xyz, rng = observations.xyz.copy(), np.random.default_rng(seed)
    wrong = np.flatnonzero(observations.model == 0)
    xyz[wrong] += 0.1 * rng.standard_normal((len(wrong), 3))  # 0.8 m
    solution = adjust_spatially(replace(observations, xyz=xyz))
    with pytest.raises(ContradictedModelError) as refused:
        without_gross_errors(solution)
    assert (refused.value.model, refused.value.n_models) == (0, 9)


@pytest.mark.parametrize("seed", range(3))
def test_a_block_stays_where_its_last_step_led(seed):
    """A linear step from there led away, and the next adjustment began far off."""
    observations = with_a_model_of_chance(a_block(seed=seed)[0], seed + 3)
    found = adjust_spatially(observations)
    again = found.readjusted(observations)
    assert again.sum_of_squares == pytest.approx(found.sum_of_squares, rel=1e-6)
    assert np.abs(again.placement.centre - found.placement.centre).max() < 0.05


def test_much_measured_beside_little_control_makes_a_block_no_smaller():
    """Residuals on the ground shrink with its scale: it was 0.24 : 1000 too small."""
    scale = []
    for seed in range(12):
        observations, truth = a_block(seed=seed, n_points=900, every=120)
        error = np.random.default_rng(seed).standard_normal(truth.shape)  # 1 m
        coarse = observations.is_control[:, None, None] * np.eye(3)
        away = truth[:, :2] - truth[:, :2].mean(axis=0)
        # with the opposite errors what they do to the scale is the opposite, too
        for each in (error, -error):
            control = observations.control + each
            given = {"control": control, "control_covariance": coarse}
            found = adjust_spatially(replace(observations, **given))
            moved = (found.points - truth)[:, :2]
            scale.append(np.sum(away * moved) / np.sum(away**2))
    assert abs(np.mean(scale)) < 2e-5
