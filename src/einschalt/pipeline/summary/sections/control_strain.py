"""Control points that disagree with the block, each by itself or all together."""

import math
from functools import singledispatch

from einschalt.foundations.display_names import printable
from einschalt.foundations.language import mark, translated
from einschalt.foundations.typesetting import lengths, number
from einschalt.pipeline.assessment.facts.control_strain import (
    DisplacedControlFacts,
    SuspectControlFacts,
)
from einschalt.pipeline.summary.section import NO_SECTION, Section
from einschalt.pipeline.summary.wording import probability

TOGETHER = mark(
    "The largest of {n}, as far as a smooth strain of their network can be estimated; "
    "no single point need be inconsistent."
)
ASIDE = mark("They are set aside: the new points do not depend on them.")
STRAIN = mark(
    "easting, northing: error of the given coordinates that would explain it."
)
STRAIN_IN_SPACE = mark(
    "easting, northing, height: error of the given coordinates that would explain it."
)


@singledispatch
def section(facts) -> Section:
    """Set size and direction of the contradictions."""
    del facts
    return NO_SECTION


@section.register
def _(facts: SuspectControlFacts) -> Section:
    shown = facts.suspects
    has_heights = not all(math.isnan(point.height) for point in shown)
    names = [printable(point.point_id) for point in shown]
    columns = [lengths([point.easting for point in shown])]
    columns += [lengths([point.northing for point in shown])]
    header = _header()
    if has_heights:
        columns += [lengths([point.height for point in shown])]
        header = (*header, translated("height"))
    columns += [[number(point.w) for point in shown]]
    columns += [[probability(point.p_value) for point in shown]]
    rows = zip(names, *columns, strict=True)
    remarks = [translated(STRAIN_IN_SPACE if has_heights else STRAIN)]
    if facts.is_set_aside:
        remarks.append(translated(ASIDE))
    if facts.n_suspects > len(shown):
        remarks.append(
            translated(
                "These are the worst {n} of {n_all}.",
                n=len(shown),
                n_all=facts.n_suspects,
            )
        )
    title = translated("Control points that disagree with the block")
    return Section(title, (*header, "w", "p"), tuple(rows), tuple(remarks))


def _header():
    return "", translated("easting"), translated("northing")


@section.register
def _(facts: DisplacedControlFacts) -> Section:
    points, east, north = zip(*facts.displacements, strict=True)
    rows = zip(map(printable, points), lengths(east), lengths(north), strict=True)
    title = translated("Control points that are displaced together")
    remark = translated(TOGETHER, n=facts.n_control)
    return Section(title, _header(), tuple(rows), (remark,))
