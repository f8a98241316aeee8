"""Control points that disagree with the block, each by itself or all together."""

from functools import singledispatch

from einschalt.foundations.display_names import printable
from einschalt.foundations.typesetting import lengths, number
from einschalt.pipeline.assessment.facts.control_strain import (
    DisplacedControlFacts,
    SuspectControlFacts,
)
from einschalt.pipeline.summary.section import NO_SECTION, Section
from einschalt.pipeline.summary.wording import probability

TOGETHER = (
    "The largest of {}, as far as a smooth strain of their network can be estimated; "
    "none has to disagree by itself."
)
ASIDE = "They are set aside: the new points do not depend on them."
STRAIN = "easting, northing: the error of the given coordinates that explains it."


@singledispatch
def section(facts) -> Section:
    """Set size and direction of the contradictions."""
    del facts
    return NO_SECTION


@section.register
def _(facts: SuspectControlFacts) -> Section:
    shown = facts.suspects
    rows = zip(
        (printable(point.point_id) for point in shown),
        lengths([point.easting for point in shown]),
        lengths([point.northing for point in shown]),
        (number(point.w) for point in shown),
        (probability(point.p_value) for point in shown),
        strict=True,
    )
    said = [STRAIN]
    if facts.is_set_aside:
        said.append(ASIDE)
    if facts.n_suspects > len(shown):
        said.append(f"These are the worst {len(shown)} of {facts.n_suspects}.")
    header = ("", "easting", "northing", "w", "p")
    title = "Control points that disagree with the block"
    return Section(title, header, tuple(rows), tuple(said))


@section.register
def _(facts: DisplacedControlFacts) -> Section:
    points, east, north = zip(*facts.displacements, strict=True)
    rows = zip(map(printable, points), lengths(east), lengths(north), strict=True)
    title = "Control points that are displaced together"
    said = (TOGETHER.format(facts.n_control),)
    return Section(title, ("", "easting", "northing"), tuple(rows), said)
