"""Every number that the text of Kovarik 1971 states, beside ours.

His four diagrams are lost as pictures; what the text quotes from them is all that a
computation can be held against. A printed number stands for an interval: half a unit of
its last digit to either side, or less where the text says "just under".
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from einschalt.foundations.units import METRES_PER_UM
from einschalt.theory.measuring_error import m_g_from_machine
from einschalt.theory.planning.kovarik_precision import (
    PlannedModel,
    best_scale,
    mean_of_coverages,
    planned_precision,
)

PAPER = PlannedModel()
CM = 100.0

RULE_IS_FITTED = (
    "the text does not say where the edge is; of simple rules twice the middle, "
    "counted on 138 x 161 mm, fits best, and a free fit (232 cm², factor 2.06) meets "
    "every statement on edges but the 16 cm"
)
OWN_CONTRADICTION = (
    "m_t depends on spacing over scale number only, so at 1:6000 it is twice that at "
    "1:12000. 'Just under 9' there, printed in the next sentence, makes it just under "
    "18 here: the print contradicts itself"
)
MEASURED = (
    "this is a result, from differences of coverages; the formula takes both for "
    "independent, which they are not (a block simulated after Neukirchen has 5.2 cm)"
)
READ_OFF = "read from a diagram by its author, and called 'almost'"


@dataclass(frozen=True)
class Statement:
    """A number of the text."""

    where: str  # page of the volume, and what the number is
    printed: float
    low: float  # what the print allows
    high: float
    ours: float
    unit: str = "cm"
    why: str = ""  # why ours lies outside, where it does


def compare_with_print() -> pd.DataFrame:
    """Compare every stated number with ours.

    where, unit, printed, low, high (what the print allows), ours, difference (ours less
    printed), outside (by how much ours leaves what the print allows, 0 where it does
    not), why.

    Examples
    --------
    >>> compared = compare_with_print()
    >>> compared.loc[compared["outside"] > 1.0, ["printed", "ours"]].round(1)
       printed  ours
    3     16.0  17.9
    """
    parts = (_transformation, _totals, _instruments, _flying_heights, _neukirchen)
    table = pd.DataFrame([statement for part in parts for statement in part()])
    table["difference"] = table["ours"] - table["printed"]
    below, above = table["low"] - table["ours"], table["ours"] - table["high"]
    table["outside"] = np.maximum(np.maximum(below, above), 0.0).round(12)
    table.loc[table["outside"] == 0.0, "why"] = ""
    columns = ["where", "unit", "printed", "low", "high", "ours"]
    return table[[*columns, "difference", "outside", "why"]]


def _planned(scale_number, spacing, m_0_cm, m_g_um):
    return planned_precision(
        scale_number, spacing, m_0_cm / CM, m_g_um * METRES_PER_UM, PAPER
    )


def _rounded(where, printed, ours, why=RULE_IS_FITTED):
    """Make a statement whose number is rounded to whole centimetres."""
    return Statement(where, printed, printed - 0.5, printed + 0.5, float(ours), why=why)


def _just_under(where, printed, ours):
    return Statement(where, printed, printed - 0.5, printed, float(ours), why=READ_OFF)


def _transformation():
    """Pages 40 and 42: the transformation alone."""

    def edge(scale_number, spacing, m_0_cm):
        return CM * _planned(scale_number, spacing, m_0_cm, 10.0).m_t_edge

    at = "diagram 1: m_t in the middle with 30 points"
    yield Statement(at, 0.18, 0.175, 0.185, 30**-0.5, "m_0")
    at = "diagram 3: m_t at the edge, "
    yield _rounded(f"{at}1:6000, 200 m, m_0 10 cm", 5.0, edge(6000, 200, 10))
    yield _rounded(f"{at}1:6000, 300 m, m_0 10 cm", 7.0, edge(6000, 300, 10))
    yield _rounded(
        f"{at}1:6000, 400 m, m_0 20 cm", 16.0, edge(6000, 400, 20), OWN_CONTRADICTION
    )
    yield _rounded(f"{at}1:12000, 200 m, m_0 10 cm", 2.0, edge(12000, 200, 10))
    yield _rounded(f"{at}1:12000, 300 m, m_0 10 cm", 3.0, edge(12000, 300, 10))
    yield _just_under(
        f"{at}1:12000, 400 m, m_0 20 cm ('just under')", 9.0, edge(12000, 400, 20)
    )


def _totals():
    """Pages 43 to 45: the total error, diagrams 4 a to d."""
    a = _planned(6000, 200, 10, 10)
    at = "diagram 4a: M, 1:6000, 200 m, "
    yield _rounded(f"{at}middle", 6.0, CM * a.M_centre)
    yield _rounded(f"{at}edge", 8.0, CM * a.M_edge)
    yield _rounded(f"{at}mean of two coverages", 5.0, CM * a.M_double)
    d = _planned(6000, 400, 20, 5)
    at = "diagram 4d: M at the edge less M in the middle, 1:6000, 400 m ('almost')"
    ours, why = float(CM * (d.M_edge - d.M_centre)), f"{READ_OFF}; {RULE_IS_FITTED}"
    yield Statement(at, 10.0, 9.0, 10.0, ours, why=why)


def _instruments():
    """Page 44, footnote 4: from the machine to the image."""
    machine, image = (m_g_from_machine(0.015, 0.010, factor) for factor in (1.0, 2.5))
    at = "footnote 4: plan error in the machine of 0.015 and 0.01 mm ('about')"
    yield Statement(at, 0.02, 0.015, 0.025, machine, "mm")
    at = "footnote 4: the same in the image, through 2.5 ('hardly')"
    yield Statement(at, 0.01, 0.005, 0.01, image, "mm")


def _flying_heights():
    """Pages 42 and 46: flying heights above ground."""
    for name, height, low, high in (
        ("1:6000, f 152 mm", 6000 * 0.152, 900.0, 1000.0),
        ("1:12000, f 152 mm", 12000 * 0.152, 1800.0, 1900.0),
        ("Neukirchen high, 1:15000, f 15 cm", 15000 * 0.15, 2140.0, 2270.0),
        ("Neukirchen low, 1:7500, f 15 cm", 7500 * 0.15, 1090.0, 1220.0),
    ):
        at = f"flying height of {name}: {low:.0f} to {high:.0f} m"
        yield Statement(at, (low + high) / 2.0, low, high, height, "m")


def _neukirchen():
    """Page 46: the test, beside diagram 4c at 1:7500 and 300 m."""
    planned = _planned(7500, 300, 10, 5)
    at = "Neukirchen, result beside diagram 4c (1:7500, 300 m): "
    yield _rounded(f"{at}middle of models", 5.0, CM * planned.M_centre)
    yield _rounded(f"{at}edge of models", 7.0, CM * planned.M_edge)
    low = _planned(8000, 300, 9.5, 5)
    at = "Neukirchen, result at 1:8000: mean of two coverages"
    ours = float(CM * mean_of_coverages(low.M_centre, low.M_edge, 2))
    yield Statement(at, 4.5, 4.25, 4.75, ours, why=MEASURED)


def compare_conclusions() -> pd.DataFrame:
    """Check what the text concludes without a number.

    conclusion, holds, because (our numbers).

    Examples
    --------
    >>> bool(compare_conclusions()["holds"].all())
    True
    """
    scales = np.array([6000.0, 8000.0, 10000.0, 12000.0])[:, None]
    spacings = np.array([200.0, 300.0, 400.0])
    given = {"4a": (10, 10), "4b": (20, 10), "4c": (10, 5), "4d": (20, 5)}
    diagrams = {name: _planned(scales, spacings, *both) for name, both in given.items()}
    edge = {name: CM * planned.M_edge for name, planned in diagrams.items()}
    span = {n: (CM * (p.M_edge - p.M_centre)).max() for n, p in diagrams.items()}
    best = best_scale(spacings, 0.10, 10e-6, PAPER)
    rows = [
        (
            "4a has the smallest span from the middle to the edge",
            min(span, key=span.get) == "4a",
            ", ".join(f"{name} {value:.1f} cm" for name, value in span.items()),
        ),
        (
            "4c has the smallest values",
            min(edge, key=lambda name: edge[name].mean()) == "4c",
            ", ".join(f"{name} {v.mean():.1f} cm" for name, v in edge.items()),
        ),
        *_backfires(edge),
        (
            "400 m loses at the edges towards 1:6000 in 4a, 300 m does not",
            bool(
                edge["4a"][0, 2] > edge["4a"][1, 2]
                and edge["4a"][0, 1] < edge["4a"][1, 1]
            ),
            f"best scale for 300 m 1:{best[1]:.0f}, for 400 m 1:{best[2]:.0f}",
        ),
    ]
    return pd.DataFrame(rows, columns=["conclusion", "holds", "because"])


def _backfires(edge):
    for name in ("4b", "4d"):
        at_6000, at_8000 = edge[name][:2, 1]
        yield (
            f"{name}: a larger scale can be worse",
            bool(at_6000 > at_8000),
            f"edge at 300 m: 1:6000 {at_6000:.1f} cm, 1:8000 {at_8000:.1f} cm",
        )
