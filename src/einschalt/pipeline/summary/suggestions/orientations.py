"""Suggestions on relative orientations: no convergence, dangerous surfaces."""

import numpy as np
from scipy.special import chdtrc

from einschalt.foundations.display_names import shortened
from einschalt.foundations.typesetting import count, fixed, length, names, number
from einschalt.foundations.units import METRES_PER_MM
from einschalt.pipeline.assessment.image_precision import image_component
from einschalt.pipeline.summary.suggestion import SIGNIFICANCE, Suggestion
from einschalt.pipeline.summary.suggestions.suspects import is_wrong, shown_component
from einschalt.stages.stage3_model_transformation import transform_models

MEASURE_ELSEWHERE = "Measure points in them that lie higher or lower, or farther apart"
WORST_FIRST = ("critical", "weak")
LARGE_SIGMA = 3.0
# m_0 with corrections over m_0 without: of the wrong sign they double what they mend
SPOILT = 1.2


def orientations_without_convergence(result):
    """Models whose relative orientation did not come to rest."""
    rows = result.orientations
    if rows.empty:
        return None
    open_ones = rows[~rows["is_converged"].astype(bool)]
    if open_ones.empty:
        return None
    return Suggestion(
        f"{count(len(open_ones), 'model')} with a relative orientation that did not "
        f"converge: {_models(open_ones)}",
        "Look for gross errors in their image coordinates or y-parallaxes",
    )


def models_near_a_dangerous_surface(result):
    """Models whose points hardly determine their relative orientation."""
    rows = result.orientations
    if rows.empty:
        return None
    rows = rows[rows["is_converged"].astype(bool)]
    by_verdict = [rows[rows["verdict"] == verdict] for verdict in WORST_FIRST]
    parts = [
        f"{count(len(part), 'model')} {verdict} ({_models(part)})"
        for verdict, part in zip(WORST_FIRST, by_verdict, strict=True)
        if len(part)
    ]
    if not parts:
        return None
    inflation = max(part["inflation"].max() for part in by_verdict if len(part))
    uncertain = f"up to {fixed(inflation, 1)} times as uncertain as on flat terrain"
    # where the points determine nothing the factor is infinite
    known = uncertain if np.isfinite(inflation) else "not determined"
    return Suggestion(
        f"Relative orientation near a dangerous surface: {', '.join(parts)}; omega is "
        f"{known}",
        MEASURE_ELSEWHERE,
    )


def ambiguous_orientations(result):
    """Pairs whose points do not tell two orientations apart."""
    rows = result.orientations
    if rows.empty or not rows["is_ambiguous"].any():
        return None
    open_ones = rows[(rows["is_ambiguous"] & rows["is_converged"]).astype(bool)]
    if open_ones.empty:
        return None
    return Suggestion(
        f"{count(len(open_ones), 'model')} with a second relative orientation that "
        f"fits about as well: {_models(open_ones)}; the one nearer to the normal case "
        "was taken",
        "Measure more points in them, at different heights",
    )


def orientations_with_large_sigma_0(result):
    """Models whose relative orientation fits far worse than those of their flight."""
    rows = result.orientations
    if rows.empty:
        return None
    sigma_0 = rows["sigma_0"].astype(float)
    usual = sigma_0.groupby(rows["flight"]).transform("median")
    # one redundant observation says little: a large one may be chance
    p_value = chdtrc(rows["redundancy"], rows["redundancy"] * (sigma_0 / usual) ** 2)
    is_large = (sigma_0 > LARGE_SIGMA * usual) & (p_value * len(rows) < SIGNIFICANCE)
    if not is_large.any():
        return None
    largest = sigma_0[is_large].max() * METRES_PER_MM
    return Suggestion(
        f"{count(int(is_large.sum()), 'model')} with sigma_0 of the relative "
        f"orientation more than 3 times the median of the flight: "
        f"{_models(rows[is_large])}; up to {length(largest)}",
        "Look for gross errors in their image coordinates or y-parallaxes",
    )


def image_points_worse_than_given(result):
    """Flights whose image points are less precise than their m_g says.

    The other way round proves nothing: residuals see y-parallax only.
    """
    problems = []
    for name, rows in result.orientations.groupby("flight", sort=False):
        flight = result.block.flights[name]
        if not flight.has_images:
            continue
        shown = image_component(rows, flight)
        if shown.estimated > shown.given and is_wrong(shown):
            problems.append(
                f"m_g_um of the {name.replace('_', ' ')} is given as "
                f"{number(shown.given)}, but the residuals of the image points show "
                f"{shown_component(shown)}"
            )
    if not problems:
        return None
    return Suggestion(
        "; ".join(problems),
        "Give that figure or a larger one, if neither gross errors nor a wrong camera "
        "made it: residuals of relative orientation see y-parallax only",
    )


def corrections_that_spoil(result):
    """Flights whose models fit better without the correction by y-parallaxes."""
    if result.low is None:  # the two-step way was not possible
        return None
    for name, flight in result.block.flights.items():
        fit = result.low if name == "low_flight" else result.high.transformation
        if flight.y_parallaxes is None:
            continue
        ground = _ground(result, name)
        without = transform_models(flight.points_to_fit, ground, flight.transformation)
        if not fit.m_0_plan > SPOILT * without.m_0_plan:
            continue
        return Suggestion(
            f"The corrections by y-parallaxes make the {name.replace('_', ' ')} fit "
            f"worse: m_0 {length(fit.m_0_plan)}, without them "
            f"{length(without.m_0_plan)}",
            "Turn the sign of y_parallax: y of the moved bundle less y of the fixed "
            "one (see orientation_case)",
        )
    return None


def _ground(result, flight):
    control = result.block.control_points
    if flight == "high_flight":
        return control[control["role"] == "control"]
    points = result.approximations
    if control is None:
        return points
    check = control.loc[control["role"] == "check", "point_id"]
    return points[~points["point_id"].isin(check)]


def models_upside_down(result):
    """Spatial models that had to be turned over: mirror images of flat terrain."""
    models = result.models
    if not {"omega", "phi"} <= set(models.columns):
        return None
    models = models[models["is_usable"].astype(bool)]
    angles = models[["omega", "phi"]].astype(float)
    over = models[np.cos(angles["omega"]) * np.cos(angles["phi"]) < 0.0]
    if over.empty:
        return None
    return Suggestion(
        f"{count(len(over), 'spatial model')} upside down: {_models(over)}",
        "Turn the sign of x or y in their image or model coordinates: x to the right, "
        "y upwards, z upwards",
    )


def image_points_that_contradict(result):
    """Image points that contradict their pair, and what was done with them."""
    rows = result.orientation_residuals
    if "is_suspect" not in rows or not rows["is_suspect"].any():
        return None
    p_value = rows["p_value"].to_numpy(dtype=float)
    # a suspect of one pair in a thousand is chance: the worst must stand out of all
    if np.nanmin(p_value) * np.isfinite(p_value).sum() > SIGNIFICANCE:
        return None
    suspects = rows[rows["is_suspect"]].sort_values("p_value", kind="stable")
    shown = names(
        [
            f"{flight.removesuffix('_flight')} {shortened(model)} {shortened(point)}"
            for flight, model, point in zip(
                suspects["flight"],
                suspects["model_id"],
                suspects["point_id"],
                strict=True,
            )
        ],
        4,
    )
    done = {
        "keep": 'Measure them again, or set outliers = "snoop"',
        "snoop": "They were taken out of the orientation: measure them again",
    }
    return Suggestion(
        f"{count(len(suspects), 'image point')} that contradict their pair, worst "
        f"first (flight, model, point): {shown}",
        done.get(
            result.settings.outliers,
            "They have less weight in the orientation: measure them again",
        ),
    )


def _models(rows):
    shown = [
        f"{flight.removesuffix('_flight')} {shortened(model_id)}"
        for flight, model_id in zip(rows["flight"], rows["model_id"], strict=True)
    ]
    return names(shown)
