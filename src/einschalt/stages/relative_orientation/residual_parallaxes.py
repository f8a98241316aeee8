"""Residual y-parallaxes in plan, as a figure of them needs: one row per point."""

import numpy as np
import pandas as pd

from einschalt.foundations.frame_columns import values_of
from einschalt.stages.relative_orientation.dangerous_surface import turned_to_base
from einschalt.theory.adjustment.least_squares import pool_standard_errors

NAMES = ["coverage", "model_id"]


def parallaxes_of_parallaxes(oriented, y_parallaxes) -> pd.DataFrame:
    """Residual parallaxes of models that were oriented by their y-parallaxes.

    model, point_id, x, y (in plan), residual, standard_error of the residual from the
    sigma_0 of all models together, all in the unit of the measurements.
    """
    names = NAMES if oriented.has_coverages else NAMES[1:]
    places = y_parallaxes[[*names, "point_id", "x", "y"]]
    points = oriented.residuals.merge(places, on=[*names, "point_id"])
    sigma_0 = _pooled(oriented.models)
    return pd.DataFrame(
        {
            "model": labels(points, oriented.has_coverages),
            **{name: points[name] for name in ("point_id", "x", "y", "residual")},
            "standard_error": sigma_0 * np.sqrt(points["redundancy_number"]),
        }
    )


def parallaxes_of_images(oriented, principal_distance) -> pd.DataFrame:
    """Residual parallaxes of models that were oriented by their image coordinates.

    model, point_id, x, y (in plan, at the mean image scale), residual, standard_error
    of the residual from the sigma_0 of all models together, base [mm].

    Notes
    -----
    The y-parallax of two images is the difference of their coordinates across the
    base: its variance is that of two coordinates.
    """
    cameras = oriented.elements.cameras
    # a point that was taken out has no place in the model
    residuals = oriented.residuals[oriented.residuals["weight"].notna()]
    count = np.where(oriented.is_oriented, oriented.models["n_points"], 0)
    model = np.repeat(np.arange(len(count)), count)
    xyz = values_of(oriented.model_points, ["x", "y", "z"])
    place, axes = turned_to_base(cameras, xyz, model)
    depth = np.bincount(model, -place[:, 2], len(count)) / np.maximum(count, 1)
    place *= principal_distance / depth[model][:, np.newaxis]
    residual = 0.0
    for side, sign in (("left", 1.0), ("right", -1.0)):
        rotation = getattr(cameras, f"{side}_rotation")
        across = np.einsum("nij,nj->ni", rotation, axes[:, 1])[:, :2]
        across /= np.linalg.norm(across, axis=1)[:, np.newaxis]
        columns = [f"residual_x_{side}", f"residual_y_{side}"]
        both = across[model] * values_of(residuals, columns)
        residual = residual + sign * both.sum(axis=1)
    variance = 2.0 * _pooled(oriented.models) ** 2
    return pd.DataFrame(
        {
            "model": labels(residuals, "coverage" in residuals),
            "point_id": residuals["point_id"],
            "x": place[:, 0],
            "y": place[:, 1],
            "residual": residual,
            "standard_error": np.sqrt(variance * residuals["redundancy_number"]),
            "base": _bases(cameras)[model] * principal_distance / depth[model],
        }
    )


def labels(frame, has_coverages):
    """Names of models that are unique over coverages."""
    if not has_coverages:
        return frame["model_id"].astype(object)
    return (frame["coverage"] + ": " + frame["model_id"]).astype(object)


def _bases(cameras):
    return np.linalg.norm(cameras.right_centre - cameras.left_centre, axis=1)


def _pooled(models):
    return pool_standard_errors(models["sigma_0"], models["redundancy"])
