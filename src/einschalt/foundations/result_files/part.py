"""A part of a file of results: one object, wherever it stands in the file."""

from dataclasses import dataclass, field

from einschalt.foundations.meanings_with_units import unit_and_meaning


@dataclass(frozen=True)
class Part:
    """Names of one object, by the places at which it stands.

    A place is a path of names from the top of the file, with dots between them; ``[]``
    is any object of a list and ``*`` any name that a block gives. The top itself is
    empty.
    """

    places: tuple[str, ...]
    # by name: meaning, with its unit in brackets behind it if it has one
    names: dict[str, str]
    # by name: meaning of each word, or whole number, that may stand there
    values: dict[str, dict[str, str]] = field(default_factory=dict)

    def meaning(self, name) -> tuple[str, str]:
        """Unit of a name, empty where it has none, and what it means."""
        return unit_and_meaning(self.names[name])


# wherever an object tells which flight it is about
FLIGHT = "name of the flight: high_flight or low_flight"
