"""What to say of affinity of film and of strain of the control network."""

from math import isfinite

from einschalt.foundations.display_names import printable
from einschalt.foundations.typesetting import length
from einschalt.pipeline.summary.suggestion import Suggestion, filled
from einschalt.pipeline.summary.wording import flight_name, ppm

MOST_SHOWN = 3
REMEDIES = {
    "check_network": (
        "Check the network there, and give control from another one, since more of "
        "the same shares it"
    ),
    "check_network_or_adjust": (
        "Check the network there, and give control from another one, since more of "
        'the same shares it. method = "simultaneous" suffers less from it'
    ),
    "check_network_in_parts": (
        "Check whether its parts come from the same network, survey and system"
    ),
    "look_for_wrong_control_or_raise_errors": (
        "Look for wrong ones, or raise standard_error_m"
    ),
}
STRAINED = (
    "The control network is strained: neighbours among the {n_control} control points "
    "are displaced together, by {size:length} (total, RMS) over {reach:length}, most "
    "at "
)
RECKONED = ": reckon with {claimed_with_strain:length}, not {claimed:length}"


def film_affinity(finding):
    """The affinity of each flight, and what it makes."""
    said = "; ".join(
        f"in the {flight_name(part['flight'])} x is longer than y by "
        f"{ppm(part['stretch'], part['stretch_error'])}, with a shear of "
        f"{ppm(part['shear'], part['shear_error'])}, which makes "
        f"{length(part['bias'])} (total, RMS)"
        for part in finding.facts["flights"]
    )
    flights = " and ".join(f"[{part['flight']}]" for part in finding.facts["flights"])
    remedy = f'Set transformation = "affine" in {flights}'
    return Suggestion(f"Film or machine has an affinity: {said}", remedy)


def strained_network(finding):
    """Its size, where it is largest and where to, and what to reckon with."""
    facts = finding.facts
    worst = ", ".join(
        f"{printable(point)} (easting {length(east)}, northing {length(north)})"
        for point, east, north in facts["displacements"][:MOST_SHOWN]
    )
    reckoned = RECKONED if isfinite(facts["claimed_with_strain"]) else ""
    return (
        f"{filled(STRAINED, finding)}{worst}; standard_error_total does not hold that"
        f"{filled(reckoned, finding)}"
    )


def broken_network(finding):
    """Which part lies apart, and where to; or by how much control is bent."""
    bent = (
        "The control network is bent: a quadratic strain of its "
        "{n_control:count control point} has {size:length} (total, RMS)"
    )
    apart = (
        "The control network is broken in two: on one side of a line {n_points} of its "
        "{n_control:count control point} lie apart from the others, by easting "
        "{easting:length}, northing {northing:length}: {names:names of n_points}"
    )
    so = bent if finding.facts["kind"] == "bend" else apart
    return filled(f"{so}. It moves the new points by {{moved:length}} (RMS)", finding)


WORDS = {
    "film_affinity": film_affinity,
    "broken_network": broken_network,
    "strained_network": strained_network,
    "contradicting_control": (
        "The {n_control} control points contradict each other by more than their "
        "standard errors"
    ),
}
