"""Designs of flights, and their expected precision."""

import pickle
import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

import einschalt as es
from einschalt.foundations.errors import EinschaltError, GeometryError, SettingsError
from einschalt.pipeline.planning.flights.flight_design import FlightDesign
from einschalt.pipeline.planning.propagation import expected_precision
from einschalt.pipeline.planning.propagation.expected_precision import (
    expect_precision,
    propagate_design,
    zones_of,
)
from einschalt.stages.error_propagation.plane_flights import UnusableModelError

DESIGN = FlightDesign(scale_number=8000, spacing=300, m_g_um=5, width=4500, height=4500)


@pytest.fixture(scope="module")
def expected():
    return expect_precision(DESIGN)


@pytest.mark.parametrize("most_work", [0, -1.0, float("nan"), "1e7", True, None])
def test_a_limit_of_work_is_a_number_above_zero(most_work):
    with pytest.raises(SettingsError, match=r"most_work = .*; expected a number above"):
        replace(DESIGN, most_work=most_work)
    assert replace(DESIGN, most_work=np.inf).layout_spacing == DESIGN.spacing


@pytest.mark.parametrize(
    "means", [{"weighting": "plain"}, {"weighting": "weighted"}], ids=str
)
def test_a_propagated_block_can_be_pickled(means):
    propagated = propagate_design(DESIGN, **means)
    back = pickle.loads(pickle.dumps(propagated))
    assert "expected" not in vars(back)  # is made when it is asked for, as before
    for name in ("points", "values"):
        pd.testing.assert_frame_equal(
            getattr(back.expected, name), getattr(propagated.expected, name)
        )


@pytest.mark.parametrize("weighting", ["auto", "plain", "weighted", "rigorous"])
def test_figures_are_those_of_the_block_itself(weighting):
    expected = expect_precision(DESIGN, weighting=weighting)
    block = es.simulate_block(seed=0, geometry=DESIGN.geometry(), noise=DESIGN.noise())
    result = es.densify(block, es.Settings(weighting=weighting))
    assert expected.figures.mean == pytest.approx(result.figures.mean_total, rel=1e-12)
    paper = result.figures.mean_paper
    if result.solution.means.is_rigorous:  # the formula is one of plain means
        of_values = result.single_values.groupby("point_id")["standard_error_paper"]
        of_points = of_values.agg(lambda errors: np.mean(errors**2) / len(errors))
        is_new = result.points.set_index("point_id")["role"] == "new"
        paper = np.sqrt(of_points[is_new].mean())
    assert expected.figures.paper_mean == pytest.approx(paper, rel=1e-12)
    assert len(expected.values) == len(result.single_values)


def test_expected_is_what_densify_does_if_nothing_is_asked(expected):
    assert expected.figures == expect_precision(DESIGN, weighting="rigorous").figures
    plain = expect_precision(DESIGN, weighting="plain").figures
    assert 0.95 * plain.mean < expected.figures.mean < 0.99 * plain.mean
    # the most central values have plain means, as they have in densify
    central = expect_precision(DESIGN, coverage_mean="most_central").figures
    assert central.mean > expected.figures.mean


def test_the_formula_is_that_of_the_values_that_are_averaged():
    of_paper = [
        expect_precision(DESIGN, coverage_mean="most_central", weighting=weighting)
        for weighting in ("plain", "rigorous")
    ]
    plain, rigorous = (expected.figures for expected in of_paper)
    # the models lie on other approximate coordinates, which are means as well
    assert rigorous.paper_mean == pytest.approx(plain.paper_mean, rel=5e-3)
    assert rigorous.mean < plain.mean


def test_one_model_alone_is_the_point_itself():
    # where a point lies in one model only, its value is its coordinate
    expected = expect_precision(replace(DESIGN, n_coverages=1))
    values = expected.values.groupby("point_id").filter(lambda rows: len(rows) == 1)
    points = expected.points.set_index("point_id")["standard_error_total"]
    assert len(values) > 5
    np.testing.assert_allclose(
        values["standard_error_total"], points.loc[values["point_id"]], rtol=1e-9
    )


def test_parts_make_the_whole(expected):
    total = np.sqrt(sum(part**2 for part in expected.parts.values()))
    assert total == pytest.approx(expected.figures.mean)


def test_zones_lie_where_they_should(expected):
    zones = zones_of(expected.values)
    assert not (zones["centre"] & zones["edge"]).any()
    assert all(zone.any() for zone in zones.values())
    figures = expected.figures
    assert figures.single_centre < figures.single_edge
    assert figures.paper_mean < figures.mean < figures.single


def test_shifting_the_second_coverage_gains(expected):
    unshifted = expect_precision(replace(DESIGN, coverage_shift=0.0))
    assert unshifted.figures.mean > expected.figures.mean
    one = expect_precision(replace(DESIGN, n_coverages=1))
    assert one.figures.mean > unshifted.figures.mean


def test_summary_says_both_and_where_it_comes_from(expected):
    text = expected.summary()
    assert text.startswith("Expected precision of")
    for part in (
        "one model, edge",
        "rule of 1971",
        "Contributions: control",
        "1:15000",
    ):
        assert part in text


def test_an_oblong_image_covers_what_it_should():
    design = replace(DESIGN, image_format=(0.1, 0.2))
    geometry = design.geometry()
    assert geometry.image_base == pytest.approx(0.04)
    assert geometry.image_strip_distance == pytest.approx(0.14)
    rim = 0.1 / 46
    assert geometry.usable_model == pytest.approx((0.06 - 2 * rim, 0.2 - 2 * rim))
    square = replace(DESIGN, image_format=(0.2, 0.2)).geometry()
    assert (
        square.usable_model == replace(DESIGN, image_format=0.2).geometry().usable_model
    )


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"scale_number": "1:8000"}, "Give the denominator: 8000 for 1:8000"),
        ({"high_scale_number": "1:20 000"}, "Give the denominator"),
        ({"scale_number": 0}, "scale_number = 0"),
        ({"spacing": -300}, "spacing = -300"),
        ({"m_g_um": 5e-6}, "Did you give metres"),
        ({"high_scale_number": 6000}, "smaller image scale"),
        ({"high_m_g_um": 0}, "m_g_um = 0"),
        ({"n_coverages": 7}, "n_coverages = 7"),
        ({"control_per_model": 4}, "control_per_model = 4"),
        ({"forward_overlap": 0.4}, "forward_overlap = 0.4; expected 0.522 to"),
        ({"coverage_shift": 2}, "coverage_shift = 2"),
        ({"width": 500, "height": 500}, "2 x 2 points lie on 500 x 500 m"),
        ({"spacing": 2000}, "larger than a model at 1:8000"),
    ],
)
def test_impossible_designs_are_refused(change, says):
    with pytest.raises(EinschaltError, match=says):
        replace(DESIGN, **change)


def test_crowded_models_are_laid_out_with_fewer_points():
    crowded = FlightDesign(
        scale_number=8000,
        spacing=30,
        m_g_um=1.9,
        image_format=(0.024, 0.036),
        principal_distance=0.035,
        forward_overlap=0.8,
        side_overlap=0.6,
        width=900,
        height=900,
    )
    assert crowded.layout_spacing == 30.0
    few = replace(crowded, spacing=10)
    assert 20.0 < few.layout_spacing < 30.0
    # the same errors as those of the points that can still be laid out
    mean = expect_precision(crowded).figures.mean
    expected = expect_precision(few)
    assert expected.figures.mean == pytest.approx(mean, rel=0.03)
    said = " ".join(expected.summary().split())
    assert "apart instead of 10, which hardly matters" in said


@pytest.mark.slow
def test_fewer_points_have_the_control_and_the_errors_of_all():
    """They had other control, over areas of other extents: errors 11 % larger."""
    thinned = FlightDesign(
        scale_number=8000,
        spacing=5,
        m_g_um=1.9,
        image_format=(0.013, 0.0173),
        principal_distance=0.0123,
        forward_overlap=0.8,
        side_overlap=0.6,
    )
    closer = replace(thinned, most_work=8.0 * thinned.most_work)
    assert (thinned.layout_spacing, closer.layout_spacing) == pytest.approx(
        (9.9, 5.0), abs=0.1
    )
    few, many = map(expect_precision, (thinned, closer))
    assert few.n_control == many.n_control
    assert few.n_high_models == many.n_high_models
    assert few.n_low_models == many.n_low_models
    assert few.figures.mean == pytest.approx(many.figures.mean, rel=0.03)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["affine", "rigid"])
def test_a_seventh_of_the_points_makes_the_errors_of_all(kind):
    """Their measuring errors counted as those of single points: 5 to 7 % larger."""
    thinned = FlightDesign(
        scale_number=13_500,
        spacing=15,
        m_g_um=1.0,
        kind=kind,
        image_format=(0.0088, 0.0132),
        principal_distance=0.0088,
        forward_overlap=0.8,
        side_overlap=0.6,
        width=700,
        height=700,
        most_work=2.5e6,
    )
    assert thinned.layout_spacing > 2.6 * 15
    few, many = map(propagate_design, (thinned, replace(thinned, most_work=np.inf)))
    assert few.n_low_models == many.n_low_models
    assert few.mean == pytest.approx(many.mean, rel=0.025)


def test_something_else_is_refused():
    with pytest.raises(SettingsError, match="a FlightDesign"):
        expect_precision({"scale_number": 8000})


@pytest.mark.parametrize("n_coverages", [1, 2, 3])
def test_the_rule_of_1971_knows_how_many_coverages_there_are(n_coverages):
    expected = expect_precision(replace(DESIGN, n_coverages=n_coverages))
    rule = expected.formula
    mean = np.hypot(rule.M_centre, rule.M_edge) / np.sqrt(2.0 * n_coverages)
    table = expected.summary()
    (row,) = re.findall(
        r"^  (?:one coverage|mean of \w+ coverages) .*$", table, re.MULTILINE
    )
    assert float(row.split()[-1]) == pytest.approx(100 * mean, abs=0.051)


def test_an_area_of_control_alone_is_refused():
    small = replace(DESIGN, width=900.0, height=900.0, control_per_model=9)
    with pytest.raises(GeometryError, match="all points of the area would be control"):
        expect_precision(small)


@pytest.mark.parametrize(
    ("kind", "scale_number", "n_coverages", "weighting"),
    # at 1:33000 the map bends the models of both flights
    [
        ("affine", 8000, 2, "plain"),
        ("affine", 8000, 2, "rigorous"),
        ("helmert", 8000, 1, "auto"),
        ("rigid", 8000, 2, "auto"),
        ("affine", 33000, 2, "auto"),
    ],
)
def test_arrays_give_what_the_stages_give(
    kind, scale_number, n_coverages, weighting, monkeypatch
):
    spacing = scale_number / 20.0
    design = FlightDesign(
        scale_number=scale_number,
        spacing=spacing,
        m_g_um=5,
        kind=kind,
        n_coverages=n_coverages,
        width=25.0 * spacing,
        height=20.0 * spacing,
    )
    by_arrays = expect_precision(design, weighting=weighting)

    def refuse(*_flights):
        raise UnusableModelError

    monkeypatch.setattr(expected_precision, "propagate_flights", refuse)
    by_stages = expect_precision(design, weighting=weighting)
    for name in ("points", "values"):
        one, other = getattr(by_arrays, name), getattr(by_stages, name)
        pd.testing.assert_frame_equal(one, other, rtol=1e-12, atol=1e-15)
    for name in ("figures", "formula"):
        one, other = (vars(getattr(e, name)) for e in (by_arrays, by_stages))
        assert one == pytest.approx(other, rel=1e-12, nan_ok=True)
    assert by_arrays.parts == pytest.approx(by_stages.parts, rel=1e-12)
    assert by_arrays.summary() == by_stages.summary()
