"""Ray intersection: the printed example, degenerate rays, truth against claim."""

import numpy as np
import pytest

from einschalt.theory.ray_intersection import (
    distance_from_parallax,
    intersect_rays,
)

CENTIMETRE = 0.01
# what is printed: distances, weights in units of 1e-6, deviations [cm]
DISTANCES = np.array([400.0, 3800.0, 600.0, 5410.0])
WEIGHTS = np.array([6.25, 0.07, 2.80, 0.03])
DEVIATIONS = np.array([0.0, 6.2, 0.0, 8.7])


def rays_to(point, azimuth, distance):
    """Stations from which a point is seen under these azimuths."""
    along = np.stack([np.sin(azimuth), np.cos(azimuth)], axis=1)
    return np.asarray(point) - along * np.asarray(distance)[:, np.newaxis]


def test_printed_distance():
    # ten centesimal seconds; 5411, which is printed rounded to 5410
    angle = 10.0 * np.pi / 2e6
    assert distance_from_parallax(0.085, angle) == pytest.approx(
        6366.2 * 8.5 / 10.0, abs=0.5
    )
    assert distance_from_parallax(0.085, angle) == pytest.approx(5410.0, abs=5.0)


def test_printed_weights():
    # two decimals are printed: (1/600)² = 2.78, printed 2.80, is the one that is
    # rounded to one, and comes 0.02 short
    weights = 1e6 / DISTANCES**2
    np.testing.assert_allclose(weights[[0, 1, 3]], WEIGHTS[[0, 1, 3]], atol=5e-3)
    np.testing.assert_allclose(weights[2], 2.78, atol=5e-3)
    np.testing.assert_allclose(weights[2], WEIGHTS[2], atol=0.05)


@pytest.mark.parametrize("seed", range(20))
def test_printed_deviations_follow_from_the_weights(seed):
    # The directions are not printed. With any, as long as rays 1 and 3 meet well, the
    # normal equations sum(w n e) = 0 leave these two rays less than 0.5 cm ("0 cm")
    # when rays 2 and 4 keep 6.2 and 8.7 cm.
    rng = np.random.default_rng(seed)
    azimuth = rng.uniform(0.0, 2.0 * np.pi, 4)
    azimuth[2] = azimuth[0] + rng.choice([-1, 1]) * rng.uniform(0.9, 2.2)
    right = np.stack([np.cos(azimuth), -np.sin(azimuth)], axis=1)
    pull = right / DISTANCES[:, np.newaxis] ** 2
    far = pull[[1, 3]].T @ DEVIATIONS[[1, 3]]
    deviations = DEVIATIONS.copy()
    deviations[[0, 2]] = np.linalg.solve(pull[[0, 2]].T, -far)
    np.testing.assert_allclose(np.round(deviations[[0, 2]]) + 0.0, 0.0)

    station = rays_to([0.0, 0.0], azimuth, DISTANCES)
    station -= right * deviations[:, np.newaxis] * CENTIMETRE
    found = intersect_rays(station, azimuth, np.array([0, 4]), DISTANCES)
    np.testing.assert_allclose(found.point, 0.0, atol=1e-10)
    np.testing.assert_allclose(found.deviation / CENTIMETRE, deviations, atol=1e-8)


def test_measured_distances_hardly_matter():
    rng = np.random.default_rng(1)
    azimuth = np.array([0.3, 1.9, 2.0, 4.4])
    station = rays_to([0.0, 0.0], azimuth, DISTANCES) + rng.normal(size=(4, 2)) * 0.05
    start = np.array([0, 4])
    rough = intersect_rays(station, azimuth, start, DISTANCES * [1.1, 0.9, 0.95, 1.1])
    iterated = intersect_rays(station, azimuth, start)
    np.testing.assert_allclose(rough.point, iterated.point, atol=0.005)
    np.testing.assert_allclose(iterated.distance, DISTANCES, atol=0.2)
    np.testing.assert_allclose(iterated.weight, iterated.distance**-2)


def test_sign_of_deviations():
    # the second and third rays look north along x = 0 and 2; the point is between
    station = np.array([[-100.0, 50.0], [0.0, 0.0], [2.0, 0.0]])
    found = intersect_rays(station, np.array([np.pi / 2, 0.0, 0.0]), np.array([0, 3]))
    np.testing.assert_allclose(found.point, [[1.0, 50.0]], atol=1e-9)
    np.testing.assert_allclose(found.deviation, [0.0, 1.0, -1.0], atol=1e-9)
    # 2 m of scatter at 50 m: sigma_0² = 2 (1/50)² / (3 - 2)
    np.testing.assert_allclose(found.sigma_0, np.sqrt(2.0 / found.distance[1] ** 2))


def test_minimum_of_the_weighted_squares():
    rng = np.random.default_rng(2)
    azimuth = rng.uniform(0, 2 * np.pi, 6)
    distance = rng.uniform(200, 4000, 6)
    station = rays_to([1.0, 2.0], azimuth, distance) + rng.normal(size=(6, 2))
    found = intersect_rays(station, azimuth, np.array([0, 6]), distance)
    right = np.stack([np.cos(azimuth), -np.sin(azimuth)], axis=1)
    rows = right / distance[:, np.newaxis]
    point, *_ = np.linalg.lstsq(rows, np.sum(rows * station, axis=1))
    np.testing.assert_allclose(found.point[0], point, rtol=1e-9)
    np.testing.assert_allclose(found.cofactor[0], np.linalg.inv(rows.T @ rows))


def test_claimed_covariance_is_the_one_it_has():
    # 20000 points seen from the same five stations with errors of 1 mgon
    rng = np.random.default_rng(3)
    n_points, sigma = 20_000, 1e-3 * np.pi / 200.0
    azimuth = np.array([0.2, 1.4, 2.9, 4.0, 5.5])
    distance = np.array([300.0, 900.0, 500.0, 2500.0, 1200.0])
    station = np.tile(rays_to([0.0, 0.0], azimuth, distance), (n_points, 1))
    measured = np.tile(azimuth, n_points) + rng.normal(scale=sigma, size=5 * n_points)
    found = intersect_rays(station, measured, 5 * np.arange(n_points + 1))
    claimed = found.cofactor.mean(axis=0) * sigma**2
    # a variance of 20000 values is good to 1 %: three times that
    np.testing.assert_allclose(
        np.cov(found.point.T), claimed, rtol=0.03, atol=0.03 * np.trace(claimed)
    )
    np.testing.assert_allclose(np.mean(found.sigma_0**2), sigma**2, rtol=0.03)
    np.testing.assert_allclose(
        found.covariance, found.cofactor * found.sigma_0[:, None, None] ** 2
    )


def test_large_coordinates_lose_nothing():
    azimuth = np.array([0.4, 2.2, 3.9])
    station = rays_to([0.0, 0.0], azimuth, [300.0, 500.0, 800.0])
    start, far = np.array([0, 3]), np.array([4.5e6, 5.3e6])
    near = intersect_rays(station, azimuth, start)
    shifted = intersect_rays(station + far, azimuth, start)
    # 5.3e6 m in double precision has steps of 1e-9 m
    np.testing.assert_allclose(shifted.point - far, near.point, atol=5e-9)
    np.testing.assert_allclose(shifted.cofactor, near.cofactor, rtol=1e-9)


def test_one_point_alone_equals_the_same_among_many():
    rng = np.random.default_rng(4)
    counts = np.array([3, 0, 2, 7, 1, 4])
    start = np.append(0, counts.cumsum())
    station, azimuth = rng.normal(size=(17, 2)) * 500, rng.uniform(0, 6.28, 17)
    together = intersect_rays(station, azimuth, start)
    np.testing.assert_array_equal(together.is_determined, counts >= 2)
    for point, count in enumerate(counts):
        rows = slice(start[point], start[point + 1])
        alone = intersect_rays(station[rows], azimuth[rows], np.array([0, count]))
        # weights are iterated until the slowest point stands still
        np.testing.assert_allclose(
            together.point[point], alone.point[0], rtol=1e-6, atol=1e-5
        )


def test_rays_that_point_away_are_said():
    station = np.array([[0.0, 0.0], [100.0, 0.0], [50.0, -80.0]])
    azimuth = np.radians([45.0, -45.0, 180.0])
    found = intersect_rays(station, azimuth, np.array([0, 3]))
    np.testing.assert_array_equal(found.is_behind, [False, False, True])


@pytest.mark.parametrize(
    ("station", "azimuth"),
    [
        ([[0.0, 0.0]], [0.3]),
        ([[0.0, 0.0], [1.0, 0.0]], [0.3, 0.3]),
        ([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]], [0.3, 0.3 + np.pi, 0.3]),
        ([[0.0, 0.0], [1.0, 0.0]], [0.3, 0.3005]),
        ([[5.0, 5.0], [5.0, 5.0]], [0.3, 1.3]),
    ],
    ids=["one ray", "parallel", "opposite", "nearly parallel", "one station"],
)
def test_hopeless_rays_are_nan(station, azimuth):
    found = intersect_rays(
        np.array(station), np.array(azimuth), np.array([0, len(azimuth)])
    )
    assert not found.is_determined[0]
    assert np.isnan(found.cofactor).all()
    assert np.isnan(found.sigma_0[0])


def test_two_rays_have_no_sigma_0():
    station = np.array([[0.0, 0.0], [300.0, 0.0]])
    found = intersect_rays(station, np.radians([45.0, -45.0]), np.array([0, 2]))
    assert np.isnan(found.sigma_0[0])
    np.testing.assert_allclose(found.deviation, 0.0, atol=1e-12)
    assert np.isfinite(found.cofactor).all()
