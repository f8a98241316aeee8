"""Control points that disagree with the block, each by itself or all together."""

import math
from dataclasses import dataclass

MOST_SUSPECTS = 20
MOST_DISPLACED = 8


@dataclass(frozen=True)
class SuspectControl:
    """A control point that disagrees with the block by itself."""

    point_id: str
    # the error of the given coordinates that explains it [m]
    easting: float
    northing: float
    w: float
    p_value: float
    height: float = math.nan  # of the same error [m]; NaN in plan


@dataclass(frozen=True)
class SuspectControlFacts:
    """Control points that disagree with the block, each by itself."""

    suspects: tuple[SuspectControl, ...]  # the worst ones first
    n_suspects: int  # all of them
    is_set_aside: bool


@dataclass(frozen=True)
class DisplacedControlFacts:
    """Control points of a strained network, none of which disagrees by itself."""

    # name, easting, northing [m], the largest first
    displacements: tuple[tuple[str, float, float], ...]
    n_control: int


def suspect_control_facts(
    examined,
) -> SuspectControlFacts | DisplacedControlFacts | None:
    """Find the control points that one adjustment of the block contradicts.

    Where no control point is suspect by itself, what they show together.
    """
    control = examined.adjustment.control
    suspects = control[control["is_suspect"]].sort_values("p_value")
    if suspects.empty:
        return displaced_control_facts(examined)
    columns = ["point_id", "strain_easting", "strain_northing", "w", "p_value"]
    columns += ["strain_height"] if "strain_height" in suspects else []
    shown = suspects.head(MOST_SUSPECTS)
    rows = zip(*(shown[name] for name in columns), strict=True)
    return SuspectControlFacts(
        tuple(SuspectControl(name, *map(float, sizes)) for name, *sizes in rows),
        len(suspects),
        bool(suspects["is_set_aside"].any()),
    )


def displaced_control_facts(examined) -> DisplacedControlFacts | None:
    """Find the control points that a smooth strain of their network displaces most."""
    strain = examined.strain
    if strain is None or not (strain.is_significant and strain.is_smooth):
        return None
    rows = strain.displacements.head(MOST_DISPLACED).itertuples(index=False)
    shown = tuple((name, float(east), float(north)) for name, east, north in rows)
    return DisplacedControlFacts(shown, strain.n_control)
