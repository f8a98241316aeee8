"""Control points that disagree with the block, each by itself or all together."""

from einschalt.foundations.display_names import printable
from einschalt.foundations.typesetting import lengths, number
from einschalt.pipeline.summary.sections.claim import probability
from einschalt.pipeline.summary.sections.section import Section

MOST_SHOWN = 20
MOST_DISPLACED = 8
TOGETHER = (
    "The largest of {}, as far as a smooth strain of their network can be estimated; "
    "none has to disagree by itself."
)
ASIDE = "They are set aside: the new points do not depend on them."
STRAIN = "easting, northing: the error of the given coordinates that explains it."


def section(result) -> Section:
    """Size and direction of the contradictions; no rows where there are none."""
    if (
        result.simultaneous is None
        or not result.simultaneous.control["is_suspect"].any()
    ):
        return _displaced_together(result.patterns.strain)
    control = result.simultaneous.control
    suspects = control[control["is_suspect"]].sort_values("p_value")
    shown = suspects.head(MOST_SHOWN)
    rows = zip(
        map(printable, shown["point_id"]),
        lengths(shown["strain_easting"]),
        lengths(shown["strain_northing"]),
        map(number, shown["w"]),
        map(probability, shown["p_value"]),
        strict=True,
    )
    said = [STRAIN]
    if suspects["is_set_aside"].any():
        said.append(ASIDE)
    if len(suspects) > len(shown):
        said.append(f"These are the worst {len(shown)} of {len(suspects)}.")
    header = ("", "easting", "northing", "w", "p")
    title = "Control points that disagree with the block"
    return Section(title, header, tuple(rows), tuple(said))


def _displaced_together(strain):
    """Control points of a strained network, none of which disagrees by itself."""
    title = "Control points that are displaced together"
    header = ("", "easting", "northing")
    if strain is None or not (strain.is_significant and strain.is_smooth):
        return Section(title, header, ())
    shown = strain.displacements.head(MOST_DISPLACED)
    columns = lengths(shown["easting"]), lengths(shown["northing"])
    rows = zip(map(printable, shown["point_id"]), *columns, strict=True)
    return Section(title, header, tuple(rows), (TOGETHER.format(strain.n_control),))
