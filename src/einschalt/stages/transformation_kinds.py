"""The kinds of transformation: what each fits, what it needs, and why it fails."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from einschalt.foundations import tables
from einschalt.foundations.arguments import is_choice
from einschalt.foundations.kept_texts import kept
from einschalt.foundations.language import mark
from einschalt.theory.transformation import affine, helmert, helmert_3d, rigid
from einschalt.theory.transformation.plane_fit import (
    OTHER_SCALE,
    SAME_GROUND,
    TOO_FEW,
    UNDETERMINED,
)


@dataclass(frozen=True)
class Kind:
    """One kind of transformation: how it is fitted, and what it needs."""

    fit: Callable
    cofactors: Callable
    source: tuple[str, ...]
    target: tuple[str, ...]
    least_points: int
    needs: str


FEW = mark("{n:common point|common points}, but {kind} needs {least}")
NO_POINTS = mark("no common points, but {kind} needs {least}")
MORE_POINTS = "Measure more common points in it, or merge it with its neighbour"
MORE_CONTROL = (
    "Measure more common points in it, or determine more control points there"
)
PLANE = (("x", "y"), ("easting", "northing"))
SPACE = (("x", "y", "z"), ("easting", "northing", "height"))
WEIGHT = tables.Column("weight", "number", "a weight", False, is_positive=True)
SPATIAL = "helmert_3d"
TRANSFORMATION_KINDS = {
    "affine": Kind(
        affine.fit_affine, affine.affine_cofactors, *PLANE, 3, "three off a line"
    ),
    "helmert": Kind(
        helmert.fit_helmert, helmert.helmert_cofactors, *PLANE, 2, "two apart"
    ),
    "rigid": Kind(rigid.fit_rigid, rigid.rigid_cofactors, *PLANE, 2, "two apart"),
    SPATIAL: Kind(
        helmert_3d.fit_helmert_3d,
        helmert_3d.helmert_3d_cofactors,
        *SPACE,
        3,
        "three off a line",
    ),
}


def is_spatial(flight):
    """Whether the models of a flight are spatial; not of one that says nothing."""
    return is_choice(getattr(flight, "transformation", ""), (SPATIAL,))


def model_schema(kind):
    """Schema of the model points that a kind needs."""
    schema = tables.MODEL_POINTS.requiring(*kind.source)
    return replace(schema, columns=(*schema.columns, WEIGHT))


def ground_schema(kind):
    """Schema of the ground points that a kind needs."""
    columns = (*tables.CONTROL_POINTS.columns[:3], WEIGHT)
    if "height" in kind.target:
        # a point without height is left out, not refused
        height = tables.Column("height", unit="metres", may_be_missing=True)
        columns = (*columns, height)
    return tables.Schema("ground_points", columns, ("point_id",))


def placed_ground_schema(kind):
    """Schema of ground points that are led back into a model."""
    target = tuple(tables.Column(name, unit="metres") for name in kind.target)
    names = (tables.COVERAGE, tables.MODEL_ID, tables.POINT_ID)
    return tables.Schema("ground_points", (*names, *target), tables.MODEL_POINTS.key)


def reasons_for(fit, kind):
    """Say of each model why it is not usable.

    Array of text, (n_models,); empty for usable models.
    """
    reasons = np.full(len(fit.n_points), "", dtype=object)
    for place in np.flatnonzero(fit.status == TOO_FEW):
        count = int(fit.n_points[place])
        words = {"n": count, "kind": fit.kind, "least": kind.least_points}
        reasons[place] = kept(FEW if count else NO_POINTS, **words)
    reasons[fit.status == UNDETERMINED] = (
        f"its points lie on a line or in one place, but {fit.kind} needs {kind.needs}"
    )
    reasons[fit.status == OTHER_SCALE] = (
        "its scale is not near 1, at which rigid holds it"
    )
    reasons[fit.status == SAME_GROUND] = (
        "all of its points have the same ground coordinates"
    )
    reasons[fit.is_mirrored] = "the model is a mirror image of the ground"
    return reasons


def more_points_for(kind):
    """Say how a model gets enough points for a transformation.

    One in space is of photographs mostly, and nothing merges these with a neighbour.
    """
    in_space = TRANSFORMATION_KINDS[kind].target == SPACE[1]
    return MORE_CONTROL if in_space else MORE_POINTS


def remedies_for(fit):
    """Say of each model how to mend it.

    Array of text, (n_models,); it means nothing for usable models.
    """
    remedies = np.full(
        len(fit.n_points),
        more_points_for(fit.kind),
        dtype=object,
    )
    if fit.kind == "affine":
        # two points, or points on a line, are enough for helmert
        remedies[fit.n_points >= TRANSFORMATION_KINDS["helmert"].least_points] = (
            "Transform with helmert, or merge it with its neighbour"
        )
    remedies[fit.status == OTHER_SCALE] = (
        "Give its coordinates in ground units, or transform with helmert"
    )
    remedies[fit.status == SAME_GROUND] = "Give each ground point its own coordinates"
    remedies[fit.is_mirrored] = "Exchange easting and northing, or turn the sign of x"
    return remedies
