"""The folder of a result: which files, which columns, in which order written."""

import json
import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from tests.changed_results import changed

from einschalt.foundations.errors import FileError
from einschalt.interfaces.files import result_folder
from einschalt.interfaces.files.block_folder import read_block
from einschalt.interfaces.files.block_writing import write_block
from einschalt.interfaces.files.input_files import checksum
from einschalt.interfaces.files.result_folder import TABLES, write_result
from einschalt.pipeline.densify import densify
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block

pytestmark = pytest.mark.usefixtures("computed_once")

SUFFIXES = (".csv", ".parquet")
PROPAGATED = ("error_sources", "neighbours", "ellipses", "control_left_out")
FILES = {
    *(f"{name}{suffix}" for name in (*TABLES, "coverages") for suffix in SUFFIXES),
    # errors of this block are propagated, and nothing in it was oriented
    *(f"{name}{suffix}" for name in PROPAGATED for suffix in SUFFIXES),
    "failures.csv",
    "block.gpkg",
    "report.html",
    "summary.txt",
    "assessment.json",
    "provenance.json",
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory, faulty_result):
    folder = tmp_path_factory.mktemp("out") / "new" / "result"
    write_result(faulty_result, folder)
    return folder


def test_every_file_is_there_and_no_other(folder):
    assert {path.name for path in folder.iterdir()} == FILES


@pytest.mark.parametrize("name", [*TABLES, "coverages"])
def test_parquet_keeps_every_digit(folder, faulty_result, name):
    table = pd.read_parquet(folder / f"{name}.parquet")
    expected = getattr(faulty_result, name)[table.columns]
    assert set(table.columns) == set(getattr(faulty_result, name).columns)
    for column in table:
        if pd.api.types.is_float_dtype(expected[column]):
            np.testing.assert_array_equal(table[column], expected[column])
        else:
            assert table[column].fillna("").tolist() == (
                expected[column].fillna("").tolist()
            )


def test_csv_shows_what_parquet_holds(folder):
    text = {"point_id": str, "coverage": str, "model_id": str}
    for name in TABLES:
        csv = pd.read_csv(folder / f"{name}.csv", dtype=text)
        table = pd.read_parquet(folder / f"{name}.parquet")
        assert list(csv.columns) == list(table.columns)
        assert len(csv) == len(table)
    csv = pd.read_csv(folder / "points.csv", dtype=text)
    points = pd.read_parquet(folder / "points.parquet")
    np.testing.assert_allclose(csv["easting"], points["easting"], atol=0.00005001)
    paper = "standard_error_paper"
    np.testing.assert_allclose(csv[paper], points[paper], atol=0.000005001)


def test_columns_come_in_the_order_that_is_promised(folder):
    def header(name):
        return (folder / f"{name}.csv").read_text().splitlines()[0]

    assert header("points").startswith("point_id,easting,northing,")
    assert header("models").startswith(
        "flight,coverage,model_id,transformation,n_points,redundancy,m_0,s_0,"
        "is_usable,reason,a0,a1,a2,b0,b1,b2"
    )
    assert header("residuals").startswith(
        "flight,coverage,model_id,point_id,residual_easting,residual_northing,"
        "leverage,redundancy_number"
    )
    assert header("failures") == "flight,coverage,model_id,stage,reason,remedy"


def test_coordinates_have_four_decimals_and_errors_five(folder):
    row = (folder / "points.csv").read_text().splitlines()[1]
    assert re.match(r"[^,]+,\d+\.\d{4},\d+\.\d{4},", row)
    header, row = (folder / "residuals.csv").read_text().splitlines()[:2]
    values = dict(zip(header.split(","), row.split(","), strict=True))
    assert re.fullmatch(r"-?\d+\.\d{5}", values["residual_easting"])


def test_summary_and_report_are_those_of_the_result(folder, faulty_result):
    summary = (folder / "summary.txt").read_text(encoding="utf-8")
    # what was printed, without the time that it took
    assert faulty_result.summary() == f"{summary}Computed in 0.50 s.\n"
    assert (folder / "report.html").read_text(encoding="utf-8").startswith("<!")


def test_assessment_is_that_of_the_result(folder, faulty_result):
    text = (folder / "assessment.json").read_text(encoding="utf-8")

    def refuse(constant):
        raise AssertionError(f"{constant} is no JSON")

    said = json.loads(text, parse_constant=refuse)
    assert said == faulty_result.assessment.to_dict()
    assert list(said) == list(faulty_result.assessment.to_dict())
    assert said["block"]["name"] == faulty_result.block.name
    assert len(said["findings"]) == len(faulty_result.assessment.findings) > 0


def test_provenance_vouches_for_the_other_files(folder):
    origin = json.loads((folder / "provenance.json").read_text(encoding="utf-8"))
    assert origin["outputs"] == {
        name: checksum(folder / name) for name in FILES - {"provenance.json"}
    }


@pytest.mark.slow
def test_a_result_that_cannot_be_written_leaves_the_older_one(
    tmp_path, good_result, monkeypatch
):
    write_result(good_result, tmp_path)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}

    def fail(_result):
        raise ZeroDivisionError

    monkeypatch.setattr(result_folder, "render", fail)
    with pytest.raises(ZeroDivisionError):
        write_result(good_result, tmp_path)
    assert before == {path.name: path.read_bytes() for path in tmp_path.iterdir()}


def test_folder_that_cannot_be_written(tmp_path, good_result):
    (tmp_path / "out").touch()
    with pytest.raises(FileError, match=r"out: cannot be written: .* Choose another"):
        write_result(good_result, tmp_path / "out")


@pytest.mark.slow
def test_name_with_umlauts_blanks_and_commas(tmp_path, good_result):
    strange = 'Ö "7", 8'
    points = good_result.points.copy()
    points["point_id"] = [strange, *points["point_id"].iloc[1:]]
    write_result(changed(good_result, points=points), tmp_path / "Ö aus, gabe")
    back = pd.read_csv(tmp_path / "Ö aus, gabe" / "points.csv", dtype={"point_id": str})
    assert back["point_id"].iloc[0] == strange


@pytest.mark.slow
def test_from_folder_to_folder(tmp_path, demo_block):
    """Write a block, read it, densify it, write the result: twice the same."""
    write_block(demo_block, tmp_path / "block")
    for name in ("one", "two"):
        block = read_block(tmp_path / "block")
        result = densify(block)
        write_result(result, tmp_path / name)
    for path in (tmp_path / "one").iterdir():
        if path.name != "provenance.json":
            assert path.read_bytes() == (tmp_path / "two" / path.name).read_bytes()


@pytest.mark.slow
@pytest.mark.parametrize("measurement", ["parallaxes", "images"])
def test_oriented_models_stand_in_orientations(tmp_path, measurement):
    geometry = replace(PRESETS["demo"].geometry, measurement=measurement)
    write_block(simulate_block("demo", seed=2, geometry=geometry), tmp_path / "block")
    result = densify(read_block(tmp_path / "block"))
    write_result(result, tmp_path / "result")
    orientations = pd.read_csv(
        tmp_path / "result" / "orientations.csv", dtype={"coverage": str}
    )
    key = ["coverage", "model_id"]
    n_models = sum(
        len(flight.model_table()[key].drop_duplicates())
        for flight in result.block.flights.values()
    )
    assert 0 < len(orientations) <= n_models
    assert list(orientations.columns[:3]) == ["flight", "coverage", "model_id"]
    residuals = pd.read_csv(tmp_path / "result" / "orientation_residuals.csv")
    assert list(residuals.columns[:3]) == ["flight", "coverage", "model_id"]
    assert len(residuals) == len(result.orientation_residuals)


def test_a_block_is_not_overwritten_by_its_result(good_result, tmp_path):
    (tmp_path / "block.toml").write_text("[block]\n", encoding="utf-8")
    with pytest.raises(FileError, match=r"the folder holds a block.*another folder"):
        write_result(good_result, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["block.toml"]


@pytest.mark.slow
def test_moves_of_the_passes_are_a_table(demo_block, tmp_path):
    result = densify(demo_block, Settings(iterations=3))
    write_result(result, tmp_path / "out")
    written = pd.read_parquet(tmp_path / "out" / "iterations.parquet")
    assert written["iteration"].tolist() == [2, 3]
    assert "control_left_out.csv" not in {p.name for p in (tmp_path / "out").iterdir()}
    assert "Iterations: moves" in (tmp_path / "out" / "report.html").read_text("utf-8")
