"""Control points that disagree with the block, each by itself or all together."""

from dataclasses import dataclass

MOST_SUSPECTS = 20
MOST_DISPLACED = 8


@dataclass(frozen=True)
class SuspectControl:
    """A control point that disagrees with the block by itself.

    Attributes
    ----------
    point_id : str
    easting, northing : float
        The error of the given coordinates that explains it [m].
    w, p_value : float
    """

    point_id: str
    easting: float
    northing: float
    w: float
    p_value: float


@dataclass(frozen=True)
class SuspectControlFacts:
    """Control points that disagree with the block, each by itself.

    Attributes
    ----------
    suspects : tuple of SuspectControl
        The worst ones first.
    n_suspects : int
        All of them.
    is_set_aside : bool
    """

    suspects: tuple[SuspectControl, ...]
    n_suspects: int
    is_set_aside: bool


@dataclass(frozen=True)
class DisplacedControlFacts:
    """Control points of a strained network, none of which disagrees by itself.

    Attributes
    ----------
    displacements : tuple of (str, float, float)
        Name, easting, northing [m], the largest first.
    n_control : int
    """

    displacements: tuple[tuple[str, float, float], ...]
    n_control: int


def suspect_control_facts(
    examined,
) -> SuspectControlFacts | DisplacedControlFacts | None:
    """Find the control points that one adjustment of the block contradicts.

    Parameters
    ----------
    examined : SimultaneousExamination

    Returns
    -------
    SuspectControlFacts, DisplacedControlFacts or None
        Where no control point is suspect by itself, what they show together.
    """
    control = examined.adjustment.control
    suspects = control[control["is_suspect"]].sort_values("p_value")
    if suspects.empty:
        return displaced_control_facts(examined)
    columns = ("point_id", "strain_easting", "strain_northing", "w", "p_value")
    shown = suspects.head(MOST_SUSPECTS)
    rows = zip(*(shown[name] for name in columns), strict=True)
    return SuspectControlFacts(
        tuple(SuspectControl(name, *map(float, sizes)) for name, *sizes in rows),
        len(suspects),
        bool(suspects["is_set_aside"].any()),
    )


def displaced_control_facts(examined) -> DisplacedControlFacts | None:
    """Find the control points that a smooth strain of their network displaces most.

    Parameters
    ----------
    examined : Examination

    Returns
    -------
    DisplacedControlFacts or None
        None where no smooth strain was found.
    """
    strain = examined.patterns.strain
    if strain is None or not (strain.is_significant and strain.is_smooth):
        return None
    rows = strain.displacements.head(MOST_DISPLACED).itertuples(index=False)
    shown = tuple((name, float(east), float(north)) for name, east, north in rows)
    return DisplacedControlFacts(shown, strain.n_control)
