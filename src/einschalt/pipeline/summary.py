"""What print(result) shows: the verdict, problems and suggestions, then the numbers."""

from typing import NamedTuple

import numpy as np

from einschalt.foundations.typesetting import (
    count,
    length,
    lengths,
    number,
    number_word,
    printable,
    scale,
    seconds,
    table,
    wrapped,
)
from einschalt.foundations.units import METRES_PER_MM, ground_from_image_um
from einschalt.pipeline.suggestions import (
    coverages_of_low_flight,
    find_suggestions,
    has_credible_propagation,
    n_models,
)
from einschalt.pipeline.suspect_suggestions import shown_component

TOTAL = (
    "All figures are total point errors, √(σ_E² + σ_N²); the error of one coordinate "
    "is total / √2."
)
INTERNAL = (
    "internal: from the differences of the coverages; it sees only the uncorrelated "
    "part of the error."
)
HEIGHTS = "Heights are computed; no figure here judges them."
SINGLE = "single: paper for the value of one model, internal for that of one coverage."
PROPAGATED = (
    "propagated: errors of control and of both flights, of the sizes given, carried "
    "through every stage with their correlations."
)
PAPER = "paper: Kovarik 1971, M² = (m_g · scale number)² + m_t²."
TOO_SMALL = "standard_error_paper is too small: {}."
HIGH_SHARED = "the approximate coordinates share the high flight's transformation error"
GIVEN_SHARED = "neighbouring approximate points share errors, which is not known here"
UNBROKEN = "\N{NO-BREAK SPACE}=\N{NO-BREAK SPACE}"
BOTH_SHARE = "{} coverages share the approximate coordinates"


class Rows(NamedTuple):
    """A table of text: its title, its header, and its rows."""

    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


def summarize(result) -> str:
    """Write the text of ``print(result)`` and of summary.txt.

    Parameters
    ----------
    result : DensificationResult

    Returns
    -------
    str
        First line the verdict, then "Problems and suggestions", then tables.
    """
    parts = [
        verdict(result),
        _suggestions(find_suggestions(result)),
        _numbers(precision(result), (too_small(result), *remarks(result))),
        _numbers(differences(result)),
        _numbers(
            flights(result),
            (
                *approximations(result),
                *orientations(result),
                *measured_errors(result),
            ),
        ),
        settings_line(result),
    ]
    return "\n\n".join(part for part in parts if part) + "\n"


def verdict(result) -> str:
    """Say in one line how many points the block has and how good they are."""
    return f"{printable(result.block.name)}: {verdict_on(result)}"


def verdict_on(result) -> str:
    """Say the verdict without the name of the block."""
    figures = result.figures
    new = count(figures.n_new, "new point") if figures.n_new else "no new points"
    verdict = f"{new}{_how_good(result)}"
    if result.failures.empty:
        return verdict
    failed = result.failures[["flight", "coverage", "model_id"]].drop_duplicates()
    n_all = sum(n_models(flight) for flight in result.block.flights.values())
    return f"{verdict}; {len(failed)} of {count(n_all, 'model')} failed"


def _how_good(result):
    """The propagated figure where it holds, and the paper's beside it; or a bound."""
    figures = result.figures
    if not np.isfinite(figures.mean_paper):
        return ""
    paper = f"{length(figures.mean_paper)} after Kovarik's budget"
    if has_credible_propagation(result):
        return f", {length(figures.mean_total)} (total, {_mean_of(result)}; {paper})"
    if np.isnan(figures.mean_total):
        return f", {paper} (total, {_mean_of(result)})"
    known = [figures.mean_total, figures.mean_paper, figures.mean_internal]
    return f", {length(np.nanmax(known))} or worse (total, {_mean_of(result)})"


def _mean_of(result):
    n_coverages = coverages_of_low_flight(result)
    if n_coverages == 1:
        return "one coverage"
    return f"mean of {number_word(n_coverages)} coverages"


def _suggestions(suggestions):
    lines = ["Problems and suggestions"]
    if not suggestions:
        lines.append("  none")
    for suggestion in suggestions:
        lines.append(wrapped(str(suggestion), first="  - ", indent="    "))
        lines += [
            wrapped(detail, first="      ", indent="        ")
            for detail in suggestion.details
        ]
    return "\n".join(lines)


def _numbers(rows, remarks=()):
    if not rows.rows:
        return ""
    lines = [rows.title, table(rows.rows, header=rows.header)]
    lines += [wrapped(remark, first="  ", indent="    ") for remark in remarks]
    return "\n".join(lines)


def precision(result) -> Rows:
    """Precision of the new points: single value and mean, each as it is known."""
    figures = result.figures
    single = ("single", np.nan, figures.single_paper, figures.single_internal)
    mean = (
        _mean_of(result),
        figures.mean_total,
        figures.mean_paper,
        figures.mean_internal,
    )
    titles, *columns = zip(single, mean, strict=True)
    header = ("", "propagated", "paper", "internal")
    shown = [
        (name, lengths(column))
        for name, column in zip(header[1:], columns, strict=True)
        if name != "propagated" or np.isfinite(figures.mean_total)
    ]
    rows = zip(titles, *(texts for _, texts in shown), strict=True)
    return Rows(
        "Precision of the new points (total, RMS)",
        ("", *(name for name, _ in shown)),
        tuple(rows) if figures.n_new else (),
    )


def remarks(result) -> tuple[str, ...]:
    """Say what the figures of precision mean."""
    chosen = [TOTAL, PAPER]
    if np.isfinite(result.figures.mean_total):
        chosen.insert(1, PROPAGATED)
    if coverages_of_low_flight(result) > 1:
        chosen.append(INTERNAL)
        if result.settings.coverage_mean == "all":
            chosen.append(SINGLE)
    if "height" in result.points:
        chosen.append(HEIGHTS)
    return tuple(chosen)


def too_small(result) -> str:
    """Say why the paper's figure is too small, as far as that is known here."""
    n_coverages = coverages_of_low_flight(result)
    word = "both" if n_coverages == 2 else f"all {number_word(n_coverages)}"
    shared = [BOTH_SHARE.format(word)] if n_coverages > 1 else []
    if result.block.high_flight is not None:
        return TOO_SMALL.format(", and ".join([HIGH_SHARED, *shared]))
    if shared:
        return TOO_SMALL.format(f"{shared[0]}; more so where {GIVEN_SHARED}")
    return f"standard_error_paper is too small where {GIVEN_SHARED}."


def differences(result) -> Rows:
    """Densified minus given coordinates at the known points."""
    figures = result.figures
    known = [
        ("control points", figures.n_control, figures.control_rms),
        ("check points", figures.n_check, figures.check_rms),
    ]
    known = [row for row in known if row[1]]
    total = lengths([row[2] for row in known])
    rows = [
        (name, f"{n_points:d}", rms)
        for (name, n_points, _), rms in zip(known, total, strict=True)
    ]
    return Rows(
        "Differences densified - given (total, RMS)",
        ("", "points", "difference"),
        tuple(rows),
    )


def flights(result) -> Rows:
    """Say what each flight measured, and how well its models fit."""
    figures = result.figures
    m_0_of = {"high_flight": figures.m_0_high, "low_flight": figures.m_0_low}
    m_0 = lengths([m_0_of[name] for name in result.block.flights])
    m_g = lengths(
        [
            ground_from_image_um(flight.m_g_um, flight.scale_number)
            for flight in result.block.flights.values()
        ]
    )
    rows = [
        (
            name.replace("_", " "),
            scale(flight.scale_number),
            flight.transformation,
            f"{n_models(flight):d}",
            _usable(result.models, name),
            f"{number(flight.m_g_um)} µm",
            m_g[place],
            m_0[place],
        )
        for place, (name, flight) in enumerate(result.block.flights.items())
    ]
    header = ("", "scale", "fit", "models", "usable", "m_g", "on ground", "m_0")
    return Rows("Flights (m_g and m_0 are total)", header, tuple(rows))


def _usable(models, flight):
    is_usable = models["is_usable"].astype(bool)
    return f"{int((is_usable & (models['flight'] == flight)).sum()):d}"


def approximations(result) -> tuple[str, ...]:
    """Say where the approximate coordinates come from and how good they are."""
    block, figures = result.block, result.figures
    if block.high_flight is None:
        n_points = count(len(block.approximate_points), "point")
        m_0 = block.approximate_m_0_m
        said = f"{length(m_0)} (total, as given)" if m_0 else "of unknown precision"
        return (f"Approximate coordinates: {n_points} given, {said}.",)
    n_points = count(len(result.approximations), "point")
    internal = figures.approximation_internal
    if not np.isfinite(internal):
        return (f"Approximate coordinates: {n_points} from the high flight.",)
    said = f"{length(internal)} (total, internal)"
    return (f"Approximate coordinates: {n_points} from the high flight, {said}.",)


def orientations(result) -> tuple[str, ...]:
    """Say how well the models of each flight could be oriented."""
    lines = []
    for flight, rows in result.orientations.groupby("flight", sort=False):
        redundancy = rows["redundancy"].to_numpy(dtype=float)
        square = np.nansum(redundancy * rows["sigma_0"].to_numpy(dtype=float) ** 2)
        sigma_0 = np.sqrt(square / redundancy.sum()) if redundancy.sum() else np.nan
        has_images = result.block.flights[flight].has_images
        observed = "an image coordinate" if has_images else "a y-parallax"
        lines.append(
            f"Relative orientation, {flight.replace('_', ' ')}: "
            f"{count(len(rows), 'model')}, sigma_0 {length(sigma_0 * METRES_PER_MM)} "
            f"of {observed}; it sees y-parallax only."
        )
    return tuple(lines)


def measured_errors(result) -> tuple[str, ...]:
    """Say what m_g of each flight the measurements show."""
    if result.components is None:
        return ()
    return tuple(
        f"m_g of the {flight.replace('_', ' ')}: given {number(component.given)}, "
        f"the data say {shown_component(component)} µm."
        for flight, component in (
            ("high_flight", result.components.high_flight),
            ("low_flight", result.components.low_flight),
        )
    )


def settings_line(result) -> str:
    """Say with what settings the block was computed, and how long it took."""
    chosen = ", ".join(
        f"{key}{UNBROKEN}{value}" for key, value in result.settings.model_dump().items()
    )
    lines = wrapped(f"Settings: {chosen}.").replace(UNBROKEN, " = ")
    return f"{lines}\nComputed in {seconds(result.seconds)}."
