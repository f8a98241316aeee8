"""What memory a block needs, before it is asked for.

The propagation of errors holds, for each pair of points of a model, what an error of
one does to the other: a matched cloud of a million points in one model would need
terabytes.
"""

import os
import platform

from einschalt.foundations.errors import GeometryError

# measured: models of 1000 to 1500 points, both flights, everything together
BYTES_PER_PAIR = 64


def needed_bytes(block) -> tuple[float, int]:
    """Memory for the pairs of points of all models, and points of the largest model."""
    n_pairs, largest = 0.0, 0
    for flight in block.flights.values():
        table = flight.model_table()
        n_points = table.groupby(["coverage", "model_id"], sort=False).size()
        n_pairs += float((n_points.astype(float) ** 2).sum())
        largest = max(largest, int(n_points.max())) if len(n_points) else largest
    return BYTES_PER_PAIR * n_pairs, largest


def require_memory(block):
    """Refuse a block that surely needs more memory than this process may have."""
    needed, largest = needed_bytes(block)
    there = allowed_bytes()
    if needed <= there:
        return
    raise GeometryError(
        f"the block needs about {_gigabytes(needed)} of memory, with up to {largest} "
        "points in a model",
        expected=f"at most the {_gigabytes(there)} that this process may have",
        remedy="Take fewer points of a model, such as a tenth of a matched cloud",
    )


def _gigabytes(n_bytes):
    size = n_bytes / 1e9
    return f"{size:.2g} GB" if size < 10.0 else f"{size:.0f} GB"


def allowed_bytes() -> float:
    """Memory of this computer, or the limit of this process; inf if unknown."""
    found = [float("inf")]
    if platform.system() != "Windows":
        import resource  # noqa: PLC0415 - Windows has no such module

        limit = resource.getrlimit(resource.RLIMIT_DATA)[0]
        found += [float(limit)] if limit != resource.RLIM_INFINITY else []
        if "SC_PHYS_PAGES" in os.sysconf_names:
            found.append(
                float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
            )
    return min(found)
