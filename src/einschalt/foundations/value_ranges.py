"""Ranges that the numbers of a settings dataclass must keep."""

from dataclasses import dataclass

import numpy as np

from einschalt.foundations.arguments import described
from einschalt.foundations.errors import EinschaltError, SettingsError

LARGEST = float(np.finfo(float).max)  # Python's whole numbers go on


@dataclass(frozen=True)
class Range:
    """Smallest and largest value of one field, and its unit for the message.

    ``likely_slip`` is what a value outside suggests: "Did you give millimetres?"; if
    not every one does, ``slips`` are the smallest and the largest that do.
    """

    low: float
    high: float
    unit: str = ""
    is_whole: bool = False
    likely_slip: str = ""
    slips: tuple[float, float] = (0.0, np.inf)

    def __contains__(self, value):
        """Whether a value is a number of the right kind within the range."""
        # bool is an int to Python, and yet no measure
        is_number = isinstance(value, int | float | np.integer | np.floating)
        if isinstance(value, bool) or not is_number or not abs(value) <= LARGEST:
            return False
        is_kind = not self.is_whole or float(value).is_integer()
        return self.low <= value <= self.high and is_kind

    def remedy_for(self, value) -> str:
        """What a value outside suggests; no other unit makes 0 or less a size.

        >>> spacing = Range(
        ...     1, 10_000, likely_slip="Did you give kilometres?", slips=(1e-3, 10)
        ... )
        >>> spacing.remedy_for(0.25), spacing.remedy_for(-5.0), spacing.remedy_for(1e5)
        ('Did you give kilometres?', '', '')
        """
        is_number = isinstance(value, int | float | np.integer | np.floating)
        if not is_number or value <= 0:
            return ""
        low, high = self.slips
        return self.likely_slip if low <= value <= high else ""

    def __str__(self):
        """Return the range as it stands in a message."""
        number = "a whole number, " if self.is_whole else ""
        unit = f" {self.unit}" if self.unit else ""
        return f"{number}{self.low:g} to {self.high:g}{unit}"


def problems_in(owner, ranges) -> list[EinschaltError]:
    """Find the fields of a dataclass that lie outside their ranges.

    >>> from types import SimpleNamespace
    >>> relief = SimpleNamespace(relief=-1.0)
    >>> print(problems_in(relief, {"relief": Range(0, 100, "metres")})[0])
    relief = -1.0; expected 0 to 100 metres.
    """
    return [
        SettingsError(
            f"{name} = {described(getattr(owner, name))}",
            expected=str(allowed),
            remedy=allowed.remedy_for(getattr(owner, name)),
        )
        for name, allowed in ranges.items()
        if getattr(owner, name) not in allowed
    ]
