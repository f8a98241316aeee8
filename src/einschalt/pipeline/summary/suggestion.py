"""The form of every suggestion: what was found, and what to do about it."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Suggestion:
    """One problem and what to do about it."""

    problem: str  # one sentence without its full stop
    # one sentence without its full stop; empty where there is nothing to do
    remedy: str = ""
    details: tuple[str, ...] = ()  # parts of the problem, one a line

    def __str__(self):
        """Problem and remedy as sentences, without the details."""
        return f"{self.problem}. {self.remedy}." if self.remedy else f"{self.problem}."
