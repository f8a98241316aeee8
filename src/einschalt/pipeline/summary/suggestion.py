"""The form of every suggestion: what was found, and what to do about it."""

from dataclasses import dataclass

from einschalt.foundations.display_names import printable
from einschalt.foundations.language import Amount, figure, translated
from einschalt.foundations.typesetting import count, factor, length, number
from einschalt.pipeline.summary.wording import (
    flight_name,
    some_image_points,
    some_models,
    some_observations,
    some_of,
)

# how words write a fact: ``{largest:length}``
SIZES = {
    "length": length,
    "factor": factor,
    "number": number,
    "flight": flight_name,
    "name": printable,
}
# and the first of many: ``{models:models of n_models}``
LISTS = {
    "names": some_of,
    "models": some_models,
    "observations": some_observations,
    "image_points": some_image_points,
}


@dataclass(frozen=True)
class Suggestion:
    """One problem and what to do about it, each one sentence without its full stop."""

    problem: str
    remedy: str = ""  # empty where there is nothing to do
    details: tuple[str, ...] = ()  # parts of the problem, one a line

    def __str__(self):
        """Problem and remedy as sentences, without the details."""
        return f"{self.problem}. {self.remedy}." if self.remedy else f"{self.problem}."


@dataclass(frozen=True)
class _Fact:
    """A fact that is written as the words for its finding ask."""

    value: object
    facts: dict

    def __format__(self, way):
        how, _, rest = way.partition(" ")
        if how == "count":
            # two forms, parted by "|", where a plural s is not all
            return (
                f"{Amount(self.value):{rest}}"
                if "|" in rest
                else count(self.value, rest)
            )
        if how in LISTS:
            return LISTS[how](self.value, self.facts[rest.removeprefix("of ")])
        if how in SIZES:
            return SIZES[how](self.value)
        return self.value if isinstance(self.value, str) else figure(self.value, way)


def filled(words, finding, **texts) -> str:
    """Fill a message with names and facts of a finding, as SIZES and LISTS write them.

    ``{n_points:count new point}`` is a number of new points. ``texts`` are written as
    they are.
    """
    facts = {**finding.facts, "names": finding.names, **texts}
    return translated(words).format(
        **{key: _Fact(value, facts) for key, value in facts.items()}
    )
