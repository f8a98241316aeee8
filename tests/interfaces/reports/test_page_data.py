"""What the page draws is what the result holds."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from tests.changed_results import changed, judged_before
from tests.interfaces.reports.test_packed_data import Unpacked

from einschalt.interfaces.files.block_folder import read_block
from einschalt.interfaces.files.block_writing import write_block
from einschalt.interfaces.reports.html_report import page_data
from einschalt.interfaces.reports.page_models import KEYS, footprints
from einschalt.interfaces.reports.page_plots import plots, sources_of_error
from einschalt.interfaces.reports.page_points import MOST_SIGNS, evenly_chosen
from einschalt.interfaces.reports.title_block import title_block
from einschalt.pipeline.settings import Settings


@pytest.fixture(scope="module")
def data(good_result):
    return Unpacked(page_data(good_result, "cm"))


@pytest.mark.parametrize(
    ("unit", "name", "metres"), [("km", "km", 1e3), ("um", "µm", 1e-6), ("m", "m", 1.0)]
)
def test_errors_of_any_size_have_a_unit(good_result, unit, name, metres):
    """Control in gon, or a wrong zone, is kilometres off."""
    told = Unpacked(page_data(good_result, unit)).head["unit"]
    assert told == {"name": name, "metres": pytest.approx(metres)}


def test_points_come_back(data, good_result):
    points, facts = good_result.points, data.head["points"]
    assert data.names(facts["names"]) == list(points["point_id"])
    assert data.texts(facts["role"]) == list(points["role"])
    claim = data.head["claim"]
    for name, column, within in (
        ("east", "easting", 5.1e-4),
        ("north", "northing", 5.1e-4),
        ("error", claim, 2e-4),
        ("paper", "standard_error_paper", 2e-4),
        ("models", "n_models", 0.0),
    ):
        np.testing.assert_allclose(
            data.numbers(facts[name]), points[column].astype(float), atol=within, rtol=0
        )
    known = points["difference_easting"].where(points["role"] != "new")
    np.testing.assert_allclose(data.numbers(facts["known_east"]), known, atol=5e-4)


def test_of_many_points_some_have_signs_and_they_lie_evenly():
    assert evenly_chosen(1000).all()
    chosen = evenly_chosen(100_000)
    assert chosen.mean() == pytest.approx(MOST_SIGNS / 100_000, rel=1e-3)
    # in every column alike where points stand in rows of a hundred
    by_column = chosen.reshape(-1, 100).mean(axis=0)
    assert by_column.min() > 0.2
    assert by_column.max() < 0.3


def test_coverage_differences_are_first_minus_second(data, good_result):
    values = good_result.single_values
    name = good_result.points["point_id"].iloc[40]
    own = values[values["point_id"] == name].groupby("coverage")["northing"].mean()
    found = data.numbers(data.head["points"]["apart_north"])[40]
    assert found == pytest.approx(own["1"] - own["2"], abs=1e-3)
    assert data.head["coverages"] == ["1", "2"]


def test_footprints_hold_the_points_of_their_models(good_result):
    corners = footprints(good_result)
    xy = good_result.points[["easting", "northing"]].to_numpy()
    row_of = pd.Series(range(len(xy)), good_result.points["point_id"])
    values = good_result.single_values.assign(flight="low_flight")
    by_model = values.groupby(KEYS)["point_id"]
    for place, model in enumerate(good_result.models[KEYS].itertuples(index=False)):
        if tuple(model) not in by_model.groups:
            continue
        own = xy[row_of[by_model.get_group(tuple(model))]]
        polygon = xy[corners[place].astype(int)]
        np.testing.assert_array_equal(polygon.min(axis=0), own.min(axis=0))
        np.testing.assert_array_equal(polygon.max(axis=0), own.max(axis=0))
        # counter-clockwise, nowhere turning to the right
        sides = np.roll(polygon, -1, axis=0) - polygon
        after = np.roll(sides, -1, axis=0)
        turns = sides[:, 0] * after[:, 1] - sides[:, 1] * after[:, 0]
        assert (turns >= -1e-6).all()


def test_residuals_of_normal_errors_are_shown_as_normal(good_result):
    shown = plots(good_result)["residuals"]
    assert shown["n"] == 2 * len(good_result.residuals) == sum(shown["counts"])
    expected, observed = np.array(shown["expected"]), np.array(shown["observed"])
    inner = np.abs(expected) < 1.5
    np.testing.assert_allclose(observed[inner], expected[inner], atol=0.25)
    assert (np.diff(observed) >= 0.0).all()


def test_sources_add_up(good_result, given_approximations_result):
    shown = plots(good_result)["sources"]
    assert sum(shown["shares"]) == pytest.approx(1.0, abs=1e-3)
    new = good_result.points["role"] == "new"
    total = good_result.points.loc[new, "standard_error_total"] ** 2
    classes = np.array(shown["classes"])
    assert classes.shape == (10, len(shown["codes"]))
    assert classes.sum(axis=1).mean() == pytest.approx(total.mean(), rel=0.02)
    assert (np.diff(classes.sum(axis=1)) > 0.0).all()
    assert "sources" not in plots(given_approximations_result)


def test_small_errors_have_sources_as_well(good_result):
    columns = [
        name for name in good_result.error_sources if name.startswith("standard_error_")
    ]
    table = good_result.error_sources.copy()
    table[columns] /= 1000.0  # a tenth of a millimetre
    small = SimpleNamespace(
        block_error_sources=good_result.block_error_sources,
        error_sources=table,
        points=good_result.points,
    )
    expected = np.array(sources_of_error(good_result)["classes"]) / 1e6
    shown = sources_of_error(small)["classes"]
    np.testing.assert_allclose(shown, expected, rtol=1e-3)


def test_residuals_of_a_gross_error_are_counted_at_the_end(good_result):
    rows = good_result.residuals.copy()
    rows.loc[3, "residual_easting"] = 100.0
    shown = plots(judged_before(good_result, residuals=rows))["residuals"]
    assert shown["n_far"] == 1
    assert shown["counts"][-1] == 1


@pytest.mark.parametrize("name", ["given_approximations", "unchecked"])
def test_blocks_of_other_kinds_have_data(name, request):
    Unpacked(page_data(request.getfixturevalue(f"{name}_result"), "mm"))


def test_the_title_block_says_whose_the_block_is(tmp_path, demo_block, good_result):
    named = replace(demo_block, project="A1 & A2", operator="Ä. Bauer")
    write_block(named, tmp_path / "block")
    read = read_block(tmp_path / "block")
    shown = dict(title_block(judged_before(good_result, block=read)))
    assert (shown["Project"], shown["Operator"]) == ("A1 & A2", "Ä. Bauer")
    assert re.fullmatch("[0-9a-f]{16}", shown["Checksum of the input"])


def test_the_title_block_names_the_system_and_the_method(good_result):
    shown = dict(title_block(good_result))
    assert shown["Reference system"] == "MGI / Austria GK Central (EPSG:31255)"
    assert shown["Method"].startswith("two steps")
    assert shown["Settings"] == "all defaults"
    # as on a form that nobody has filled in
    assert shown["Project"] == shown["Operator"] == "not given"
    assert "Checksum of the input" not in shown  # of a block without files
    chosen = changed(
        good_result, settings=Settings(weighting="plain", significance=0.01)
    )
    assert dict(title_block(chosen))["Settings"] == (
        "weighting = plain, significance = 0.01; others default"
    )
