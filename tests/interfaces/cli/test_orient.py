"""``einschalt orient``: parallaxes, image pairs, and terrain before the flight."""

from xml.etree import ElementTree as ET

import numpy as np
import pandas as pd
import pytest

from einschalt.interfaces.files.camera_toml import read_camera
from einschalt.stages.relative_orientation.orient_from_images import orient_from_images
from einschalt.stages.relative_orientation.orient_from_parallaxes import (
    orient_from_parallaxes,
)

BASE, DEPTH, DISTANCE = 92.0, 152.0, 153.0
OF_PARALLAXES = {
    *("models", "parameters", "cofactors", "residuals", "contradiction"),
    *("dangerous_surface", "failures"),
}
OF_IMAGES = OF_PARALLAXES - {"contradiction"} | {"model_points", "model_precision"}


def write(frame, path):
    frame.to_csv(path, index=False)
    return path


def six_points(relative_depth):
    x, side = np.array([(x, s) for s in (0.0, 1.0, -1.0) for x in (0.0, BASE)]).T
    z = -DEPTH * (1.0 - relative_depth * np.abs(side))
    return np.column_stack([x, -z * side * 100.0 / 152.0, z])


@pytest.fixture
def parallaxes(tmp_path):
    """A flat model, a valley, and one with four points."""
    rng = np.random.default_rng(1)
    tables = [
        pd.DataFrame(xyz, columns=["x", "y", "z"]).assign(
            model_id=name,
            point_id=list("123456")[: len(xyz)],
            y_parallax=rng.normal(scale=0.005, size=len(xyz)),
        )
        for name, xyz in (
            ("7/8", six_points(0.0)),
            ("0012", six_points(0.25)),
            ("9/10", six_points(0.0)[:4]),
        )
    ]
    return write(pd.concat(tables), tmp_path / "parallaxes.csv")


@pytest.fixture
def image_pairs(tmp_path):
    """Two vertical pairs of 20 points with 5 µm."""
    rng = np.random.default_rng(2)
    tables = []
    for name in ("1/2", "2/3"):
        xyz = rng.uniform([0, -95, -165], [BASE, 95, -140], size=(20, 3))
        rays = (xyz, xyz - [BASE, 0.0, 0.0])
        image = np.hstack([-DISTANCE * ray[:, :2] / ray[:, 2:] for ray in rays])
        image += rng.normal(scale=0.005, size=image.shape)
        columns = ["x_left", "y_left", "x_right", "y_right"]
        table = pd.DataFrame(image, columns=columns)
        tables.append(table.assign(model_id=name, point_id=np.arange(20).astype(str)))
    return write(pd.concat(tables), tmp_path / "pairs.csv")


@pytest.fixture
def terrain(tmp_path):
    """A plain, a valley and a peak above the flight."""
    heights = [[600] * 6, [600, 600, *[900] * 4], [600, 600, 3000, 600, 600, 600]]
    table = pd.DataFrame(heights, columns=[f"h{n}" for n in range(1, 7)])
    return write(table.assign(model_id=["7/8", "0012", "p"]), tmp_path / "terrain.csv")


def read(folder, name):
    names = {"model_id": str, "point_id": str}
    return pd.read_csv(folder / f"{name}.csv", dtype=names)


def assert_tables(folder, names):
    assert {path.stem for path in folder.glob("*.csv")} == names
    for name in names:
        table = pd.read_parquet(folder / f"{name}.parquet")
        assert len(table) == len(read(folder, name))
        assert list(table.columns) == list(read(folder, name).columns)


def assert_figure(folder, models):
    root = ET.parse(folder / "residual_parallaxes.svg").getroot()
    said = {"".join(node.itertext()) for node in root.iter() if node.text}
    assert set(models) <= said


def assert_same(read_back, computed, rtol):
    # whole numbers and names are read back as other types
    loose = {"check_dtype": False, "check_index_type": False}
    pd.testing.assert_frame_equal(read_back, computed, rtol=rtol, **loose)


def test_parallaxes(invoke, parallaxes, tmp_path):
    out = tmp_path / "out"
    shown = invoke("orient", parallaxes, "--base", 92, "--output", out)
    assert shown.exit_code == 0
    assert shown.stderr == ""
    assert_tables(out, OF_PARALLAXES)
    assert_figure(out, ["7/8", "0012"])
    assert "2 of 3 models oriented" in shown.stdout
    assert "model 0012, weak: its points lie near a dangerous" in shown.stdout
    assert f"Results in {out}" in shown.stdout
    assert shown.stdout.startswith((out / "summary.txt").read_text("utf-8"))
    given = pd.read_csv(parallaxes, dtype={"model_id": str, "point_id": str})
    expected = orient_from_parallaxes(given, BASE)
    parameters = read(out, "parameters").set_index("model_id")
    assert_same(parameters, expected.parameters, rtol=1e-14)
    cofactors = read(out, "cofactors")
    assert "coverage" not in cofactors
    first = cofactors[cofactors["model_id"] == "7/8"].set_index("element")
    np.testing.assert_allclose(
        first.drop(columns="model_id"), expected.cofactor("7/8"), rtol=1e-14
    )
    surfaces = read(out, "dangerous_surface").set_index("model_id")
    assert surfaces["verdict"].tolist() == ["safe", "weak", "critical"]
    assert read(out, "failures")["model_id"].tolist() == ["9/10"]
    contradiction = read(out, "contradiction").set_index("model_id")
    np.testing.assert_allclose(contradiction["w"], expected.contradiction["w"])


@pytest.mark.parametrize("method", ["least_squares", "krames", "gruber"])
@pytest.mark.parametrize("case", ["independent", "dependent_left", "dependent_right"])
def test_method_and_case_are_passed_on(invoke, parallaxes, tmp_path, method, case):
    options = ["--base", 92, "--method", method, "--case", case]
    shown = invoke("orient", parallaxes, *options, "--output", tmp_path / "out")
    assert shown.exit_code == 0
    given = pd.read_csv(parallaxes, dtype={"model_id": str, "point_id": str})
    expected = orient_from_parallaxes(given, BASE, case=case, method=method)
    parameters = read(tmp_path / "out", "parameters").set_index("model_id")
    assert_same(parameters, expected.parameters, rtol=1e-12)


def test_bases_can_come_from_a_table(invoke, parallaxes, tmp_path):
    bases = pd.DataFrame({"model_id": ["7/8", "9/10"], "base": [92.0, 92.0]})
    file = write(bases, tmp_path / "models.csv")
    shown = invoke("orient", parallaxes, "--base", file, "-o", tmp_path / "out")
    assert shown.exit_code == 0
    failures = read(tmp_path / "out", "failures").set_index("model_id")["reason"]
    assert failures["0012"] == "its base is missing"
    surfaces = read(tmp_path / "out", "dangerous_surface").set_index("model_id")
    assert surfaces.loc["0012", "reason"] == "it has no base"


def test_coverages_are_kept_apart(invoke, parallaxes, tmp_path):
    given = pd.read_csv(parallaxes).query("model_id == '7/8'")
    both = pd.concat([given.assign(coverage=name) for name in ("north", "south")])
    write(both, parallaxes)
    out = tmp_path / "out"
    assert invoke("orient", parallaxes, "--base", 92, "-o", out).exit_code == 0
    for name in OF_PARALLAXES - {"failures"}:
        assert set(read(out, name)["coverage"]) == {"north", "south"}
    assert_figure(out, ["north: 7/8", "south: 7/8"])


def test_a_table_without_models_is_one_model_and_that_is_said(
    invoke, parallaxes, tmp_path
):
    given = pd.read_csv(parallaxes).query("model_id == '7/8'")
    write(given.drop(columns="model_id"), parallaxes)
    shown = invoke("orient", parallaxes, "--base", 92, "-o", tmp_path / "out")
    assert shown.exit_code == 0
    assert "parallaxes.csv has no column model_id: it is one model" in shown.stderr
    assert read(tmp_path / "out", "parameters")["model_id"].tolist() == ["1"]


def test_a_name_of_models_that_was_mistaken_is_said(invoke, parallaxes, tmp_path):
    given = pd.read_csv(parallaxes)
    out = tmp_path / "out"
    write(given.rename(columns={"model_id": "Modl_id"}), parallaxes)
    shown = invoke("orient", parallaxes, "--base", BASE, "--output", out)
    assert shown.exit_code == 2
    assert "Rename 'Modl_id' to 'model_id'" in shown.stderr
    # points of the same name are points of several models
    write(given.drop(columns="model_id"), parallaxes)
    shown = invoke("orient", parallaxes, "--base", BASE, "--output", out)
    assert shown.exit_code == 2
    assert "column 'model_id' is missing" in shown.stderr
    assert "repeats" not in shown.stderr


def test_images(invoke, image_pairs, tmp_path):
    out = tmp_path / "out"
    options = ["--principal-distance", DISTANCE, "--base", BASE]
    shown = invoke("orient", image_pairs, *options, "--output", out)
    assert shown.exit_code == 0
    assert_tables(out, OF_IMAGES)
    assert_figure(out, ["1/2", "2/3"])
    assert "Relative orientation of 2 of 2 models" in shown.stdout
    given = pd.read_csv(image_pairs, dtype={"model_id": str, "point_id": str})
    expected = orient_from_images(given, DISTANCE, base_length=BASE)
    parameters = read(out, "parameters").set_index("model_id")
    assert_same(parameters, expected.parameters, rtol=1e-9)
    assert (read(out, "dangerous_surface")["verdict"] == "safe").all()
    points = read(out, "model_points")
    np.testing.assert_allclose(points["z"], expected.model_points["z"], rtol=1e-9)


@pytest.mark.slow
def test_six_point_models_come_with_the_construction_of_krames(
    invoke, parallaxes, tmp_path
):
    out = tmp_path / "out"
    given = pd.read_csv(parallaxes, dtype={"model_id": str})
    write(given.replace("7/8", "older"), parallaxes)
    assert invoke("orient", parallaxes, "--base", 92, "-o", out).exit_code == 0
    assert (out / "krames_older.svg").exists()
    write(given, parallaxes)
    assert invoke("orient", parallaxes, "--base", 92, "-o", out).exit_code == 0
    drawn = {path.name for path in out.glob("krames_*.svg")}
    assert drawn == {"krames_7-8.svg", "krames_0012.svg"}
    for name in drawn:
        assert ET.parse(out / name).getroot().tag.endswith("svg")


CAMERA = """\
convention = "metashape"
f = 12750
width = 20_000
height = 20_000
k1 = -0.01
pixel_size_um = 12
"""


def test_images_in_pixels_of_a_camera(invoke, image_pairs, tmp_path):
    file = tmp_path / "camera.toml"
    file.write_text(CAMERA, encoding="utf-8")
    pairs, camera = pd.read_csv(image_pairs), read_camera(file)
    for names in (["x_left", "y_left"], ["x_right", "y_right"]):
        pairs[names] = camera.measured_from_xy(pairs[names].to_numpy())
    pixels = write(pairs, tmp_path / "pixels.csv")
    in_mm, out = tmp_path / "mm", tmp_path / "out"
    assert invoke("orient", pixels, "--camera", file, "-o", out).exit_code == 0
    shown = invoke("orient", image_pairs, "--principal-distance", 153, "-o", in_mm)
    assert shown.exit_code == 0
    found, wanted = (pd.read_csv(folder / "parameters.csv") for folder in (out, in_mm))
    np.testing.assert_allclose(found.iloc[:, 1:], wanted.iloc[:, 1:], atol=1e-9)


def test_outliers_of_images_can_be_taken_out(invoke, image_pairs, tmp_path):
    pairs = pd.read_csv(image_pairs)
    pairs.loc[4, "y_right"] += 0.5
    spoilt, out = write(pairs, tmp_path / "spoilt.csv"), tmp_path / "out"
    call = (spoilt, "--principal-distance", 153, "--outliers", "snoop", "-o", out)
    shown = invoke("orient", *call)
    assert shown.exit_code == 0
    assert "They were taken out" in " ".join(shown.stdout.split())
    residuals = pd.read_csv(out / "residuals.csv")
    assert residuals.index[residuals["is_suspect"]].tolist() == [4]
    assert residuals["weight"].isna().sum() == 1


def test_terrain(invoke, terrain, tmp_path):
    out = tmp_path / "out"
    options = ["--principal-distance", 152, "--flying-height", 1000]
    shown = invoke("orient", "--terrain", terrain, *options, "--output", out)
    assert shown.exit_code == 0
    assert_tables(out, {"dangerous_surface"})
    surfaces = read(out, "dangerous_surface").set_index("model_id")
    assert surfaces["verdict"].tolist() == ["safe", "critical", "critical"]
    np.testing.assert_allclose(
        surfaces.loc["0012", "inflation"], 1 / (1 - 0.3 * (1 + 1.52**2)), rtol=1e-7
    )
    assert "3 models: 2 critical, 1 safe" in shown.stdout
    assert "Fly 1990 m above the valley" in shown.stdout
    assert "terrain reaches the flying height" in shown.stdout


def test_terrain_by_scale_altitude_format_and_wing(invoke, terrain, tmp_path):
    def inflation(*options):
        call = ["--terrain", terrain, "--principal-distance", 152, *options]
        assert invoke("orient", *call, "-o", tmp_path / "out").exit_code == 0
        surfaces = read(tmp_path / "out", "dangerous_surface").set_index("model_id")
        return surfaces.loc["0012", "inflation"]

    height = inflation("--flying-height", 1216)
    np.testing.assert_allclose(inflation("--scale-number", 8000), height, rtol=1e-9)
    np.testing.assert_allclose(inflation("--altitude", 1816), height, rtol=1e-9)
    narrow = inflation("--altitude", 1816, "--wing", 70)
    assert narrow == pytest.approx(inflation("--altitude", 1816, "--image-format", 170))
    assert narrow != pytest.approx(height)
    overlap = inflation("--altitude", 1816, "--forward-overlap", 0.8)
    assert overlap == pytest.approx(height)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("{parallaxes}", "--base is missing; expected a TABLE of y-parallaxes"),
        ("--base 92", "TABLE is missing"),
        ("--principal-distance 153", "TABLE is missing"),
        ("--terrain {terrain}", "--principal-distance is missing"),
        ("{parallaxes} --terrain {terrain}", "TABLE is given beside --terrain"),
        (
            "{parallaxes} --base 92 --estimator rigorous",
            "--estimator is given beside --base",
        ),
        (
            "{parallaxes} --base 92 --scale-number 8000",
            "--scale-number is given beside --base",
        ),
        (
            "{pairs} --principal-distance 153 --method gruber",
            "--method is given beside --principal-distance",
        ),
        ("{parallaxes} --base -92", "--base = -92; expected a positive length"),
        ("{parallaxes} --base none.csv", "none.csv: the file does not exist"),
        ("{parallaxes} --base many", "many: the suffix is missing"),
        (
            "{pairs} --principal-distance 153 --base none.csv",
            "--base = 'none.csv'; expected the length of the base",
        ),
        (
            "{pairs} --base 92",
            "pairs.csv holds image coordinates; expected a TABLE of y-parallaxes",
        ),
        (
            "{pairs} --principal-distance 153 --camera c.toml",
            "--camera is given beside --principal-distance",
        ),
        ("{pairs} --camera c.toml", "c.toml: the file does not exist"),
        (
            "{parallaxes} --base 92 --outliers snoop",
            "--outliers is given beside --base",
        ),
        (
            "{parallaxes} --principal-distance 153",
            "parallaxes.csv holds y-parallaxes; expected a TABLE of y-parallaxes",
        ),
        ("{parallaxes} --base .", "--base: '.' is not a number; expected millimetres"),
        ("{parallaxes} --base 9/2", "'9/2' is not a number; expected millimetres, or"),
        ("{pairs} --principal-distance 0.153", "Did you give metres?"),
        ("nowhere.csv --base 92", "nowhere.csv: the file does not exist"),
        ("--terrain {terrain} --principal-distance 152", "no flying height is given"),
        (
            "--terrain {terrain} --principal-distance 15200 --altitude 2000",
            "--principal-distance = 15.2; expected metres between 0.001 and 5. Did",
        ),
        (
            "--terrain {terrain} --principal-distance 0.152 --altitude 2000",
            "--principal-distance = 0.000152; expected metres between 0.001 and 5.",
        ),
        (
            "--terrain {parallaxes} --principal-distance 152 --altitude 2000",
            "parallaxes.csv holds y-parallaxes; expected a TABLE of y-parallaxes",
        ),
        (
            "--terrain {wrong} --principal-distance 152 --altitude 2000",
            "wrong.csv, row 1: column 'h1' is missing",
        ),
    ],
)
def test_wrong_input_has_status_2_and_no_traceback(
    arguments, message, invoke, request, tmp_path
):
    files = {
        "{parallaxes}": request.getfixturevalue("parallaxes"),
        "{pairs}": request.getfixturevalue("image_pairs"),
        "{terrain}": request.getfixturevalue("terrain"),
        "{wrong}": write(pd.DataFrame({"model_id": [1]}), tmp_path / "wrong.csv"),
    }
    call = [files.get(argument, argument) for argument in arguments.split()]
    shown = invoke("orient", *call, "--output", tmp_path / "out")
    assert shown.exit_code == 2
    assert shown.stderr.startswith("einschalt: ")
    assert message in shown.stderr
    assert "Traceback" not in shown.stderr
    assert not (tmp_path / "out").exists()


def test_wrong_values_name_file_row_and_point(invoke, parallaxes, tmp_path):
    text = parallaxes.read_text(encoding="utf-8").split("\n")
    row = text[3].split(",")
    text[3] = ",".join([*row[:-1], "n/a"])
    parallaxes.write_text("\n".join(text), encoding="utf-8")
    shown = invoke("orient", parallaxes, "--base", 92, "-o", tmp_path / "out")
    assert shown.exit_code == 2
    assert (
        "parallaxes.csv, row 4, point 3, model 7/8: y_parallax 'n/a' is not a number"
        in shown.stderr
    )


def test_nothing_to_orient_has_status_2_and_still_says_why(
    invoke, parallaxes, tmp_path
):
    out = tmp_path / "out"
    assert invoke("orient", parallaxes, "--base", 92, "-o", out).exit_code == 0
    assert (out / "residual_parallaxes.svg").exists()
    given = pd.read_csv(parallaxes).query("model_id == '9/10'")
    write(given, parallaxes)
    shown = invoke("orient", parallaxes, "--base", 92, "-o", out)
    assert shown.exit_code == 2
    assert "no model could be oriented" in shown.stderr
    assert read(out, "failures")["reason"].tolist() == ["4 points, but five are needed"]
    assert not (out / "residual_parallaxes.svg").exists()


def test_no_name_of_a_model_steers_the_terminal(invoke, parallaxes, tmp_path):
    table = pd.read_csv(parallaxes, dtype=str)
    steering = {"9/10": "\u202e9/10", "7/8": "\x1b[2J7/8"}
    write(table.replace({"model_id": steering}), parallaxes)
    done = invoke("orient", parallaxes, "--base", BASE, "--output", tmp_path / "out")
    assert done.exit_code == 0
    assert "model \\u202e9/10: 4 points, but five are needed" in done.stdout
    assert not any(sign in done.stdout for sign in "\u202e\x1b")


@pytest.mark.slow
def test_parquet_is_read_as_csv_is(invoke, parallaxes, tmp_path):
    given = pd.read_csv(parallaxes, dtype={"model_id": str, "point_id": str})
    given.to_parquet(tmp_path / "parallaxes.parquet")
    for suffix in ("csv", "parquet"):
        file = tmp_path / f"parallaxes.{suffix}"
        assert (
            invoke("orient", file, "--base", 92, "-o", tmp_path / suffix).exit_code == 0
        )
    one, other = (
        (tmp_path / suffix / "parameters.csv").read_text()
        for suffix in ("csv", "parquet")
    )
    assert one == other


def test_a_base_with_a_decimal_comma_is_said(invoke, parallaxes, tmp_path):
    done = invoke("orient", parallaxes, "--base", "92,5", "-o", tmp_path / "out")
    assert done.exit_code == 2
    assert "--base: '92,5' has a decimal comma" in done.stderr
    assert "Write 92.5" in done.stderr


def test_hopeless_pairs_are_rows_with_verdict_and_reason(invoke, image_pairs, tmp_path):
    good = pd.read_csv(image_pairs).query("model_id == '1/2'")
    left, right = ["x_left", "y_left"], ["x_right", "y_right"]
    along = np.linspace(-1.0, 1.0, 5)[:, None] * [40.0, 80.0]
    on_line = good.iloc[:5].assign(
        x_left=46.0 + along[:, 0], y_left=along[:, 1],
        x_right=along[:, 0] - 46.0, y_right=along[:, 1],
    )  # fmt: skip
    exchanged = good.rename(columns=dict(zip(left + right, right + left, strict=True)))
    rng = np.random.default_rng(4)
    pairs = {
        "on a line": on_line,
        "one place": good.assign(x_left=1.0, y_left=1.0, x_right=2.0, y_right=2.0),
        "no base": good.assign(x_right=good["x_left"], y_right=good["y_left"]),
        "one mirrored": good.assign(x_right=-good["x_right"]),
        "no pair": good.assign(
            **dict(zip(left + right, rng.uniform(-90, 90, (4, 20)), strict=True))
        ),
        "four points": good.iloc[:4],
    }
    doubtful = {
        "exchanged": exchanged,
        "both mirrored": good.assign(x_left=-good["x_left"], x_right=-good["x_right"]),
    }
    tables = [t.assign(model_id=name) for name, t in {**pairs, **doubtful}.items()]
    file = write(pd.concat([good, *tables])[good.columns], tmp_path / "all.csv")
    out = tmp_path / "out"
    done = invoke("orient", file, "--principal-distance", DISTANCE, "-o", out)
    assert done.exit_code == 0
    failures = read(out, "failures")
    assert set(failures["model_id"]) == set(pairs)
    assert failures[["reason", "remedy"]].notna().all(axis=None)
    surfaces = read(out, "dangerous_surface").set_index("model_id")
    assert (surfaces.loc[list(pairs), "verdict"] == "critical").all()
    assert surfaces.loc[list(pairs), "reason"].notna().all()
    said = " ".join(done.stdout.split())
    assert "model exchanged, both mirrored: the base points against x" in said


@pytest.mark.parametrize("method", ["least_squares", "krames", "gruber"])
def test_hopeless_models_are_rows_with_verdict_and_reason(invoke, tmp_path, method):
    flat = pd.DataFrame(six_points(0.0), columns=["x", "y", "z"])
    flat = flat.assign(point_id=list("123456"), y_parallax=[1, 0, 2, -1, 0, 1])
    flat["y_parallax"] *= 0.005
    # on the circle through the left centre, and the same through the right one
    on_cylinder = -DEPTH / 2.0 * (1.0 + np.sqrt(1.0 - (2.0 * 70.0 / DEPTH) ** 2))
    hopeless = {
        "on a line": flat.assign(y=0.0, z=-DEPTH),
        "one place": flat.assign(x=3.0, y=4.0),
        "on a cylinder": flat.assign(
            y=0.7 * flat["y"], z=np.where(flat["y"] == 0.0, -DEPTH, on_cylinder)
        ),
        "behind": flat.assign(z=-flat["z"]),
        "no base": flat,
        "base in metres": flat,
        "four points": flat.iloc[:4],
    }
    bases = {"no base": 1e-9, "base in metres": BASE / 1000.0}
    tables = [t.assign(model_id=name) for name, t in hopeless.items()]
    tables.append(flat.assign(model_id="good"))
    file = write(pd.concat(tables), tmp_path / "all.csv")
    base = [{"model_id": n, "base": bases.get(n, BASE)} for n in [*hopeless, "good"]]
    base = write(pd.DataFrame(base), tmp_path / "bases.csv")
    out = tmp_path / "out"
    shown = invoke("orient", file, "--base", base, "--method", method, "-o", out)
    assert shown.exit_code == 0
    failures = read(out, "failures")
    assert set(failures["model_id"]) == set(hopeless)
    assert failures[["reason", "remedy"]].notna().all(axis=None)
    surfaces = read(out, "dangerous_surface").set_index("model_id")
    # a base of 0.1 mm is one to the theory, however it was meant
    lost = [name for name in hopeless if name != "base in metres"]
    assert (surfaces.loc[lost, "verdict"] == "critical").all()
    assert surfaces.loc[lost, "reason"].notna().all()
    assert surfaces.loc["good", "verdict"] == "safe"
    assert read(out, "parameters")["model_id"].tolist() == [*hopeless, "good"]


@pytest.mark.slow
def test_as_a_process(spawn, terrain, tmp_path):
    out = ["-o", tmp_path / "out"]
    options = ["--principal-distance", "152", "--altitude", "1600", *out]
    done = spawn("orient", "--terrain", terrain, *options)
    assert done.returncode == 0
    assert done.stderr == ""
    assert "Dangerous surfaces before the flight" in done.stdout
