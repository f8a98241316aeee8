"""Affinity of film and strain of the control network: what was looked for and found."""

from einschalt.foundations.kept_texts import retold
from einschalt.foundations.language import mark, mark_each, translated
from einschalt.foundations.typesetting import MISSING, length
from einschalt.pipeline.assessment.facts.patterns import NoStrainTest
from einschalt.pipeline.summary.section import Section
from einschalt.pipeline.summary.wording import flight_name, ppm

REMARK = mark(
    "Affinity: by how much x is longer than y in all models of a flight, and the angle "
    "between them smaller than a right angle (1 ppm is 1 mm per km). Strain: errors "
    "that neighbouring control points share; total, RMS."
)
NO_STRAIN = mark_each(
    {
        NoStrainTest.ORIENTATIONS_BEND: (
            "Strain was not tested: errors of the orientations bend models, which "
            "would be mistaken for strain."
        ),
        NoStrainTest.ORIENTATIONS_BEND_WEIGHED: (
            "Strain was not tested: errors of the orientations bend models, which "
            'would be mistaken for strain. method = "simultaneous" takes them into '
            "account and tests each control point."
        ),
        NoStrainTest.TOO_LARGE: (
            "Strain was not tested: the block is too large for the test ({size})."
        ),
    }
)


def section(facts) -> Section:
    """Set what patterns there are."""
    found = facts.patterns
    rows = [row for affinity in found.affinities for row in _affinity(affinity)]
    if found.strain is not None:
        rows.append(_strain(found.strain))
    untested = (
        (translated(NO_STRAIN[facts.untested], size=retold(facts.size)),)
        if facts.untested is not None
        else ()
    )
    title = translated("Systematic patterns: affinity of film, strain of control")
    header = ("", translated("found"), translated("verdict"))
    return Section(title, header, tuple(rows), (translated(REMARK), *untested))


def _affinity(found):
    flight = flight_name(found.flight)
    if not found.is_significant:
        verdict = translated("none")
    elif found.is_absorbed:
        verdict = translated("significant, absorbed by affine")
    else:
        verdict = translated("significant, adds {length}", length=length(found.bias))
    stretch = ppm(found.stretch, found.stretch_error)
    shear = ppm(found.shear, found.shear_error)
    name = translated("{flight}, x against y", flight=flight)
    if found.axes == "ground":
        name = translated("{flight}, east against north", flight=flight)
    return (
        (name, stretch, verdict),
        (translated("{flight}, shear", flight=flight), shear, ""),
    )


def _strain(found):
    name = translated("{n:control point|control points}", n=found.n_control)
    if not found.is_significant:
        return name, MISSING, translated("none")
    if not found.is_smooth:
        return name, MISSING, translated("single points")
    sizes = {"size": length(found.size), "reach": length(found.reach)}
    return name, translated("{size} over {reach}", **sizes), translated("significant")
