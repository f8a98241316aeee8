"""Suggestions on affinity of film and on strain of the control network."""

import numpy as np

from einschalt.foundations.display_names import printable
from einschalt.foundations.typesetting import length
from einschalt.pipeline.summary.sections.patterns import ppm
from einschalt.pipeline.summary.suggestion import Suggestion
from einschalt.pipeline.summary.suggestions.suspects import has_control_against_block

# of the figure that is claimed: a smaller bias adds half a per cent to it
MIN_REPORTED_RATIO = 0.1
MOST_SHOWN = 3


def film_affinity(result):
    """Flights whose models have an affinity that their transformation leaves."""
    found = [
        part
        for part in result.patterns.affinities
        if part.is_significant
        and not part.is_absorbed
        and part.bias > MIN_REPORTED_RATIO * result.figures.mean_total
    ]
    if not found:
        return None
    said = "; ".join(
        f"in the {part.flight.replace('_', ' ')} x is longer than y by "
        f"{ppm(part.stretch, part.stretch_error)}, with a shear of "
        f"{ppm(part.shear, part.shear_error)}, which makes {length(part.bias)} "
        "(total, RMS)"
        for part in found
    )
    flights = " and ".join(f"[{part.flight}]" for part in found)
    return Suggestion(
        f"Film or machine has an affinity: {said}",
        f'Set transformation = "affine" in {flights}',
    )


def network_strain(result):
    """Control points that contradict each other by more than their standard errors."""
    strain = result.patterns.strain
    if strain is None or not strain.is_significant:
        return None
    if strain.is_smooth:
        return _smooth_strain(result, strain)
    if has_control_against_block(result):
        return None  # they are named already
    return Suggestion(
        f"The {strain.n_control} control points contradict each other by more than "
        "their standard errors",
        "Look for wrong ones, or raise standard_error_m",
    )


def _smooth_strain(result, strain):
    """Say its size, where it is largest and where to, and what can be done."""
    worst = [
        f"{printable(point)} (easting {length(east)}, northing {length(north)})"
        for point, east, north in strain.displacements.head(MOST_SHOWN).itertuples(
            index=False
        )
    ]
    known, other = result.figures.mean_total, ""
    reckoned = (
        f": reckon with {length(np.hypot(known, strain.size))}, not {length(known)}"
    )
    if result.simultaneous is None:
        other = '. method = "simultaneous" suffers less from it'
    return Suggestion(
        f"The control network is strained: neighbours among the {strain.n_control} "
        f"control points are displaced together, by {length(strain.size)} (total, RMS) "
        f"over {length(strain.reach)}, most at {', '.join(worst)}; "
        f"standard_error_total does not hold that{reckoned if known > 0.0 else ''}",
        "Check the network there, and give control from another one, since more of "
        f"the same shares it{other}",
    )
