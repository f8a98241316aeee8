"""What should be known of transformations before they are used."""

import numpy as np

from einschalt.foundations.errors import name_some
from einschalt.foundations.language import figure, in_english, mark, translated
from einschalt.foundations.typesetting import per_cent

FAR_ABOVE_OTHERS = 5.0  # times the median of all that a result has
LEAST_TOLD = 5e-5  # metres: less is 0 as it is written
OF_EXTENT = 0.01  # of what a transformation covers
FEWEST = 3  # transformations of which one can be far above the others
UNCHECKED = mark(
    "{n:transformation|transformations} without a point to spare: {names}. No point "
    "was held out, and a gross error in them cannot be detected."
)
FAR_ABOVE = mark(
    "{n:transformation misses|transformations miss} held-out points by more than "
    "{factor} times the median of all, {median} m: {names}, up to {worst} m. Look for "
    "gross errors in their points before you use them."
)
FAR_FOR_EXTENT = mark(
    "{n:transformation misses|transformations miss} held-out points by more than "
    "{percent} of the extent of their points: {names}, up to {worst} m. Look for gross "
    "errors before you use them."
)


@in_english
def doubts_of(operations) -> tuple[str, ...]:
    """Say which of the published operations nothing checks, or what they miss by far.

    ``operations``: list of PublishedOperation.
    """
    errors = np.array([one.error_at_held_out for one in operations], dtype=float)
    is_held = np.array([one.n_held_out > 0 for one in operations])
    said = []
    if not is_held.all():
        unchecked = [o for o, held in zip(operations, is_held, strict=True) if not held]
        said.append(translated(UNCHECKED, n=len(unchecked), names=_names(unchecked)))
    extents = np.array([_extent(one) for one in operations])
    is_told = is_held & (errors > LEAST_TOLD)
    is_wide = is_told & (errors > OF_EXTENT * extents)
    if is_wide.any():
        facts = _facts(operations, errors, is_wide)
        said.append(translated(FAR_FOR_EXTENT, percent=per_cent(OF_EXTENT), **facts))
    median = np.median(errors[is_held]) if is_held.sum() >= FEWEST else np.inf
    is_far = is_told & ~is_wide & (errors > FAR_ABOVE_OTHERS * median)
    if is_far.any():
        facts = _facts(operations, errors, is_far)
        facts |= {"factor": f"{FAR_ABOVE_OTHERS:g}", "median": figure(median, ".4f")}
        said.append(translated(FAR_ABOVE, **facts))
    return tuple(said)


def _facts(operations, errors, is_meant):
    """Number, names, the worst first, and the largest error."""
    places = np.flatnonzero(is_meant)
    places = places[np.argsort(-errors[places], kind="stable")]
    return {
        "n": len(places),
        "names": _names([operations[place] for place in places]),
        "worst": figure(errors[places[0]], ".4f"),
    }


def _names(operations):
    return name_some(one.code for one in operations)


def _extent(one):
    """Length of the box about the identical points of an operation [m]."""
    return float(np.hypot(*np.ptp(one.target[:, :2], axis=0)))
