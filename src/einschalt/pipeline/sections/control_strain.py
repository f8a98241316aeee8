"""Control points that disagree with the simultaneously adjusted block."""

from einschalt.foundations.shown_names import printable
from einschalt.foundations.typesetting import lengths, number
from einschalt.pipeline.sections.section import Section

MOST_SHOWN = 20
STRAIN = "easting, northing: the error of the given coordinates that explains it."


def section(result) -> Section:
    """Size and direction of the contradictions; no rows where there are none."""
    title = "Control points that disagree with the block"
    header = ("", "easting", "northing", "w", "p")
    if result.simultaneous is None:
        return Section(title, header, ())
    control = result.simultaneous.control
    suspects = control[control["is_suspect"]].sort_values("p_value")
    shown = suspects.head(MOST_SHOWN)
    rows = zip(
        map(printable, shown["point_id"]),
        lengths(shown["strain_easting"]),
        lengths(shown["strain_northing"]),
        map(number, shown["w"]),
        map(number, shown["p_value"]),
        strict=True,
    )
    said = [STRAIN]
    if len(suspects) > len(shown):
        said.append(f"These are the worst {len(shown)} of {len(suspects)}.")
    return Section(title, header, tuple(rows), tuple(said))
