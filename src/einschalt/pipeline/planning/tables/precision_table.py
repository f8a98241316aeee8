"""Precision planning: tables before the flight, and the scale that is best.

pandas is imported where a frame is made: the text of ``einschalt plan`` needs none,
and comes at once.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from einschalt.foundations.language import in_english
from einschalt.foundations.typesetting import number, scale
from einschalt.foundations.units import METRES_PER_UM
from einschalt.pipeline.planning.flights.arguments import (
    checked_axis,
    checked_number,
    planned_model,
    require_reasonable_size,
)
from einschalt.pipeline.planning.flights.points_in_models import require_points
from einschalt.theory.planning.kovarik_precision import (
    FEW_POINTS,
    PlannedModel,
    PlannedPrecision,
    best_scale,
    planned_precision,
    settings_that_balance,
    spacing_that_balances,
)

if TYPE_CHECKING:
    import pandas as pd

AXES = ("scale_number", "spacing", "m_0", "m_g_um")
PRECISIONS = tuple(PlannedPrecision.__dataclass_fields__)
GAPS = "consecutive images overlap by less than half: models leave gaps between them"


@dataclass(frozen=True, eq=False)
class PrecisionTable:
    """Precision for every combination of scale, spacing, m_0 and m_g."""

    model: PlannedModel
    principal_distance: float  # [m]
    # ``scale_number, spacing, m_0, m_g_um``: the values that are combined
    axes: dict[str, np.ndarray]
    # arrays that broadcast to one axis for each of these, in this order
    planned: PlannedPrecision
    warnings: tuple[str, ...]  # what the formulas cannot say here

    @property
    def shape(self):
        """How many values each axis has."""
        return tuple(len(self.axes[name]) for name in AXES)

    def array(self, name):
        """One quantity for all combinations.

        An attribute of PlannedPrecision; (n_scales, n_spacings, n_m_0, n_m_g).
        """
        return np.broadcast_to(getattr(self.planned, name), self.shape)

    def columns(self):
        """All columns of the table, the scale number varying slowest.

        Arrays by name, (n_combinations,).
        """
        grid = np.meshgrid(*self.axes.values(), indexing="ij", copy=False)
        columns = {name: axis.ravel() for name, axis in zip(AXES, grid, strict=True)}
        columns["flying_height"] = columns["scale_number"] * self.principal_distance
        columns |= {name: self.array(name).ravel() for name in PRECISIONS}
        return columns


@in_english
def precision_table(axes, model, principal_distance) -> PrecisionTable:
    """Compute the precision of every combination.

    ``axes`` are ``scale_number, spacing, m_0, m_g_um``, numbers or sequences of them;
    ``principal_distance`` [m]. EinschaltError where a value is not sensible, or models
    hold too few points.
    """
    checked = {name: checked_axis(name, axes[name]) for name in AXES}
    distance = checked_number("principal_distance", principal_distance)
    require_reasonable_size(*checked.values())
    require_points(model, checked["scale_number"], checked["spacing"])
    scale_number, spacing, m_0, m_g_um = np.ix_(*checked.values())
    planned = planned_precision(
        scale_number, spacing, m_0, m_g_um * METRES_PER_UM, model
    )
    return PrecisionTable(
        model, distance, checked, planned, tuple(_warnings(checked, model))
    )


def _warnings(axes, model):
    scale_number, spacing = np.ix_(axes["scale_number"], axes["spacing"])
    n_points = model.n_points(scale_number, spacing)
    if model.forward_overlap < 0.5:
        yield GAPS
    is_few = n_points < FEW_POINTS
    if not is_few.any():
        return
    place = np.unravel_index(np.argmin(n_points), n_points.shape)
    where = f"{scale(axes['scale_number'][place[0]])}, {axes['spacing'][place[1]]:g} m"
    said = (
        f"{is_few.sum()} of {is_few.size} combinations of scale and spacing have fewer "
        f"than {FEW_POINTS:.0f} points in a model, down to "
        f"{number(n_points[place])} ({where})"
    )
    if model.edge == "lattice":
        yield f"{said}: where the points happen to lie decides there"
        return
    least = axes["scale_number"][place[0]], axes["spacing"][place[1]]
    evenly, lattice = (
        float(np.sqrt(leverage(*least).edge))
        for leverage in (model.leverage, replace(model, edge="lattice").leverage)
    )
    yield (
        f"{said}: the formula of evenly spread points fails there. At the edge it "
        f"gives {number(evenly)} m_0; points on a lattice {_in_m_0(lattice)} in the "
        "corner: see edge = lattice"
    )


def _in_m_0(factor):
    if not np.isfinite(factor):
        return "may not even determine the transformation"
    return f"give {number(factor)} m_0"


def plan_precision(
    scale_number: float | Sequence[float],
    spacing: float | Sequence[float],
    m_0: float | Sequence[float],
    m_g_um: float | Sequence[float],
    *,
    kind: Literal["affine", "helmert", "rigid"] = "affine",
    edge: Literal["kovarik", "mid_edge", "corner", "lattice"] = "kovarik",
    image_format: float | tuple[float, float] = 0.23,
    principal_distance: float = 0.152,
    forward_overlap: float = 0.6,
    side_overlap: float = 0.3,
) -> "pd.DataFrame":
    """Tabulate the expected precision of a flight: the diagrams of Kovarik 1971.

    Parameters
    ----------
    scale_number : float or sequence of float
        Denominator of the image scale.
    spacing : float or sequence of float
        Mean distance of neighbouring points [m].
    m_0 : float or sequence of float
        TOTAL error of the approximate coordinates [m].
    m_g_um : float or sequence of float
        TOTAL error of a measured point in the image [µm].
    kind : {"affine", "helmert", "rigid"}
        Transformation of every model.
    edge : {"kovarik", "mid_edge", "corner", "lattice"}
        Where the edge of a model is looked at: the rule that fits the values printed in
        1971 (twice the middle, points counted without the side overlap); or in the
        middle of its longer half, or in its corner, with evenly spread points; or in
        its corner, with points on a lattice.
    image_format : float or tuple of float
        Side of the image, or its sides along and across the strip [m].
    principal_distance : float
        [m]
    forward_overlap, side_overlap : float
        Parts of the image.

    Returns
    -------
    DataFrame
        One row for each combination: scale_number, spacing, m_0, m_g_um,
        flying_height, n_points, m_g_ground, m_t_centre, m_t_edge, M_centre, M_edge,
        M_double; metres, TOTAL. ``attrs["warnings"]`` says where the formulas fail.

    Raises
    ------
    EinschaltError
        A value is not sensible, or models hold too few points.

    Notes
    -----
    M is Kovarik's, which is too good for the mean of two coverages: see
    :func:`einschalt.expect_precision`.

    Examples
    --------
    >>> table = plan_precision([6000, 8000], 300, 0.10, 10)
    >>> table[["scale_number", "M_centre", "M_edge", "M_double"]].round(4)
       scale_number  M_centre  M_edge  M_double
    0        6000.0    0.0687  0.0900    0.0566
    1        8000.0    0.0839  0.0945    0.0632
    """
    model = planned_model(kind, edge, image_format, forward_overlap, side_overlap)
    axes = dict(zip(AXES, (scale_number, spacing, m_0, m_g_um), strict=True))
    table = precision_table(axes, model, principal_distance)
    return frame_of(table.columns(), table.warnings)


def optimal_scale(
    spacing: float | Sequence[float],
    m_0: float | Sequence[float],
    m_g_um: float | Sequence[float],
    *,
    kind: Literal["affine", "helmert", "rigid"] = "affine",
    edge: Literal["kovarik", "mid_edge", "corner", "lattice"] = "kovarik",
    image_format: float | tuple[float, float] = 0.23,
    principal_distance: float = 0.152,
    forward_overlap: float = 0.6,
    side_overlap: float = 0.3,
) -> "pd.DataFrame":
    """Find the scale number at which the edge of a model is most precise.

    A larger scale loses accuracy: fewer points lie in a model, and its transformation
    becomes worse faster than the measurement becomes better.

    Parameters
    ----------
    spacing, m_0, m_g_um, kind, edge, image_format, principal_distance, \
forward_overlap, side_overlap
        As :func:`plan_precision` takes them.

    Returns
    -------
    DataFrame
        One row for each combination: spacing, m_0, m_g_um, scale_number,
        flying_height, n_points, m_g_ground, m_t_centre, m_t_edge, M_centre, M_edge,
        M_double; metres, TOTAL. ``attrs["warnings"]`` says where the formulas fail:
        where precise images meet poor approximate coordinates, models are best so
        small that they hold few points.

    Raises
    ------
    SettingsError
        A value is not sensible.

    Examples
    --------
    >>> best = optimal_scale([200, 300, 400], 0.10, 10)
    >>> best["scale_number"].round().astype(int).to_list()
    [5180, 6345, 7326]
    """
    table = best_columns(
        {"spacing": spacing, "m_0": m_0, "m_g_um": m_g_um},
        planned_model(kind, edge, image_format, forward_overlap, side_overlap),
        principal_distance,
    )
    is_few = table["n_points"] < FEW_POINTS
    few = (
        f"{is_few.sum()} of {is_few.size} best scales leave fewer than "
        f"{FEW_POINTS:.0f} points in a model"
    )
    if edge != "lattice":
        few += ": see edge = lattice"
    return frame_of(table, (few,) if is_few.any() else ())


def best_columns(axes, model, principal_distance):
    """Columns of :func:`optimal_scale`.

    ``axes`` are ``spacing, m_0, m_g_um``; arrays by name, (n_combinations,).
    """
    checked = {name: checked_axis(name, axes[name]) for name in AXES[1:]}
    distance = checked_number("principal_distance", principal_distance)
    require_reasonable_size(*checked.values())
    grid = np.meshgrid(*checked.values(), indexing="ij")
    columns = {name: v.ravel() for name, v in zip(AXES[1:], grid, strict=True)}
    given = columns["spacing"], columns["m_0"], columns["m_g_um"] * METRES_PER_UM
    scale_number = best_scale(*given, model)
    planned = planned_precision(scale_number, *given, model)
    columns |= {"scale_number": scale_number, "flying_height": scale_number * distance}
    return columns | {name: getattr(planned, name) for name in PRECISIONS}


def break_even_columns(table):
    """Say up to which effort measuring and transformation are worth improving.

    scale_number, spacing, m_0, m_g_um; ``settings``, of a point, up to which measuring
    decides at the edge; ``spacing_at_break_even`` [m], down to which denser points gain
    there. Arrays by name, (n_combinations,).
    """
    columns = table.columns()
    ground, m_t = columns["m_g_ground"], columns["m_t_edge"]
    return {name: columns[name] for name in AXES} | {
        "settings": settings_that_balance(ground, m_t),
        "spacing_at_break_even": spacing_that_balances(columns["spacing"], ground, m_t),
    }


def frame_of(columns, warnings=()):
    """Make a frame of columns.

    With ``attrs["warnings"]``.
    """
    # imported when a frame is asked for: a table as text needs none
    import pandas as pd  # noqa: PLC0415

    frame = pd.DataFrame(columns, copy=False)
    frame.attrs["warnings"] = list(warnings)
    return frame
