"""Figures of plans: what is drawn is what was computed, and the same each time."""

import numpy as np
import pytest

from einschalt.interfaces.files.plan_folder import write_plan
from einschalt.interfaces.reports import planning_figures as figures
from einschalt.pipeline.expected_precision import expect_precision
from einschalt.pipeline.flight_design import FlightDesign
from einschalt.pipeline.plan_search import PlanChoices, find_plans
from einschalt.pipeline.planning import precision_table
from einschalt.pipeline.planning_arguments import planned_model


@pytest.fixture(scope="module")
def table():
    axes = {
        "scale_number": [6000, 8000, 12000],
        "spacing": [200, 400],
        "m_0": [0.1, 0.2],
        "m_g_um": [10, 5],
    }
    return precision_table(
        axes, planned_model("affine", "kovarik", 0.23, 0.6, 0.3), 0.152
    )


@pytest.fixture(scope="module")
def expected():
    return expect_precision(
        FlightDesign(scale_number=8000, spacing=300, m_g_um=5, width=4e3, height=4e3)
    )


def test_diagram_4_goes_through_the_table(table):
    figure = figures.total_error_figure(table)
    assert [panel.get_title()[:2] for panel in figure.axes] == ["4a", "4b", "4c", "4d"]
    # 4d: m_0 20 cm, 5 µm; edge at 400 m, which begins at 1:6000
    edge = figure.axes[3].lines
    drawn = {line.get_label(): line for line in edge}["400 m"].get_ydata()[0]
    assert drawn == pytest.approx(100 * table.array("M_edge")[0, 1, 1, 1])


def test_diagrams_1_to_3_go_through_the_table(table):
    first, second, third = figures.points_and_transformation_figure(table).axes
    n_points = {line.get_label(): line for line in second.lines}["200 m"].get_ydata()
    assert n_points[[0, -1]] == pytest.approx(table.array("n_points")[[0, 2], 0, 0, 0])
    m_t = {line.get_label(): line for line in third.lines}["400 m"].get_ydata()
    assert m_t[0] == pytest.approx(100 * table.array("m_t_edge")[0, 1, 0, 0])
    assert "middle" in {line.get_label() for line in first.lines}


def test_one_scale_and_a_lattice_can_be_drawn():
    axes = {"scale_number": [6000], "spacing": [400], "m_0": [0.1], "m_g_um": [10]}
    model = planned_model("affine", "lattice", 0.23, 0.6, 0.3)
    table = precision_table(axes, model, 0.152)
    for figure in (
        figures.total_error_figure(table),
        figures.points_and_transformation_figure(table),
    ):
        assert figures.figure_bytes(figure)["png"].startswith(b"\x89PNG")


def test_plans_show_the_front(table):
    found = find_plans(
        0.05, PlanChoices(scale_number=(6000, 9000), spacing=(300,), m_g_um=(10,))
    )
    (panel,) = figures.plans_figure(found).axes
    front = next(line for line in panel.lines if line.get_label() == "efficient")
    assert len(front.get_xdata()) == found.plans["is_efficient"].sum()
    assert np.all(np.diff(front.get_ydata()) < 0)
    nowhere = find_plans(
        0.001, PlanChoices(scale_number=(6000,), spacing=(300,), m_g_um=(10,))
    )
    texts = [text.get_text() for text in figures.plans_figure(nowhere).axes[0].texts]
    assert any(text.startswith("nearest: 1:6000") for text in texts)


def test_map_has_one_colour_for_one_error(expected):
    panels = figures.precision_map_figure(expected, expected).axes
    maps = [panel for panel in panels if panel.get_xlabel() == "east [km]"]
    assert len(maps) == 3
    norms = {panel.collections[0].norm for panel in maps}
    assert len(norms) == 1
    profile = next(p for p in panels if p.get_title() == "one model's values")
    assert profile.lines[0].get_ydata().max() >= 100 * expected.figures.single_centre


def test_files_are_the_same_each_time_and_whole(table, tmp_path):
    def drawn():
        return figures.figure_bytes(figures.total_error_figure(table))

    first = drawn()
    assert first == drawn()
    assert b"<svg" in first["svg"]
    write_plan(tmp_path / "plan", {}, {"diagram_4": first}, "text")
    names = sorted(file.name for file in (tmp_path / "plan").iterdir())
    assert names == ["diagram_4.png", "diagram_4.svg", "summary.txt"]
