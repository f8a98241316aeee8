"""Errors of given coordinates, and what points share of them.

Control of one part of a network, or approximate coordinates from one strip, may be
displaced together: points of one ``group`` share a shift. Or errors are the more alike
the nearer points are to each other, ρ = exp(−d / L) with a correlation length L. Both
become sources of independent errors with an operator to the coordinates, so that all
that is linear in these carries them on.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse

from einschalt.foundations.frame_columns import values_of
from einschalt.foundations.names import encode, is_among, ranks
from einschalt.theory.adjustment.least_squares import SQRT2
from einschalt.theory.adjustment.point_operator import (
    Axes,
    PointOperator,
    by_coordinate,
    unchanged,
)
from einschalt.theory.adjustment.spatial_correlation import exponential_factor

CONTROL_POINTS, APPROXIMATE_POINTS = "control_points", "approximate_points"
GROUPS = {CONTROL_POINTS: "control_groups", APPROXIMATE_POINTS: "approximate_groups"}
PLAN = ["easting", "northing"]
# metres; coordinates that lie nearer are the same, written with fewer digits
LEAST_APART = 1e-4


@dataclass(frozen=True, eq=False)
class GivenErrors:
    """Errors of the coordinates of a table, from independent sources."""

    chains: dict[str, PointOperator]  # from each source to the coordinates
    # of each source's errors, per coordinate [m]; with a column for each axis where
    # they differ
    sizes: dict[str, np.ndarray]
    # the source of shifts of groups, where nobody gave their size: that is 1 m, TOTAL
    to_be_estimated: str = ""

    def picked(self, pick):
        """The same of other rows: ``pick`` leads from the coordinates to these."""
        return replace(self, chains={n: pick @ c for n, c in self.chains.items()})

    def apply(self, errors):
        """Errors of the coordinates, packed, from those of all sources."""
        return sum(chain.apply(errors[name]) for name, chain in self.chains.items())


def errors_of_control(block, axes) -> GivenErrors:
    """Errors of all control points of a block, check points among them."""
    return errors_of_table(
        *(block, CONTROL_POINTS, "control"),
        control_errors(block.control_points, axes),
        axes,
    )


def errors_of_table(block, table, source, sizes, axes) -> GivenErrors:
    """Errors of the points of a table of a block.

    ``sizes`` are those that each point has for itself, of the source of that name, per
    coordinate [m], (n_points,) or (n_points, n_axes).
    """
    points = getattr(block, table)
    length = block.correlation_lengths_m.get(table, 0.0)
    chains = {source: unchanged(axes)}
    if length > 0.0:
        factor = _factor(values_of(points, PLAN), length, sizes)
        chains[source] = _of_sizes(sparse.csr_array(factor), sizes, axes)
    sizes = {source: sizes}
    members = group_members(points)
    if members is None:
        return GivenErrors(chains, sizes)
    name, total = GROUPS[table], block.group_errors_m.get(table)
    chains[name] = by_coordinate(members, axes)
    sizes[name] = np.full(members.shape[1], (total or 1.0) / SQRT2)
    return GivenErrors(chains, sizes, "" if total else name)


def approximations_are_control(block) -> bool:
    """Whether all approximate coordinates are the given ones of control points.

    Then their errors are those of control: independent, and of known size.
    """
    if block.approximate_points is None or block.control_points is None:
        return False
    return bool(_are_control(block).all())


def control_among_approximations(block) -> np.ndarray:
    """Names of control points whose given coordinates are approximate ones as well."""
    known = block.approximate_points
    if known is None or block.control_points is None:
        return np.empty(0, dtype=object)
    return known["point_id"].to_numpy(dtype=object)[_are_control(block)]


def errors_where_control(block):
    """Errors of approximate points that are given as control, of one coordinate [m].

    Shape (n_points,); NaN where they are others, or control has no standard error.
    """
    known, control = block.approximate_points, block.control_points
    if control is None or "standard_error_m" not in control:
        return np.full(len(known), np.nan)
    errors = control.set_index("point_id")["standard_error_m"].astype(float) / SQRT2
    errors = errors.reindex(known["point_id"]).to_numpy()
    return np.where(_are_control(block), errors, np.nan)


def _are_control(block):
    """Which approximate points have the given coordinates of control, (n_points,)."""
    known, control = block.approximate_points, block.control_points
    axes = [n for n in (*PLAN, "height") if n in known and n in control]
    given = control.set_index("point_id")[axes].reindex(known["point_id"])
    apart = np.nan_to_num(np.abs(values_of(known, axes) - given.to_numpy(dtype=float)))
    is_named = is_among(known["point_id"], control["point_id"])
    return is_named & (apart < LEAST_APART).all(axis=1)


def control_shares_errors(block) -> bool:
    """Whether it is said that errors of control points have something in common."""
    control = block.control_points
    if control is None or "standard_error_m" not in control:
        return False
    is_correlated = block.correlation_lengths_m.get(CONTROL_POINTS, 0.0) > 0.0
    return is_correlated or group_members(control) is not None


def group_members(points):
    """Which group each point is in, (n_points, n_groups) sparse; None without groups.

    The groups stand in the order of their names, in which their shifts are drawn.
    Points whose ``group`` is empty share nothing.
    """
    if "group" not in points:
        return None
    is_in_one = (points["group"].notna() & (points["group"] != "")).to_numpy()
    rows = np.flatnonzero(is_in_one)
    if len(rows) == 0:
        return None
    groups = encode(points["group"].iloc[rows])
    shape = (len(points), len(groups))
    places = ranks(groups.names)[groups.codes]
    return sparse.csr_array((np.ones(len(rows)), (rows, places)), shape)


def _factor(place, length, sizes):
    """Factor of the correlations of the points that have errors.

    Points without are sources of nothing: what others shared with them is with these.
    """
    rows = np.flatnonzero(np.reshape(sizes, (len(sizes), -1)).any(axis=1))
    if len(rows) == len(place):
        return exponential_factor(place, length)
    factor = np.zeros((len(place), len(place)))
    if len(rows):
        factor[np.ix_(rows, rows)] = exponential_factor(place[rows], length)
    return factor


def _of_sizes(factor, sizes, axes):
    """Operator of a factor of correlations; sources keep the sizes of their points."""
    each = axes.each(sizes).ravel()
    matrix = by_coordinate(factor, axes).matrix
    per_size = np.divide(1.0, each, out=np.zeros(len(each)), where=each != 0.0)
    scaled = sparse.diags_array(each) @ matrix @ sparse.diags_array(per_size)
    return PointOperator((scaled.tocsr(),), axes)


def control_errors(control_points, axes):
    """Errors of given coordinates; a height has that of a coordinate if none is given.

    Per coordinate [m], (n_points,), in space (n_points, 3).
    """
    in_plan = control_points["standard_error_m"].to_numpy(dtype=float) / SQRT2
    if axes is not Axes.SPACE or "standard_error_height" not in control_points:
        return in_plan
    of_height = control_points["standard_error_height"].to_numpy(dtype=float)
    of_height = np.where(np.isfinite(of_height), of_height, in_plan)
    return np.column_stack([in_plan, in_plan, of_height])
