"""What to say of heights that are not as good as stated."""

from einschalt.foundations.typesetting import length
from einschalt.pipeline.summary.suggestion import filled

REMEDIES = {
    "check_that_height": "Check its height, and set it aside if it is wrong",
    "check_height_network": (
        "Look for control heights of different levelling networks or datums"
    ),
    "check_principal_distance": (
        "Look at the principal distance, the scale of z and the base"
    ),
    "give_system": (
        'Give the reference system of the coordinates, such as crs = "EPSG:31255"; or '
        'earth_curvature = "ignored" if they are those of a plane, or the models are '
        "corrected"
    ),
    "check_heights": (
        "Check the heights of control and check points, and their standard errors"
    ),
}


def heights_beyond_claim(finding):
    """Every comparison that contradicts the claimed heights."""
    said = "; ".join(
        f"those of {test['quantity']} are missed by {length(test['observed'])} (RMS), "
        f"predicted {length(test['predicted'])}"
        for test in finding.facts["rejected"]
    )
    return f"The claimed heights do not stand: {said}"


def broken_heights(finding):
    """Which part lies apart, and by how much; or by how much control is bent."""
    bent = "The heights of {n_control:count control point} are bent by {size:length}"
    apart = (
        "The heights of {n_points} of {n_control:count control point} lie "
        "{size:length} from the others, on one side of a line: {names:names of "
        "n_points}"
    )
    so = bent if finding.facts["kind"] == "bend" else apart
    return filled(f"{so}, which moves heights by {{moved:length}} (RMS)", finding)


def heights_out_of_scale(finding):
    """Of which flights, and by how much."""
    flights = " and ".join(name.replace("_", " ") for name in finding.names)
    return filled(
        f"Model heights of the {flights} are {{per_cent:+.2f}} % out of scale against "
        "those of control, which moves heights by {moved:length} (RMS)",
        finding,
    )


WORDS = {
    "curvature_untold": (
        "No reference system is given, and the ground is taken for flat. On a map the "
        "Earth's curvature bends the heights in a model by {bend:length} (RMS), "
        "and their standard error is {stated:length}"
    ),
    "heights_beyond_claim": heights_beyond_claim,
    "broken_heights": broken_heights,
    "heights_out_of_scale": heights_out_of_scale,
    "wrong_control_height": (
        "The height of control point {names:names of n_points} is {size:length} off, "
        "which moves heights by {moved:length} (RMS)"
    ),
}
