"""What a name in assessment.json or provenance.json means, by the place where it is."""

from collections.abc import Iterator
from dataclasses import dataclass, field

from einschalt.foundations.result_files import (
    claims,
    finding_facts,
    findings,
    flights,
    overview,
    patterns,
    precision,
    provenance,
)

ASSESSMENT, PROVENANCE = "assessment.json", "provenance.json"
MODULES = (
    *(overview, claims, precision, flights, patterns, findings),
    finding_facts,
)
PARTS = {
    ASSESSMENT: tuple(part for module in MODULES for part in module.PARTS),
    PROVENANCE: provenance.PARTS,
}
"""By file, all parts of it."""


@dataclass(frozen=True)
class MeaningInFile:
    """What a name, or a word that stands there, means in a file of results."""

    file: str
    places: tuple[str, ...]
    unit: str  # empty where it has none
    text: str
    values: dict[str, str] = field(default_factory=dict)
    value: str = ""  # the word, at places that have it

    @property
    def where(self) -> str:
        """File and places, as they are told."""
        return self._told(self.places)

    @property
    def each_where(self) -> list[str]:
        """File and place, for each place."""
        return [self._told([place]) for place in self.places]

    def _told(self, places):
        told = ", ".join(filter(None, (self.file, *places)))
        return f"{told} = {self.value}" if self.value else told


def meanings_in_files(name) -> Iterator[MeaningInFile]:
    """Give what a name means in each part of the files, or what a word there means.

    >>> [meaning.where for meaning in meanings_in_files("seal")]
    ['provenance.json']
    >>> [meaning.where for meaning in meanings_in_files("only_way")]
    ['assessment.json, choice.reason, better.reason = only_way']
    """
    for file, parts in PARTS.items():
        for part in parts:
            if name in part.names:
                values = part.values.get(name, {})
                yield MeaningInFile(file, part.places, *part.meaning(name), values)
            for key, values in part.values.items():
                if name in values:
                    at = tuple(path_of(place, key) for place in part.places)
                    yield MeaningInFile(file, at, "", values[name], value=name)


def path_of(place, name) -> str:
    """Path of a name from the top of its file.

    >>> path_of("claim", "tests"), path_of("", "claim")
    ('claim.tests', 'claim')
    """
    return f"{place}.{name}" if place else name


def names_with_values() -> dict[str, tuple[str, ...]]:
    """All names of both files, each with the words that may stand there."""
    found = {}
    for parts in PARTS.values():
        for part in parts:
            for name in part.names:
                found.setdefault(name, {}).update(part.values.get(name, {}))
    return {name: tuple(values) for name, values in sorted(found.items())}


def words_of_files() -> frozenset[str]:
    """All names of both files, and all words that may stand there."""
    named = names_with_values()
    return frozenset((*named, *(word for words in named.values() for word in words)))
