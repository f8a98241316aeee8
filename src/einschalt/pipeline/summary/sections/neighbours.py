"""How well the coordinates of neighbours agree: the precision of their differences."""

from einschalt.foundations.language import figure, mark, translated
from einschalt.foundations.typesetting import length, lengths
from einschalt.pipeline.summary.section import NO_SECTION, Section

REMARK = mark(
    "Neighbours share errors. The first figure is that of their coordinate "
    "differences, the second that of two independent points of the same precision."
)


def section(facts) -> Section:
    """Set the precision of coordinate differences between neighbours."""
    if facts is None:
        return NO_SECTION
    figures = lengths([facts.total, facts.total_if_independent])
    distance = length(facts.median_distance)
    row = (
        translated("neighbours"),
        figure(facts.n_pairs, "d"),
        distance,
        *figures,
    )
    header = (
        *("", translated("pairs"), translated("median distance")),
        *(translated("propagated"), translated("if independent")),
    )
    title = translated("Coordinate differences between neighbours (total, RMS)")
    return Section(title, header, (row,), (translated(REMARK),))
