"""Bends that the spatial models of a flight share, as either way has corrected them."""

from dataclasses import dataclass


@dataclass(frozen=True)
class BentFlight:
    """What all models of a flight are bent by, and corrected by."""

    flight: str
    p_value: float
    size_edge: float  # of heights at the edge of the models, RMS [m]


def bent_flights_of(examined) -> tuple[BentFlight, ...]:
    """Flights whose models were corrected, of an examination; none where none was."""
    adjustment = getattr(examined.solution, "adjustment", None)
    if adjustment is None:
        bends = examined.solution.shared_bends
        tests = {} if bends is None else bends.tests
        found = [(name, t.p_value, t.size_edge) for name, t in tests.items()]
    elif adjustment.tables.is_spatial:
        table = adjustment.deformations
        table = table[table["is_modelled"].astype(bool)]
        found = table[["flight", "p_value", "size_edge"]].itertuples(index=False)
    else:
        found = []
    return tuple(BentFlight(str(f), float(p), float(size)) for f, p, size in found)
