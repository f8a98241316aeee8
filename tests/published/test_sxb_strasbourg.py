"""Strasbourg: real photographs against surveyed control and a published bundle.

Source: DBAT (N. Börlin, P. Grussenmeyer), data and results as data_examples/
sxb_strasbourg/README.md says. The published bundle adjustment uses all photographs and
all rays at once; single models on the same measurements cannot be as good, and the
limits below are what models with the bases of this block can keep.
"""

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import einschalt as es
from einschalt.stages.stage2_relative_orientation import image_pairs
from einschalt.stages.stage4_error_propagation import propagate_values

FOLDER = Path(__file__).parents[2] / "data_examples" / "sxb_strasbourg"
README = FOLDER / "README.md"
AXES = ["easting", "northing", "height"]
WITHOUT_CONTROL = {"8811-8936", "8811-9111"}  # two control points each
IN_ONE_IMAGE = "403"
HALF_MM = 0.00051


@pytest.fixture(scope="module")
def block():
    return es.read_block(FOLDER)


@pytest.fixture(scope="module")
def result(block):
    return es.densify(block)


@pytest.fixture(scope="module")
def published():
    table = pd.read_csv(FOLDER / "published_bundle.csv", dtype={"point_id": str})
    return table.set_index("point_id")


def rms(differences):
    return np.sqrt(np.mean(np.square(differences), axis=0))


def against_bundle(result, published, role):
    points = result.points[result.points["role"] == role].set_index("point_id")
    return points[AXES] - published.loc[points.index, AXES]


def rows_of(heading):
    """Rows of the table below a heading of README.md, numbers as numbers."""
    text = README.read_text(encoding="utf-8").split(f"## {heading}\n")[1]
    lines = [line for line in text.split("\n## ")[0].splitlines() if line[:1] == "|"]
    cells = [[c.strip() for c in line.strip("|").split("|")] for line in lines]
    return [row for row in cells if re.fullmatch(r"\d{3}|\d{4}-\d{4}", row[0])]


def numbers(cells):
    return [float(c.replace("−", "-")) if c not in ("", "–") else np.nan for c in cells]


def test_pixels_became_millimetres_from_the_principal_point(block):
    # first and last row of the source's table: column and row, 6 µm pixels
    images = block.low_flight.image_points.set_index(["image_id", "point_id"])
    for key, column, row in (
        (("8811", "317"), 5007.6667, 7275.6667),
        (("8937", "347"), 8197.3333, 11243.6667),
    ):
        expected = (column * 0.006 - 26.577, 38.811 - row * 0.006)
        np.testing.assert_allclose(images.loc[key, ["x", "y"]], expected, atol=6e-7)
    assert len(images) == 1196
    assert images["x"].abs().max() < 26.577
    assert images["y"].abs().max() < 39.165


def test_the_system_that_was_inferred_holds_the_points(block):
    assert block.crs == "EPSG:27561"
    assert block.notes == ()


def test_all_ten_pairs_are_oriented_as_they_are(result):
    oriented = result.orientations.set_index("model_id")
    assert len(oriented) == 10
    assert oriented["is_converged"].all()
    assert oriented["sigma_0"].between(0.0049, 0.0075).all()
    # two directions of flight: half of the pairs are turned by about 180 degrees
    turned = np.degrees(oriented["kappa"].abs()) > 170
    assert turned.sum() == 6
    assert np.degrees(oriented["kappa"].abs()).max() > 177


def test_models_with_two_control_points_fail_and_stop_nothing(result):
    assert set(result.failures["model_id"]) == WITHOUT_CONTROL
    assert result.failures["reason"].str.startswith("2 common points").all()
    usable = result.models[result.models["is_usable"]]
    assert len(usable) == 8
    assert (usable["transformation"] == "helmert_3d").all()


def test_control_against_the_published_bundle(result, published):
    east, north, height = rms(against_bundle(result, published, "control"))
    assert east <= 0.085
    assert north <= 0.085
    assert height <= 0.45


def test_check_points_enter_nothing_and_differ_as_in_the_bundle(result, published):
    points = result.points.set_index("point_id")
    assert set(points.index[points["role"] == "check"]) == {"351", "410"}
    fitted = set(result.residuals["point_id"])
    assert not fitted & {"351", "410"}
    # the bundle misses the given values of 410 by 0.30 m as well
    differences = against_bundle(result, published, "check")
    assert differences[["easting", "northing"]].abs().max().max() <= 0.085


@pytest.mark.slow
def test_one_adjustment_places_all_models_near_the_bundle(block, published):
    """Spatial models with their projection centres, beside a bundle of all rays."""
    found = es.densify(block, es.Settings(method="simultaneous"))
    # two of the models have two control points each: their neighbours hold them
    assert found.models["is_usable"].all()
    assert len(found.models) == 10
    assert set(found.simultaneous.centres["image_id"]) == {
        *("8811", "8936", "8937", "8938", "9111"),
    }
    east, north, height = rms(against_bundle(found, published, "control"))
    # given with 2 cm in each coordinate, and held with that in both
    assert max(east, north, height) < 0.02
    check = against_bundle(found, published, "check")
    assert check[["easting", "northing"]].abs().max().max() < 0.04
    adjusted = found.simultaneous.points.set_index("point_id").loc[check.index]
    away = check["height"] / adjusted["standard_error_height"]
    assert away.abs().max() < 3.0
    assert found.simultaneous.s_0 == pytest.approx(1.0, abs=0.15)
    said = " ".join(found.summary().split())
    assert "two steps: approximate coordinates as they were given" in said
    assert "from the high flight" not in said


def test_leave_one_out_over_the_control(block):
    oriented = es.relative_orientation(block.low_flight)
    given = block.approximate_points
    missed = []
    for point in given["point_id"]:
        kept = given[given["point_id"] != point]
        fit = es.transform_models(oriented.model_points, kept, kind="helmert_3d")
        means = es.average_coverages(fit.values(oriented.model_points)).points
        missed.append(predicted(means, given, point))
    missed = np.array(missed)
    assert len(missed) == 14
    assert np.isnan(missed).all(axis=1).sum() == 1  # 403 lies in one photograph
    east, north, height = np.sqrt(np.nanmean(missed**2, axis=0))
    assert 0.07 <= east <= 0.15
    assert 0.07 <= north <= 0.15
    assert height <= 0.60
    table = np.array([numbers(row[1:4]) for row in rows_of("Leave-one-out")])
    assert [row[0] for row in rows_of("Leave-one-out")] == list(given["point_id"])
    np.testing.assert_allclose(table, missed, rtol=0, atol=HALF_MM)


def predicted(means, given, point):
    found = means.loc[means["point_id"] == point, AXES].to_numpy()
    known = given.loc[given["point_id"] == point, AXES].to_numpy()
    return (found - known)[0] if len(found) else np.full(3, np.nan)


def test_only_the_coverages_show_that_two_kinds_of_points_are_displaced(result):
    # 1.5 pixels of 6 µm in column, which runs north, in photographs of 1:14 400
    values = result.single_values.merge(result.points[["point_id", "role"]])
    of_points = values.groupby(["coverage", "role", "point_id"])[AXES[:2]].mean()
    difference = (of_points.loc["along"] - of_points.loc["across"]).dropna()
    east, north = difference.loc["new"].mean()
    assert len(difference.loc["new"]) == 300
    assert north == pytest.approx(-1.5 * 6e-6 * 14_400, abs=0.02)
    assert abs(east) < 0.01
    assert abs(difference.loc["control", "northing"].mean()) < 0.03


def test_readme_tells_every_point(result, published):
    points = result.points.set_index("point_id")
    rows = rows_of("Points")
    assert {row[0] for row in rows} == set(published.index)
    for name, role, n_models, *differences in rows:
        if name == IN_ONE_IMAGE:
            assert name not in points.index
            continue
        point = points.loc[name]
        assert (role, int(n_models)) == (point["role"], point["n_models"])
        to_given = point[[f"difference_{axis}" for axis in AXES]].tolist()
        to_bundle = (point[AXES] - published.loc[name, AXES]).tolist()
        np.testing.assert_allclose(
            numbers(differences), to_given + to_bundle, rtol=0, atol=HALF_MM
        )


def test_readme_tells_what_the_propagation_claims(result):
    new = result.points[result.points["role"] == "new"]
    total, height = new["standard_error_total"], new["standard_error_height"]
    assert total.median() == pytest.approx(0.12, abs=0.005)
    assert height.median() == pytest.approx(0.60, abs=0.005)
    assert rms(total) == pytest.approx(0.1294, abs=0.0005)
    assert rms(height) == pytest.approx(0.648, abs=0.005)
    values = propagate_values(
        result.examination.error_model,
        result.solution.model_points["low_flight"]["point_id"],
    ).covariance
    is_poor = result.solution.model_points["low_flight"]["model_id"] == "8936-8938"
    poor = np.median(np.diagonal(values[is_poor], axis1=1, axis2=2), axis=0)
    assert np.sqrt(poor[2]) == pytest.approx(25.0, abs=0.5)
    tests = {test.name: test for test in result.claim.tests}
    section = README.read_text(encoding="utf-8").split("## Propagated precision\n")[1]
    rows = re.findall(r"\| (.+?) \| ([\d.]+) cm \| ([\d.]+) cm \| ([\d.]+) \|", section)
    names = {"residuals at the control": "residuals of the low flight"}
    assert len(rows) == 3
    for name, observed, predicted, p_value in rows:
        test = tests[names.get(name, name)]
        found = [100 * test.observed, 100 * test.predicted, test.p_value]
        told = [float(observed), float(predicted), float(p_value)]
        assert (np.abs(np.subtract(told, found)) < [0.051, 0.051, 0.0051]).all()
    assert result.claim.is_supported


@pytest.mark.slow
def test_a_model_on_three_points_in_line_spoils_the_plain_mean_alone(
    block, result, published
):
    plain = es.densify(block, es.Settings(weighting="plain"))
    new = plain.points[plain.points["role"] == "new"]
    assert rms(new["standard_error_total"]) == pytest.approx(0.49, abs=0.005)
    assert rms(new["standard_error_height"]) == pytest.approx(5.0, abs=0.05)
    assert against_bundle(plain, published, "check")["height"].max() > 1.0
    for role, limit in (("control", 0.15), ("check", 0.35)):
        east, north, height = rms(against_bundle(result, published, role))
        assert max(east, north) <= 0.055
        assert height <= limit
    assert result.claim.is_supported


def base_height_ratio(block):
    flight = block.low_flight
    pairs = image_pairs(flight.image_points, flight.models)
    oriented = es.orient_from_images(pairs, flight.principal_distance_mm)
    base = np.linalg.norm(oriented.parameters[["bx", "by", "bz"]], axis=1)
    depth = oriented.model_points.groupby("model_id", sort=False)["z"].mean().abs()
    return (base / depth.loc[oriented.parameters.index]).round(2)


def test_readme_tells_every_pair(block, result):
    ratio = base_height_ratio(block)
    oriented = result.orientations.set_index("model_id")
    models = result.models.set_index("model_id")
    residuals = result.residuals.set_index("model_id")
    rows = rows_of("Pairs")
    assert [row[0] for row in rows] == list(oriented.index)
    for name, coverage, n, sigma_um, b_h, kappa, n_control, *error in rows:
        pair = oriented.loc[name]
        assert coverage == pair["coverage"]
        assert int(n) == pair["n_points"]
        assert int(n_control) == models.loc[name, "n_points"]
        assert float(sigma_um) == pytest.approx(1e3 * pair["sigma_0"], abs=0.0051)
        assert float(b_h) == ratio[name]
        found = np.degrees(pair["kappa"])
        assert numbers([kappa])[0] == pytest.approx(found, abs=0.051)
        if name in WITHOUT_CONTROL:
            continue
        own = residuals.loc[[name], [f"residual_{axis}" for axis in AXES]]
        np.testing.assert_allclose(numbers(error), rms(own), rtol=0, atol=HALF_MM)
