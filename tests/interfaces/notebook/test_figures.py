"""Figures on axes of matplotlib: what they show is what the result holds."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib import pyplot as plt
from tests.changed_results import judged_before
from tests.interfaces.reports.test_planning_figures import AXES
from tests.pipeline.summary.test_german_summary import DATA, ENGLISH

import einschalt as es
from einschalt.foundations.errors import SettingsError, TableError
from einschalt.foundations.language import written_in
from einschalt.interfaces.notebook.maps import LAYERS
from einschalt.interfaces.notebook.result_plots import ResultPlots
from einschalt.interfaces.reports.planning_figures import diagrams_figure
from einschalt.interfaces.reports.plans_figure import plans_figure
from einschalt.interfaces.reports.precision_map_figure import precision_map_figure
from einschalt.pipeline.densify import densify
from einschalt.pipeline.planning.choice.check import check_plans
from einschalt.pipeline.planning.flights.arguments import planned_model
from einschalt.pipeline.planning.tables.precision_table import precision_table
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block

ROOT = Path(__file__).parents[3]
NAMES = [name for name in vars(ResultPlots) if not name.startswith("_")]


@pytest.fixture(autouse=True)
def closed():
    """No figure is left to the next test."""
    yield
    plt.close("all")


@pytest.fixture(scope="module")
def adjusted_result(demo_block):
    return densify(demo_block, Settings(method="simultaneous"))


@pytest.fixture(scope="module")
def spatial_result():
    """Spatial models from image coordinates: heights, and parallaxes."""
    geometry = replace(
        PRESETS["demo"].geometry, measurement="images", transformation="helmert_3d"
    )
    return densify(simulate_block("demo", seed=2, geometry=geometry))


def words_of(ax):
    key = ax.get_legend()
    named = [] if key is None else [text.get_text() for text in key.get_texts()]
    return ax.get_title(loc="left"), ax.get_xlabel(), ax.get_ylabel(), *named


# what the others have none of is said in test_what_a_result_has_none_of…
HAS_NONE_OF = {
    "good_result": {"parallaxes"},
    "given_approximations_result": {"parallaxes", "paper", "sources", "neighbours"},
    "adjusted_result": {"parallaxes", "sources", "neighbours", "correlogram"},
    "spatial_result": set(),
}


@pytest.mark.slow
@pytest.mark.parametrize("result", HAS_NONE_OF)
def test_each_is_drawn_on_the_axes_that_are_given(result, request):
    plot = ResultPlots(request.getfixturevalue(result))
    drawn = set()
    for name in NAMES:
        _, ax = plt.subplots()
        try:
            assert getattr(plot, name)(ax) is ax
        except TableError:
            assert not ax.has_data()
            continue
        drawn.add(name)
        title, x, y, *_ = words_of(ax)
        assert ax.has_data()
        assert title
        assert x
        assert y
    assert set(NAMES) - drawn == HAS_NONE_OF[result]


def all_texts(figure):
    """Everything that a figure says, figures at its axes too, once it is drawn."""
    figure.canvas.draw()
    texts = (one.get_text() for one in figure.findobj(plt.Text) if one.get_visible())
    return [text for text in texts if re.search("[A-Za-z0-9]", text)]


def not_german(texts):
    """Texts with English words or decimal points."""
    said = (DATA.sub("", text).strip() for text in texts)
    return [text for text in said if ENGLISH.search(text) or re.search(r"\d\.\d", text)]


@pytest.mark.slow
@pytest.mark.parametrize("result", HAS_NONE_OF)
def test_each_is_german_where_german_is_asked_for(result, request):
    plot = ResultPlots(request.getfixturevalue(result))
    for name in NAMES:
        if name in HAS_NONE_OF[result]:
            continue
        options = {"layers": LAYERS} if name == "map" else {}
        english = all_texts(getattr(plot, name)(**options).figure)
        with written_in("de"):
            ax = getattr(plot, name)(**options)
        # the figure is drawn when German is over, as a notebook does
        german = all_texts(ax.figure)
        assert not not_german(german)
        assert len(german) == len(english)
        words = {text for text in english if re.search("[a-z]{3}.* .*[a-z]{3}", text)}
        assert not {DATA.sub("", text) for text in words & {*german}} - {""}
        plt.close("all")


@pytest.mark.slow
def test_figures_of_plans_are_german_where_german_is_asked_for():
    design = es.FlightDesign(
        scale_number=8000, spacing=300, m_g_um=5, width=3000, height=3000
    )
    expected = es.expect_precision(design)
    choices = es.PlanChoices(scale_number=(6000, 9000), spacing=(300,), m_g_um=(10,))
    found = es.find_plans(0.05, choices)
    checked = check_plans(found, es.PlanFrame(), most=3)
    table = precision_table(
        AXES, planned_model("affine", "kovarik", 0.23, 0.6, 0.3), 0.152
    )
    with written_in("de"):
        figures = [
            expected.plot.map().figure,
            expected.plot.profile().figure,
            expected.plot.sources().figure,
            found.plot.costs().figure,
            plans_figure(found, checked),
            precision_map_figure(expected, expected),
            diagrams_figure(table),
        ]
    assert [text for one in figures for text in not_german(all_texts(one))] == []


def test_without_axes_there_is_a_new_figure(good_result):
    ax = ResultPlots(good_result).residuals()
    assert plt.get_fignums() == [ax.figure.number]


def test_what_a_result_has_none_of_is_said_and_leaves_no_empty_figure(good_result):
    expected = "no residual parallaxes; expected at least 20 of relative orientations"
    with pytest.raises(TableError, match=expected):
        ResultPlots(good_result).parallaxes()
    assert plt.get_fignums() == []


def test_the_map_is_in_metres_and_says_its_units(good_result):
    points = good_result.points
    ax = ResultPlots(good_result).map()
    new = points[points["role"] == "new"]
    (dots,) = (c for c in ax.collections if len(c.get_offsets()) == len(new))
    shown = np.sort(dots.get_offsets().data, axis=0)
    np.testing.assert_allclose(
        shown, np.sort(new[["easting", "northing"]].to_numpy(), axis=0)
    )
    np.testing.assert_allclose(
        np.sort(dots.get_array()), np.sort(100.0 * new["standard_error_total"])
    )
    assert ax.get_aspect() == 1.0
    assert words_of(ax)[1:3] == ("easting [km]", "northing [km]")
    bar = ax.figure.axes[-1].get_ylabel()
    assert bar == "standard_error_total of the new points [cm]"
    assert {"densified − given", "control points", "check points"} <= {*words_of(ax)}


def test_vectors_of_a_map_are_as_long_as_their_bar_says(good_result):
    ax = ResultPlots(good_result).map(layers="differences")
    (bar,) = ax.artists
    (text,) = (one.get_text() for one in bar.findobj(plt.Text) if one.get_text())
    factor = float(text.rpartition("× ")[2])
    (vectors,) = ax.collections[:1]
    feet, tips = np.stack(vectors.get_segments(), axis=1)
    points = good_result.points.dropna(subset="difference_easting")
    points = points[points["role"] != "new"]
    sides = points[["difference_easting", "difference_northing"]].to_numpy()
    np.testing.assert_allclose(tips - feet, factor * sides, atol=1e-6)


@pytest.mark.slow
def test_names_are_no_formulas(good_result):
    values = good_result.single_values
    renamed = values.assign(coverage=values["coverage"].map({"1": "$\\1", "2": "x$"}))
    block = replace(good_result.block, name="$\\no$")
    named = judged_before(good_result, single_values=renamed, block=block)
    for ax in (ResultPlots(named).coverage_differences(), ResultPlots(named).map()):
        ax.figure.canvas.draw()


def test_models_of_a_map_and_those_that_failed(faulty_result):
    ax = ResultPlots(faulty_result).map(layers=["models", "points"])
    assert {"models of the low flight", "suspect points"} <= {*words_of(ax)}
    ax = ResultPlots(faulty_result).m_0_per_model()
    assert "3 failed models" in words_of(ax)


def test_the_histogram_holds_every_new_point_and_its_key_their_quantiles(good_result):
    points = good_result.points
    errors = points.loc[points["role"] == "new", "standard_error_total"]
    ax = ResultPlots(good_result).precision()
    assert sum(bar.get_height() for bar in ax.patches) == len(errors) == 77
    title, x, _, median, most, rms = words_of(ax)
    assert title == "Precision of 77 new points"
    assert x == "standard_error_total [cm]"
    assert median == f"median {100 * np.median(errors):.1f} cm"
    assert most == f"95 % {100 * np.quantile(errors, 0.95):.1f} cm"
    assert rms == f"RMS {100 * np.sqrt(np.mean(errors**2)):.1f} cm"


def test_few_points_that_are_far_out_stand_in_the_last_bar(good_result):
    points = good_result.points.copy()
    points.loc[points.index[points["role"] == "new"][:2], "standard_error_total"] = 3.0
    wild = judged_before(good_result)
    vars(wild)["points"] = points
    ax = ResultPlots(wild).precision()
    assert ax.patches[-1].get_height() == 2
    assert words_of(ax)[1].endswith("[cm]; the last bar holds 2 beyond it")


def test_heights_have_figures_too(spatial_result):
    plot = ResultPlots(spatial_result)
    column = "standard_error_height"
    assert words_of(plot.precision(column=column))[1].startswith(f"{column} [")
    bar = plot.map(column=column).figure.axes[-1]
    assert bar.get_ylabel().startswith(f"{column} of the new points [")


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (
            lambda plot: plot.map(layers="roads"),
            "layers = 'roads'; expected some of mo",
        ),
        (lambda plot: plot.map(layers=5), "layers = 5; expected some of models"),
        (
            lambda plot: plot.map(column="width"),
            "column = 'width' is none of the point",
        ),
        (lambda plot: plot.precision(plt), "expected axes of matplotlib. Make them wi"),
    ],
)
def test_wrong_arguments_are_said(good_result, call, said):
    with pytest.raises(SettingsError, match=said):
        call(ResultPlots(good_result))
    assert plt.get_fignums() == []


def test_plans_have_figures():
    design = es.FlightDesign(
        scale_number=8000, spacing=300, m_g_um=5, width=3000, height=3000
    )
    expected = es.expect_precision(design)
    new = expected.points[expected.points["role"] == "new"]
    ax = expected.plot.map()
    assert ax.figure.axes[-1].get_ylabel() == "expected standard error, total [cm]"
    np.testing.assert_allclose(
        ax.collections[0].get_array(), 100.0 * new["standard_error_total"]
    )
    bars = expected.plot.sources().patches
    sizes = [*expected.parts.values(), expected.figures.mean]
    widths = [bar.get_width() for bar in bars]
    np.testing.assert_allclose(widths, 100.0 * np.array(sizes), rtol=1e-3)
    assert "formula of 1971" in words_of(expected.plot.profile())
    choices = es.PlanChoices(scale_number=(6000, 8000), spacing=(300,), m_g_um=(5,))
    found = es.find_plans(0.05, choices)
    ax = found.plot.costs()
    n_drawn = sum(len(dots.get_offsets()) for dots in ax.collections)
    assert n_drawn == len(found.plans)
    assert words_of(ax)[0] == f"{len(found.plans)} plans, 5.0 cm wanted"
    assert repr(found) == f"<PlanSearch: {found.verdict}>"
    assert found.verdict in " ".join(found.summary().split())
    assert found._repr_html_().count("<pre>") == expected._repr_html_().count("<pre>")


def test_the_page_names_every_figure():
    page = (ROOT / "docs" / "figures.md").read_text(encoding="utf-8")
    named = re.findall(
        r"`(\w+)\(", page.partition("| `result.plot.`")[2].split("\n\n")[0]
    )
    assert named == NAMES
