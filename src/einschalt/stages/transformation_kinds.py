"""The kinds of transformation: what each fits, what it needs, and why it fails."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from einschalt.foundations import tables
from einschalt.theory.transformation import affine, helmert, helmert_3d, rigid
from einschalt.theory.transformation.plane_fit import TOO_FEW, UNDETERMINED


@dataclass(frozen=True)
class Kind:
    """One kind of transformation: how it is fitted, and what it needs."""

    fit: Callable
    cofactors: Callable
    source: tuple[str, ...]
    target: tuple[str, ...]
    least_points: int
    needs: str


PLANE = (("x", "y"), ("easting", "northing"))
SPACE = (("x", "y", "z"), ("easting", "northing", "height"))
KINDS = {
    "affine": Kind(
        affine.fit_affine, affine.affine_cofactors, *PLANE, 3, "three off a line"
    ),
    "helmert": Kind(
        helmert.fit_helmert, helmert.helmert_cofactors, *PLANE, 2, "two apart"
    ),
    "rigid": Kind(rigid.fit_rigid, rigid.rigid_cofactors, *PLANE, 2, "two apart"),
    "helmert_3d": Kind(
        helmert_3d.fit_helmert_3d,
        helmert_3d.helmert_3d_cofactors,
        *SPACE,
        3,
        "three off a line",
    ),
}


def model_schema(kind):
    """Schema of the model points that a kind needs.

    Parameters
    ----------
    kind : Kind

    Returns
    -------
    Schema
    """
    columns = tuple(
        replace(column, is_required="z" in kind.source)
        if column.name == "z"
        else column
        for column in tables.MODEL_POINTS.columns
    )
    return tables.Schema("model_points", columns, tables.MODEL_POINTS.key)


def ground_schema(kind):
    """Schema of the ground points that a kind needs.

    Parameters
    ----------
    kind : Kind

    Returns
    -------
    Schema
    """
    columns = (
        *tables.CONTROL_POINTS.columns[:3],
        tables.Column("weight", "number", "a weight", False, is_positive=True),
    )
    if "height" in kind.target:
        columns = (*columns, tables.Column("height", unit="metres"))
    return tables.Schema("ground_points", columns, ("point_id",))


def placed_ground_schema(kind):
    """Schema of ground points that are led back into a model.

    Parameters
    ----------
    kind : Kind

    Returns
    -------
    Schema
    """
    target = tuple(tables.Column(name, unit="metres") for name in kind.target)
    names = (tables.COVERAGE, tables.MODEL_ID, tables.POINT_ID)
    return tables.Schema("ground_points", (*names, *target), tables.MODEL_POINTS.key)


def reasons_for(fit, kind):
    """Say of each model why it is not usable.

    Parameters
    ----------
    fit : PlaneFit or SpatialFit
    kind : Kind

    Returns
    -------
    ndarray of object, shape (n_models,)
        Empty text for usable models.
    """
    reasons = np.full(len(fit.n_points), "", dtype=object)
    for place in np.flatnonzero(fit.status == TOO_FEW):
        count = int(fit.n_points[place])
        points = "point" if count == 1 else "points"
        reasons[place] = (
            f"{count or 'no'} common {points}, but {fit.kind} needs {kind.least_points}"
        )
    reasons[fit.status == UNDETERMINED] = (
        f"its points lie on a line or in one place, but {fit.kind} needs {kind.needs}"
    )
    reasons[fit.is_mirrored] = "the model is a mirror image of the ground"
    return reasons


def remedy_for(reason, kind_name):
    """Say how to mend a model that is not usable.

    Parameters
    ----------
    reason : str
        From :func:`reasons_for`.
    kind_name : str

    Returns
    -------
    str
    """
    if "mirror" in reason:
        return "Exchange easting and northing, or turn the sign of x"
    # two points, or points on a line, are enough for helmert; fewer for nothing
    is_enough_for_helmert = reason.startswith(("2 common", "its points lie"))
    if kind_name == "affine" and is_enough_for_helmert:
        return "Transform with helmert, or merge it with its neighbour"
    return "Measure more common points in it, or merge it with its neighbour"
