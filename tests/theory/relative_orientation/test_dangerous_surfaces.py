"""Verdicts: against dense algebra, valleys, surfaces, hopeless figures of points."""

import numpy as np
import pytest

from einschalt.theory.relative_orientation.dangerous_surfaces import (
    examine_surfaces,
    flat_twin,
    gaps_to_surface,
    middle_depth,
    singular_values,
)
from einschalt.theory.relative_orientation.hallert import (
    adjust_parallaxes,
    flat_six_points,
)
from einschalt.theory.relative_orientation.parallax_equations import (
    CASES,
    INDEPENDENT,
    design_matrix,
    element_scale,
)

BASE, HALF_WIDTH, DEPTH = 92.0, 100.0, 152.0


def examine_one(xyz, base=BASE, **options):
    return examine_surfaces(xyz, np.array([base]), np.array([0, len(xyz)]), **options)


def hilly_points(n_points, seed):
    rng = np.random.default_rng(seed)
    return rng.uniform([-5, -95, -190], [97, 95, -110], size=(n_points, 3))


def valley(relative_depth):
    """Six standard points, the wings seen under 100/152."""
    xyz = flat_six_points(HALF_WIDTH, BASE, DEPTH)
    wings = [1, 2, 4, 5]
    xyz[wings, 1:] *= 1.0 - relative_depth
    return xyz


def on_surface(coefficients, n_points, seed, base=BASE):
    """Points of an orthogonal ruled quadric, below the base."""
    rng = np.random.default_rng(seed)
    x = rng.uniform(0.0, base, n_points)
    ray = np.stack([rng.uniform(-0.65, 0.65, n_points), -np.ones(n_points)], axis=1)
    w, phi_1, phi_2, kappa_1, kappa_2 = coefficients
    ruled = x * (ray @ [phi_1, kappa_1]) - (x - base) * (ray @ [phi_2, kappa_2])
    reach = ruled / (w * np.sum(ray**2, axis=1))
    return np.column_stack([x, ray * reach[:, np.newaxis]])


SURFACES = {
    "cylinder": (1.0, 0.0, 0.0, -1.739, -1.739),
    "tilted_cylinder": (1.0, 0.15, 0.15, -1.793, -1.793),
    "cone_like": (1.0, 0.0, 0.0, -1.9, -1.5),
    "hyperboloid": (1.0, 0.1, -0.2, -1.739, -1.630),
}


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("n_points", [5, 6, 9, 40])
def test_equals_dense_algebra(case, n_points):
    xyz = hilly_points(n_points, seed=n_points)
    found = examine_one(xyz, case=case)
    cofactors = [
        np.linalg.inv(design.T @ design)
        for design in (
            design_matrix(points, BASE, case)
            for points in (xyz, flat_twin(xyz, found.depth[0]))
        )
    ]
    sigma_omega, flat = (np.sqrt(cofactor[0, 0]) for cofactor in cofactors)
    np.testing.assert_allclose(found.sigma_omega, sigma_omega, rtol=1e-7)
    np.testing.assert_allclose(found.inflation, sigma_omega / flat, rtol=1e-7)
    scale = element_scale(found.depth, case)[0]
    design = design_matrix(xyz, BASE, case) / scale / np.sqrt(n_points)
    values = np.linalg.svd(design, compute_uv=False)
    np.testing.assert_allclose(found.singular_value[0], values[-1], rtol=1e-10)
    start = np.array([0, n_points])
    np.testing.assert_allclose(
        singular_values(xyz, np.array([BASE]), start, found.depth, case)[0],
        values,
        rtol=1e-10,
    )


@pytest.mark.parametrize("case", CASES)
def test_sigma_omega_is_that_of_the_adjustment(case):
    xyz = hilly_points(12, seed=1)
    start = np.array([0, 12])
    adjusted = adjust_parallaxes(xyz, np.zeros(12), np.array([BASE]), start, case=case)
    np.testing.assert_allclose(
        examine_one(xyz, case=case).sigma_omega[0],
        np.sqrt(adjusted.cofactor[0, 0, 0]),
        rtol=1e-9,
    )


def test_verdict_does_not_depend_on_the_elements():
    # singular values do, though: 0.064 against 0.124 for the flat wide-angle layout
    xyz = np.concatenate([valley(0.2), hilly_points(9, seed=2)])
    start, base = np.array([0, 6, 15]), np.full(2, BASE)
    found = [examine_surfaces(xyz, base, start, case=case) for case in CASES]
    for other in found[1:]:
        np.testing.assert_allclose(other.inflation, found[0].inflation, rtol=1e-9)
        np.testing.assert_array_equal(other.verdict.level, found[0].verdict.level)
        ratio = other.flat_singular_value / found[0].flat_singular_value
        assert ratio[0] > 1.5


@pytest.mark.parametrize("relative_depth", np.arange(-0.4, 0.5, 0.05))
def test_inflation_in_a_valley(relative_depth):
    critical = HALF_WIDTH**2 / (HALF_WIDTH**2 + DEPTH**2)
    found = examine_one(valley(relative_depth))
    np.testing.assert_allclose(
        found.inflation, 1.0 / abs(1.0 - relative_depth / critical), rtol=1e-7
    )
    np.testing.assert_allclose(found.planes.gap[0], found.planes.gap[0, 0])
    np.testing.assert_allclose(
        found.planes.over_correction_n[0],
        (1.0 - relative_depth) / (2.0 * (critical - relative_depth)),
        rtol=1e-9,
    )


@pytest.mark.parametrize(
    ("part_of_critical", "verdict"),
    [
        (-1.0, "safe"),
        (0.0, "safe"),
        (0.499, "safe"),
        (0.5, "weak"),
        (0.899, "weak"),
        (0.9, "critical"),
        (1.0, "critical"),
        (1.1, "critical"),
        (1.101, "weak"),
        (1.5, "weak"),
        (1.501, "safe"),
    ],
)
def test_thresholds_at_half_and_nine_tenths_of_the_critical_depth(
    part_of_critical, verdict
):
    critical = HALF_WIDTH**2 / (HALF_WIDTH**2 + DEPTH**2)
    found = examine_one(valley(part_of_critical * critical))
    assert found.verdict.names[0] == verdict
    assert (found.verdict.reasons[0] == "") == (verdict == "safe")


def test_one_dangerous_plane_alone_is_harmless():
    # Krames' formulas divide by the N of this plane; least squares does not need it
    critical = HALF_WIDTH**2 / (HALF_WIDTH**2 + DEPTH**2)
    xyz = flat_six_points(HALF_WIDTH, BASE, DEPTH)
    xyz[:3] = valley(critical)[:3]
    found = examine_one(xyz)
    size = DEPTH**4
    assert abs(found.planes.determinant[0, 0]) < 1e-12 * size
    assert found.planes.determinant[0, 1] > 0.1 * size
    np.testing.assert_allclose(found.inflation, np.sqrt(2.0), rtol=1e-9)
    assert found.verdict.names[0] == "safe"
    assert found.better_plane[0] == 1
    np.testing.assert_allclose(
        found.sigma_omega[0], found.planes.sigma_omega[0, 1], rtol=1e-9
    )


def test_weights_of_both_planes_add_up_to_least_squares():
    rng = np.random.default_rng(7)
    xyz = np.tile(flat_six_points(HALF_WIDTH, BASE, DEPTH), (100, 1))
    xyz[:, 1:] += rng.uniform(-20, 20, size=(600, 2))
    found = examine_surfaces(xyz, np.full(100, BASE), 6 * np.arange(101))
    np.testing.assert_allclose(
        found.sigma_omega**-2, found.planes.weight.sum(axis=1), rtol=1e-9
    )


@pytest.mark.parametrize("name", SURFACES)
@pytest.mark.parametrize("case", CASES)
def test_points_of_a_dangerous_surface_give_its_coefficients(name, case):
    coefficients = np.array(SURFACES[name])
    xyz = on_surface(coefficients, 14, seed=8)
    found = examine_one(xyz, case=case)
    assert found.verdict.names[0] == "critical"
    assert "on a dangerous surface" in found.verdict.reasons[0]
    assert found.singular_value[0] < 1e-14
    assert found.singular_value_ratio[0] < 1e-12
    assert found.inflation[0] > 1e10
    surface = found.surface[0]
    np.testing.assert_allclose(surface / surface[0], coefficients, atol=1e-10)
    np.testing.assert_allclose(gaps_to_surface(xyz, BASE, surface), 0.0, atol=1e-12)
    # and it is a correction that leaves no parallax
    np.testing.assert_allclose(
        design_matrix(xyz, BASE, INDEPENDENT) @ surface, 0.0, atol=1e-11
    )


def test_every_base_normal_plane_cuts_a_circle_through_the_base():
    rng = np.random.default_rng(9)
    for x in rng.uniform(-20.0, 110.0, 20):
        slope = rng.uniform(-0.6, 0.6, 4)
        points = on_surface(SURFACES["hyperboloid"], 4, seed=10)
        points[:, 0] = x
        w, phi_1, phi_2, kappa_1, kappa_2 = SURFACES["hyperboloid"]
        ray = np.stack([slope, -np.ones(4)], axis=1)
        ruled = x * (ray @ [phi_1, kappa_1]) - (x - BASE) * (ray @ [phi_2, kappa_2])
        yz = ray * (ruled / (w * np.sum(ray**2, axis=1)))[:, np.newaxis]
        rows = np.column_stack([yz, np.sum(yz**2, axis=1)])
        values = np.linalg.svd(rows / np.abs(rows).max(axis=0), compute_uv=False)
        assert values[-1] < 1e-14


@pytest.mark.parametrize("rise", [0.02, 0.1])
def test_terrain_near_a_surface_is_weak_or_critical(rise):
    xyz = on_surface(SURFACES["cylinder"], 30, seed=11)
    xyz[:10, 1:] *= 1.0 - rise
    found = examine_one(xyz)
    assert found.verdict.names[0] == ("critical" if rise < 0.05 else "weak")
    assert "near a dangerous surface" in found.verdict.reasons[0]
    gaps = gaps_to_surface(xyz, BASE, found.surface[0])
    assert 0.0 < np.abs(gaps).max() < 3.0 * rise


def test_inflation_is_what_an_adjustment_suffers():
    # 4000 adjustments with random errors, in a valley and on its flat twin
    rng = np.random.default_rng(12)
    n_runs = 4000
    start, base = 6 * np.arange(n_runs + 1), np.full(n_runs, BASE)
    errors = rng.normal(scale=1e-5, size=6 * n_runs)
    spread = [
        adjust_parallaxes(
            np.tile(valley(depth), (n_runs, 1)), errors, base, start, case=INDEPENDENT
        )
        .elements[:, 0]
        .std()
        for depth in (0.25, 0.0)
    ]
    # a standard deviation of 4000 runs is good to 1.1 %, the same errors drive both
    np.testing.assert_allclose(
        spread[0] / spread[1], examine_one(valley(0.25)).inflation[0], rtol=0.02
    )


def test_errors_that_grow_with_depth_weigh_high_points_more():
    # in images the sides of a valley, being nearer, have the smaller parallax errors
    xyz = valley(0.2)
    weight = DEPTH / -xyz[:, 2]
    design = design_matrix(xyz, BASE, INDEPENDENT) * weight[:, np.newaxis]
    sigma = np.sqrt(np.linalg.inv(design.T @ design)[0, 0])
    found = examine_one(xyz, grows_with_depth=True)
    np.testing.assert_allclose(found.sigma_omega, sigma, rtol=1e-9)
    assert found.inflation[0] < examine_one(xyz).inflation[0]


@pytest.mark.parametrize("unit", [1e-3, 1.0, 1e6])
def test_unit_and_number_of_models_do_not_matter(unit):
    counts = np.array([6, 0, 9, 5, 4, 30])
    xyz = hilly_points(counts.sum(), seed=13)
    start = np.append(0, counts.cumsum())
    base = np.linspace(80.0, 100.0, len(counts))
    together = examine_surfaces(xyz * unit, base * unit, start)
    for model, count in enumerate(counts):
        alone = examine_one(xyz[start[model] : start[model + 1]], base=base[model])
        np.testing.assert_allclose(
            together.inflation[model], alone.inflation[0], rtol=1e-9
        )
        np.testing.assert_allclose(
            together.singular_value[model], alone.singular_value[0], rtol=1e-9
        )
        assert together.verdict.names[model] == alone.verdict.names[0]
        assert ("five are needed" in alone.verdict.reasons[0]) == (count < 5)


def test_depth_is_that_of_the_middle():
    start = np.array([0, 6])
    np.testing.assert_allclose(middle_depth(valley(0.3), start), DEPTH)
    only_wings = valley(0.3)[[1, 2, 4, 5]]
    np.testing.assert_allclose(middle_depth(only_wings, np.array([0, 4])), 0.7 * DEPTH)


def test_flat_twin_differs_in_the_column_of_omega_alone():
    xyz = hilly_points(9, seed=15)
    twin = flat_twin(xyz, DEPTH)
    np.testing.assert_allclose(twin[:, 2], -DEPTH)
    own, flat = (design_matrix(points, BASE, INDEPENDENT) for points in (xyz, twin))
    np.testing.assert_allclose(own[:, 1:], flat[:, 1:], rtol=1e-14)
    assert (np.abs(own[:, 0] / flat[:, 0] - 1.0) > 1e-3).all()


LINE = np.linspace(-1.0, 1.0, 5)[:, np.newaxis]
FLAT = flat_six_points(HALF_WIDTH, BASE, DEPTH)
HOPELESS = {
    "nothing": (np.empty((0, 3)), BASE, "0 points, but five are needed"),
    "four points": (FLAT[:4], BASE, "4 points, but five are needed"),
    "a line": (
        np.array([46.0, 0.0, -DEPTH]) + LINE * [46.0, 90.0, 10.0],
        BASE,
        "on a line or close together",
    ),
    "the base line": (
        np.array([46.0, 0.0, -DEPTH]) + LINE * [46.0, 0.0, 0.0],
        BASE,
        "on a line or close together",
    ),
    "a plumb line": (
        np.array([46.0, 0.0, -DEPTH]) + LINE * [0.0, 0.0, 20.0],
        BASE,
        "on a line or close together",
    ),
    "identical points": (FLAT[[2] * 8], BASE, "on a line or close together"),
    "two places": (FLAT[[1, 2, 1, 2, 1, 2]], BASE, "on a line or close together"),
    "hardly any base": (FLAT, 1e-9, "its base is less than a hundredth of its depth"),
    "no base": (FLAT, 0.0, "it has no base"),
    "base in mm": (FLAT / 1e3, BASE, "its base is more than ten times its depth"),
    "negative base": (FLAT, -92.0, "it has no base"),
    "missing base": (FLAT, np.nan, "it has no base"),
    "behind": (FLAT * [1.0, 1.0, -1.0], BASE, "at or above the projection centres"),
    "one behind": (
        np.vstack([FLAT, [46.0, 0.0, 0.0]]),
        BASE,
        "at or above the projection centres",
    ),
    "no coordinates": (FLAT * np.nan, BASE, "a point has no coordinates"),
}


@pytest.mark.parametrize("name", HOPELESS)
def test_hopeless_models_have_a_verdict_and_a_reason(name):
    xyz, base, reason = HOPELESS[name]
    found = examine_one(xyz, base=base)
    assert found.verdict.names[0] == "critical"
    assert reason in found.verdict.reasons[0]


def test_hopeless_models_do_not_touch_the_others():
    counts = [len(xyz) for xyz, *_ in HOPELESS.values()]
    xyz = np.concatenate([FLAT, *(xyz for xyz, *_ in HOPELESS.values()), FLAT])
    base = np.array([BASE, *(base for _, base, _ in HOPELESS.values()), BASE])
    found = examine_surfaces(xyz, base, np.cumsum([0, 6, *counts, 6]))
    assert (found.verdict.names[1:-1] == "critical").all()
    assert found.verdict.names[[0, -1]].tolist() == ["safe", "safe"]
    np.testing.assert_allclose(found.inflation[[0, -1]], 1.0)
    np.testing.assert_allclose(found.planes.over_correction_n[[0, -1]], 1.6552)


def test_measured_lines_are_not_taken_for_good_figures():
    # 5 µm in 150 mm make a line a little crooked
    rng = np.random.default_rng(14)
    line = np.array([46.0, 0.0, -DEPTH]) + LINE.repeat(4, axis=0) * [46.0, 90.0, 10.0]
    found = examine_one(line + rng.normal(scale=0.005, size=line.shape))
    assert found.verdict.names[0] == "critical"
    found = examine_one(line + rng.normal(scale=0.1, size=line.shape))
    assert found.verdict.names[0] == "weak"
    assert "nearly on a line" in found.verdict.reasons[0]


def test_only_relief_saves_points_on_two_lines_along_the_base():
    xyz = np.array([[x, y, -DEPTH] for x in (0.0, 46.0, 92.0) for y in (-90.0, 90.0)])
    assert "on a line" in examine_one(xyz).verdict.reasons[0]
    xyz[::3, 1:] *= 0.8
    found = examine_one(xyz)
    assert found.verdict.names[0] == "weak"
    assert "only its relief" in found.verdict.reasons[0]
