"""The form of every suggestion: what was found, and what to do about it."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Suggestion:
    """One problem and what to do about it.

    Attributes
    ----------
    problem : str
        One sentence without its full stop.
    remedy : str
        One sentence without its full stop; empty where there is nothing to do.
    details : tuple of str
        Parts of the problem, one a line.
    """

    problem: str
    remedy: str = ""
    details: tuple[str, ...] = ()

    def __str__(self):
        """Problem and remedy as sentences, without the details."""
        return f"{self.problem}. {self.remedy}." if self.remedy else f"{self.problem}."
