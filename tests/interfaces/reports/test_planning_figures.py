"""Figures of plans: what is drawn is what was computed, and the same each time."""

from itertools import combinations

import numpy as np
import pytest
import shapely

from einschalt.foundations.errors import FileError
from einschalt.interfaces.files.plan_folder import write_figure, write_plan
from einschalt.interfaces.reports import figure_files
from einschalt.interfaces.reports.planning_figures import diagrams_figure
from einschalt.interfaces.reports.plans_figure import plans_figure
from einschalt.interfaces.reports.precision_map_figure import precision_map_figure
from einschalt.pipeline.planning.area.flight_area import FlightArea
from einschalt.pipeline.planning.area.recommended import plan_area, search_over
from einschalt.pipeline.planning.choice.check import check_plans
from einschalt.pipeline.planning.estimate.search import (
    PlanChoices,
    PlanFrame,
    find_plans,
)
from einschalt.pipeline.planning.flights.arguments import planned_model
from einschalt.pipeline.planning.flights.flight_design import FlightDesign
from einschalt.pipeline.planning.propagation.expected_precision import expect_precision
from einschalt.pipeline.planning.tables.precision_table import precision_table

AXES = {
    "scale_number": [6000, 8000, 12000],
    "spacing": [200, 400],
    "m_0": [0.1, 0.2],
    "m_g_um": [10, 5],
}
# what the colour-blind see of linear red, green, blue: Machado, Oliveira and Fernandes
# 2009, table 1, severity 1
COLOUR_BLIND = {
    "protanopia": [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "deuteranopia": [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ],
    "tritanopia": [
        [1.255528, -0.076749, -0.178779],
        [-0.078411, 0.930809, 0.147602],
        [0.004733, 0.691367, 0.303900],
    ],
    "none": np.eye(3),
}


@pytest.fixture(scope="module")
def table():
    model = planned_model("affine", "kovarik", 0.23, 0.6, 0.3)
    return precision_table(AXES, model, 0.152)


@pytest.fixture(scope="module")
def expected():
    return expect_precision(
        FlightDesign(scale_number=8000, spacing=300, m_g_um=5, width=4e3, height=4e3)
    )


def edges(panel):
    """The edge curves of a panel, in the order of the spacings."""
    return [line.get_ydata() for line in panel.lines if len(line.get_xdata()) > 100]


def bars(panel):
    """Lower and upper ends of the bars, by spacing and scale."""
    return np.array(
        [[path[:, 1] for path in bar.get_segments()] for bar in panel.collections]
    )


def test_the_sheet_holds_all_diagrams(table):
    titles = [panel.get_title(loc="left") for panel in diagrams_figure(table).axes]
    assert [title.split()[0] for title in titles] == [
        *("1", "2", "3", "3", "4a", "4b", "4c", "4d")
    ]


def test_bars_and_lines_are_those_of_the_table(table):
    *_, third, a, b, c, d = diagrams_figure(table).axes[2:]
    for panel, symbol in ((third, "m_t"), (d, "M")):
        names = f"{symbol}_centre", f"{symbol}_edge"
        for spacing in range(2):
            low, high = (100 * table.array(n)[:, spacing, 1, 1] for n in names)
            np.testing.assert_allclose(bars(panel)[spacing, :, 0], low)
            np.testing.assert_allclose(bars(panel)[spacing, :, 1], high)
            curve = edges(panel)[spacing]
            np.testing.assert_allclose(curve[[0, -1]], high[[0, -1]])
    # one height for all that are compared
    assert len({panel.get_ylim() for panel in (a, b, c, d)}) == 1


def test_the_ring_is_the_best_scale(table):
    a = diagrams_figure(table).axes[4]
    (ring,) = [line for line in a.lines if line.get_markerfacecolor() == "white"]
    # 200 m is best below 1:6000, 400 m at 1:7326
    assert ring.get_xdata()[0] == pytest.approx(7326, abs=25)


def test_points_are_those_of_the_table(table):
    first, second = diagrams_figure(table).axes[:2]
    n_points = second.lines[0].get_ydata()
    assert n_points[[0, -1]] == pytest.approx(table.array("n_points")[[0, 2], 0, 0, 0])
    assert first.lines[0].get_ydata()[30 - 4] == pytest.approx(0.1826, abs=5e-5)
    assert [text.get_text() for text in second.texts] == ["400 m", "200 m"]


@pytest.mark.slow
@pytest.mark.parametrize("edge", ["kovarik", "lattice"])
def test_one_scale_and_many_values_can_be_drawn(edge):
    model = planned_model("affine", edge, 0.23, 0.6, 0.3)
    single = {"scale_number": [6000], "spacing": [500], "m_0": [0.1], "m_g_um": [10]}
    many = {
        "scale_number": np.arange(5000, 15000, 500),
        "spacing": np.arange(100, 400, 20),
        "m_0": [0.1, 0.15, 0.2],
        "m_g_um": [10, 7, 5],
    }
    for axes, n_panels in ((single, 4), (many, 12)):
        figure = diagrams_figure(precision_table(axes, model, 0.152))
        assert len(figure.axes) == n_panels
        assert figure_files.figure_bytes(figure, ("png",))["png"].startswith(b"\x89PNG")


def test_labels_keep_apart_and_order():
    places = figure_files.apart([1.0, 1.1, 1.2, 5.0, 5.3], 0.5)
    assert np.diff(places).min() == pytest.approx(0.5)
    assert places[:3] == pytest.approx([0.6, 1.1, 1.6])
    assert sum(places) == pytest.approx(13.6)


def test_colours_differ_for_the_colour_blind():
    wanted = [colour_of(code) for code in figure_files.ORDERED]
    for sight in COLOUR_BLIND.values():
        seen = [lab(np.clip(np.array(sight) @ colour, 0.0, 1.0)) for colour in wanted]
        # neighbours in CIELAB: 2 is just seen, 10 at a glance
        assert min(np.linalg.norm(a - b) for a, b in combinations(seen, 2)) > 25.0


def colour_of(code):
    srgb = np.array([int(code[i : i + 2], 16) for i in (1, 3, 5)]) / 255.0
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def lab(linear):
    to_xyz = [
        [0.4124564, 0.3575761, 0.1804375],
        [0.2126729, 0.7151522, 0.0721750],
        [0.0193339, 0.1191920, 0.9503041],
    ]
    ratio = np.array(to_xyz) @ linear / [0.95047, 1.0, 1.08883]
    f = np.where(ratio > 0.008856, np.cbrt(ratio), 7.787 * ratio + 16 / 116)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


def test_plans_show_the_front_and_what_holds():
    choices = PlanChoices(scale_number=(6000, 9000), spacing=(300,), m_g_um=(10,))
    found = find_plans(0.05, choices)
    checked = check_plans(found, PlanFrame(), most=3)
    (panel,) = plans_figure(found, checked).axes
    front = next(line for line in panel.lines if line.get_label() == "efficient")
    assert len(front.get_xdata()) == found.plans["is_efficient"].sum()
    assert np.all(np.diff(front.get_ydata()) < 0)
    said = " ".join(text.get_text() for text in panel.texts)
    assert f"{found.plans['is_feasible'].sum()} reach it" in said
    assert "cheapest estimate: low flight 1:" in said
    (panel,) = plans_figure(find_plans(0.001, choices)).axes
    assert any("nearest: low flight 1:6000" in text.get_text() for text in panel.texts)


def test_map_has_one_colour_for_one_error(expected):
    panels = precision_map_figure(expected, expected).axes
    maps = [panel for panel in panels if panel.get_xlabel() == "east [km]"]
    assert len(maps) == 3
    assert len({panel.collections[0].norm for panel in maps}) == 1
    titles = [panel.get_title(loc="left") for panel in maps]
    assert titles[0] == f"expected: {100 * expected.figures.mean:.1f} cm"
    profile = next(p for p in panels if "One model" in p.get_title(loc="left"))
    assert profile.lines[0].get_ydata().max() >= 100 * expected.figures.single_centre


def test_map_of_an_area_is_in_its_system_and_ends_at_its_border():
    """A notch and a hole stay white."""
    low = np.array([420_000.0, 330_000.0])
    # the hole runs in the direction of the outline, as of any file
    outline = [[0, 0], [4000, 0], [4000, 2000], [2000, 2000], [2000, 4000], [0, 4000]]
    hole = [[500, 500], [1500, 500], [1500, 1500], [500, 1500]]
    shape = shapely.Polygon(low + outline, [low + hole])
    area = FlightArea(shapely.affinity.rotate(shape, 20.0, origin=tuple(low)))
    choices = PlanChoices(
        scale_number=(8000,), spacing=(250,), m_g_um=(10,), n_coverages=(2,)
    )
    found, frame = search_over(0.2, area, choices, PlanFrame())
    plan = plan_area(area, found, frame)
    figure = precision_map_figure(plan.checked.expected, area=plan.checked_on)
    figure.canvas.draw()
    pixels = np.asarray(figure.canvas.buffer_rgba())
    panel = next(p for p in figure.axes if p.get_xlabel() == "east [km]")
    east, north = panel.dataLim.intervalx, panel.dataLim.intervaly
    bounds = np.array(area.shape.bounds) / 1e3
    np.testing.assert_allclose([east[0], north[0], east[1], north[1]], bounds)

    def is_white(place):
        at = low + place
        turned = shapely.affinity.rotate(shapely.Point(at), 20.0, origin=tuple(low))
        column, row = panel.transData.transform([turned.x / 1e3, turned.y / 1e3])
        around = pixels[
            -int(row) - 3 : -int(row) + 3, int(column) - 3 : int(column) + 3
        ]
        return (around[..., :3] == 255).all(axis=-1).mean() > 0.5

    assert is_white([1000.0, 1000.0])
    assert is_white([3000.0, 3000.0])
    assert not is_white([3000.0, 1000.0])
    assert not is_white([1000.0, 3000.0])


@pytest.mark.slow
def test_files_are_the_same_each_time_and_whole(table, tmp_path):
    def drawn():
        return figure_files.figure_bytes(diagrams_figure(table))

    first = drawn()
    assert first == drawn()
    assert b"<svg" in first["svg"]
    write_plan(tmp_path / "plan", {}, {"diagrams": first}, "text")
    names = sorted(file.name for file in (tmp_path / "plan").iterdir())
    assert names == ["diagrams.png", "diagrams.svg", "summary.txt"]


def test_a_figure_of_unknown_suffix_is_not_drawn(tmp_path):
    def fail():
        raise AssertionError

    with pytest.raises(FileError, match=r"'\.doc' is none of a figure.*Write a\.png"):
        write_figure(fail, tmp_path / "a.doc")
