"""Problems that a computed block shows, and what to do about each.

Every function looks at one thing and returns at most one :class:`Suggestion`. Nothing
is judged here that was not measured: a problem states the figures that show it.
"""

import numpy as np

from einschalt.foundations.display_names import printable, shortened
from einschalt.foundations.typesetting import count, factor, length, names
from einschalt.foundations.units import ground_from_image_um
from einschalt.pipeline.summary.suggestion import Suggestion
from einschalt.pipeline.summary.suggestions.claim import (
    claim_that_does_not_stand,
    figure_left_out,
    no_check_points,
)
from einschalt.pipeline.summary.suggestions.iterations import drift
from einschalt.pipeline.summary.suggestions.known_points import (
    MIN_REPORTED_RATIO,
    check_differences,
    control_differences,
    shifted_block,
    upper_ratio,
)
from einschalt.pipeline.summary.suggestions.orientations import (
    ambiguous_orientations,
    corrections_that_spoil,
    image_points_that_contradict,
    image_points_worse_than_given,
    models_near_a_dangerous_surface,
    models_upside_down,
    orientations_with_large_sigma_0,
    orientations_without_convergence,
)
from einschalt.pipeline.summary.suggestions.precision import (
    block_that_shrinks,
    imprecise_points,
)
from einschalt.pipeline.summary.suggestions.suspects import (
    control_against_block,
    control_that_contradicts,
    coverages_that_differ,
    gross_measurements,
    settings_that_scatter,
    suspect_observations,
    wrong_measuring_errors,
)
from einschalt.pipeline.summary.suggestions.systematic_errors import (
    film_affinity,
    network_strain,
)

RAISE_M_G = "Raise m_g_um of the low flight, or look for gross errors"
LARGE_M_0 = 3.0
LARGE_SPREAD = 5.0
MOST_DETAILS = 5


def find_suggestions(result) -> tuple[Suggestion, ...]:
    """Look for everything that the user of a result should know before using it.

    Parameters
    ----------
    result : DensificationResult

    Returns
    -------
    tuple of Suggestion
        The gravest first; empty where nothing was found.
    """
    found = (
        failed_models(result),
        points_without_coordinates(result),
        orientations_without_convergence(result),
        models_near_a_dangerous_surface(result),
        image_points_that_contradict(result),
        ambiguous_orientations(result),
        orientations_with_large_sigma_0(result),
        corrections_that_spoil(result),
        models_upside_down(result),
        claim_that_does_not_stand(result),
        block_that_shrinks(result),
        drift(result),
        check_differences(result),
        control_against_block(result),
        control_differences(result),
        control_that_contradicts(result),
        shifted_block(result),
        high_flight_misfit(result),
        contradicted_figures(result),
        wrong_measuring_errors(result),
        image_points_worse_than_given(result),
        settings_that_scatter(result),
        film_affinity(result),
        network_strain(result),
        gross_measurements(result),
        suspect_observations(result),
        coverages_that_differ(result),
        points_that_differ(result),
        imprecise_points(result),
        models_with_large_m_0(result),
        mirrored_models(result),
        points_in_one_coverage(result),
        models_without_redundancy(result),
        no_check_points(result),
        figure_left_out(result),
        *notes_of_reading(result),
    )
    return tuple(suggestion for suggestion in found if suggestion is not None)


def failed_models(result):
    """Models that gave no transformation, counted by their reason."""
    failures = result.failures
    if failures.empty:
        return None
    keys = ["flight", "coverage", "model_id"]
    n_failed = len(failures[keys].drop_duplicates())
    n_all = sum(n_models(flight) for flight in result.block.flights.values())
    groups = failures.groupby(["flight", "reason", "remedy"], sort=False, dropna=False)
    biggest = sorted(groups, key=lambda group: -len(group[1]))
    details = [
        _failure_line(flight, reason, remedy, rows["model_id"])
        for (flight, reason, remedy), rows in biggest[:MOST_DETAILS]
    ]
    n_more = len(biggest) - MOST_DETAILS
    if n_more > 0:
        details.append(f"and {count(n_more, 'further reason')}, see failures.csv")
    return Suggestion(
        f"{n_failed} of {count(n_all, 'model')} failed", details=tuple(details)
    )


def _failure_line(flight, reason, remedy, models):
    flight = str(flight).replace("_", " ")
    which = f"{flight}, {count(len(models), 'model')} ({names(models, 3)})"
    text = f"{which}: {_sentence(reason)}"
    has_remedy = isinstance(remedy, str) and remedy.strip()
    return f"{text}. {_sentence(remedy)}." if has_remedy else text


def _sentence(text):
    return printable(text).strip().rstrip(".")


def n_models(flight):
    """Count the models of a flight as they were measured."""
    table = flight.models if flight.has_images else flight.model_points
    return len(table[["coverage", "model_id"]].drop_duplicates())


def points_without_coordinates(result):
    """Points that the low flight measured and no usable model holds."""
    measured = result.block.low_flight.model_table()["point_id"]
    is_lost = ~measured.isin(result.points["point_id"])
    lost = measured[is_lost].drop_duplicates()
    if lost.empty:
        return None
    return Suggestion(
        f"{count(len(lost), 'measured point')} without coordinates ({names(lost)})",
        "Their models failed, or too few points of these have approximate coordinates",
    )


def has_credible_propagation(result):
    """Whether there is a propagated figure that the measurements do not contradict.

    It takes the sizes of all errors as given, so nothing in the measurements can
    enlarge it; the other two figures see less, but they see the measurements.
    """
    figures = result.figures
    measured = np.nanmax([figures.mean_paper, figures.mean_internal, 0.0])
    is_explained = bool(measured <= MIN_REPORTED_RATIO * figures.mean_total)
    has_fit = high_flight_misfit(result) is None
    return is_explained and has_fit and result.claim.is_supported


def contradicted_figures(result):
    """Measurements that do not agree with the sizes of errors as they were given."""
    figures = result.figures
    internal = f"internal {length(figures.mean_internal)}"
    paper = f"paper {length(figures.mean_paper)}"
    largest = np.nanmax([figures.mean_paper, figures.mean_internal, 0.0])
    if largest > MIN_REPORTED_RATIO * figures.mean_total:
        total = f"propagated {length(figures.mean_total)}"
        return Suggestion(
            "The measurements contradict the propagated figure, which takes the sizes "
            f"of errors as given: {total}, {paper}, {internal}",
            RAISE_M_G,
        )
    # of orientations the budget knows nothing
    is_known = result.errors is not None and any(
        flight.is_oriented_numerically for flight in result.block.flights.values()
    )
    if is_known or not figures.mean_internal > MIN_REPORTED_RATIO * figures.mean_paper:
        return None
    return Suggestion(
        f"The coverages differ more than the budget explains: {internal}, {paper}",
        RAISE_M_G,
    )


def high_flight_misfit(result):
    """Models of the high flight that fit worse than the given errors explain."""
    block = result.block
    if block.high_flight is None or "standard_error_m" not in block.control_points:
        return None
    high = result.models[result.models["flight"] == "high_flight"]
    degrees = int(high.loc[high["is_usable"].astype(bool), "redundancy"].sum())
    m_g = ground_from_image_um(block.high_flight.m_g_um, block.high_flight.scale_number)
    control = block.control_points["standard_error_m"].to_numpy(dtype=float)
    bent = _bent_by_orientation(result, block.high_flight.scale_number)
    explained = np.hypot.reduce([m_g, np.sqrt(np.mean(control**2)), bent])
    m_0 = result.figures.m_0_high
    if degrees == 0 or not m_0 / explained > upper_ratio(degrees):
        return None
    return Suggestion(
        f"m_0 of the high flight is {length(m_0)}, {factor(m_0 / explained)} the "
        f"{length(explained)} that m_g_um and the control points' errors explain",
        "Look for gross errors in high flight and control, or give larger errors",
    )


def _bent_by_orientation(result, scale_number):
    """What errors of orientations leave in a transformation of the high flight [m]."""
    rows = result.orientations
    bent = rows.loc[rows["flight"] == "high_flight", "m_g_orientation_um"]
    bent = bent.dropna().to_numpy(dtype=float)
    rms = np.sqrt(np.mean(bent**2)) if len(bent) else 0.0
    return ground_from_image_um(rms, scale_number)


def points_that_differ(result):
    """Points whose models or coverages lie far apart: gross errors."""
    points = result.points
    spread = points["spread_total"].to_numpy(dtype=float)
    if not np.isfinite(spread).any():
        return None
    usual = float(np.nanmedian(spread))
    is_large = spread > LARGE_SPREAD * usual
    if usual == 0.0 or not is_large.any():
        return None
    far = points.loc[is_large].sort_values("spread_total", ascending=False)
    return Suggestion(
        f"{count(len(far), 'point')} with values more than {LARGE_SPREAD:.0f} times as "
        f"widely scattered as the median of {length(usual)} (spread_total): "
        f"{names(far['point_id'])}; up to "
        f"{length(far['spread_total'].iloc[0])}",
        "Look for gross errors and for exchanged names",
    )


def models_with_large_m_0(result):
    """Models that fit far worse than their flight."""
    models = result.models[result.models["is_usable"].astype(bool)]
    squares = models["m_0"].fillna(0.0) ** 2 * models["redundancy"]
    of_flight = models["flight"]
    redundancy = models.groupby("flight")["redundancy"].sum().clip(lower=1)
    pooled = np.sqrt(squares.groupby(of_flight).sum() / redundancy)
    limit = LARGE_M_0 * of_flight.map(pooled)
    worst = models[models["m_0"] > limit].sort_values("m_0", ascending=False)
    if worst.empty:
        return None
    return Suggestion(
        f"{count(len(worst), 'model')} with m_0 more than {LARGE_M_0:.0f} times that "
        f"of the flight: {_models(worst)}; up to {length(worst['m_0'].iloc[0])}",
        "Look at their residuals for gross errors and for wrong control",
    )


def _models(rows):
    shown = [
        f"{flight.removesuffix('_flight')} {shortened(model_id)}"
        for flight, model_id in zip(rows["flight"], rows["model_id"], strict=True)
    ]
    return names(shown)


def mirrored_models(result):
    """Affine models with a negative determinant, which no camera makes by itself."""
    needed = ["a1", "a2", "b1", "b2"]
    models = result.models
    if not set(needed) <= set(models.columns):
        return None
    models = models[(models["transformation"] == "affine") & models["is_usable"]]
    a1, a2, b1, b2 = models[needed].to_numpy(dtype=float).T
    mirrored = models[a1 * b2 - a2 * b1 < 0.0]
    if mirrored.empty:
        return None
    if len(mirrored) == len(models):
        return Suggestion(
            f"All {count(len(models), 'affine model')} are mirrored",
            "Right where the machine's axes are left-handed; otherwise exchange "
            "easting and northing",
        )
    return Suggestion(
        f"{len(mirrored)} of {count(len(models), 'affine model')} mirrored: "
        f"{_models(mirrored)}",
        "Look for exchanged names of points in them",
    )


def points_in_one_coverage(result):
    """Points that no second coverage, or not even a second model, confirms."""
    points = result.points
    single = points[points["n_coverages"] == 1]
    if single.empty:
        return None
    alone = single[single["n_models"] == 1]
    n_coverages = coverages_of_low_flight(result)
    if n_coverages == 1:
        if alone.empty:
            return None
        some = names(alone["point_id"])
        problem = f"{count(len(alone), 'point')} in one model only ({some})"
    else:
        problem = (
            f"{count(len(single), 'point')} in one coverage only "
            f"({names(single['point_id'])}), {len(alone)} of them in one model only"
        )
    return Suggestion(problem, "Nothing confirms a point in one model")


def coverages_of_low_flight(result):
    """Count the coverages of the low flight."""
    low = result.block.low_flight
    table = low.models if low.has_images else low.model_points
    return int(table["coverage"].nunique())


def models_without_redundancy(result):
    """Models that any residual escapes."""
    models = result.models
    exact = models[models["is_usable"].astype(bool) & (models["redundancy"] == 0)]
    if exact.empty:
        return None
    return Suggestion(
        f"{count(len(exact), 'model')} without redundancy: {_models(exact)}",
        "Their m_0 is unknown and gross errors in them cannot be seen",
    )


def notes_of_reading(result):
    """Say what was ignored, filled in or reprojected while reading."""
    return [Suggestion(_sentence(note)) for note in result.block.notes]
