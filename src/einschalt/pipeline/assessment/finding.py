"""A finding: one thing that a result shows and its user should know.

Findings are data. They are made once, by :mod:`einschalt.pipeline.assessment`; what is
said of them stands in :mod:`einschalt.pipeline.summary`.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import IntEnum, StrEnum
from typing import Any

import numpy as np


class Subject(StrEnum):
    """What a finding is about."""

    BLOCK = "block"
    FLIGHT = "flight"
    MODEL = "model"
    POINT = "point"
    CONTROL = "control point"
    MEASUREMENT = "measurement"


class Gravity(IntEnum):
    """How much a finding matters."""

    NOTE = 0  # nothing is wrong with the result
    WARNING = 1  # part of the result is weak, or not checked
    GRAVE = 2  # the stated precision does not hold, or coordinates are wrong


@dataclass(frozen=True)
class Finding:
    """What was found, in numbers and names; the words for it stand elsewhere."""

    code: str  # name of the finding, the same in every result
    subject: Subject
    gravity: Gravity = Gravity.WARNING
    # of the models, points or measurements concerned, the worst first
    names: tuple[str, ...] = ()
    statistic: str = ""  # what was compared
    # its value and what was to be expected, in SI units; NaN where there is none
    observed: float = np.nan
    expected: float = np.nan
    # of a value this large if the stated precision is correct; NaN where none was
    # computed
    probability: float = np.nan
    untested: str = ""  # why it could not be tested, a code; empty where it was tested
    remedy: str = ""  # what to do, a code; empty where there is nothing to do
    # everything that the words for this finding need
    facts: Mapping[str, Any] = field(default_factory=dict)
    # code of the cause that explains it; empty where it stands by itself
    explained_by: str = ""
