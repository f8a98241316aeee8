"""Pairs from image coordinates alone: the right minimum, and its statistics."""

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from einschalt.foundations.batches import ROWS_WORTH_A_THREAD
from einschalt.foundations.errors import SettingsError
from einschalt.foundations.rotations import (
    rotation_by_vector,
    rotation_from_angles,
)
from einschalt.theory.relative_orientation.coplanarity import (
    BEHIND,
    NOT_CONVERGED,
    ORIENTED,
    TOO_FEW,
    UNDETERMINED,
    orient_pairs,
)
from einschalt.theory.relative_orientation.orientation_elements import (
    orientation_elements,
)

C = 153.0  # mm
SIGMA = 5e-3  # mm
# errors in units of their standard error: 6 is passed by 1 in 10^8
LARGEST_ERROR = 6.0


def angle_of(matrix):
    return Rotation.from_matrix(matrix).magnitude()


def image_of(ground, base, rotation, c=C):
    """Image coordinates, shape (n, 4), of points in the left image system."""
    right = (ground - base) @ rotation.T
    return np.hstack(
        [-c * ground[:, :2] / ground[:, 2:], -c * right[:, :2] / right[:, 2:]]
    )


def one_pair(n_points, seed, noise=SIGMA, relief=0.1):
    rng = np.random.default_rng(seed)
    plan = rng.uniform([-0.1, -0.7], [0.7, 0.7], (n_points, 2))
    height = -1.0 + relief * rng.uniform(-1.0, 1.0, n_points)
    ground = np.column_stack([plan, height])
    rotation = rotation_from_angles(0.05, -0.08, 0.12)
    image = image_of(ground, np.array([0.6, 0.05, -0.03]), rotation)
    return image + rng.normal(scale=noise, size=image.shape)


def orient_one(image, c=C, estimator="rigorous"):
    return orient_pairs(image, np.array([0, len(image)]), c, estimator)


def errors_of(found, base, rotation):
    """Angles between found and true rotation and base [rad]."""
    turn = angle_of(found.rotation @ np.swapaxes(rotation, 1, 2))
    chord = np.linalg.norm(found.base - base, axis=1)
    return turn, chord


# ---------------------------------------------------------------- the right minimum

HUNTS = {
    "near vertical": {"tilt_deg": 3.0},
    "any tilt to 15 degrees": {},
    "eight points": {"n_points": (8, 8)},
    "level ground": {"relief": 0.005},
    "a plane": {"relief": 0.0},
    "mountains": {"relief": 0.4},
    "normal angle": {"principal_distance": 300.0, "relief": 0.05},
    "super-wide angle": {"principal_distance": 88.0},
    "small overlap": {"overlap": (0.25, 0.45), "tilt_deg": 5.0},
    "large overlap": {"overlap": (0.8, 0.95), "tilt_deg": 5.0},
    "convergent": {"convergence_deg": 40.0, "tilt_deg": 5.0},
    "convergent, level": {"convergence_deg": 40.0, "tilt_deg": 5.0, "relief": 0.01},
    "convergent, tilted": {"convergence_deg": 40.0, "relief": 0.3},
    "tilts to 30 degrees": {"tilt_deg": 30.0, "n_points": (8, 20)},
}


@pytest.mark.parametrize("hunt", HUNTS)
def test_truth_is_found_in_every_pair(make_pairs, hunt):
    geometry = make_pairs.geometry(**HUNTS[hunt])
    pairs = make_pairs(100, sum(map(ord, hunt)), geometry)
    found = orient_pairs(pairs.image, pairs.start, pairs.principal_distance)
    assert (found.status == ORIENTED).all()
    np.testing.assert_array_equal(found.n_in_front, found.n_points)
    turn, chord = errors_of(found, pairs.base, pairs.rotation)
    variance = SIGMA**2 * np.diagonal(found.cofactor, axis1=1, axis2=2)
    is_right = (turn**2 < LARGEST_ERROR**2 * variance[:, 3:].sum(axis=1)) & (
        chord**2 < LARGEST_ERROR**2 * variance[:, :3].sum(axis=1)
    )
    # what two photographs of a plane leave open, the pair says itself
    assert (is_right | found.is_ambiguous).all()
    assert is_right.mean() > 0.98
    # never the opposite base
    assert (np.einsum("ni,ni->n", found.base, pairs.base) > 0.0)[is_right].all()
    assert found.is_ambiguous.mean() < 0.05


@pytest.mark.parametrize("kappa_deg", [0, 45, 90, 135, 180, 225, 270, 315])
@pytest.mark.parametrize("azimuth_deg", [0, 60, 120, 180, 240, 300])
def test_flight_lines_may_cross_and_oppose(kappa_deg, azimuth_deg):
    azimuth = np.radians(azimuth_deg)
    base = 0.6 * np.array([np.cos(azimuth), np.sin(azimuth), 0.02])
    rotation = rotation_from_angles(0.04, -0.06, np.radians(kappa_deg))
    rng = np.random.default_rng(kappa_deg)
    plan = 0.5 * base[:2] + rng.uniform(-0.4, 0.4, (9, 2))
    ground = np.column_stack([plan, rng.uniform(-1.1, -0.9, 9)])
    found = orient_one(image_of(ground, base, rotation))
    assert found.is_converged.all()
    turn, chord = errors_of(found, [base / np.linalg.norm(base)], rotation[None])
    assert turn[0] < 1e-12
    assert chord[0] < 1e-12


@pytest.mark.parametrize("seed", range(30))
def test_five_points_are_fitted_and_said_to_be_ambiguous(seed):
    image = one_pair(5, seed)
    found = orient_one(image)
    if found.status[0] == UNDETERMINED:  # two solutions fall together
        return
    assert found.status[0] == ORIENTED
    assert found.n_in_front[0] == 5
    assert found.sum_of_squares[0] < 1e-20
    assert np.isnan(found.sigma_0[0])
    assert found.redundancy[0] == 0
    np.testing.assert_allclose(found.residuals, 0.0, atol=1e-10)
    np.testing.assert_allclose(found.redundancy_numbers, 0.0, atol=1e-8)
    rotation = rotation_from_angles(0.05, -0.08, 0.12)
    sigma = SIGMA * np.sqrt(np.trace(found.cofactor[0, 3:, 3:]))
    is_right = angle_of(found.rotation[0] @ rotation.T) < LARGEST_ERROR * sigma
    assert is_right or found.is_ambiguous[0]


@pytest.mark.slow
def test_six_points_are_right_or_say_that_they_are_not(make_pairs):
    geometry = make_pairs.geometry(n_points=(6, 6), tilt_deg=5.0)
    pairs = make_pairs(500, 6, geometry)
    found = orient_pairs(pairs.image, pairs.start, C)
    turn, _ = errors_of(found, pairs.base, pairs.rotation)
    sigma = SIGMA * np.sqrt(np.trace(found.cofactor[:, 3:, 3:], axis1=1, axis2=2))
    is_right = turn < LARGEST_ERROR * sigma
    # two minima side by side are not always both found
    assert (is_right | found.is_ambiguous | ~found.is_converged).mean() > 0.995
    assert is_right.mean() > 0.99


# ------------------------------------------------------------------- what it equals


def bundle_of(image, c, start):
    """Free bundle adjustment of a pair by scipy: elements, points, all unknowns."""

    def misclosures(unknowns):
        base = np.array([1.0, *unknowns[:2]])
        rotation = rotation_from_angles(*unknowns[2:5])
        return (
            image_of(unknowns[5:].reshape(-1, 3), base, rotation, c) - image
        ).ravel()

    fit = least_squares(
        misclosures, start, method="lm", xtol=1e-15, ftol=1e-15, gtol=1e-15
    )
    return least_squares(
        misclosures, fit.x, jac="3-point", x_scale="jac", xtol=1e-15, ftol=1e-15
    )


@pytest.mark.parametrize(
    ("n_points", "noise"), [(6, 0.005), (7, 0.02), (12, 0.005), (25, 0.05)]
)
def test_equals_the_free_bundle(n_points, noise):
    image = one_pair(n_points, n_points, noise)
    found = orient_one(image)
    elements = orientation_elements(found)
    # start of the points: along the left rays
    depth = np.full(n_points, 1.6)
    points = np.column_stack([image[:, :2] / C, -np.ones(n_points)]) * depth[:, None]
    start = np.concatenate([elements.values[0, 1:] * 1.01, points.ravel()])
    bundle = bundle_of(image, C, start)
    np.testing.assert_allclose(elements.values[0, 1:], bundle.x[:5], atol=1e-7)
    np.testing.assert_allclose(found.residuals, bundle.fun.reshape(-1, 4), atol=1e-7)
    assert found.sum_of_squares[0] == pytest.approx(2.0 * bundle.cost, rel=1e-9)
    normal = bundle.jac.T @ bundle.jac
    cofactor = np.linalg.inv(normal)[:5, :5]
    scale = np.sqrt(np.diag(cofactor))
    np.testing.assert_allclose(
        elements.cofactor[0] / np.outer(scale, scale),
        cofactor / np.outer(scale, scale),
        # the cofactors of the conditions leave out what is of second order in v
        atol=1e-4 + noise / 20.0,
    )


@pytest.mark.parametrize("n_points", [6, 12])
def test_determinants_equal_scipy(n_points):
    image = one_pair(n_points, 3 * n_points, noise=0.02)
    left, right = image[:, :2] / C, image[:, 2:] / C
    down = -np.ones((n_points, 1))

    def determinants(unknowns):
        rays = np.hstack([right, down]) @ rotation_from_angles(*unknowns[2:])
        return np.cross(np.hstack([left, down]), rays) @ [1.0, *unknowns[:2]]

    found = orientation_elements(orient_one(image, estimator="determinants"))
    fit = least_squares(
        determinants,
        found.values[0, 1:] + 1e-3,
        jac="3-point",
        x_scale="jac",
        xtol=1e-15,
        ftol=1e-15,
        gtol=1e-15,
    )
    np.testing.assert_allclose(found.values[0, 1:], fit.x, atol=1e-9)


def test_estimators_agree_without_errors_and_differ_with_them():
    for noise, bounds in ((0.0, (0.0, 1e-12)), (SIGMA, (1e-8, 1e-3))):
        image = one_pair(8, 5, noise)
        rigorous, other = (orient_one(image, estimator=e) for e in ESTIMATORS)
        change = np.abs(rigorous.rotation - other.rotation).max()
        assert bounds[0] <= change <= bounds[1]
        assert other.sum_of_squares[0] >= rigorous.sum_of_squares[0] - 1e-20


ESTIMATORS = ("rigorous", "determinants")


# ----------------------------------------------------------------------- statistics


@pytest.mark.parametrize("estimator", ESTIMATORS)
@pytest.mark.parametrize("n_points", [7, 15])
def test_claimed_precision_is_the_true_one(estimator, n_points):
    n_pairs = 2000
    rng = np.random.default_rng(n_points)
    exact = one_pair(n_points, 77, noise=0.0)
    truth = orient_one(exact, estimator=estimator)
    image = np.tile(exact, (n_pairs, 1))
    image += rng.normal(scale=SIGMA, size=image.shape)
    start = n_points * np.arange(n_pairs + 1)
    found = orient_pairs(image, start, C, estimator)
    assert found.is_converged.all()
    difference = (
        orientation_elements(found).values[:, 1:]
        - orientation_elements(truth).values[:, 1:]
    )
    weight = np.linalg.inv(SIGMA**2 * orientation_elements(found).cofactor)
    squares = np.einsum("ni,nij,nj->n", difference, weight, difference)
    # chi-square with 5 degrees of freedom: its mean within 4 standard errors
    assert squares.mean() == pytest.approx(5.0, abs=4.0 * np.sqrt(10.0 / n_pairs))
    inside = (squares < chi2.ppf(0.95, 5)).mean()
    assert inside == pytest.approx(0.95, abs=4.0 * np.sqrt(0.95 * 0.05 / n_pairs))
    redundancy = n_points - 5
    spread = 4.0 * np.sqrt(2.0 / (redundancy * n_pairs))
    excess = 1.0 if estimator == "rigorous" else 1.2
    mean = (found.sigma_0**2).mean() / SIGMA**2
    assert 1.0 - spread < mean < excess + spread


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_redundancy_numbers_add_up(make_pairs, estimator):
    pairs = make_pairs(50, 4)
    found = orient_pairs(pairs.image, pairs.start, C, estimator)
    total = np.add.reduceat(found.redundancy_numbers, pairs.start[:-1])
    np.testing.assert_allclose(total, found.redundancy, rtol=1e-9)
    assert (found.redundancy_numbers > -1e-9).all()
    assert (found.redundancy_numbers < 1.0).all()


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_corrected_rays_meet(make_pairs, estimator):
    pairs = make_pairs(50, 9)
    found = orient_pairs(pairs.image, pairs.start, C, estimator)
    pair = np.repeat(np.arange(50), found.n_points)
    adjusted = pairs.image + found.residuals
    down = np.full((len(adjusted), 1), -C)
    left = np.hstack([adjusted[:, :2], down]) / C
    right = np.hstack([adjusted[:, 2:], down]) / C
    right = np.einsum("nji,nj->ni", found.rotation[pair], right)
    volume = np.einsum("ni,ni->n", found.base[pair], np.cross(left, right))
    np.testing.assert_allclose(volume, 0.0, atol=1e-14)
    squares = np.add.reduceat((found.residuals**2).sum(axis=1), pairs.start[:-1])
    np.testing.assert_allclose(squares, found.sum_of_squares, rtol=1e-6)


def test_a_gross_error_does_not_spoil_the_choice():
    image = one_pair(14, 21)
    image[4, 3] += 2.0
    found = orient_one(image)
    assert found.is_converged[0]
    assert found.n_in_front[0] == 14
    assert found.sigma_0[0] > 50 * SIGMA
    standardised = np.linalg.norm(found.residuals, axis=1) / np.sqrt(
        found.redundancy_numbers
    )
    assert np.argmax(standardised) == 4


# ------------------------------------------------------------------------ invariances


def test_a_pair_does_not_depend_on_the_batch(make_pairs):
    pairs = make_pairs(40, 12)
    many = orient_pairs(pairs.image, pairs.start, C)
    for k in (0, 7, 39):
        rows = slice(pairs.start[k], pairs.start[k + 1])
        one = orient_one(pairs.image[rows])
        np.testing.assert_array_equal(one.base[0], many.base[k])
        np.testing.assert_array_equal(one.rotation[0], many.rotation[k])
        np.testing.assert_array_equal(one.cofactor[0], many.cofactor[k])
        np.testing.assert_array_equal(one.residuals, many.residuals[rows])


def test_threads_do_not_change_the_result(make_pairs):
    pairs = make_pairs(40, 13)
    times = ROWS_WORTH_A_THREAD // len(pairs.image) + 1
    many = orient_pairs(
        np.tile(pairs.image, (times, 1)),
        np.append(0, np.cumsum(np.tile(np.diff(pairs.start), times))),
        C,
    )
    once = orient_pairs(pairs.image, pairs.start, C)
    np.testing.assert_array_equal(many.rotation, np.tile(once.rotation, (times, 1, 1)))


def test_order_of_points_does_not_matter():
    image = one_pair(15, 8)
    order = np.random.default_rng(0).permutation(15)
    one, other = orient_one(image), orient_one(image[order])
    np.testing.assert_allclose(other.rotation, one.rotation, atol=1e-11)
    np.testing.assert_allclose(other.residuals, one.residuals[order], atol=1e-11)


def test_unit_of_the_image_does_not_matter():
    image = one_pair(10, 8)
    one, other = orient_one(image), orient_one(1000.0 * image, 1000.0 * C)
    np.testing.assert_allclose(other.rotation, one.rotation, atol=1e-13)
    np.testing.assert_allclose(other.sigma_0, 1000.0 * one.sigma_0, rtol=1e-9)
    np.testing.assert_allclose(
        1e6 * other.cofactor, one.cofactor, rtol=1e-7, atol=1e-12
    )


def test_turned_photographs_turn_the_orientation():
    image = one_pair(12, 30)
    turn_left, turn_right = 2.0, -1.2
    one = orient_one(image)
    about_left = rotation_by_vector([0.0, 0.0, turn_left])
    about_right = rotation_by_vector([0.0, 0.0, turn_right])
    turned = np.hstack(
        [image[:, :2] @ about_left[:2, :2].T, image[:, 2:] @ about_right[:2, :2].T]
    )
    other = orient_one(turned)
    np.testing.assert_allclose(other.base[0], about_left @ one.base[0], atol=1e-10)
    np.testing.assert_allclose(
        other.rotation[0], about_right @ one.rotation[0] @ about_left.T, atol=1e-10
    )
    assert other.sum_of_squares[0] == pytest.approx(one.sum_of_squares[0], rel=1e-10)


def test_exchanged_photographs_exchange_the_orientation():
    image = one_pair(12, 31)
    one, other = orient_one(image), orient_one(image[:, [2, 3, 0, 1]])
    np.testing.assert_allclose(other.rotation[0], one.rotation[0].T, atol=1e-10)
    np.testing.assert_allclose(
        other.base[0], -one.rotation[0] @ one.base[0], atol=1e-10
    )
    np.testing.assert_allclose(
        other.residuals, one.residuals[:, [2, 3, 0, 1]], atol=1e-9
    )


def test_two_cameras_keep_their_own_principal_distances():
    rng = np.random.default_rng(14)
    ground = rng.uniform([-0.1, -0.7, -1.1], [0.7, 0.7, -0.9], (12, 3))
    base, rotation = np.array([0.6, 0.0, 0.0]), rotation_from_angles(0.02, 0.03, 0.1)
    image = image_of(ground, base, rotation)
    image[:, 2:] *= 210.0 / C
    found = orient_one(image, c=(C, 210.0))
    assert angle_of(found.rotation[0] @ rotation.T) < 1e-12
    twice = orient_pairs(
        np.vstack([image, image]), [0, 12, 24], [[C, 210.0], [C, 210.0]]
    )
    np.testing.assert_array_equal(twice.rotation[1], found.rotation[0])


# ------------------------------------------------------------------------- failures


def line_of_points(n_points=10):
    along = np.linspace(-0.2, 0.8, n_points)
    return np.column_stack([along, 0.3 + 0.5 * along, -1.0 + 0.1 * along])


DEGENERATE = {
    "points in a line": line_of_points(),
    "one point many times": np.tile([0.3, 0.2, -1.0], (8, 1)),
    "two points many times": np.tile([[0.3, 0.2, -1.0], [0.1, -0.4, -1.0]], (5, 1)),
}


@pytest.mark.parametrize("noise", [0.0, SIGMA, 4 * SIGMA])
@pytest.mark.parametrize("figure", DEGENERATE)
def test_figures_that_determine_nothing_are_rows_not_exceptions(figure, noise):
    rotation = rotation_from_angles(0.02, -0.01, 0.03)
    image = image_of(DEGENERATE[figure], np.array([0.6, 0.02, 0.0]), rotation)
    image += np.random.default_rng(1).normal(scale=noise, size=image.shape)
    good = one_pair(10, 1)
    found = orient_pairs(
        np.vstack([good, image, good]),
        np.cumsum([0, 10, len(image), 10]),
        C,
    )
    assert found.status[[0, 2]].tolist() == [ORIENTED, ORIENTED]
    # with noise there may be a minimum somewhere, which is not reached
    assert found.status[1] in {UNDETERMINED, NOT_CONVERGED}
    assert found.is_converged.tolist() == [True, False, True]
    if found.status[1] == UNDETERMINED:
        assert np.isnan(found.base[1]).all()
        assert np.isnan(found.cofactor[1]).all()
        assert np.isnan(found.residuals[10:-10]).all()
    np.testing.assert_array_equal(found.rotation[0], found.rotation[2])


@pytest.mark.parametrize("noise", [0.0, SIGMA])
def test_without_a_base_there_is_no_orientation(noise):
    rng = np.random.default_rng(4)
    ground = rng.uniform([-0.5, -0.5, -1.1], [0.5, 0.5, -0.9], (15, 3))
    image = image_of(ground, np.zeros(3), rotation_from_angles(0.02, -0.01, 0.03))
    found = orient_one(image + rng.normal(scale=noise, size=image.shape))
    assert found.status[0] in {UNDETERMINED, BEHIND}


def test_points_on_a_cylinder_through_the_base_are_undetermined():
    rng = np.random.default_rng(5)
    around = rng.uniform(-2.5, 2.5, 12)
    ground = np.column_stack(
        [rng.uniform(-0.1, 0.7, 12), 0.5 * np.sin(around), -0.6 - 0.5 * np.cos(around)]
    )
    ground[:, 2] += 0.1
    image = image_of(ground, np.array([0.6, 0.0, 0.0]), np.eye(3))
    assert orient_one(image).status[0] == UNDETERMINED


@pytest.mark.parametrize("n_points", [0, 1, 4])
def test_too_few_points_are_a_status(n_points):
    good = one_pair(10, 2)
    found = orient_pairs(
        np.vstack([good[:n_points], good]), [0, n_points, n_points + 10], C
    )
    assert found.status.tolist() == [TOO_FEW, ORIENTED]
    assert np.isnan(found.sigma_0[0])
    assert found.redundancy.tolist() == [0, 5]


def test_no_pair_gives_no_row():
    found = orient_pairs(np.empty((0, 4)), [0], C)
    assert len(found.base) == len(found.status) == 0


def test_points_of_nothing_do_not_converge_or_lie_behind():
    rng = np.random.default_rng(0)
    image = rng.uniform(-100.0, 100.0, (20 * 30, 4))
    found = orient_pairs(image, 30 * np.arange(21), C)
    is_honest = np.isin(found.status, [NOT_CONVERGED, BEHIND, UNDETERMINED])
    assert (is_honest | (found.sigma_0 > 1.0)).all()


def test_values_that_are_no_numbers_are_undetermined():
    image = one_pair(8, 1)
    image[2, 1] = np.nan
    assert orient_one(image).status[0] == UNDETERMINED


def test_unknown_estimator():
    with pytest.raises(SettingsError, match="estimator = 'best' is unknown; expected"):
        orient_one(one_pair(8, 1), estimator="best")
