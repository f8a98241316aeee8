"""The simultaneous adjustment, and the two-step way beside it."""

import numpy as np

from einschalt.foundations.typesetting import (
    count,
    length,
    lengths,
    names,
    number,
)
from einschalt.pipeline.densification.simultaneous import unknown_error
from einschalt.pipeline.summary.section import Section

SIMULTANEOUS = (
    "simultaneous: all models of all flights and the control in one adjustment; errors "
    "of the sizes given, with their correlations{}."
)
ORIENTED = ", and of the orientations, as sigma_0 of all models has them"
TWO_STEPS = (
    "two steps: approximate coordinates from the high flight, the low flight onto them "
    "(two_step_easting, two_step_northing)."
)
IMPOSSIBLE = "The two-step way is not possible in this block: too little control."
MOVED = "points were moved by the distribution of residuals"
UNKNOWN = "No standard errors are given: {}."
SHOWN = "(standard errors that the residuals show)"
BLIND = "It does not see errors that all models share: look at the model deformation"


def section(result) -> Section:
    """Precision of the new points both ways."""
    figures, two_step = result.figures, result.two_step
    rows = [("simultaneous adjustment", figures.mean_total, np.nan, np.nan)]
    if two_step is not None:
        other = two_step.figures
        rows.append(
            ("two steps", other.mean_total, other.mean_paper, other.mean_internal)
        )
    titles, *columns = zip(*rows, strict=True)
    texts = zip(titles, *(lengths(column) for column in columns), strict=True)
    return Section(
        "Precision of the new points (total, RMS)",
        ("", "propagated", "paper", "internal"),
        tuple(texts) if figures.n_new else (),
        (caution(result), *remarks(result)),
    )


def caution(result) -> str:
    """Say what s_0 is, and what it cannot see."""
    adjusted = result.simultaneous
    if adjusted.redundancy <= 0:
        return "No redundancy: nothing checks the adjustment."
    return (
        f"s_0 = {number(adjusted.s_0)} (redundancy {adjusted.redundancy}); 1 where the "
        f"errors are as large as given. {BLIND}."
    )


def remarks(result) -> tuple[str, ...]:
    """Say what the figures mean, and how far apart the two ways are."""
    said = [_errors_taken(result), *_estimated(result), *_heights(result)]
    if result.two_step is None:
        said.append(IMPOSSIBLE)
    else:
        said += [TWO_STEPS, *_apart(result)]
    if np.isnan(result.figures.mean_total) and result.figures.n_new:
        why = unknown_error(result.block, result.orientation_errors)
        said.append(UNKNOWN.format(why or MOVED))
    return tuple(said)


def _errors_taken(result):
    """Say which errors the adjustment takes into account."""
    observations = result.simultaneous.tables.observations
    is_oriented = getattr(observations, "orientation", None) is not None
    return SIMULTANEOUS.format(ORIENTED if is_oriented else "")


def _estimated(result):
    """Sizes of errors with which the block was adjusted, where they were estimated."""
    components = result.simultaneous.components
    if result.settings.variance_components == "given":
        return ()
    shown = components[components["is_estimated"]]
    sizes = [
        f"{name.replace('_', ' ')} {length(size)}"
        for name, size in zip(shown["group"], shown["standard_error_m"], strict=True)
    ]
    return (f"Errors of one coordinate {SHOWN}: {', '.join(sizes) or 'none'}.",)


def _heights(result):
    """How good the heights of spatial models are, and from where that is known."""
    adjusted = result.simultaneous
    if not adjusted.tables.is_spatial:
        return ()
    said = []
    errors = result.points.get("standard_error_height")
    if errors is not None and (is_new := result.points["role"] == "new").any():
        size = length(np.sqrt(np.mean(errors[is_new] ** 2)))
        said.append(f"Heights of the new points: {size} (propagated, RMS).")
    sizes = adjusted.components.set_index("group")["standard_error_m"]
    flights = [
        f"{name.replace('_', ' ')} {length(sizes[f'{name}, height'])}"
        for name in adjusted.tables.flights
    ]
    said.append(f"Measured heights: {', '.join(flights)} {SHOWN}.")
    if len(adjusted.centres):
        said.append(
            f"Projection centres of {count(len(adjusted.centres), 'photograph')} tie "
            "the models as well, with errors that the residuals show."
        )
    return tuple(said)


def _apart(result):
    points = result.points
    apart = np.hypot(
        points["easting"] - points["two_step_easting"],
        points["northing"] - points["two_step_northing"],
    )
    apart = apart[apart.notna()]
    if apart.empty:
        return ()
    worst = points.loc[apart.idxmax(), "point_id"]
    said = (
        f"The two ways differ by {length(np.sqrt(np.mean(apart**2)))} (total, RMS), "
        f"most at {names([worst])}: {length(apart.max())}."
    )
    return (said,)
