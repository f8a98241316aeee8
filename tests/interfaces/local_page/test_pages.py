"""Compare, plan and many blocks: what the pages say, and what they refuse."""

import json
import re
import shutil
import time
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

import einschalt as es
from einschalt.interfaces.files.result_folder import write_result
from einschalt.interfaces.local_page import batch_pages, plan_pages
from einschalt.interfaces.local_page.comparison import compare
from einschalt.interfaces.local_page.drawings import precision_map, vectors
from einschalt.interfaces.local_page.refusals import RefusedError


@pytest.fixture(scope="module")
def results(tmp_path_factory, good_result):
    """Two results of a block: the second without a point, one point moved by 5 m."""
    from tests.changed_results import judged_before

    root = tmp_path_factory.mktemp("results")
    points = good_result.points.copy()
    points.loc[points.index[5], "easting"] += 3.0
    points.loc[points.index[5], "northing"] -= 4.0
    other = judged_before(good_result, points=points.drop(index=points.index[0]))
    write_result(good_result, root / "first")
    write_result(other, root / "second")
    return root


@pytest.mark.slow
def test_results_are_compared_point_by_point(visit, results, good_result):
    moved = good_result.points["point_id"].iloc[5]
    found = compare(results / "first", results / "second")
    assert found.columns == ("point", "role", "ΔE [m]", "ΔN [m]", "total [m]")
    assert [*found.rows[0][:1], *map(float, found.rows[0][2:])] == [moved, 3, -4, 5]
    assert {row[-1] for row in found.rows[1:]} == {found.rows[1][-1]}
    assert float(found.rows[1][-1]) == 0.0
    assert found.apart[-1] == ("5.0 m", "largest")
    assert "1 point in the first result alone." in found.remarks
    page = visit(results).get("/compare?a=first&b=second").text
    assert found.verdict in page
    assert page.count('class="vector"') == len(good_result.points)  # and its scale


@pytest.mark.slow
def test_results_of_different_blocks_say_so_first(results, good_result, tmp_path):
    other = es.densify(replace(good_result.block, name="Other"))
    write_result(other, tmp_path / "other")
    found = compare(results / "first", tmp_path / "other")
    name = good_result.block.name
    assert found.verdict.startswith(f"Different blocks, {name} and Other: ")
    assert not compare(results / "first", results / "second").verdict.startswith("Diff")


def test_results_of_other_inputs_say_which_differ(make_block, tmp_path):
    folder = make_block(tmp_path / "block").path
    write_result(es.densify(es.read_block(folder)), tmp_path / "first")
    path = folder / "control_points.csv"
    path.write_text(f"{path.read_text('utf-8').strip()}\n\n", encoding="utf-8")
    write_result(es.densify(es.read_block(folder)), tmp_path / "second")
    results = tmp_path / "first", tmp_path / "second"
    said = "The inputs are not the same: control_points.csv differ."
    assert compare(*results).remarks[0] == said
    assert compare(results[0], results[0]).remarks == []
    for name in ("high_flight.csv", "low_flight.csv"):
        path = folder / name
        path.write_text(f"{path.read_text('utf-8').strip()}\n\n", encoding="utf-8")
    write_result(es.densify(es.read_block(folder)), tmp_path / "third")
    remark = compare(results[0], tmp_path / "third").remarks[0]
    assert remark.startswith("All inputs differ: control_points.csv, high_flight.csv")


def test_what_is_no_result_is_not_compared(visit, results, tmp_path):
    shutil.copytree(results / "first", tmp_path / "changed")
    frame = pd.read_parquet(tmp_path / "changed" / "points.parquet")
    frame.to_parquet(tmp_path / "changed" / "points.parquet", compression="gzip")
    with pytest.raises(RefusedError, match="as einschalt has written it"):
        compare(tmp_path / "changed", results / "second")
    visitor = visit(results)
    assert visitor.get("/compare?a=first&b=../secret").status == 403
    assert visitor.get("/compare?a=first&b=nothing").status == 404


def test_a_result_leads_to_its_report_and_to_others(visit, results):
    page = visit(results).get("/result?path=first").text
    assert 'src="/report?path=first"' in page
    assert "<option>second</option>" in page


def test_sliders_answer_as_the_planning_does(visit, root):
    from einschalt.pipeline.planning.estimate.search import PlanChoices, find_plans

    choices = PlanChoices(
        scale_number=(6000.0,),
        spacing=(300.0,),
        m_g_um=(5.0,),
        high_over_low=(2.5,),
        n_settings=(2,),
        n_coverages=(2,),
        control_per_model=(9,),
    )
    plan = find_plans(1.0, choices).plans.iloc[0]
    asked = "scale_number=6000&high_over_low=2.5&spacing=300&m_g_um=5&n_settings=2"
    asked += "&n_coverages=2&control_per_model=9&control_cm=3"
    answer = json.loads(visit(root).get(f"/plan/figures?{asked}").text)
    figures = {text: figure for figure, text in answer["figures"]}
    assert (
        figures["expected, total (estimate)"] == f"{100 * plan['expected_mean']:.1f} cm"
    )
    assert float(figures["cost per km² (estimate)"]) == pytest.approx(
        plan["cost"], rel=0.05
    )
    assert figures["high flight above ground"] == f"{plan['high_flying_height']:.0f} m"
    assert answer["is_plan"]


def test_the_map_says_what_was_propagated_for_it(visit, root):
    drawn = json.loads(visit(root).get("/plan/map?camera=film_wide&spacing=300").text)
    design = es.FlightDesign(
        scale_number=8000,
        spacing=300,
        m_g_um=5,
        high_scale_number=15000,
        high_m_g_um=5,
        n_coverages=2,
    )
    mean = es.expect_precision(design).figures.mean
    said = f"the points will have {100 * mean:.1f} cm (mean of the coverages), total"
    assert said in drawn["said"]
    assert drawn["svg"].startswith("<svg")


def test_a_drone_above_its_limit_is_told(visit, root):
    answer = json.loads(visit(root).get("/plan/figures?camera=uav_one_inch").text)
    said = "The high flight, 165 m above ground, is higher than the 120 m that drones "
    assert answer["said"].startswith(said)
    low = "/plan/figures?camera=uav_one_inch&high_over_low=1.25"
    assert "120 m" not in json.loads(visit(root).get(low).text)["said"]


@pytest.mark.parametrize(
    "asked",
    ["spacing=1e9", "camera=<b>", "scale_number=-1", "m_g_um=", "m_g_um= "],
)
def test_sliders_take_nothing_beyond_their_ranges(asked):
    fields = dict([asked.split("=")])
    camera, values = plan_pages._values(fields)
    for slider in plan_pages.sliders_of(camera):
        assert slider.least <= values[slider.name] <= slider.most
    answer = plan_pages.figures_of(fields)
    assert answer["is_plan"] or "points lie in a" in answer["said"]


@pytest.mark.parametrize("typed", ["abc", "nan", "1e999", "1,5,0", "1.234,5"])
def test_what_is_no_number_is_not_taken_for_the_usual_value(visit, root, typed):
    for page in ("plan", "plan/figures", "plan/map"):
        answer = visit(root).get(f"/{page}?spacing={typed}")
        assert "is not a number" in answer.text, page


def test_sliders_take_either_decimal_sign():
    comma, point = ({"m_g_um": typed} for typed in ("7,5", "7.5"))
    assert plan_pages._values(comma) == plan_pages._values(point)


@pytest.mark.parametrize("camera", plan_pages.CAMERAS)
def test_sliders_stand_at_their_steps(camera):
    """A browser would move them there, and the figures would be those of elsewhere."""
    asked = {
        "camera": camera,
        "spacing": "250,5",
        "m_g_um": "7.77",
        "n_settings": "2.6",
    }
    _, values = plan_pages._values(asked)
    for slider in plan_pages.sliders_of(camera):
        n_steps = (values[slider.name] - slider.least) / slider.step
        assert round(n_steps) == pytest.approx(n_steps, abs=1e-6), slider
    assert values["n_settings"] == 3


def test_the_usual_flight_of_every_camera_is_within_its_sliders():
    for camera in plan_pages.CAMERAS:
        assert plan_pages.figures_of({"camera": camera})["is_plan"], camera
        for slider in plan_pages.sliders_of(camera):
            assert slider.least <= slider.usual <= slider.most, (camera, slider)


def test_maps_show_every_point_where_it_lies():
    points = pd.DataFrame(
        {
            "easting": [0.0, 100.0, 0.0],
            "northing": [0.0, 0.0, 100.0],
            "role": ["control", "new", "new"],
            "standard_error_total": [0.01, 0.02, 0.03],
        }
    )
    drawing = precision_map(points)
    marks = re.findall(r'class="c(\d)" cx="([\d.]+)" cy="([\d.]+)"', drawing)
    steps, x, y = (list(map(float, part)) for part in zip(*marks, strict=True))
    assert steps == [0.0, 4.0, 8.0]
    assert x[1] > x[0] == x[2]
    assert y[2] < y[0] == y[1]  # north is above
    assert drawing.count('class="control"') == 1
    still = points.assign(d_easting=0.0, d_northing=0.0, total=0.0)
    assert "nan" not in vectors(still)


def test_no_vector_is_cut_at_the_edge_of_its_map():
    """A point at the left that moved west by what nobody else did."""
    places = [(0.0, 0.0), (0.0, 100.0), (100.0, 0.0), (100.0, 100.0)]
    moves = [(-1.0, -1.0), (0.0, 1.0), (1.0, 0.0), (0.0, 0.0)]
    moved = pd.DataFrame(places, columns=["easting", "northing"])
    moved[["d_easting", "d_northing"]] = moves
    moved["total"] = np.hypot(moved["d_easting"], moved["d_northing"])
    drawing = vectors(moved)
    box = re.search(r'viewBox="([^"]*)"', drawing)[1]
    left, above, width, height = map(float, box.split())
    ends = re.findall(r"M([-\d.]+) ([-\d.]+)l([-\d.]+) ([-\d.]+)", drawing)
    assert len(ends) == len(moved)
    x, y, dx, dy = np.array(ends, dtype=float).T
    assert left <= (x + dx).min() < 40.0  # beyond the points
    assert (x + dx).max() <= left + width
    assert above <= (y + dy).min()
    below = float(re.search(r"M40 ([\d.]+)h", drawing)[1])
    assert (y + dy).max() < below < above + height  # the scale stands below all


def test_a_start_without_a_block_is_refused(visit, root):
    visitor = visit(root)
    answer = visitor.post("/start", {})
    assert answer.status == 404
    assert "holds no block.toml" in answer.text
    assert list(root.iterdir()) == []


@pytest.mark.slow
def test_many_blocks_fill_a_table(visit, root, make_block):
    make_block(root / "sound")
    spoilt = make_block(root / "<i>spoilt")
    spoilt.replace("low_flight.csv", "coverage", "covfefe")
    visitor = visit(root)
    listed = visitor.get("/batch").text
    assert "2 blocks" in listed
    assert "&lt;i&gt;spoilt" in listed
    visitor.post("/batch", {"output": "all"})
    run = visitor.session.runs.get(1)
    cells = [row["cells"] for row in batch_pages.rows_of(run)]
    assert sorted(cells)[1][0] == "sound"
    end = time.monotonic() + 300.0
    while run.state == "running" and time.monotonic() < end:
        time.sleep(0.05)
    assert run.state == "done", run.problems
    page = visitor.get("/run/1").text
    assert '<a href="/result?path=all%2Fsound">sound</a>' in page
    assert "<i>" not in page
    assert "low_flight.csv" in page
    state = json.loads(visitor.get("/run/1/state").text)
    outcomes = {row["cells"][0]: row["cells"][1] for row in state["rows"]}
    assert outcomes == {"sound": "done", "<i>spoilt": "failed"}
    assert (root / "all" / "blocks.html").exists()


@pytest.mark.slow
def test_a_block_that_names_files_elsewhere_is_left_out_of_a_batch(
    visit, root, make_block
):
    block = make_block(root / "other")
    block.replace("block.toml", "control_points.csv", "../../secret/control_points.csv")
    visitor = visit(root)
    assert visitor.post("/batch", {"output": "all"}).status == 403
    assert visitor.get("/batch").status == 403
    assert not (root / "all").exists()
    make_block(root / "sound")
    listed = visitor.get("/batch").text
    assert "1 block in" in listed
    assert re.search(r"Left out.*<li>other: .*not below the folder", listed, re.DOTALL)
    visitor.post("/batch", {"output": "all"})
    run = visitor.session.runs.get(1)
    end = time.monotonic() + 300.0
    while run.state == "running" and time.monotonic() < end:
        time.sleep(0.05)
    assert run.state == "done", run.problems
    assert list(run.rows) == ["sound"]
    assert not (root / "all" / "other").exists()
