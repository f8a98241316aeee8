"""How well the coordinates of neighbours agree: the precision of their differences."""

from einschalt.foundations.typesetting import length, lengths
from einschalt.pipeline.summary.section import NO_SECTION, Section

REMARK = (
    "Neighbours share errors. Their coordinate differences have the first figure; the "
    "second is what two independent points of their precision would have."
)


def section(facts) -> Section:
    """Set the precision of coordinate differences between neighbours."""
    if facts is None:
        return NO_SECTION
    figures = lengths([facts.total, facts.total_if_independent])
    distance = length(facts.median_distance)
    row = ("neighbours", f"{facts.n_pairs:d}", distance, *figures)
    header = ("", "pairs", "median distance", "propagated", "if independent")
    title = "Coordinate differences between neighbours (total, RMS)"
    return Section(title, header, (row,), (REMARK,))
