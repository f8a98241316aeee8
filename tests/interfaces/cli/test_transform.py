"""``einschalt transform``."""

import numpy as np
import pandas as pd
import pytest

TABLES = ("parameters", "models", "residuals", "failures", "points")


@pytest.fixture
def files(tmp_path):
    """Two models of four points on E = 1000 + 2x + y/2, N = 500 - x/2 + 2y, exactly."""
    x, y = np.array([0.0, 100.0, 100.0, 0.0]), np.array([0.0, 0.0, 80.0, 80.0])
    easting, northing = 1000.0 + 2.0 * x + 0.5 * y, 500.0 - 0.5 * x + 2.0 * y
    model = pd.concat(
        pd.DataFrame({"model_id": name, "point_id": list("abcd"), "x": x, "y": y})
        for name in ("7/8", "0012")
    )
    model.to_csv(tmp_path / "model.csv", index=False)
    ground = {"point_id": list("abcd"), "easting": easting, "northing": northing}
    pd.DataFrame(ground).to_csv(tmp_path / "ground.csv", index=False)
    return tmp_path


def run(invoke, folder, *options):
    tables = folder / "model.csv", folder / "ground.csv"
    return invoke("transform", *tables, "--output", folder / "out", *options)


def read(folder, name):
    return pd.read_csv(folder / "out" / f"{name}.csv", dtype={"model_id": str})


def test_all_tables_are_written_twice(invoke, files):
    shown = run(invoke, files)
    assert shown.exit_code == 0
    for name in TABLES:
        table = pd.read_parquet(files / "out" / f"{name}.parquet")
        assert len(table) == len(read(files, name))
    assert "affine transformation of 2 of 2 models" in shown.stdout
    assert f"Results in {files / 'out'}" in shown.stdout


def test_parameters_are_those_of_the_data(invoke, files):
    run(invoke, files)
    parameters = read(files, "parameters")
    assert list(parameters["model_id"]) == ["7/8", "0012"]
    expected = [1000.0, 2.0, 0.5, 500.0, -0.5, 2.0]
    columns = ["a0", "a1", "a2", "b0", "b1", "b2"]
    np.testing.assert_allclose(parameters[columns], [expected] * 2, atol=1e-9)
    assert "coverage" not in parameters


def test_helmert_is_the_same_where_the_data_are_conformal(invoke, files):
    run(invoke, files, "--kind", "helmert")
    parameters = read(files, "parameters")[["a", "b", "te", "tn"]]
    np.testing.assert_allclose(parameters, [[2.0, -0.5, 1000.0, 500.0]] * 2, atol=1e-9)


def test_a_table_without_models_is_one_model_and_that_is_said(invoke, files):
    model = pd.read_csv(files / "model.csv").drop(columns="model_id").head(4)
    model.to_csv(files / "model.csv", index=False)
    shown = run(invoke, files)
    assert shown.exit_code == 0
    assert "model.csv has no column model_id: it is one model" in shown.stderr
    assert "+proj=pipeline +step +proj=affine +xoff=" in shown.stdout
    assert list(read(files, "models")["model_id"]) == ["1"]


def test_other_points_can_be_transformed(invoke, files):
    more = pd.DataFrame({"model_id": ["0012"], "point_id": ["q"], "x": 10.0, "y": 20.0})
    more.to_csv(files / "more.csv", index=False)
    shown = run(invoke, files, "--apply", files / "more.csv")
    assert shown.exit_code == 0
    point = read(files, "points").iloc[0]
    assert (point["model_id"], point["point_id"]) == ("0012", "q")
    assert (point["easting"], point["northing"]) == (1030.0, 535.0)


def test_points_without_a_model_are_those_of_the_only_one(invoke, files):
    model = pd.read_csv(files / "model.csv", dtype={"model_id": str})
    model[model["model_id"] == "0012"].to_csv(files / "model.csv", index=False)
    more = pd.DataFrame({"point_id": ["q"], "x": 10.0, "y": 20.0})
    more.to_csv(files / "more.csv", index=False)
    assert run(invoke, files, "--apply", files / "more.csv").exit_code == 0
    point = read(files, "points").iloc[0]
    assert (point["model_id"], point["point_id"]) == ("0012", "q")
    assert (point["easting"], point["northing"]) == (1030.0, 535.0)


def test_points_without_a_model_are_refused_where_there_are_several(invoke, files):
    more = pd.DataFrame({"point_id": ["q"], "x": 10.0, "y": 20.0})
    more.to_csv(files / "more.csv", index=False)
    shown = run(invoke, files, "--apply", files / "more.csv")
    assert shown.exit_code == 2
    assert "more.csv: it has no column model_id, and model.csv holds 2 models; " in (
        shown.stderr
    )
    assert "Add a column model_id, such as '7/8'." in shown.stderr


def test_a_fault_of_the_points_is_said_once(invoke, files):
    text = (files / "model.csv").read_text()
    (files / "model.csv").write_text(text.replace("7/8,", ",", 1))
    shown = run(invoke, files)
    assert shown.exit_code == 2
    assert shown.stderr.count("model_id is missing") == 1


def test_a_model_that_was_not_fitted_is_said(invoke, files):
    more = pd.DataFrame({"model_id": ["99"], "point_id": ["q"], "x": 10.0, "y": 20.0})
    more.to_csv(files / "more.csv", index=False)
    shown = run(invoke, files, "--apply", files / "more.csv")
    assert shown.exit_code == 2
    assert "model 99: the model was not fitted" in shown.stderr


def in_coverages(files, *coverages):
    """Give the models' table all its points in every one of some coverages."""
    model = pd.read_csv(files / "model.csv", dtype=str)
    parts = [model.assign(coverage=coverage) for coverage in coverages]
    pd.concat(parts).to_csv(files / "model.csv", index=False)
    more = pd.DataFrame({"model_id": ["0012"], "point_id": ["q"], "x": 10.0, "y": 20.0})
    more.to_csv(files / "more.csv", index=False)


def test_points_without_coverage_of_a_model_in_several_are_refused(invoke, files):
    in_coverages(files, "1", "2")
    shown = run(invoke, files, "--apply", files / "more.csv")
    assert shown.exit_code == 2
    said = "more.csv, model 0012: coverages 1, 2 each have this model"
    assert said in shown.stderr
    assert not (files / "out").exists()


def test_points_without_coverage_of_a_model_in_one(invoke, files):
    in_coverages(files, "2")
    shown = run(invoke, files, "--apply", files / "more.csv")
    assert shown.exit_code == 0
    point = read(files, "points").iloc[0]
    assert (point["coverage"], point["easting"], point["northing"]) == (2, 1030, 535)


def test_failed_models_do_not_stop_the_others(invoke, files):
    with (files / "model.csv").open("a", encoding="utf-8") as file:
        file.write("lonely,a,0,0\n")
    shown = run(invoke, files)
    assert shown.exit_code == 0
    assert "lonely" in shown.stdout
    assert list(read(files, "failures")["model_id"]) == ["lonely"]


def test_no_model_at_all_has_status_2(invoke, files):
    ground = pd.read_csv(files / "ground.csv")
    ground["point_id"] += "_"
    ground.to_csv(files / "ground.csv", index=False)
    shown = run(invoke, files)
    assert shown.exit_code == 2
    assert "no model could be transformed" in shown.stderr
    assert len(read(files, "failures")) == 2


def test_faults_of_both_files_are_said_together(invoke, files):
    shown = run(invoke, files, "--kind", "helmert_3d")
    assert shown.exit_code == 2
    assert "model.csv, row 1: column 'z' is missing" in shown.stderr
    assert "ground.csv, row 1: column 'height' is missing" in shown.stderr


def test_a_value_that_is_no_number_is_said_with_its_row(invoke, files):
    text = (
        (files / "ground.csv").read_text(encoding="utf-8").replace("1200.0", "twelve")
    )
    (files / "ground.csv").write_text(text, encoding="utf-8")
    shown = run(invoke, files)
    assert shown.exit_code == 2
    assert (
        "ground.csv, row 3, point b: easting 'twelve' is not a number" in shown.stderr
    )


def test_ignored_columns_are_said(invoke, files):
    pd.read_csv(files / "ground.csv").assign(colour="red").to_csv(
        files / "ground.csv", index=False
    )
    assert "ground.csv: ignored column colour" in run(invoke, files).stderr


def test_many_points_left_out_are_a_warning_that_says_why(invoke, tmp_path):
    east, north = (side.ravel() for side in np.mgrid[0:6, 0:6] * 100.0)
    table = pd.DataFrame({"point_id": range(36), "x": east, "y": north})
    table.to_csv(tmp_path / "model.csv", index=False)
    moved = np.where(np.arange(36) % 5 == 0, 250.0, 0.0)
    ground = pd.DataFrame({"point_id": range(36), "easting": east + moved})
    ground["northing"] = north - moved
    ground.to_csv(tmp_path / "ground.csv", index=False)
    shown = run(invoke, tmp_path, "--distribute", "triangles")
    assert shown.exit_code == 0, shown.output
    left_out = len(read(tmp_path, "left_out"))
    assert f"warning: {left_out} of 36 identical points left out" in shown.stderr
    assert "the transformation folds" in shown.stderr
    assert "--outliers set_aside" in shown.stderr


def test_a_place_that_cannot_be_written_is_refused_before_the_work(
    invoke, files, monkeypatch
):
    monkeypatch.setattr("einschalt.interfaces.cli.work.transform._read", None)
    (files / "out").write_text("a file, and no folder")
    tables = files / "model.csv", files / "ground.csv"
    refused = invoke("transform", *tables, "--output", files / "out" / "new")
    assert refused.exit_code == 2
    assert "out/new: cannot be written: " in refused.stderr
