"""What is to be published of a result: of a fitted transformation, or of a block.

Of a block every model of its flights leads from its machine coordinates to the ground.
"""

import re
from dataclasses import dataclass

import numpy as np
import pandas as pd

from einschalt.foundations.coordinate_operations import system_label
from einschalt.foundations.errors import GeometryError
from einschalt.foundations.projections import read_crs, read_source_crs
from einschalt.foundations.published_systems import (
    area_of_points,
    east_north,
    own_frame,
    plane_part,
    published_target,
    site_frame,
)
from einschalt.foundations.rotations import rotation_from_angles
from einschalt.interfaces.publication.published_operation import PublishedOperation
from einschalt.stages.gridded_transformation import GriddedTransformation
from einschalt.stages.held_out_points import (
    DIFFERENCES,
    held_out_error,
    held_out_points,
    without_point,
)
from einschalt.stages.transformation_kinds import TRANSFORMATION_KINDS
from einschalt.stages.triangulated_transformation import TriangulatedTransformation

MODEL_OF_FLIGHT = ["flight", "coverage", "model_id"]
NEARLY_ONE = 0.1  # a unit within so much of a metre is one


@dataclass(frozen=True, eq=False)
class Frames:
    """How what is published is called, and between which systems it leads."""

    name: str
    crs: object  # name of the system of the ground, or None
    source_crs: object = None  # of the frame from which it leads, where it is known

    @property
    def target(self):
        """The plane system of the ground as its authority has it, or None of a site."""
        return published_target(self.crs)

    def systems(self, title, unit_m):
        """The frame from which an operation leads, and easting, northing of its end."""
        unit_m = 1.0 if abs(unit_m - 1.0) < NEARLY_ONE else float(f"{unit_m:.6g}")
        target = self.target
        if target is None:
            known = None if self.crs is None else read_crs(self.crs)
            return site_frame(title, unit_m), known or site_frame("Local system")
        if self.source_crs is None:
            return own_frame(title, target, unit_m), east_north(target)
        old = plane_part(read_crs(self.source_crs))
        return own_frame(f"{title} ({old.name})", old), east_north(target)

    @property
    def target_label(self):
        """Name and code of the system of the ground."""
        target = self.target
        return "a local system" if target is None else system_label(target)

    @property
    def source_label(self):
        """Name and code of the frame from which it leads."""
        if self.source_crs is None:
            return "coordinates of its own"
        return system_label(read_source_crs(self.source_crs))

    def area(self, points):
        """Area of use [degrees] of points (n, 2) on the ground, or None of a site."""
        target = self.target
        return None if target is None else area_of_points(points, target)


def operations_of_fit(fit, frames):
    """All usable models of a ModelTransformation: list of PublishedOperation."""
    places = np.flatnonzero(fit.models["is_usable"].to_numpy())
    names = fit.models[["coverage", "model_id"]].to_numpy()[places]
    keys = names if fit.has_coverages else names[:, 1:]
    differences = None
    if not isinstance(fit, (TriangulatedTransformation, GriddedTransformation)):
        differences = held_out_points(fit)[DIFFERENCES].to_numpy()
    made = []
    for place, code, key in zip(places, codes(frames.name, keys), keys, strict=True):
        rows = slice(fit.observed.start[place], fit.observed.start[place + 1])
        target = fit.observed.target[rows]
        title = frames.name if len(places) == 1 else f"{frames.name}, {' '.join(key)}"
        matrix, shift = fit.fit.homogeneous(place)
        facts = _distribution_of(fit, place, rows, differences)
        matrix, shift = facts.pop("affine", (matrix, shift))
        frame, system = frames.systems(
            title, abs(np.linalg.det(matrix)) ** (1 / len(matrix))
        )
        made.append(
            PublishedOperation(
                code=code,
                title=title,
                model=" ".join(key) if len(places) > 1 else "",
                matrix=matrix,
                shift=shift,
                source=fit.observed.source[rows],
                target=target,
                frame=frame,
                system=system,
                area=frames.area(target[:, :2]),
                **facts,
            )
        )
    return _some(made)


def _distribution_of(fit, place, rows, differences):
    """How good one transformation is, and its triangles or grid where it has any."""
    if differences is not None:
        error, n_held = held_out_error(differences[rows])
        return {"accuracy_m": error, "n_held_out": n_held}
    if isinstance(fit, GriddedTransformation):
        return _grid_of(fit, place)
    held = fit.held_out[DIFFERENCES].to_numpy()[rows]
    error, n_held = held_out_error(held)
    return {
        "accuracy_m": error,
        "n_held_out": n_held,
        "given_net": fit.nets[place],
        "left_out": _left_out_of_model(fit, place),
    }


def _grid_of(fit, place):
    grid = fit.grids[place].grid
    error, n_held = fit.held_out_error([place])
    return {
        "affine": (grid.matrix, grid.shift),
        "accuracy_m": error,
        "n_held_out": n_held,
        "grid": grid,
        "left_out": _left_out_of_model(fit, place),
    }


def _left_out_of_model(fit, place):
    model = fit.models[["coverage", "model_id"]].iloc[place]
    return fit.left_out[(fit.left_out[["coverage", "model_id"]] == model).all(axis=1)]


def operations_of_block(tables, frames, bent=()):
    """Every usable model of a block's flights: list of PublishedOperation.

    ``tables``: models, residuals and points of the result; ``bent``: flights whose
    models share a deformation that is modelled, which no affine transformation holds.
    """
    models = tables["models"]
    models = models[models["is_usable"] & ~models["flight"].isin(list(bent))]
    if frames.target is not None:  # spatial models were bent as the map is
        models = models[models["transformation"] != "helmert_3d"]
    # gross errors that were taken out have no leverage: they are not held out
    residuals = tables["residuals"]
    fitted = residuals[residuals["leverage"] != 0.0]
    held = fitted.merge(tables["points"], on="point_id")
    groups = held.groupby(MODEL_OF_FLIGHT, sort=False).indices
    keys = models[MODEL_OF_FLIGHT].astype(str).to_numpy()
    made = []
    for row, code, key in zip(
        models.to_dict("records"), codes(frames.name, keys), keys, strict=True
    ):
        places = groups.get(tuple(key))
        if places is not None:
            one = _of_model(row, held.iloc[places], frames, code, key)
            made += [one] if one is not None else []
    return _some(made)


def _of_model(row, points, frames, code, key):
    kind = TRANSFORMATION_KINDS[row["transformation"]]
    target = points[list(kind.target)].to_numpy(dtype=float)
    known = np.isfinite(target).all(axis=1)
    if known.sum() < kind.least_points:
        return None
    target, points = target[known], points[known]
    matrix, shift = affine_part(row)
    title = f"{frames.name}, {' '.join(key)}"
    frame, system = frames.systems(
        title, abs(np.linalg.det(matrix)) ** (1 / len(matrix))
    )
    residuals = points[["residual_easting", "residual_northing"]].to_numpy()
    missed, n_held = held_out_error(without_point(residuals, points[["leverage"]]))
    error = missed
    if "standard_error_total" in points:  # what its points share does not show
        propagated = np.sqrt((points["standard_error_total"] ** 2).mean())
        error = float(np.fmax(missed, propagated))
    return PublishedOperation(
        code=code,
        title=title,
        model=" ".join(key),
        matrix=matrix,
        shift=shift,
        source=np.linalg.solve(matrix, (target - shift).T).T,
        target=target,
        accuracy_m=error,
        n_held_out=n_held,
        frame=frame,
        system=system,
        area=frames.area(target[:, :2]),
        missed_m=missed,
    )


def affine_part(row):
    """Matrix and shift of the parameters of one model.

    >>> affine_part({"transformation": "helmert", "a": 2, "b": 1, "te": 5, "tn": 6})[0]
    array([[ 2., -1.],
           [ 1.,  2.]])
    """
    kind = row["transformation"]
    if kind == "affine":
        matrix = [[row["a1"], row["a2"]], [row["b1"], row["b2"]]]
        return np.array(matrix, dtype=float), np.array([row["a0"], row["b0"]])
    if kind == "helmert_3d":
        turned = rotation_from_angles(row["omega"], row["phi"], row["kappa"]).T
        shift = np.array([row["te"], row["tn"], row["th"]])
        return row["scale"] * turned, shift
    a, b = row.get("a"), row.get("b")
    if kind == "rigid":
        a, b = np.cos(row["theta"]), np.sin(row["theta"])
    return np.array([[a, -b], [b, a]], float), np.array([row["te"], row["tn"]], float)


def codes(name, keys):
    """Codes of models: the name alone of a single one, and no two alike.

    >>> codes("B", np.array([["1", "7/8"], ["1", "7-8"]]))
    ['B_1_7-8', 'B_1_7-8_2']
    """
    if len(keys) == 1 and len(keys[0]) < len(MODEL_OF_FLIGHT):
        return [name]
    taken, found = set(), []
    for key in keys:
        plain = re.sub(r"[^A-Za-z0-9_-]+", "-", "_".join(key))
        code, number = f"{name}_{plain}", 2
        while code.casefold() in taken:
            code, number = f"{name}_{plain}_{number}", number + 1
        taken.add(code.casefold())
        found.append(code)
    return found


def _some(made):
    if made:
        return made
    raise GeometryError(
        "the result has no transformation that could be published",
        expected="a model that is transformed, in a flight without a modelled common "
        "deformation; and in plan, where there is a system of the Earth: its curvature "
        "is in no affine transformation",
        remedy="The table failures says why models are not usable",
    )


def left_out_of(operations):
    """Identical points that are no corners of triangles: DataFrame, by operation."""
    parts = [
        one.left_out.assign(operation=one.code)
        for one in operations
        if one.left_out is not None and len(one.left_out)
    ]
    columns = ["operation", "point_id", "deviation", "reason"]
    if not parts:
        return pd.DataFrame(columns=columns)
    return pd.concat(parts, ignore_index=True)[columns]
