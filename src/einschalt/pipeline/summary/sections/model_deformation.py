"""Deformations that all models of a flight share, and which way to believe."""

import numpy as np

from einschalt.foundations.typesetting import fixed, length, lengths
from einschalt.pipeline.summary.sections.claim import probability
from einschalt.pipeline.summary.sections.section import Section

LEAST_CHECK = 8
CLEARLY = 1.25
ALIKE = (
    "alike: correlation of the residuals of neighbouring points in a model, after what "
    "was modelled; near 0 where errors are random."
)


def section(result) -> Section:
    """Say what was tested and modelled; no rows where nothing was tested."""
    title = "Deformation that the models of a flight share (total, RMS)"
    header = ("", "p", "in the middle", "at the edge", "modelled", "alike")
    adjusted = result.simultaneous
    if adjusted is None or adjusted.deformations.empty:
        return Section(title, header, ())
    found = adjusted.deformations
    rows = zip(
        found["flight"].str.replace("_", " "),
        map(probability, found["p_value"]),
        lengths(found["size_middle"]),
        lengths(found["size_edge"]),
        np.where(found["is_modelled"], "yes", "no"),
        [fixed(value, 2) for value in found["neighbour_correlation"]],
        strict=True,
    )
    return Section(title, header, tuple(rows), (ALIKE, verdict(result)))


def verdict(result) -> str:
    """Say which of the two ways to believe for this block, and why.

    Check points decide where there are enough of them; otherwise what the residuals
    show of deformation.
    """
    rms = _check_rms(result)
    if rms is not None and max(rms) > CLEARLY * min(rms):
        better = "simultaneous adjustment" if rms[0] < rms[1] else "two steps"
        return (
            f"Believe the {better}: at the check points the simultaneous adjustment "
            f"has {length(rms[0])}, two steps have {length(rms[1])}."
        )
    found = result.simultaneous.deformations
    left = found["is_detected"] & ~found["is_modelled"]
    if left.any():
        return (
            "Believe the two steps, or model the deformation: the simultaneous "
            "adjustment accumulates it."
        )
    if found["is_alike"].any():
        return (
            "Believe the two steps, where they are possible: models are deformed each "
            "in its own way, and the simultaneous adjustment accumulates that."
        )
    if found["is_modelled"].any():
        return (
            "Believe the simultaneous adjustment: the deformation is modelled, and "
            "what is left shows no pattern."
        )
    if found["p_value"].isna().all():
        return (
            "Whether models are deformed cannot be tested: their points have too "
            "little redundancy. Neither way is better founded for this block."
        )
    return "Believe the simultaneous adjustment: no deformation shows."


def _check_rms(result):
    """RMS at the check points, simultaneous and in two steps; None with too few."""
    if result.two_step is None:
        return None
    squares = []
    for points in (result.points, result.two_step.points):
        check = points[points["role"] == "check"].set_index("point_id")
        squares.append(
            check["difference_easting"] ** 2 + check["difference_northing"] ** 2
        )
    one, two = squares[0].align(squares[1], join="inner")
    if len(one) < LEAST_CHECK:
        return None
    return float(np.sqrt(one.mean())), float(np.sqrt(two.mean()))
