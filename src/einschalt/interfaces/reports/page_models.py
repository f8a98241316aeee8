"""What the page knows of models: their figures, and where they lie."""

import numpy as np
import pandas as pd

from einschalt.foundations.batches import segments_present
from einschalt.foundations.frame_columns import columns_of, values_of, with_columns
from einschalt.foundations.kept_texts import retold
from einschalt.foundations.units import METRES_PER_MM
from einschalt.interfaces.reports.packed_data import quantum_of
from einschalt.pipeline.summary.wording import transformation_name

KEYS = ["flight", "coverage", "model_id"]
N_CORNERS = 8
MOST_FOOTPRINTS = 20_000


def pack_models(packed, result):
    """Put the models into the page's data."""
    models = result.models
    found = {
        "n": len(models),
        "names": packed.names(models["model_id"]),
        "flight": packed.codes(_flights(models)),
        "coverage": packed.codes(models["coverage"]),
        "fit": packed.codes(map(transformation_name, models["transformation"])),
        "points": packed.numbers(models["n_points"], 1.0),
        "redundancy": packed.numbers(models["redundancy"], 1.0),
        "usable": packed.numbers(models["is_usable"].astype(float), 1.0),
        "reason": packed.codes(models["reason"].fillna("").map(retold)),
    }
    for name in ("m_0", "s_0"):
        found[name] = packed.numbers(models[name], quantum_of(models[name]))
    sigma = _sigma_0(result)
    if sigma is not None:
        found["sigma_0"] = packed.numbers(sigma, quantum_of(sigma))
    corners = footprints(result)
    if corners is not None:
        found["corners"] = packed.numbers(corners.ravel(), 1.0)
    packed.head["models"] = found


def _flights(models):
    return models["flight"].str.removesuffix("_flight")


def _sigma_0(result):
    """sigma_0 of the relative orientation of each model [m], or None."""
    rows = result.orientations
    if not len(rows):
        return None
    rows = rows.drop_duplicates(KEYS).set_index(KEYS)["sigma_0"].astype(float)
    places = pd.MultiIndex.from_frame(result.models[KEYS])
    return rows.reindex(places).to_numpy() * METRES_PER_MM


def footprints(result):
    """Outermost points of each model in eight directions (n_models, 8), or None.

    Rows of ``result.points``; NaN where no point of a model is known. They are the
    corners of a convex polygon, in their order.
    """
    points, models = result.points, result.models
    inside = _points_of_models(result)
    if not len(inside) or not len(models) or len(models) > MOST_FOOTPRINTS:
        return None
    row_of = pd.Series(np.arange(len(points)), points["point_id"])
    row = row_of[~row_of.index.duplicated()].reindex(inside["point_id"]).to_numpy()
    places = pd.MultiIndex.from_frame(columns_of(models, KEYS))
    places = pd.Series(np.arange(len(models)), places)
    places = places[~places.index.duplicated()]
    own = pd.MultiIndex.from_frame(columns_of(inside, KEYS))
    model = places.reindex(own).to_numpy()
    xy = values_of(points, ["easting", "northing"])
    is_known = np.isfinite(row) & np.isfinite(model)
    row, model = row[is_known].astype(int), model[is_known].astype(int)
    is_located = np.isfinite(xy[row]).all(axis=1)
    row, model = row[is_located], model[is_located]
    if not len(row):
        return None
    return _outermost(xy, row, model, len(models))


def _outermost(xy, row, model, n_models):
    parts = segments_present(model)
    row, model, starts = row[parts.order], model[parts.order], parts.start[:-1]
    corners = np.full((n_models, N_CORNERS), np.nan)
    for corner in range(N_CORNERS):
        angle = 2.0 * np.pi * corner / N_CORNERS
        along = xy[row] @ np.array([np.cos(angle), np.sin(angle)])
        farthest = np.maximum.reduceat(along, starts)[parts.group]
        places = np.where(along == farthest, np.arange(len(row)), len(row))
        first = np.minimum.reduceat(places, starts)
        corners[model[starts], corner] = row[first]
    return corners


def _points_of_models(result):
    """Which points lie in which model, as values and residuals tell."""
    values = result.single_values
    parts = [columns_of(result.residuals, [*KEYS, "point_id"])]
    if len(values):
        low = columns_of(values, ["coverage", "model_id", "point_id"])
        parts.insert(0, with_columns(low, flight="low_flight"))
    return pd.concat([part for part in parts if len(part)] or parts)
