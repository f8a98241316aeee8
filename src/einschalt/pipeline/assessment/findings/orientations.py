"""Relative orientations: convergence, dangerous surfaces, contradictions."""

from dataclasses import asdict

import numpy as np

from einschalt.foundations.units import METRES_PER_MM, METRES_PER_UM
from einschalt.pipeline.assessment.evidence.ground.frame import are_upside_down
from einschalt.pipeline.assessment.evidence.image_precision import (
    good_sigma_0,
    image_component,
)
from einschalt.pipeline.assessment.evidence.images.better_image_points import (
    better_image_points,
)
from einschalt.pipeline.assessment.finding import Gravity
from einschalt.pipeline.assessment.findings.kinds import (
    MODEL,
    MOST_NAMED,
    finding,
    models_of,
    row_keys,
    weak_models,
)
from einschalt.stages.stage3_model_transformation import transform_models
from einschalt.theory.adjustment.global_tests import ratio_p_value
from einschalt.theory.adjustment.heavy_tails import FAR_OUT_BY_CHANCE
from einschalt.theory.adjustment.multiple_testing import any_significant, bonferroni
from einschalt.theory.adjustment.significance import FINDING_SIGNIFICANCE

LARGE_SIGMA = 3.0
# m_0 with corrections over m_0 without: of the wrong sign they double what they mend
SPOILT = 1.2
IMAGE_POINT = (*MODEL, "point_id")
# what was done with image points that contradict their pair
DONE = {"keep": "measure_again_or_snoop", "snoop": "taken_out"}
TAILS = dict.fromkeys(("keep", "snoop"), "weigh_wrong_points_down")


def orientations_without_convergence(examined):
    """Models whose relative orientation did not come to rest."""
    rows = examined.orientations
    if rows.empty:
        return None
    return weak_models(
        "orientations_without_convergence",
        rows[~rows["is_converged"].astype(bool)],
        remedy="look_for_gross_errors_of_orientation",
    )


def models_near_a_dangerous_surface(examined):
    """Models whose points hardly determine their relative orientation."""
    rows = examined.orientations
    if rows.empty:
        return None
    rows = rows[rows["is_converged"].astype(bool)]
    critical, weak = (rows[rows["verdict"] == word] for word in ("critical", "weak"))
    if critical.empty and weak.empty:
        return None
    found = [part for part in (critical, weak) if len(part)]
    inflation = float(max(part["inflation"].max() for part in found))
    return finding(
        "models_near_a_dangerous_surface",
        names=[*critical["model_id"], *weak["model_id"]],
        statistic="standard error of omega, by that on flat terrain",
        observed=inflation,
        expected=1.0,
        remedy="measure_points_elsewhere",
        facts={
            "critical": models_of(critical),
            "weak": models_of(weak),
            # infinite where the points determine nothing
            "inflation": inflation,
        },
    )


def ambiguous_orientations(examined):
    """Pairs whose points do not tell two orientations apart."""
    rows = examined.orientations
    if rows.empty or not rows["is_ambiguous"].any():
        return None
    open_ones = rows[(rows["is_ambiguous"] & rows["is_converged"]).astype(bool)]
    return weak_models(
        "ambiguous_orientations", open_ones, remedy="measure_more_points"
    )


def orientations_with_large_sigma_0(examined):
    """Models whose relative orientation fits far worse than those of their flight."""
    rows = examined.orientations
    if rows.empty:
        return None
    sigma_0 = rows["sigma_0"].astype(float)
    usual = sigma_0.groupby(rows["flight"]).transform("median")
    # one redundant observation says little: a large one may be chance
    ratio = (sigma_0 / usual).to_numpy()
    p_value = bonferroni(ratio_p_value(ratio, rows["redundancy"]), len(rows))
    is_large = (ratio > LARGE_SIGMA) & (p_value < FINDING_SIGNIFICANCE)
    if not is_large.any():
        return None
    worst = rows[is_large].loc[sigma_0[is_large].idxmax()]
    largest = float(worst["sigma_0"]) * METRES_PER_MM
    return finding(
        "orientations_with_large_sigma_0",
        names=rows.loc[is_large, "model_id"],
        statistic="sigma_0 of a relative orientation",
        observed=largest,
        expected=float(usual[worst.name]) * METRES_PER_MM,
        probability=np.nanmin(p_value),
        remedy="look_for_gross_errors_of_orientation",
        facts={
            **models_of(rows[is_large]),
            "times_usual": LARGE_SIGMA,
            "largest_sigma_0": largest,
        },
    )


def image_points_worse_than_given(examined):
    """Flights whose image points are less precise than their m_g says.

    The other way round proves nothing: residuals see y-parallax only.
    """
    worse = []
    for name, rows in examined.orientations.groupby("flight", sort=False):
        flight = examined.block.flights[name]
        if not flight.has_images:
            continue
        shown = image_component(rows, flight, good_sigma_0(examined, name))
        if shown.estimated > shown.given and shown.is_contradicted:
            worse.append(shown.facts_of(name))
    if not worse:
        return None
    return finding(
        "image_points_worse_than_given",
        names=[part["flight"] for part in worse],
        statistic="m_g of image points",
        observed=worse[0]["estimated_um"] * METRES_PER_UM,
        expected=worse[0]["given_um"] * METRES_PER_UM,
        remedy="give_that_m_g_or_a_larger_one",
        facts={"flights": tuple(worse)},
    )


def image_points_better_than_given(examined):
    """Flights whose image points are more precise than their m_g says.

    Where the block shows it as well: residuals of orientations alone prove nothing.
    """
    found = better_image_points(examined)
    if not found:
        return None
    better = [shown.facts_of(name) for name, shown in found.items()]
    return finding(
        "image_points_better_than_given",
        names=[part["flight"] for part in better],
        statistic="m_g of image points",
        observed=better[0]["estimated_um"] * METRES_PER_UM,
        expected=better[0]["given_um"] * METRES_PER_UM,
        remedy="give_a_smaller_m_g",
        facts={"flights": tuple(better)},
    )


def heavy_tails_of_image_points(examined):
    """Flights of whose image points a share is much worse than the others."""
    flights = tuple(
        {
            "flight": name,
            "far_out": tails.far_out,
            "good_sigma_0": tails.sigma * METRES_PER_MM,
            "share": tails.share,
            "times_as_large": tails.factor,
        }
        for name, tails in examined.image_tails.items()
    )
    if not flights:
        return None
    worst = max(examined.image_tails.values(), key=lambda tails: tails.far_out)
    return finding(
        "heavy_tails_of_image_points",
        names=[part["flight"] for part in flights],
        statistic="image points beyond three standard errors of the good ones",
        observed=worst.far_out,
        expected=FAR_OUT_BY_CHANCE,
        probability=worst.p_value,
        remedy=TAILS.get(examined.settings.outliers, "wrong_points_weigh_less"),
        facts={"flights": flights},
    )


def corrections_that_spoil(two_step):
    """Flights whose models fit better without the correction by y-parallaxes."""
    for name, flight in two_step.block.flights.items():
        if flight.y_parallaxes is None:
            continue
        fit = two_step.solution.first_fit(name)
        ground = two_step.solution.ground_of(name)
        without = transform_models(flight.points_to_fit, ground, flight.transformation)
        if fit.m_0_plan > SPOILT * without.m_0_plan:
            return _spoilt(name, float(fit.m_0_plan), float(without.m_0_plan))
    return None


def corrections_that_spoil_two_steps(adjusted):
    """The same in the two steps beside an adjustment, where they are possible."""
    if not adjusted.two_step.is_possible:
        return None
    return corrections_that_spoil(adjusted.two_step)


def _spoilt(flight, corrected, uncorrected):
    return finding(
        "corrections_that_spoil",
        names=(flight,),
        statistic="m_0 of the flight",
        observed=corrected,
        expected=uncorrected,
        remedy="turn_sign_of_y_parallax",
        facts={
            "flight": flight,
            "m_0_corrected": corrected,
            "m_0_uncorrected": uncorrected,
        },
    )


def models_upside_down(examined):
    """Spatial models that had to be turned over: mirror images of flat terrain."""
    models = are_upside_down(examined.models)
    over = models[models["is_upside_down"]]
    return weak_models("models_upside_down", over, remedy="turn_sign_of_x_or_y")


def exchanged_image_names(examined):
    """Pairs of points measured under each other's name in a photograph."""
    found = examined.exchanged_image_names
    if not found:
        return None
    worst, takes_part = found[0], any(each.takes_part for each in found)
    return finding(
        "exchanged_image_names",
        gravity=Gravity.GRAVE if takes_part else Gravity.WARNING,
        names=worst.points,
        statistic="sigma_0 of the model, as measured and with the names put right",
        observed=worst.sigma_0 * METRES_PER_MM,
        expected=worst.sigma_0_exchanged * METRES_PER_MM,
        remedy="put_the_names_right",
        facts={
            "n_exchanges": len(found),
            "exchanges": tuple(map(_facts_in_metres, found[:MOST_NAMED])),
            "takes_part": takes_part,
            "explains": (),
        },
    )


def _facts_in_metres(exchange):
    facts = asdict(exchange)
    lengths = ("sigma_0", "sigma_0_exchanged")
    return facts | {name: facts[name] * METRES_PER_MM for name in lengths}


def image_points_that_contradict(examined):
    """Image points that contradict their pair."""
    rows = examined.orientation_residuals
    if "is_suspect" not in rows or not rows["is_suspect"].any():
        return None
    p_value = rows["p_value"].to_numpy(dtype=float)
    # a suspect of one pair in a thousand is chance: the worst must stand out of all
    if not any_significant(p_value, FINDING_SIGNIFICANCE):
        return None
    suspects = rows[rows["is_suspect"]].sort_values("p_value", kind="stable")
    image_points = row_keys(suspects, IMAGE_POINT)
    return finding(
        "image_points_that_contradict",
        names=suspects["point_id"],
        statistic="residual of an image point",
        probability=np.nanmin(bonferroni(p_value)),
        remedy=DONE.get(examined.settings.outliers, "weighted_down"),
        facts={"n_points": len(suspects), "image_points": image_points},
    )


FOR_BOTH = (
    exchanged_image_names,
    orientations_without_convergence,
    models_near_a_dangerous_surface,
    image_points_that_contradict,
    ambiguous_orientations,
    orientations_with_large_sigma_0,
    models_upside_down,
    image_points_worse_than_given,
    image_points_better_than_given,
    heavy_tails_of_image_points,
)
TWO_STEP = (*FOR_BOTH, corrections_that_spoil)
SIMULTANEOUS = (*FOR_BOTH, corrections_that_spoil_two_steps)
