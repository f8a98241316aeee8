"""``einschalt plan``."""

import json
import re
import typing

import numpy as np
import pandas as pd
import pytest

import einschalt as es
from einschalt.foundations.errors import EinschaltError, GeometryError
from einschalt.interfaces.cli.plan import CameraName, Edge, Kind
from einschalt.interfaces.cli.plan_values import costs_of
from einschalt.pipeline.planning.flights.cameras import CAMERAS
from einschalt.pipeline.planning.flights.costs import PlanCosts
from einschalt.theory.planning.kovarik_precision import EDGES
from einschalt.theory.planning.leverage import PLANNED_KINDS


def test_choices_are_those_of_planning():
    assert typing.get_args(Kind) == PLANNED_KINDS
    assert typing.get_args(Edge) == EDGES
    assert typing.get_args(CameraName) == tuple(CAMERAS)


def test_without_arguments_it_gives_the_tables_of_1971(invoke, golden):
    shown = invoke("plan")
    assert shown.exit_code == 0
    golden(shown.stdout, "plan_1971.txt")


@pytest.mark.slow
def test_defaults_take_hardly_longer_than_a_library_of_tables(processor_seconds):
    call, library = ("-m", "einschalt", "plan"), ("-c", "import pandas")
    ours, without = processor_seconds(call, library)
    assert ours < 1.3 * without  # usually 0.7 times, 0.5 s


@pytest.mark.parametrize("suffix", ["csv", "parquet"])
def test_the_table_is_written(suffix, invoke, tmp_path):
    file = tmp_path / f"plan.{suffix}"
    shown = invoke(
        *("plan", "--scale", "6000:8000:1000", "--scale", "12000", "--m-0", "0.1"),
        *("--spacing", "200,300", "--m-g-um", 5, "--output", file),
    )
    assert shown.exit_code == 0, shown.stderr
    read = pd.read_csv(file) if suffix == "csv" else pd.read_parquet(file)
    table = es.plan_precision([6000, 7000, 8000, 12000], [200, 300], 0.1, 5)
    assert list(read) == list(table)
    np.testing.assert_allclose(read, table, rtol=1e-15)


def test_camera_and_what_replaces_it(invoke, tmp_path):
    file = tmp_path / "plan.csv"
    invoke("plan", "--camera", "dmc_3", "--output", file)
    assert pd.read_csv(file)["flying_height"][0] == pytest.approx(15000 * 0.092)
    options = ("--image-format", "50x100", "--principal-distance", "120")
    given = ("plan", "--camera", "dmc_3", *options, "--edge", "corner")
    invoke(*given, "--output", file, "--overwrite")
    row = pd.read_csv(file).iloc[0]
    assert row["flying_height"] == pytest.approx(15000 * 0.12)
    assert row["n_points"] == pytest.approx(0.6 * 0.05 * 0.1 * (15000 / 200) ** 2)


def test_long_tables_are_cut_in_the_text_only(invoke, tmp_path):
    file = tmp_path / "plan.csv"
    shown = invoke(
        *("plan", "--scale", "6000:15000:500", "--spacing", "100:300:10"),
        *("--m-0", "0.1:0.2:0.01", "--output", file),
    )
    assert "and 11 scales and 11 spacings more" in shown.stdout
    assert "and 3 such tables more" in shown.stdout
    assert len(pd.read_csv(file)) == 19 * 21 * 11 * 2


@pytest.mark.parametrize(
    ("option", "value", "says"),
    [
        ("--scale-number", "0.0001", "Give the denominator: 8000 for 1:8000"),
        ("--scale-number", "0", "--scale-number = 0"),
        ("--spacing", "3000", "spacing = 3000 m is larger than a model at 1:6000"),
        ("--m-0", "10", "10 cm are 0.10"),
        ("--m-0", "ten", "--m-0 'ten'; expected numbers as 6000,8000"),
        ("--m-0", "0.1:0.2", "first:last:step"),
        ("--m-0", "0.2:0.1:0.01", "with a step above 0, upwards"),
        ("--m-0", "0.1:0.2:1e-9", "100000000 values; expected at most 1000000"),
        ("--m-g-um", "0.00001", "Did you give metres or millimetres?"),
        ("--forward-overlap", "1", "--forward-overlap = 1"),
        ("--side-overlap", "30", "Did you give per cent?"),
        ("--image-format", "0.23", "--image-format = 0.23; expected 2 to 1000 mill"),
        ("--image-format", "1x2x", "--image-format ''"),
        ("--principal-distance", "0.152", "Did you give metres?"),
        ("--output", "plan.doc", "suffix '.doc' is unknown"),
    ],
)
def test_nonsense_is_refused_with_the_remedy(option, value, says, invoke):
    shown = invoke("plan", option, value)
    assert shown.exit_code == 2
    assert says in " ".join(shown.stderr.split())
    assert "Traceback" not in shown.stderr


@pytest.mark.slow
def test_a_target_gives_plans_that_were_checked(invoke, tmp_path):
    shown = invoke(
        *("plan", "--target", 0.06, "--scale", "7000,9000", "--spacing", 300),
        *("--n-settings", "2,4", "--n-coverages", 2, "--output", tmp_path / "plan"),
    )
    assert shown.exit_code == 0, shown.stderr
    assert "reach 6.0 cm" in shown.stdout
    assert "Checked by propagation on a layout" in " ".join(shown.stdout.split())
    files = {file.name for file in (tmp_path / "plan").iterdir()}
    assert {"plans.csv", "plans.parquet", "plans.png", "plans.svg"} <= files
    assert {"precision_map.png", "expected_points.csv", "summary.txt"} <= files
    plans = pd.read_csv(tmp_path / "plan" / "plans.csv")
    flights = plans["high_scale_number"] / plans["scale_number"]
    asked = plans[flights.round(4).isin(es.PlanChoices.high_over_low)]
    assert 30 < len(asked) <= 2 * 5 * 2 * 2
    # about the best of them, and about what came near to the target with another
    # pattern of control, also what lies between, of what was not asked for
    between = plans.drop(asked.index)
    of_patterns = between.groupby("control_per_model").size()
    assert (of_patterns <= 4 * 2).all()
    assert 0 < len(of_patterns) <= asked["control_per_model"].nunique()
    assert len(set(between["scale_number"])) == 1
    assert set(plans["n_settings"]) == {2, 4}
    assert (plans.loc[plans["is_feasible"], "reached"] <= 0.06).all()


def test_a_wish_that_cannot_be_met_is_answered(invoke):
    shown = invoke("plan", "--target", 0.002, "--scale", 8000, "--spacing", 300)
    assert shown.exit_code == 1  # the search is done, its target is not reached
    said = " ".join(shown.stdout.split())
    assert "no plan of 54 reaches 2.0 mm" in said
    assert said.startswith("No plan is recommended")
    assert "It is limited by" in said


def test_programs_are_told_why_no_plan_is_recommended(invoke):
    asked = ("--target", 0.002, "--scale", 8000, "--spacing", 300, "--json")
    shown = invoke("plan", *asked)
    told = json.loads(shown.stdout)
    assert told["status"] == shown.exit_code == 1
    (problem,) = told["problems"]
    assert problem["found"].startswith("no plan is recommended: the nearest comes to 2")
    assert problem["expected"] == "at most 2.0 mm"
    advice = "Not tried, and would help by the closed estimate: 16 pointings each"
    assert problem["remedy"].startswith(advice)
    assert told["figures"]["is_recommended"] is False
    assert told["figures"]["target"] == 0.002
    refused = invoke("plan", "--target", 0.05, "--scale", 8000, "--spacing", 3000)
    assert refused.exit_code == 2


def test_programs_are_told_what_a_layout_is_worth(invoke):
    asked = ("--scale", 8000, "--spacing", 300, "--width", 4000, "--height", 4000)
    told = json.loads(invoke("plan", "--expect", *asked, "--json").stdout)["figures"]
    assert told["question"] == "expect"
    assert (told["scale_number"], told["high_scale_number"]) == (8000, 15000)
    parts = [told[f"from_{name}"] for name in ("control", "high_flight", "low_flight")]
    assert told["mean"] == pytest.approx(np.sqrt(np.sum(np.square(parts))), rel=1e-6)
    assert told["n_new"] + told["n_control"] == 169


@pytest.mark.slow
def test_a_layout_is_expected(invoke, tmp_path):
    shown = invoke(
        *("plan", "--expect", "--scale", 8000, "--spacing", 300, "--m-g-um", 5),
        *("--width", 4000, "--height", 4000, "--output", tmp_path / "plan"),
    )
    assert shown.exit_code == 0, shown.stderr
    assert shown.stdout.startswith("Expected precision of")
    assert "4 x 4 km" in shown.stdout
    assert (tmp_path / "plan" / "precision_map.svg").exists()


@pytest.mark.slow
def test_terrain_is_judged_at_every_scale(invoke, tmp_path):
    heights = tmp_path / "heights.csv"
    heights.write_text(
        "model_id,h1,h2,h3,h4,h5,h6\n7/8,600,600,900,900,900,900\n", encoding="utf-8"
    )
    shown = invoke(
        *("plan", "--scale", "6000,20000", "--terrain", heights),
        *("--output", tmp_path / "plan"),
    )
    assert shown.exit_code == 0, shown.stderr
    assert "model 7/8 is critical" in shown.stdout
    forecast = pd.read_csv(tmp_path / "plan" / "dangerous_surfaces.csv")
    assert forecast["scale_number"].tolist() == [6000, 20000]
    cameras = pd.read_csv(tmp_path / "plan" / "dangerous_surfaces_by_camera.csv")
    assert set(cameras["camera"]) == set(CAMERAS)
    assert (tmp_path / "plan" / "diagrams.png").exists()


@pytest.mark.slow
def test_a_figure_may_stand_in_the_folder_that_is_made(invoke, tmp_path):
    folder = tmp_path / "new"
    asked = ("--spacing", 300, "--output", folder, "--figure", folder / "f.svg")
    assert invoke("plan", *asked).exit_code == 0
    assert {"f.svg", "summary.txt"} <= {path.name for path in folder.iterdir()}
    beside = tmp_path / "other" / "f.svg"
    assert invoke("plan", *asked[:2], "--figure", beside).exit_code == 0
    assert beside.is_file()
    below_a_file = invoke("plan", *asked[:2], "--figure", beside / "no" / "f.svg")
    assert below_a_file.exit_code == 2
    assert "cannot be written" in below_a_file.stderr


@pytest.mark.slow
@pytest.mark.parametrize(
    ("question", "says"),
    [
        ((), "4d"),
        (("--target", 0.06, "--n-settings", 2), "reach it"),
        (("--expect", "--width", 4000, "--height", 4000), "coverages not shifted"),
    ],
)
def test_a_figure_is_written(question, says, invoke, tmp_path):
    file = tmp_path / "plan.svg"
    shown = invoke("plan", *question, "--spacing", 300, "--figure", file)
    assert shown.exit_code == 0, shown.stderr
    assert f"Figure in {file}" in shown.stdout.replace("\n", "")
    assert says in file.read_text(encoding="utf-8")


def test_what_does_not_count_is_said(invoke):
    shown = invoke("plan", "--spacing", 300, "--n-coverages", 3, "--where", "edge")
    assert shown.exit_code == 0
    first = "Not used for the tables: --n-coverages, --where.\n"
    assert shown.stdout.startswith(first)
    shown = invoke(
        *("plan", "--target", 0.06, "--scale", 8000, "--spacing", 300),
        *("--m-0", 0.1, "--expect"),
    )
    assert shown.stdout.startswith("Not used for --target: --m-0, --expect.\n")


def test_programs_get_all_combinations_of_the_tables(invoke, tmp_path):
    asked = ("plan", "--scale", "6000,8000", "--spacing", "200,300", "--m-0", 0.1)
    file = tmp_path / "plan.csv"
    told = json.loads(invoke(*asked, "--output", file, "--json").stdout)["figures"]
    assert list(told) == ["question", "combinations"]
    written = pd.read_csv(file)
    named = [(8000, 200), (8000, 300), (6000, 200), (6000, 300)]
    rows = told["combinations"]
    assert {(row["scale_number"], row["spacing"]) for row in rows} == set(named)
    pd.testing.assert_frame_equal(pd.DataFrame(rows), written, check_dtype=False)


def test_the_figures_of_one_combination_stand_by_themselves_as_well(invoke):
    asked = ("--scale", 6000, "--spacing", 200, "--m-0", 0.1, "--m-g-um", 10)
    told = json.loads(invoke("plan", *asked, "--json").stdout)["figures"]
    (row,) = told.pop("combinations")
    assert told == {"question": "tables"} | row
    assert round(told["M_double"], 4) == 0.0492


def test_what_does_not_count_is_a_problem_for_programs(invoke):
    shown = invoke("plan", "--spacing", 300, "--where", "edge", "--json")
    assert shown.exit_code == 0
    (problem,) = json.loads(shown.stdout)["problems"]
    assert problem["found"] == "Not used for the tables: --where."


def test_what_does_not_count_is_told_where_the_answer_fails_too(invoke):
    shown = invoke("plan", "--where", "edge", "--spacing", 300, "--scale", 100)
    assert shown.exit_code == 2
    assert "Not used for the tables: --where." in shown.stdout


def test_terrain_is_judged_for_both_flights_of_a_layout(invoke, tmp_path):
    heights = tmp_path / "heights.csv"
    heights.write_text(
        "model_id,h1,h2,h3,h4,h5,h6\n7/8,600,600,900,900,900,900\n", encoding="utf-8"
    )
    shown = invoke(
        *("plan", "--expect", "--scale", 8000, "--high-scale-number", 16000),
        *("--width", 4000, "--height", 4000, "--terrain", heights),
    )
    assert shown.exit_code == 0, shown.stderr
    said = shown.stdout[shown.stdout.index("Dangerous surfaces") :]
    assert "1:8000   1 weak" in said
    assert "1:16000" in said


@pytest.mark.slow
def test_costs_rank_the_plans(invoke, tmp_path):
    def cheapest(*costs):
        options = ("--target", 0.08, "--spacing", 300, "--output", tmp_path / "p.csv")
        options = (*options, "--overwrite")
        shown = invoke("plan", *options, *costs)
        assert shown.exit_code == 0, shown.stderr
        return pd.read_csv(tmp_path / "p.csv").iloc[0]

    dear = cheapest("--costs", "control_point=100000, image=1")
    assert dear["control_points"] < cheapest()["control_points"]


def test_a_plan_that_no_layout_holds_is_still_answered(invoke, monkeypatch, tmp_path):
    def fail(*_, **__):
        raise GeometryError("too few points", remedy="Take more")

    monkeypatch.setattr("einschalt.interfaces.cli.plan_layouts.check_plans", fail)
    asked = ("plan", "--target", 0.06, "--spacing", 300, "--scale", 8000)
    shown = invoke(*asked, "--output", tmp_path / "plan")
    assert shown.exit_code == 1, shown.stderr
    assert "cannot be laid out: too few points. Take more." in shown.stdout
    assert (tmp_path / "plan" / "plans.png").exists()

    shown = invoke(*asked, "--json")
    assert shown.exit_code == 1, shown.stderr
    told = json.loads(shown.stdout)
    assert told["figures"]["scale_number"] == 8000
    assert told["figures"]["is_recommended"] is False
    assert told["figures"]["reached_on_layout"] is None
    (problem,) = told["problems"]
    assert (problem["found"], problem["remedy"]) == ("too few points", "Take more")
    monkeypatch.undo()
    usual = json.loads(invoke(*asked, "--json").stdout)
    assert set(told["figures"]) == set(usual["figures"])
    assert told["figures"]["target"] == 0.06
    assert told["figures"]["next_best"] is None


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (
            ("--target", "0.05", "--costs", "picture=3"),
            "a price of 'picture'",
        ),
        (
            ("--target", "5cm", "--camera", "uav_one_inch", "--high-over-low", "0"),
            "--high-over-low = 0",
        ),
        (("--target", "0.05", "--costs", "image"), "costs as image=10,model=20"),
        (("--target", "0.05", "--costs", "image=x"), "--costs 'x'"),
        (("--target", "0.05", "--costs", "image=-1"), "image = -1"),
        (("--figure", "plan.doc"), "'.doc' is none of a figure"),
        (("--target", "50"), "5 cm are 0.05"),
        (("--target", "-1"), "target = -1"),
        (("--target", "0.05", "--control-per-model", "6"), "expected 5 or 9"),
        (("--target", "0.05", "--n-coverages", "1.5"), "--n-coverages = 1.5"),
        (("--expect", "--scale", "6000,8000"), "--scale has 2 values"),
        (("--expect", "--high-scale-number", "5000"), "a smaller image scale"),
        (("--expect", "--control-standard-error", "30"), "Did you give millimetres?"),
        (("--expect", "--width", "10"), "width = 10"),
        (("--terrain", "nowhere.csv"), "nowhere.csv"),
    ],
)
def test_other_nonsense_is_refused(options, says, invoke):
    shown = invoke("plan", *options)
    assert shown.exit_code == 2
    assert "Traceback" not in shown.stderr
    assert says in " ".join(shown.stderr.split())


def test_a_height_of_nothing_is_refused(invoke):
    shown = invoke("plan", "--target", "5cm", "--max-height", "0")
    assert shown.exit_code == 2
    assert "--max-height = 0" in shown.stderr
    assert "expected 5 to 20000 metres above ground" in shown.stderr


@pytest.mark.parametrize("prices", ["image=12,5,model=3", "image=12,5; model=3"])
def test_prices_have_decimal_commas_too(prices):
    assert costs_of(prices) == PlanCosts(image=12.5, model=3.0)


@pytest.mark.parametrize(
    "prices",
    [
        "control point=30, pointing=0.2, image=4, model=5",
        "control points=30; pointings at a point=0.2; photographs=4; models=5",
        "Passpunkt=30, Einstellung=0,2, Bild=4, Modell=5",
        "Passpunkte=30, Einstellungen=0,2, Bilder=4, Modelle=5",
        "Passpunkte=30, Einstellungen eines Punktes=0,2, Aufnahmen=4, Modelle=5",
        "control_point=30,setting=0.2,image=4,model=5",
    ],
)
def test_costs_by_the_words_of_the_answer(prices):
    given = costs_of(prices)
    assert given == PlanCosts(image=4.0, model=5.0, setting=0.2, control_point=30.0)


def test_two_prices_of_one_thing_are_refused():
    with pytest.raises(EinschaltError, match="two prices of setting; expected one"):
        costs_of("pointing=1, setting=2")


def test_a_price_of_thousands_is_no_decimal(invoke):
    shown = invoke("plan", "--target", "5cm", "--costs", "image=1,000")
    assert shown.exit_code == 2
    assert "expected costs as image=10,model=20" in " ".join(shown.stderr.split())


def test_a_height_limit_that_is_none_is_refused(invoke):
    for options in ((), ("--area", "a.geojson")):
        shown = invoke("plan", "--target", "5cm", "--max-height", 0, *options)
        assert shown.exit_code == 2
    shown = invoke("plan", "--target", "5cm", "--spacing", "250m", "--max-height", 0)
    assert "--max-height = 0; expected 5 to 20000 metres" in shown.stderr


@pytest.mark.slow
def test_plans_without_a_bound_of_their_error_are_told_and_written(invoke, tmp_path):
    options = ("--target", "1mm", "--scale-number", 8000, "--spacing", 600)
    shown = invoke("plan", *options, "--output", tmp_path / "out")
    assert shown.exit_code == 1
    text = " ".join(shown.stdout.split())
    assert "models hold so few points that it knows no bound" in text
    assert "comes to –" not in text
    assert "would help by the closed estimate: points 300 m apart" in text
    assert text.count(": –") == 0
    drawn = (tmp_path / "out" / "plans.svg").read_text("utf-8")
    assert "The estimate bounds the error of no plan." in drawn


@pytest.mark.parametrize(
    "options",
    [
        ("--target", "8cm", "--scale", 8000, "--spacing", 300),
        ("--expect", "--spacing", 300, "--width", 4000, "--height", 4000),
    ],
)
def test_one_coverage_is_told_beside_the_verdict_and_to_programs(options, invoke):
    one = (*options, "--n-coverages", 1)
    shown = invoke("plan", *one)
    assert shown.exit_code == 0, shown.stderr
    verdict = " ".join(shown.stdout[:600].split())
    assert "One coverage has no other to be compared with: gross errors" in verdict
    told = json.loads(invoke("plan", *one, "--json").stdout)
    (problem,) = told["problems"]
    assert problem["found"].endswith("gross errors cannot be seen")
    assert problem["expected"] == "two coverages or more"
    assert problem["remedy"].startswith("Write --n-coverages 2")
    two = json.loads(invoke("plan", *options, "--n-coverages", 2, "--json").stdout)
    assert not two["problems"]


def test_costs_are_called_counted_or_estimated(invoke, tmp_path):
    corners = [(0, 0), (6000, 0), (6000, 5000), (0, 5000), (0, 0)]
    ring = [[500_000 + x, 5_300_000 + y] for x, y in corners]
    system = {"type": "name", "properties": {"name": "EPSG:32633"}}
    area = tmp_path / "area.geojson"
    area.write_text(
        json.dumps({"type": "Polygon", "coordinates": [ring], "crs": system}), "utf-8"
    )
    asked = ("--target", "6cm", "--scale", "8000,9000", "--spacing", 300)
    asked = ("plan", *asked, "--n-settings", "1,2")
    over = invoke(*asked, "--area", area, "--json")
    figures, said = json.loads(over.stdout)["figures"], " ".join(over.stderr.split())
    assert re.search(r"Next best: .* dearer \(counted\)\.", said)
    counted = r"each km²: cost (\S+) of .*?, (\S+) of the next best"
    cost, other = re.search(counted, said).groups()
    assert float(cost) == pytest.approx(figures["cost_of_area"] / 30.0, rel=5e-3)
    assert float(other) == pytest.approx(figures["next_cost_of_area"] / 30.0, rel=5e-3)
    alone = " ".join(invoke(*asked).stdout.split())
    assert re.search(r"Next best: .* dearer \(estimated\)\.", alone)
    assert "cost, images and control points are estimated, for each km²" in alone


def test_a_target_out_of_reach_is_told_with_what_can_be_reached(invoke):
    call = ("plan", "--scale", 6000, "--spacing", 200, "--n-coverages", 2)
    missed = invoke(*call, "--target", "0.1mm", "--json")
    assert missed.exit_code == 1
    (problem,) = json.loads(missed.stdout)["problems"]
    said = r"The target is out of reach: .* smallest error is about ([\d.]+) (mm|cm)\."
    shown = " ".join(invoke(*call, "--target", "0.1mm").stdout.split())
    number, unit = re.search(said, shown).groups()
    assert f"is about {number} {unit}. Give a larger --target" in problem["remedy"]
    assert "Not tried, and would help" in problem["remedy"]
    within = invoke(*call, "--target", "2.5cm")
    assert "out of reach" not in within.stdout


@pytest.mark.parametrize(
    ("option", "name"),
    [
        ("--figure", "plan.pdf"),
        ("--figure", "file/plan.png"),
        ("--output", "file/plan.csv"),
        ("--output", "file/folder"),
    ],
)
def test_what_cannot_be_written_is_refused_before_the_work(
    option, name, invoke, tmp_path, monkeypatch
):
    (tmp_path / "file").write_text("a file, and no folder")
    monkeypatch.chdir(tmp_path)
    refused = invoke("plan", "--target", "5cm", option, name)
    assert refused.exit_code == 2
    assert name.rpartition("/")[2] in refused.stderr
    assert not refused.stdout  # the plan was printed, and lost with it
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
