"""``einschalt publish``, and ``einschalt transform --publish``."""

import json
from pathlib import Path

import pandas as pd
import pytest

FINLAND = Path(__file__).parents[3] / "data_examples" / "fi_ykj_tm35fin"
TABLES = FINLAND / "model_points.csv", FINLAND / "ground_points.csv"
SYSTEMS = "--crs", "EPSG:3067", "--source-crs", "EPSG:2393"


def vertices(path):
    content = json.loads(path.read_text(encoding="utf-8"))
    return content["vertices"], content["triangles"]


@pytest.mark.slow
def test_results_are_published_at_once_or_later_and_are_the_same(invoke, tmp_path):
    out = tmp_path / "out"
    options = "--kind", "helmert", "--distribute", "triangles", "--output", out
    shown = invoke("transform", *TABLES, *options, "--publish", "YKJ", *SYSTEMS)
    assert shown.exit_code == 0, shown.output
    assert "1501 triangles" in shown.stdout
    assert "EINSCHALT:YKJ" in shown.stdout
    shown = invoke("publish", out, "--as", "LATER", "--crs", "EPSG:3067")
    assert shown.exit_code == 0, shown.output
    one, other = out / "YKJ" / "YKJ.json", out / "LATER" / "LATER.json"
    assert vertices(one) == vertices(other)
    assert len(pd.read_csv(out / "triangles.csv")) == 1501


def test_points_left_out_are_left_out_again_when_it_is_published_later(
    invoke, tmp_path
):
    out, new = tmp_path / "out", tmp_path / "new.csv"
    ground = pd.read_csv(TABLES[1])
    ground.loc[300, "easting"] += 50.0
    ground.to_csv(new, index=False)
    options = "--distribute", "triangles", "--outliers", "set_aside", "--output", out
    assert invoke("transform", TABLES[0], new, *options).exit_code == 0
    left_out = pd.read_csv(out / "left_out.csv")["point_id"]
    assert ground.loc[300, "point_id"] in set(left_out)
    shown = invoke("publish", out, "--as", "LATER")
    assert shown.exit_code == 0, shown.output
    published = pd.read_csv(out / "LATER" / "left_out.csv")
    assert list(published["point_id"]) == list(left_out)
    assert len(vertices(out / "LATER" / "LATER.json")[0]) == 767 - len(left_out)


def test_a_folder_without_results_is_refused(invoke, tmp_path):
    shown = invoke("publish", tmp_path, "--as", "XY")
    assert shown.exit_code == 2
    assert "there is no provenance.json of einschalt" in shown.stderr


def test_a_wrong_name_is_refused_before_the_work(invoke, tmp_path):
    shown = invoke("transform", *TABLES, "--output", tmp_path / "o", "--publish", "a b")
    assert shown.exit_code == 2
    assert "name of a publication" in shown.stderr
    assert not (tmp_path / "o").exists()


@pytest.mark.slow
def test_a_grid_is_published_at_once_or_later_and_is_the_same(invoke, tmp_path):
    out = tmp_path / "out"
    options = "--distribute", "collocation", "--output", out, "--cell", "20000"
    shown = invoke("transform", *TABLES, *options, "--publish", "YKJ", *SYSTEMS)
    assert shown.exit_code == 0, shown.output
    assert "residuals distributed by collocation" in shown.stdout
    shown = invoke("publish", out, "--as", "LATER", *SYSTEMS)
    assert shown.exit_code == 0, shown.output
    one, other = (
        pd.read_csv(out / name / "operations.csv")["proj"].iloc[0]
        for name in ("YKJ", "LATER")
    )
    assert one == other.replace("LATER", "YKJ")
    points = pd.read_csv(out / "points.csv")
    assert points["standard_error_easting"].between(0.001, 1.0).all()
    distribution = pd.read_csv(out / "distribution.csv").iloc[0]
    assert (distribution["method"], distribution["cell"]) == ("collocation", 20_000.0)


def test_old_frames_have_easting_and_northing(invoke, tmp_path):
    old = pd.read_csv(TABLES[0]).rename(columns={"x": "Rechtswert", "y": "Hochwert"})
    old.to_csv(tmp_path / "old.csv", index=False)
    options = "--kind", "helmert", "--output"
    shown = invoke(
        "transform", tmp_path / "old.csv", TABLES[1], *options, tmp_path / "a"
    )
    assert shown.exit_code == 0, shown.output
    assert "x = easting, y = northing, as coordinates of the old frame" in shown.output
    assert invoke("transform", *TABLES, *options, tmp_path / "b").exit_code == 0
    one, other = (pd.read_csv(tmp_path / n / "parameters.csv") for n in "ab")
    numbers = one.select_dtypes("number").columns
    pd.testing.assert_frame_equal(one[numbers], other[numbers])


def test_points_outside_are_counted_and_a_lost_database_is_named(
    invoke, tmp_path, monkeypatch
):
    far = pd.read_csv(TABLES[0]).iloc[:3]
    far.loc[1, "y"] += 5e6
    far.to_csv(tmp_path / "far.csv", index=False)
    options = "--distribute", "triangles", "--apply", tmp_path / "far.csv"
    shown = invoke("transform", *TABLES, *options, "--output", tmp_path / "out")
    name = far.loc[1, "point_id"]
    said = f"1 of 3 points lies outside, without coordinates: {name}"
    assert said in shown.output.replace("\n", " ")
    monkeypatch.setenv("PROJ_AUX_DB", str(tmp_path / "gone.db"))
    unknown = ("--publish", "YKJ", "--crs", "EPSG:999999")
    shown = invoke("transform", *TABLES, "--output", tmp_path / "o", *unknown)
    assert shown.exit_code == 2
    assert "PROJ_AUX_DB names" in shown.output
    assert "gone.db, which is not there" in shown.output


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--publish", "YKJ", "--crs", "EPSG:31255"), "outside the area of use"),
        (
            ("--publish", "YKJ", "--crs", "EPSG:3067", "--source-crs", "EPSG:2056"),
            "puts the points at",
        ),
        (("--cell", "50"), "only collocation and natural_neighbour have a grid"),
    ],
)
def test_what_cannot_be_published_is_refused_before_the_work(
    options, said, invoke, tmp_path
):
    shown = invoke("transform", *TABLES, "--output", tmp_path / "o", *options)
    assert shown.exit_code == 2
    assert said in " ".join(shown.stderr.split())
    assert not (tmp_path / "o").exists()


def test_exchanged_axes_of_the_ground_are_said_before_the_work(invoke, tmp_path):
    ground = pd.read_csv(TABLES[1])
    names = {"easting": "northing", "northing": "easting"}
    ground.rename(columns=names).to_csv(tmp_path / "new.csv", index=False)
    where = TABLES[0], tmp_path / "new.csv", "--output", tmp_path / "o"
    shown = invoke("transform", *where, "--publish", "YKJ", *SYSTEMS)
    assert shown.exit_code == 2
    assert "inside with the two exchanged" in " ".join(shown.stderr.split())
    assert not (tmp_path / "o").exists()


@pytest.mark.parametrize("option", SYSTEMS[::2])
def test_systems_without_a_publication_are_refused(option, invoke, tmp_path):
    options = "--output", tmp_path / "o", option, "EPSG:3067"
    shown = invoke("transform", *TABLES, *options)
    assert shown.exit_code == 2
    assert f"{option} ETRS89 / TM35FIN(E,N) (EPSG:3067) is given" in shown.stderr
    assert not (tmp_path / "o").exists()
