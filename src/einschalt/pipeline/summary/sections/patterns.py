"""Affinity of film and strain of the control network: what was looked for and found."""

from einschalt.foundations.typesetting import length
from einschalt.pipeline.assessment.facts.patterns import NoStrainTest
from einschalt.pipeline.summary.section import Section
from einschalt.pipeline.summary.wording import ppm

REMARK = (
    "Affinity: by how much x is longer than y in all models of a flight, and the "
    "right angle between them smaller (1 ppm is 1 mm in a km). Strain: errors "
    "that neighbouring control points share; total, RMS."
)
BEND = (
    "Strain was not looked for: errors of the orientations bend models, which would "
    "pass for it."
)
NO_STRAIN = {
    NoStrainTest.ORIENTATIONS_BEND: BEND,
    NoStrainTest.ORIENTATIONS_BEND_WEIGHED: (
        f'{BEND} method = "simultaneous" tests each control point beside them.'
    ),
    NoStrainTest.TOO_LARGE: (
        "Strain was not looked for: the block is too large for it ({})."
    ),
}


def section(facts) -> Section:
    """Set what patterns there are."""
    found = facts.patterns
    rows = [row for affinity in found.affinities for row in _affinity(affinity)]
    if found.strain is not None:
        rows.append(_strain(found.strain))
    untested = (
        (NO_STRAIN[facts.untested].format(facts.size),)
        if facts.untested is not None
        else ()
    )
    title = "Systematic patterns: affinity of film, strain of control"
    return Section(title, ("", "found", "verdict"), tuple(rows), (REMARK, *untested))


def _affinity(found):
    flight = found.flight.replace("_", " ")
    if not found.is_significant:
        verdict = "none"
    elif found.is_absorbed:
        verdict = "significant, taken up by affine"
    else:
        verdict = f"significant, adds {length(found.bias)}"
    return (
        (f"{flight}, x against y", ppm(found.stretch, found.stretch_error), verdict),
        (f"{flight}, shear", ppm(found.shear, found.shear_error), ""),
    )


def _strain(found):
    name = f"{found.n_control} control points"
    if not found.is_significant:
        return name, "–", "none"
    if not found.is_smooth:
        return name, "–", "single points"
    return name, f"{length(found.size)} over {length(found.reach)}", "significant"
