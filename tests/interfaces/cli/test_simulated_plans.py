"""``einschalt simulate --plan``: a plan that is tried before it is flown."""

import json
import tomllib

import numpy as np
import pandas as pd
import pytest

import einschalt as es

pytestmark = pytest.mark.usefixtures("undrawn")

UTM = "EPSG:32633"
CENTRE = np.array([500_000.0, 5_300_000.0])
RING = [(0, 0), (7200, 900), (8000, 4200), (3800, 6600), (600, 5000), (0, 0)]
ONE_PLAN = (
    *("--scale-number", 11_000, "--spacing", 300, "--n-settings", 2),
    *("--n-coverages", 2, "--high-over-low", 1.5, "--control-per-model", 5),
)
SEED = 7


def figures_of(shown):
    assert shown.exit_code == 0, shown.stderr
    return json.loads(shown.stdout)["figures"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("tried")
    ring = [list(CENTRE + corner) for corner in RING]
    named = {"type": "name", "properties": {"name": UTM}}
    area = {"type": "Polygon", "coordinates": [ring], "crs": named}
    (folder / "north.geojson").write_text(json.dumps(area), "utf-8")
    x, y = np.meshgrid(np.arange(-5, 86) * 100.0, np.arange(-5, 76) * 100.0)
    z = 400.0 + 80.0 * np.sin(x / 900.0) + 40.0 * np.cos(y / 700.0)
    ground = np.column_stack([x.ravel() + CENTRE[0], y.ravel() + CENTRE[1], z.ravel()])
    np.savetxt(folder / "ground.xyz", ground, "%.2f")
    return folder


@pytest.fixture(scope="module")
def planned(invoke, folder):
    """What programs are told of a plan, and its folder."""
    area = ("--area", folder / "north.geojson", "--ground-heights", "ground.xyz")
    area = (*area[:3], folder / area[3])
    output = ("--output", folder / "plan", "--json")
    shown = invoke("plan", "--target", "6cm", *area, *ONE_PLAN, *output)
    return figures_of(shown), folder / "plan"


@pytest.fixture(scope="module")
def tried(invoke, planned):
    """What programs are told of the simulated plan, and the folder of the block."""
    place = planned[1].parent / "block"
    call = ("simulate", "--plan", planned[1], "--output", place, "--seed", SEED)
    return figures_of(invoke(*call, "--json")), place


@pytest.mark.slow
def test_python_simulates_a_folder_as_the_command_does(planned, tried):
    block = es.simulate_plan(planned[1], seed=SEED)
    by_command = es.read_block(tried[1])
    for flight in ("high_flight", "low_flight"):
        here, there = (
            getattr(one, flight).model_points.reset_index(drop=True)
            for one in (block, by_command)
        )
        pd.testing.assert_frame_equal(here, there)
    with pytest.raises(es.EinschaltError, match="frame beside a plan"):
        es.simulate_plan(planned[1], frame=es.PlanFrame())
    with pytest.raises(es.EinschaltError, match="does not exist"):
        es.simulate_plan(planned[1] / "elsewhere")


def test_programs_are_told_what_the_whole_area_takes(planned):
    told, plan = planned
    totals, effort = told["totals"], pd.DataFrame(told["effort"])
    lines = pd.read_csv(plan / "flight_lines.csv")
    assert totals["photographs"] == len(pd.read_csv(plan / "photographs.csv"))
    assert totals["control_points"] == len(pd.read_csv(plan / "control.csv"))
    assert totals["flight_lines"] == len(lines)
    assert totals["length_of_lines"] == pytest.approx(lines["length"].sum(), rel=1e-6)
    written = pd.read_csv(plan / "effort.csv")
    pd.testing.assert_frame_equal(effort, written, check_dtype=False)
    items = ("photographs", "models", "pointings", "control_points")
    assert list(effort["amount"]) == [totals[name] for name in items]
    assert totals["cost"] == told["cost_of_area"] == effort["cost"].sum()
    # the row of the plan is for each km², as it was laid out
    assert told["images"] * totals["area_km2"] == pytest.approx(totals["photographs"])
    assert told["is_recommended"] is True
    assert told["expected_on_layout"]["mean"] == told["reached_on_layout"]
    in_file = json.loads((plan / "plan.json").read_text("utf-8"))
    assert in_file["figures"]["totals"] == totals
    assert in_file["expected"] == told["reached_on_layout"]


def test_planned_and_simulated_precision_agree(tried, planned):
    told, _ = tried
    assert told["planned"] == planned[0]["reached_on_layout"]
    # points share errors: some hundred of them are known as well as some dozen are
    independent = 1.0 / np.sqrt(told["n_new"])
    assert independent < told["error_total_by_chance"] / told["planned"] < 0.15
    away = abs(told["error_total"] - told["planned"])
    # three standard errors of this simulation, and 3 % of planning
    assert away < 3.0 * told["error_total_by_chance"] + 0.03 * told["planned"]
    # the claim is no matter of chance, but its layout stands on hills
    assert told["standard_error_total"] == pytest.approx(told["planned"], rel=0.01)


def test_both_figures_stand_beside_each_other(invoke, planned, tmp_path):
    call = ("simulate", "--plan", planned[1], "--output", tmp_path / "b")
    shown = invoke(*call, "--seed", SEED).stdout.splitlines()
    first = shown.index(next(x for x in shown if x.startswith("Planned and simulated")))
    expected = f"{100 * planned[0]['reached_on_layout']:.2f} cm"
    assert shown[first + 1].split("  ")[1:] == ["planned", *[""] * 7, expected]
    assert "claimed, propagated" in shown[first + 2]
    assert shown[first + 3].endswith("cm by chance)")


def test_the_block_has_the_layout_of_the_plan(tried, planned, invoke, tmp_path):
    _, place = tried
    plan = planned[1]
    head = tomllib.loads((place / "block.toml").read_text("utf-8"))["block"]
    assert head["name"] == "north, film_wide, 1:11000 and 1:16500, 300 m (simulated)"
    assert head["crs"] == UTM
    control, wanted = (
        pd.read_csv(file).set_index("point_id")
        for file in (place / "control_points.csv", plan / "control.csv")
    )
    assert set(control.index) == set(wanted.index)
    assert (control["standard_error_m"] == wanted["standard_error_m"]).all()
    truth = pd.read_csv(place / "truth.csv").set_index("point_id")
    plane = ["easting", "northing"]
    assert np.abs(truth.loc[wanted.index, plane] - wanted[plane]).max().max() < 1e-5
    error = control[plane].to_numpy() - truth.loc[control.index, plane].to_numpy()
    assert 0.02 < np.sqrt((error**2).sum(axis=1).mean()) < 0.04
    files = (place / f"{flight}_flight.csv" for flight in ("high", "low"))
    models = [pd.read_csv(file)[["coverage", "model_id"]] for file in files]
    n_models = sum(len(table.drop_duplicates()) for table in models)
    assert n_models == planned[0]["totals"]["models"]


def test_photographs_are_those_of_the_plan(invoke, planned, tmp_path):
    call = ("simulate", "--plan", planned[1], "--output", tmp_path / "b")
    shown = invoke(*call, "--measurement", "images", "--no-compare", "--title", "Mine")
    assert shown.exit_code == 0, shown.stderr
    assert shown.stdout.startswith("Mine: ")
    assert "Planned and simulated" not in shown.stdout
    files = (tmp_path / "b" / f"{f}_flight_image_points.csv" for f in ("high", "low"))
    images = [pd.read_csv(file)["image_id"].nunique() for file in files]
    photographs = pd.read_csv(planned[1] / "photographs.csv")["flight"]
    assert images == [(photographs == f"{f}_flight").sum() for f in ("high", "low")]


@pytest.mark.slow
def test_densify_gives_the_figure_that_was_compared(invoke, tried, tmp_path):
    told, place = tried
    call = ("densify", place, "--output", tmp_path / "out", "--no-report", "--json")
    found = figures_of(invoke(*call))
    claimed = found["mean_total"]
    assert claimed == pytest.approx(told["standard_error_total"], rel=1e-6)


def test_seeds_change_errors_and_nothing_else(invoke, planned, tried, tmp_path):
    call = ("simulate", "--plan", planned[1], "--no-compare", "--output")
    assert invoke(*call, tmp_path / "other", "--seed", SEED + 1).exit_code == 0
    assert invoke(*call, tmp_path / "same", "--seed", SEED).exit_code == 0
    for file, is_of_errors in (("truth.csv", False), ("low_flight.csv", True)):
        own = (tried[1] / file).read_bytes()
        assert (tmp_path / "same" / file).read_bytes() == own
        assert ((tmp_path / "other" / file).read_bytes() != own) is is_of_errors


@pytest.mark.usefixtures("in_this_process")
def test_repetitions_have_the_planned_figure_first(invoke, planned, tmp_path):
    call = ("simulate", "--plan", planned[1], "--output", tmp_path / "many")
    shown = invoke(*call, "--repeat", 2, "--workers", 1)
    assert shown.exit_code == 0, shown.stderr
    first, second = shown.stdout.splitlines()[1:3]
    assert first.split() == [
        "planned",
        f"{100 * planned[0]['reached_on_layout']:.1f}",
        "cm",
    ]
    assert second.startswith("  true error")


def test_rows_of_a_search_are_tried(invoke, tmp_path):
    asked = ("--target", "6cm", "--spacing", 300, "--scale-number", "8000,10000")
    plans = ("--n-coverages", 2, "--high-over-low", "1.5", "--n-settings", 4)
    shown = invoke("plan", *asked, *plans, "--output", tmp_path / "plan")
    assert shown.exit_code == 0, shown.stderr
    call = ("simulate", "--plan", tmp_path / "plan", "--json", "--no-compare")
    table = pd.read_csv(tmp_path / "plan" / "plans.csv")
    for row in (None, 2):
        option = () if row is None else ("--row", row)
        told = figures_of(invoke(*call, "--output", tmp_path / f"b{row}", *option))
        low = pd.read_csv(tmp_path / f"b{row}" / "low_flight.csv")
        assert low.groupby(["coverage", "model_id"]).size().min() >= 4
    of_row = table.iloc[1]
    assert f"1:{of_row['scale_number']:.0f} and 1:" in told["block"]
    assert told["planned"] == pytest.approx(of_row["expected_mean"], rel=0.2)
    refused = invoke(*call, "--output", tmp_path / "no", "--row", 1000)
    assert refused.exit_code == 2
    assert "has no plan 1000" in refused.stderr


def test_a_plan_of_one_layout_is_tried(invoke, tmp_path):
    asked = ("--expect", "--scale-number", 8000, "--spacing", 300, "--m-g-um", 5)
    size = ("--width", 4000, "--height", 4000)
    expected = figures_of(
        invoke("plan", *asked, *size, "--output", tmp_path / "plan", "--json")
    )
    call = ("simulate", "--plan", tmp_path / "plan", "--output", tmp_path / "block")
    told = figures_of(invoke(*call, "--json"))
    assert told["planned"] == expected["mean"]
    assert told["standard_error_total"] == pytest.approx(expected["mean"], rel=1e-3)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (("--width", 3000), "--width beside --plan"),
        (("--camera", "dmc_3"), "--camera beside --plan"),
        (("--low-scale", 9000), "--low-scale beside --plan"),
    ],
)
def test_the_layout_of_a_plan_is_not_changed(options, says, invoke, planned, tmp_path):
    call = ("simulate", "--plan", planned[1], "--output", tmp_path / "block")
    shown = invoke(*call, *options)
    assert shown.exit_code == 2
    assert says in shown.stderr
    assert not (tmp_path / "block").exists()


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (("--row", 2), "--row without --plan"),
        (("--camera", "dmc_3", "--preset", "demo"), "--preset beside --camera"),
        (("--image-format", "0.23"), "expected 2 to 1000 millimetres"),
        (("--plan", "no_where"), "no_where"),
    ],
)
def test_what_is_missing_is_told(options, says, invoke, tmp_path):
    shown = invoke("simulate", "--output", tmp_path / "block", *options)
    assert shown.exit_code == 2
    assert says in shown.stderr


def test_a_camera_flies_as_it_is_planned(invoke, tmp_path):
    asked = ("--camera", "ultracam_xp", "--spacing", 300)
    call = ("simulate", "--output", tmp_path / "block", *asked, "--scale-number", 25000)
    told = figures_of(invoke(*call, "--json"))
    assert told["block"] == "ultracam_xp, 1:25000 and 1:46875, 300 m (simulated)"
    head = tomllib.loads((tmp_path / "block" / "block.toml").read_text("utf-8"))
    assert head["low_flight"]["scale_number"] == 25000
    assert head["low_flight"]["m_g_um"] == 2.5
    size = (
        pd.read_csv(tmp_path / "block" / "low_flight.csv")
        .groupby(["coverage", "model_id"])[["x", "y"]]
        .agg(np.ptp)
    )
    # 60 % of 67.9 mm along the strip, 103.9 mm across, turned a little by the machine
    assert 30.0 < size["x"].max() < 47.0
    assert 90.0 < size["y"].max() < 106.0


def test_a_camera_of_one_s_own(invoke, tmp_path):
    call = ("simulate", "--preset", "demo", "--output", tmp_path / "block", "--json")
    sides = ("--image-format", "180x230", "--principal-distance", 115)
    told = figures_of(invoke(*call, *sides, "--control-per-model", 9))
    assert told["block"] == "1:8000 and 1:15000, 300 m (simulated)"
    size = (
        pd.read_csv(tmp_path / "block" / "low_flight.csv")
        .groupby(["coverage", "model_id"])[["x", "y"]]
        .agg(np.ptp)
    )
    assert size["x"].max() < 0.6 * 180 + 12.0
