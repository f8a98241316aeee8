"""The block that was densified, and with which settings."""

from dataclasses import dataclass
from typing import Any

from einschalt.foundations.frame_columns import columns_of

MODEL = ["flight", "coverage", "model_id"]


@dataclass(frozen=True)
class BlockFacts:
    """A block by name, size and settings."""

    name: str
    crs: str | None
    # of all flights
    n_models: int
    n_failed_models: int
    # settings that differ from the defaults
    chosen_settings: tuple[tuple[str, Any], ...]


def block_facts(examined) -> BlockFacts:
    """Collect what identifies the block and its computation."""
    block, settings = examined.block, examined.settings
    fields = type(settings).model_fields
    return BlockFacts(
        name=block.name,
        crs=block.crs,
        n_models=sum(flight.n_models for flight in block.flights.values()),
        n_failed_models=len(columns_of(examined.failures, MODEL).drop_duplicates()),
        chosen_settings=tuple(
            (name, value)
            for name, value in settings.model_dump().items()
            if value != fields[name].default
        ),
    )
