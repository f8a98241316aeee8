"""``plan.plot``: figures of a plan, each on axes of matplotlib."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from einschalt.pipeline.planning.estimate.search import PlanSearch
    from einschalt.pipeline.planning.propagation.expected_precision import (
        ExpectedPrecision,
    )


class ExpectedPlots:
    """Figures of the precision that a planned block will have.

    Each takes axes of matplotlib, and gives them back; without axes they are those of a
    new figure. Data of the map are metres from the centre of the area.
    """

    def __init__(self, expected: "ExpectedPrecision") -> None:
        self._expected = expected

    def map(self, ax: "Axes | None" = None) -> "Axes":
        """Draw the standard errors to expect over the area, and its control."""
        return _drawing().expected_map(ax, self._expected)

    def profile(self, ax: "Axes | None" = None) -> "Axes":
        """Draw the precision from the middle of a model to its edge."""
        return _drawing().profile(ax, self._expected)

    def sources(self, ax: "Axes | None" = None) -> "Axes":
        """Draw what control and both flights contribute to the new points."""
        return _drawing().expected_sources(ax, self._expected)


class SearchPlots:
    """Figures of the plans that were searched, each on axes that are given, or new."""

    def __init__(self, search: "PlanSearch") -> None:
        self._search = search

    def costs(self, ax: "Axes | None" = None) -> "Axes":
        """Draw cost against precision, and the plans that no other plan beats."""
        return _drawing().costs(ax, self._search)


def _drawing() -> Any:
    # imported when something is drawn: matplotlib takes its time
    from einschalt.interfaces.notebook import plan_diagrams  # noqa: PLC0415

    return plan_diagrams
