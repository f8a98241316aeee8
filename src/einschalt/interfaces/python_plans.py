"""The Python interface of planning: plans that draw themselves."""

from collections.abc import Sequence
from dataclasses import dataclass
from os import PathLike
from typing import Any, Literal

import numpy as np
import pandas as pd

from einschalt.foundations.argument_names import naming_arguments, with_arguments
from einschalt.foundations.arguments import described
from einschalt.foundations.errors import GeometryError, SettingsError
from einschalt.foundations.told_fields import with_fields_of
from einschalt.interfaces.files.area_files import area_of_table, read_area
from einschalt.interfaces.files.height_files import read_heights_over
from einschalt.interfaces.notebook.cards import checked_plan_card, plan_card
from einschalt.interfaces.notebook.plan_plots import ExpectedPlots, SearchPlots
from einschalt.pipeline.block.block import plain_fields
from einschalt.pipeline.planning.area import recommended
from einschalt.pipeline.planning.area.flight_area import FlightArea
from einschalt.pipeline.planning.choice import check
from einschalt.pipeline.planning.choice.rows import design_of_row, require_frame
from einschalt.pipeline.planning.estimate import search
from einschalt.pipeline.planning.estimate.search import PlanChoices, PlanFrame
from einschalt.pipeline.planning.flights.flight_design import FlightDesign
from einschalt.pipeline.planning.propagation import expected_precision

FEWEST = 3  # corners of an area


@with_fields_of(expected_precision.ExpectedPrecision)
@dataclass(frozen=True, eq=False, repr=False)
class ExpectedPrecision(expected_precision.ExpectedPrecision):
    """What a planned block will be worth, with figures."""

    @property
    def plot(self) -> ExpectedPlots:
        """Figures on axes of matplotlib: ``map()``, ``profile()``, ``sources()``."""
        return ExpectedPlots(self)

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self.verdict}>"

    def _repr_html_(self) -> str:
        return plan_card(self)


@with_fields_of(search.PlanSearch)
@dataclass(frozen=True, eq=False, repr=False)
class PlanSearch(search.PlanSearch):
    """All plans, the cheapest that reach the target first, with figures."""

    @property
    def verdict(self) -> str:
        """The answer on one line; what would help names arguments of Python."""
        return with_arguments(super().verdict)

    def summary(self) -> str:
        """Return the plans as text."""
        return with_arguments(super().summary())

    @property
    def plot(self) -> SearchPlots:
        """Figures on axes of matplotlib: ``costs()``."""
        return SearchPlots(self)

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self.verdict}>"

    def _repr_html_(self) -> str:
        return plan_card(self)


@with_fields_of(check.CheckedPlan)
@dataclass(frozen=True, eq=False, repr=False)
class CheckedPlan(check.CheckedPlan):
    """The cheapest plan that keeps its target on its own layout, or the nearest one."""

    search: PlanSearch
    next_best: "CheckedPlan | None" = None

    @property
    def expected(self) -> ExpectedPrecision:
        """What is expected of the block that was laid out, with figures."""
        return ExpectedPrecision(**plain_fields(super().expected))

    @property
    def dropped(self) -> tuple[str, ...]:
        """Other plans that were tried, with why they are not recommended."""
        return tuple(map(with_arguments, super().dropped))

    def verdict(self) -> str:
        """Return which plan holds, the next best, and what does not hold."""
        return with_arguments(super().verdict())

    def outcome(self) -> str:
        """Say whether it is recommended, what it comes to, and where, in a sentence."""
        return with_arguments(super().outcome())

    def _repr_html_(self) -> str:
        return checked_plan_card(self, self.outcome())

    @classmethod
    def of(cls, found: check.CheckedPlan) -> "CheckedPlan":
        """Take what was found with its search and the next best."""
        parts = plain_fields(found)
        parts["search"] = PlanSearch(**plain_fields(found.search))
        if found.next_best is not None:
            parts["next_best"] = cls.of(found.next_best)
        return cls(**parts)


@with_fields_of(recommended.AreaPlan)
@dataclass(frozen=True, eq=False, repr=False)
class AreaPlan(recommended.AreaPlan):
    """A flight plan whose precision was propagated on its own layout."""

    search: PlanSearch
    checked: CheckedPlan

    def verdict(self) -> str:
        """Return the plan, the next best, and what it takes; arguments by name."""
        return with_arguments(super().verdict())

    def summary(self) -> str:
        """Return the plan, the next best, what it takes, and its precision."""
        return with_arguments(super().summary())

    def _repr_html_(self) -> str:
        return checked_plan_card(self, self.checked.outcome())


def expect_precision(
    design: "FlightDesign | pd.Series[Any]",
    *,
    frame: PlanFrame | None = None,
    coverage_mean: Literal["all", "most_central"] = "all",
    weighting: Literal["auto", "plain", "weighted", "rigorous"] = "auto",
    seed: int = 0,
) -> ExpectedPrecision:
    """Compute the precision of a planned block by propagation on its layout.

    Parameters
    ----------
    design : FlightDesign or Series
        Both flights, the spacing of the points and the control; or a row of ``plans``
        of :func:`find_plans`.
    frame : PlanFrame, optional
        That of the search, with a row of it.
    coverage_mean : {"all", "most_central"}
        As in :class:`einschalt.Settings`.
    weighting : {"auto", "plain", "weighted", "rigorous"}
        Mean of a point's values, as in :class:`einschalt.Settings`: where nothing is
        said, that of least variance, as densify takes it.
    seed : int
        Of the layout: points are displaced at random about a lattice.

    Returns
    -------
    ExpectedPrecision
        ``points``, ``values``, ``figures``, ``parts`` [m, TOTAL]; ``plot.map()``,
        ``plot.profile()``, ``plot.sources()``.

    Raises
    ------
    EinschaltError
        Models would hold too few points, or it is no design and no row of a search.

    Examples
    --------
    >>> design = FlightDesign(scale_number=8000, spacing=300, m_g_um=5)
    >>> expected = expect_precision(design)
    >>> expected.figures.paper_mean < expected.figures.mean
    True
    """
    means = {"coverage_mean": coverage_mean, "weighting": weighting}
    with naming_arguments():
        design = _design_of(design, frame)
        found = expected_precision.expect_precision(design, **means, seed=seed)
    return ExpectedPrecision(**plain_fields(found))


def _design_of(design, frame):
    """Take a design, or a row of a search with its frame."""
    if isinstance(design, pd.Series):
        if frame is None:
            raise SettingsError(
                "design is a row of a search, without the frame of the search",
                expected="a FlightDesign, or a row of find_plans with its frame",
                remedy="Write expect_precision(found.nearest, frame=frame)",
            )
        return design_of_row("design", design, frame, asked_by="expect_precision")
    if frame is not None:
        require_frame(frame)
        raise SettingsError(
            f"frame beside a design that is {described(design)}",
            expected="a frame beside a row of find_plans only",
            remedy="Leave frame out",
        )
    return design


def find_plans(
    target: float,
    choices: PlanChoices,
    frame: PlanFrame | None = None,
    *,
    where: Literal["everywhere", "edge", "centre"] = "everywhere",
    by: Literal["expected", "paper"] = "expected",
) -> PlanSearch:
    """Find the flights that reach a precision by estimate, the cheapest first.

    Their figures are closed estimates that are not yet checked on a layout: the
    cheapest plan may miss its target there. :func:`plan_target` finds and checks, as
    ``einschalt plan --target`` does, :func:`plan_area` over an area;
    :func:`expect_precision` takes a single row.

    Parameters
    ----------
    target : float
        TOTAL error that the delivered coordinates may have [m].
    choices : PlanChoices
        What the planner is free to choose; all values are combined.
    frame : PlanFrame, optional
        What is at hand: camera, transformation, control, costs. Aerial film with
        affine models where left out.
    where : {"everywhere", "edge", "centre"}
        Place in the models at which the target holds; it matters with one coverage.
    by : {"expected", "paper"}
        Errors with what points share, or by the formula of 1971, which is too good.

    Returns
    -------
    PlanSearch
        ``plans``, ``feasible``, ``nearest`` (the cheapest that reaches the target, or
        what comes nearest); ``plot.costs()``.

    Raises
    ------
    EinschaltError
        A value is not sensible, or no combination has enough points in its models.

    Examples
    --------
    >>> choices = PlanChoices(
    ...     scale_number=(6000, 8000, 10000), spacing=(200, 300), m_g_um=(5,)
    ... )
    >>> found = find_plans(0.05, choices)
    >>> bool((found.feasible["expected_mean"] <= 0.05).all())
    True
    """
    with naming_arguments():
        found = search.find_plans(target, choices, frame, where=where, by=by)
    return PlanSearch(**plain_fields(found))


def plan_target(
    target: float,
    choices: PlanChoices,
    frame: PlanFrame | None = None,
    *,
    where: Literal["everywhere", "edge", "centre"] = "everywhere",
    by: Literal["expected", "paper"] = "expected",
    refine: Sequence[Literal["scale_number", "high_over_low", "n_settings"]]
    | None = None,
) -> CheckedPlan:
    """Find the cheapest flights that reach a precision on their own layout.

    As ``einschalt plan --target``: the plans of :func:`find_plans` that promise most
    are laid out and propagated, until the cheapest that keeps the target is found.

    Parameters
    ----------
    target, choices, frame, where, by
        As of :func:`find_plans`.
    refine : sequence of str, optional
        Choices of which values between those given are tried as well, as of
        :func:`plan_area`. The command does so with all that are not typed.

    Returns
    -------
    CheckedPlan
        ``plan`` (row of the search), ``is_kept``, ``reached`` [m], ``expected``,
        ``next_best``, ``dropped``; ``search`` with all plans.

    Raises
    ------
    EinschaltError
        A value is not sensible, or not one plan can be laid out.

    Examples
    --------
    >>> choices = PlanChoices(
    ...     scale_number=(6000, 8000), spacing=(300,), m_g_um=(5,), n_coverages=(2,)
    ... )
    >>> plan = plan_target(0.05, choices)
    >>> plan.is_kept, bool(plan.expected.figures.mean <= 0.05)
    (True, True)
    """
    with naming_arguments():
        frame = PlanFrame() if frame is None else frame
        found = search.find_plans(target, choices, frame, where=where, by=by)
        return CheckedPlan.of(check.check_plans(found, frame, refine=refine))


def plan_area(
    target: float,
    area: Any,  # shapely, of which a geometry may be, has no types
    choices: PlanChoices,
    frame: PlanFrame | None = None,
    *,
    where: Literal["everywhere", "edge", "centre"] = "everywhere",
    by: Literal["expected", "paper"] = "expected",
    crs: str | None = None,
    ground_heights: str | PathLike[str] | None = None,
    follows_terrain: bool | None = None,
    refine: Sequence[Literal["scale_number", "high_over_low", "n_settings"]]
    | None = None,
) -> AreaPlan:
    """Plan a flight over an area that reaches a precision on its own layout.

    Parameters
    ----------
    target : float
        TOTAL error that the delivered coordinates may have [m].
    area : path, GeoDataFrame, shapely geometry or array
        Polygons in a GeoPackage, shapefile or GeoJSON, whose only layer is taken, or in
        a GeoDataFrame; or a polygon, or several, in ``crs``, or in a plane of its own;
        or the corners of one, (n, 2) [m].
    choices : PlanChoices
        What the planner is free to choose; all values are combined.
    frame : PlanFrame, optional
        What is at hand: camera, transformation, control, costs. Control points serve
        every model that holds them.
    where : {"everywhere", "edge", "centre"}
        Place in the models at which the target holds; it matters with one coverage.
    by : {"expected", "paper"}
        Estimate by which plans are searched, as in :func:`find_plans`; what is
        recommended is propagated with all that points share.
    crs : str, optional
        System of the plan; that of the area, or its zone of UTM, where left out.
    ground_heights : path, optional
        GeoTIFF, XYZ, or a table of easting, northing and height [m].
    follows_terrain : bool, optional
        Whether each photograph is taken at its height above ground; otherwise a line
        keeps one altitude. Where left out, photographs follow the ground if
        ``frame.max_height`` limits them. In both cases none is more than that above the
        ground straight below it.
    refine : sequence of str, optional
        Choices of which values between those given are tried as well, about the
        cheapest plan that reaches the target: "scale_number", "high_over_low",
        "n_settings". ``checked.finer`` of the plan has what was left between.

    Returns
    -------
    AreaPlan
        ``flown.flight_lines``, ``flown.photographs``, ``flown.control``,
        ``flown.effort`` (DataFrames), ``is_recommended``, ``checked`` (the plan and its
        propagated precision), ``next_flown``.

    Raises
    ------
    EinschaltError
        The area cannot be read, no plan fits it, or a value is not sensible.

    Examples
    --------
    >>> import shapely
    >>> choices = PlanChoices(
    ...     scale_number=(9000, 11000), spacing=(300,), m_g_um=(5,), n_coverages=(2,)
    ... )
    >>> plan = plan_area(0.06, shapely.box(0, 0, 7000, 6000), choices)
    >>> plan.is_recommended, len(plan.flown.control) > 20
    (True, True)
    """
    with naming_arguments():
        area = _area_of(area, crs)
        heights = None
        if ground_heights is not None:
            heights = read_heights_over(ground_heights, area)
        elif follows_terrain:
            raise SettingsError(
                "follows_terrain = True without heights of the terrain",
                expected="heights that photographs can follow",
                remedy="Give ground_heights, or leave follows_terrain out",
            )
        frame = PlanFrame() if frame is None else frame
        held = {"where": where, "by": by}
        found, frame = recommended.search_over(target, area, choices, frame, **held)
        ground = {"heights": heights, "follows": follows_terrain}
        plan = recommended.plan_area(area, found, frame, refine=refine, **ground)
    said = {"notes": tuple(map(with_arguments, plan.notes))}
    parts = {"search": PlanSearch(**plain_fields(plan.search))}
    parts |= {"checked": CheckedPlan.of(plan.checked)}
    return AreaPlan(**plain_fields(plan) | parts | said)


def _area_of(area, crs):
    """Take an area as users have it: a file, a table, a polygon, or its corners."""
    if isinstance(area, str | PathLike):
        return read_area(area, crs=crs)
    if hasattr(area, "geometry") and hasattr(area, "crs"):
        return area_of_table(area, crs)
    return FlightArea(_of_corners(area), crs)


def _of_corners(area):
    """Give the polygon that an array of corners is; anything else as it is."""
    if not isinstance(area, list | tuple | np.ndarray):
        return area
    import shapely  # noqa: PLC0415 - loaded when an area is planned

    try:
        corners = np.asarray(area)
    except ValueError:  # not as many coordinates of each
        corners = np.empty(0)
    is_plane = corners.ndim == 2 and corners.shape[1] == 2
    is_plane &= corners.dtype.kind in "iuf"
    if not (is_plane and len(corners) >= FEWEST and np.isfinite(corners).all()):
        raise GeometryError(
            f"area is {described(area)}",
            expected="a polygon, the path of a file, a GeoDataFrame, or corners (n, 2)",
            remedy="Give [(easting, northing), …] of at least three corners [m]",
        )
    return shapely.Polygon(corners)
