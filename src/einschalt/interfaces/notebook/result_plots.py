"""``result.plot``: figures of a result, each on axes of matplotlib."""

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from einschalt.pipeline.result import DensificationResult

Layer = Literal[
    "models",
    "points",
    "control",
    "differences",
    "coverage_differences",
    "ellipses",
]


class ResultPlots:
    """Figures of one result: each takes axes of matplotlib, and gives them back.

    Without axes they are those of a new figure. Maps are drawn in metres of the system
    of the results, whatever unit their labels have, so that more can be drawn on them.
    A :class:`TableError` says why, where a result has nothing of the kind.

    Examples
    --------
    >>> import einschalt as es
    >>> result = es.densify(es.simulate_block("demo", seed=1))
    >>> axes = result.plot.precision()
    >>> axes.get_ylabel()
    'points'
    """

    def __init__(self, result: "DensificationResult") -> None:
        self._result = result

    def __repr__(self) -> str:
        names = (name for name in vars(type(self)) if not name.startswith("_"))
        return f"<{type(self).__name__}: {', '.join(f'{name}()' for name in names)}>"

    def map(
        self,
        ax: "Axes | None" = None,
        *,
        layers: Iterable[Layer] = ("points", "control", "differences"),
        column: str | None = None,
    ) -> "Axes":
        """Draw the block: points in the colours of their errors, control, vectors.

        Parameters
        ----------
        ax : Axes, optional
        layers : iterable of str
            Some of ``models`` (outlines of the low flight's, and of those that failed),
            ``points`` (the new ones, a ring about suspects), ``control`` (with check
            points), ``differences`` (densified − given at known points),
            ``coverage_differences``, ``ellipses``; a layer that the result does not
            have is left out. All vectors and ellipses share one exaggeration.
        column : str, optional
            Of ``points``: the standard error that the colours show, such as
            ``standard_error_height``. The one that is claimed where left out.

        Raises
        ------
        SettingsError
            A layer or the column is unknown.
        TableError
            No point has coordinates.
        """
        return _maps().block_map(ax, self._result, layers, column)

    def precision(
        self, ax: "Axes | None" = None, *, column: str | None = None
    ) -> "Axes":
        """Draw the histogram of the standard errors of the new points.

        Parameters
        ----------
        ax : Axes, optional
        column : str, optional
            As of :meth:`map`.

        Raises
        ------
        SettingsError
            The column is unknown.
        TableError
            No new point has such an error.
        """
        return _diagrams().precision(ax, self._result, column)

    def residuals(self, ax: "Axes | None" = None) -> "Axes":
        """Draw the histogram of the residuals, in standard deviations of their flight.

        A TableError if fewer than 20 residuals have redundancy.
        """
        return _diagrams().residuals(ax, self._result)

    def quantiles(self, ax: "Axes | None" = None) -> "Axes":
        """Draw the normal Q–Q plot of the residuals.

        A TableError if fewer than 20 residuals have redundancy.
        """
        return _diagrams().quantiles(ax, self._result)

    def coverage_differences(self, ax: "Axes | None" = None) -> "Axes":
        """Draw how far the first two coverages lie apart at every point, as a map.

        A TableError if there are no two coverages.
        """
        return _maps().difference_map(ax, self._result)

    def m_0_per_model(self, ax: "Axes | None" = None) -> "Axes":
        """Draw m_0 of every model, a colour for each flight.

        A TableError if no model has redundancy.
        """
        return _diagrams().m_0_per_model(ax, self._result)

    def sources(self, ax: "Axes | None" = None) -> "Axes":
        """Draw where the error of the new points comes from, good points to bad.

        A TableError if errors were not propagated.
        """
        return _diagrams().sources(ax, self._result)

    def correlogram(self, ax: "Axes | None" = None) -> "Axes":
        """Draw the correlation of residuals by distance, and what the claim expects.

        A TableError if the result has none: it is that of one adjustment, or has few
        residuals.
        """
        return _diagrams().correlogram(ax, self._result)

    def neighbours(self, ax: "Axes | None" = None) -> "Axes":
        """Draw how precise coordinate differences between neighbours are.

        A TableError if errors were not propagated.
        """
        return _diagrams().neighbours(ax, self._result)

    def paper(self, ax: "Axes | None" = None) -> "Axes":
        """Draw standard errors after Kovarik's budget beside those that are claimed.

        A TableError if only one of the two is known.
        """
        return _diagrams().paper(ax, self._result)

    def parallaxes(self, ax: "Axes | None" = None) -> "Axes":
        """Draw the histogram of the parallaxes that relative orientations leave.

        A TableError if no flight was oriented by its points.
        """
        return _diagrams().parallaxes(ax, self._result)


# imported when something is drawn: matplotlib takes its time
def _maps() -> Any:
    from einschalt.interfaces.notebook import maps  # noqa: PLC0415

    return maps


def _diagrams() -> Any:
    from einschalt.interfaces.notebook import diagrams  # noqa: PLC0415

    return diagrams
