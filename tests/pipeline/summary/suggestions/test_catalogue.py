"""Problems that a block shows, each with the block that shows it."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from einschalt.pipeline.summary.sections.flights import orientations
from einschalt.pipeline.summary.suggestions import catalogue as sg
from einschalt.pipeline.summary.suggestions.known_points import claim_column
from einschalt.pipeline.summary.verdict import verdict


def with_points(result, **columns):
    """The result with columns of its points replaced by functions of the points."""
    points = result.points.copy()
    for name, change in columns.items():
        points[name] = change(points)
    return replace(result, points=points)


def with_figures(result, **figures):
    return replace(result, figures=replace(result.figures, **figures))


def with_models(result, change):
    models = result.models.copy()
    change(models)
    return replace(result, models=models)


@pytest.fixture(scope="module")
def oriented_result():
    """A block whose models are oriented from y-parallaxes."""
    from einschalt.pipeline.densify import densify
    from einschalt.pipeline.simulation.simulate_block import (
        BlockGeometry,
        simulate_block,
    )

    geometry = BlockGeometry(width=3_000.0, height=3_000.0, measurement="parallaxes")
    return densify(simulate_block("demo", seed=1, geometry=geometry))


def test_orientations_that_did_not_converge_are_named(oriented_result):
    assert sg.orientations_without_convergence(oriented_result) is None
    rows = oriented_result.orientations.copy()
    rows["is_converged"] = rows.index != rows.index[-1]
    changed = replace(oriented_result, orientations=rows)
    found = sg.orientations_without_convergence(changed)
    assert found.problem.startswith("1 model with a relative orientation that did not")
    assert found.problem.endswith(f"low {rows['model_id'].iloc[-1]}")


def test_models_near_a_dangerous_surface_are_named(oriented_result):
    assert sg.models_near_a_dangerous_surface(oriented_result) is None
    rows = oriented_result.orientations.copy()
    rows.loc[:2, "verdict"] = ["weak", "critical", "weak"]
    rows.loc[:2, "inflation"] = [2.5, 12.34, 3.0]
    names = rows["model_id"].to_numpy()
    changed = replace(oriented_result, orientations=rows)
    assert str(sg.models_near_a_dangerous_surface(changed)) == (
        f"Relative orientation near a dangerous surface: 1 model critical (high "
        f"{names[1]}), 2 models weak (high {names[0]}, high {names[2]}); omega is up "
        "to 12.3 times as uncertain as on flat terrain. Measure points in them that "
        "lie higher or lower, or farther apart."
    )
    rows.loc[1, "inflation"] = np.inf
    said = str(sg.models_near_a_dangerous_surface(changed))
    assert "; omega is not determined. Measure" in said
    # models that did not converge are named as such
    rows["is_converged"] = False
    assert sg.models_near_a_dangerous_surface(changed) is None


def test_figures_of_relative_orientation_are_said(oriented_result):
    high, of_high, low, _ = orientations(oriented_result)
    assert high.startswith("Relative orientation, high flight: 7 models, sigma_0 ")
    assert low.endswith(" µm of a y-parallax; it sees y-parallax only.")
    m_g = oriented_result.orientations.groupby("flight")["m_g_orientation_um"]
    share = np.sqrt((m_g.get_group("high_flight").astype(float) ** 2).mean())
    assert of_high == (
        "m_g of the high flight: given 7.5, of which errors of the relative "
        f"orientation make {share:.1f} µm."
    )


def test_a_good_block_has_no_problems(good_result):
    assert sg.find_suggestions(good_result) == ()


def test_failed_models_are_counted_by_reason(faulty_result):
    found = sg.failed_models(faulty_result)
    assert found.problem == "3 of 30 models failed"
    assert len(found.details) == 2
    assert found.details[0].startswith("low flight, 2 models (1/1, 1/2): ")


def test_many_reasons_are_cut_short(good_result):
    failures = pd.DataFrame(
        [
            (
                "low_flight",
                "1",
                f"{k}",
                "stage3_model_transformation",
                f"reason {k}",
                "",
            )
            for k in range(8)
        ],
        columns=good_result.failures.columns,
    )
    found = sg.failed_models(replace(good_result, failures=failures))
    assert len(found.details) == 6
    assert found.details[-1] == "and 3 further reasons, see failures.csv"


def test_measured_points_without_coordinates_are_named(good_result):
    lost = replace(good_result, points=good_result.points.iloc[2:])
    found = sg.points_without_coordinates(lost)
    first, second = good_result.points["point_id"][:2]
    assert found.problem == (
        f"2 measured points without coordinates ({first}, {second})"
    )
    assert sg.points_without_coordinates(good_result) is None


@pytest.mark.parametrize(
    ("factor", "says"), [(4.0, "Trust them more"), (0.05, "too cautious")]
)
def test_check_points_far_from_the_claim(good_result, factor, says):
    changed = with_points(
        good_result,
        difference_easting=lambda p: factor * p["difference_easting"],
        difference_northing=lambda p: factor * p["difference_northing"],
    )
    assert says in sg.check_differences(changed).remedy
    assert sg.check_differences(good_result) is None


def test_check_points_are_allowed_the_error_that_they_have(good_result):
    """With standard errors of 1 m given, differences of 10 cm prove nothing."""
    control = good_result.block.control_points.assign(standard_error_m=1.0)
    block = replace(good_result.block, control_points=control)
    found = sg.check_differences(replace(good_result, block=block))
    assert found is not None
    assert "too cautious" in found.remedy


def test_control_points_far_from_the_claim_are_named(good_result):
    is_control = good_result.points["role"] == "control"
    worst = good_result.points.loc[is_control, "point_id"].iloc[3]
    changed = with_points(
        good_result,
        difference_easting=lambda p: p["difference_easting"].where(
            p["point_id"] != worst, 2.0
        ),
    )
    assert f"largest at {worst}" in sg.control_differences(changed).problem
    assert sg.control_differences(good_result) is None


def test_a_shift_of_all_known_points_is_seen(good_result):
    changed = with_points(
        good_result, difference_northing=lambda p: p["difference_northing"] - 0.5
    )
    found = sg.shifted_block(changed)
    assert found.problem.startswith("The block is shifted: the mean difference at 6")
    assert "northing -" in found.problem
    assert sg.shifted_block(good_result) is None


def test_coverages_that_differ_more_than_the_budget(good_result):
    paper = good_result.figures.mean_paper
    changed = with_figures(good_result, mean_internal=2.0 * paper, mean_total=np.nan)
    found = sg.contradicted_figures(changed)
    assert found.problem.startswith(
        "The coverages differ more than the budget explains"
    )
    assert "Raise m_g_um" in found.remedy
    assert sg.contradicted_figures(good_result) is None
    unknown = with_figures(good_result, mean_internal=np.nan, mean_total=np.nan)
    assert sg.contradicted_figures(unknown) is None


def test_a_propagated_figure_that_the_measurements_contradict(
    good_result, faulty_result
):
    """Propagation knows no measurement: a blunder of 200 m does not enlarge it."""
    assert sg.has_credible_propagation(good_result)
    assert claim_column(good_result) == "standard_error_total"
    assert not sg.has_credible_propagation(faulty_result)
    assert claim_column(faulty_result) == "standard_error_paper"
    found = sg.contradicted_figures(faulty_result)
    assert found.problem.startswith("The measurements contradict the propagated figure")
    assert " m or worse (total, mean of two coverages)" in verdict(faulty_result)


def test_a_high_flight_that_fits_worse_than_its_errors(good_result):
    assert sg.high_flight_misfit(good_result) is None
    changed = with_figures(good_result, m_0_high=0.5)
    found = sg.high_flight_misfit(changed)
    assert found.problem == (
        "m_0 of the high flight is 50 cm, 4.3 times the 12 cm that m_g_um and the "
        "control points' errors explain"
    )
    assert not sg.has_credible_propagation(changed)


def test_exchanged_names_show_as_points_that_differ(faulty_result):
    found = sg.points_that_differ(faulty_result)
    assert "with values more than 5 times as widely scattered" in found.problem
    models = faulty_result.block.low_flight.model_points
    last = models[models["model_id"] == models["model_id"].iloc[-1]]
    assert set(last["point_id"]) & set(found.problem.replace(",", " ").split())


def test_models_with_large_m_0_are_named(good_result):
    def enlarge(models):
        models.loc[models.index[-1], "m_0"] = 5.0

    found = sg.models_with_large_m_0(with_models(good_result, enlarge))
    name = good_result.models["model_id"].iloc[-1]
    assert found.problem.startswith("1 model with m_0 more than 3 times")
    assert f"low {name}; up to 5.0 m" in found.problem


def test_mirrored_models_are_told_apart_from_mirrored_axes(good_result):
    def mirror_one(models):
        models.loc[models.index[0], ["a1", "b1"]] *= -1.0

    def mirror_all(models):
        models[["a1", "b1"]] *= -1.0

    one = sg.mirrored_models(with_models(good_result, mirror_one))
    assert one.problem.startswith("1 of 30 affine models mirrored: high ")
    everyone = sg.mirrored_models(with_models(good_result, mirror_all))
    assert everyone.problem == "All 30 affine models are mirrored"
    assert sg.mirrored_models(good_result) is None


def test_points_in_one_coverage_or_model(good_result):
    is_first = good_result.points.index < 3
    changed = with_points(
        good_result,
        n_coverages=lambda p: p["n_coverages"].where(~is_first, 1),
        n_models=lambda p: p["n_models"].where(p.index != 0, 1),
    )
    found = sg.points_in_one_coverage(changed)
    assert found.problem.startswith("3 points in one coverage only (")
    assert found.problem.endswith("1 of them in one model only")


def test_models_without_redundancy_are_named(good_result):
    def exhaust(models):
        models.loc[models.index[-1], "redundancy"] = 0

    found = sg.models_without_redundancy(with_models(good_result, exhaust))
    assert found.problem.startswith("1 model without redundancy: low ")


def test_a_block_without_check_points_says_so(unchecked_result):
    assert 'role = "check"' in sg.no_check_points(unchecked_result).remedy


def test_what_the_propagated_figure_lacks_is_said(good_result):
    from einschalt.pipeline.block.block import Block
    from einschalt.pipeline.densify import densify

    block = good_result.block
    control = block.control_points.drop(columns="standard_error_m")
    flights = {"high_flight": block.high_flight, "low_flight": block.low_flight}
    result = densify(Block(control_points=control, crs=block.crs, **flights))
    assert "standard_error_total" not in result.points
    said = " ".join(result.summary().split())
    assert "standard_error_total is left out: the control points have no stand" in said
    assert "Give standard_error_m, TOTAL in metres, in [control_points]." in said
    assert sg.figure_left_out(good_result) is None


def test_notes_of_reading_are_passed_on(good_result):
    block = good_result.block
    object.__setattr__(block, "notes", ("low.csv: ignored column colour",))
    try:
        found = sg.notes_of_reading(good_result)
    finally:
        object.__setattr__(block, "notes", ())
    assert [str(note) for note in found] == ["low.csv: ignored column colour."]
