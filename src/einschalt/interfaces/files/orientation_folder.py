"""Relative orientations and forecasts of dangerous surfaces as a folder of tables."""

import re

import numpy as np
import pandas as pd

from einschalt.interfaces.files.atomic import write_text
from einschalt.interfaces.files.tables_by_suffix import write_in_both_formats
from einschalt.interfaces.reports.krames_figure import krames_figure
from einschalt.interfaces.reports.parallax_figure import parallax_figure
from einschalt.stages.relative_orientation.residual_parallaxes import (
    labels,
    parallaxes_of_images,
    parallaxes_of_parallaxes,
)
from einschalt.theory.relative_orientation.parallax_equations import ELEMENTS

FIGURE = "residual_parallaxes.svg"
KRAMES_FIGURE = "krames_{}.svg"
MOST_KRAMES_FIGURES = 6
TABLES = (
    *("models", "parameters", "cofactors", "residuals", "contradiction"),
    *("model_points", "model_precision", "dangerous_surface", "failures"),
)
NAMES = frozenset(
    (
        *(f"{name}{suffix}" for name in TABLES for suffix in (".csv", ".parquet")),
        *(FIGURE, "summary.txt", "provenance.json"),
    )
)
# what the name of a file should not have
UNFIT = re.compile(r"[^\w.-]+")


def write_forecast(forecast, folder):
    """Write the verdicts on the models of a planned flight."""
    tables = {"dangerous_surface": forecast.models.reset_index()}
    _write(folder, tables, forecast.summary())


def write_parallax_orientation(oriented, y_parallaxes, folder):
    """Write orientations from y-parallaxes, with the measurements behind them."""
    keys = _keys(oriented.models, oriented.has_coverages)
    cofactors = _long(keys, oriented.adjustment.cofactor, ELEMENTS[oriented.case])
    more = {"contradiction": _beside(keys, oriented.contradiction)}
    _write_tables(folder, oriented, keys, cofactors, more)
    points = parallaxes_of_parallaxes(oriented, y_parallaxes)
    _write_figure(folder, oriented, points, oriented.models["base"], keys)
    _write_krames_figures(folder, oriented, y_parallaxes)


def write_image_orientation(oriented, principal_distance, folder):
    """Write orientations from image coordinates; principal distance [mm]."""
    keys = _keys(oriented.models, "coverage" in oriented.residuals)
    elements = oriented.elements
    cofactors = _long(keys, elements.cofactor, elements.estimated)
    names = ("model_points", "model_precision")
    more = {name: getattr(oriented, name) for name in names}
    _write_tables(folder, oriented, keys, cofactors, more)
    points = parallaxes_of_images(oriented, principal_distance)
    base = points.groupby("model", sort=False)["base"].first()
    base = base.reindex(labels(oriented.models, "coverage" in keys))
    _write_figure(folder, oriented, points, base, keys)


KEYS = ["coverage", "model_id"]


def _keys(models, has_coverages):
    return models[KEYS if has_coverages else KEYS[1:]].reset_index(drop=True)


def _beside(keys, frame):
    """Put a table that is indexed by model_id beside the names of its models."""
    return keys.join(frame.reset_index(drop=True))


def _long(keys, matrices, names):
    """Matrices row under row, each with the name of its element."""
    size = len(names)
    rows = keys.loc[keys.index.repeat(size)].reset_index(drop=True)
    rows["element"] = np.tile(np.array(names, dtype=object), len(keys))
    values = np.reshape(matrices, (-1, size))
    return rows.join(pd.DataFrame(values, columns=list(names)))


def _write_tables(folder, oriented, keys, cofactors, more):
    """Write what both ways give, and the further tables of one."""
    tables = {
        "models": oriented.models[[*keys, *oriented.models.columns.drop(KEYS)]],
        "parameters": _beside(keys, oriented.parameters),
        "cofactors": cofactors,
        "residuals": oriented.residuals,
        "dangerous_surface": _beside(keys, oriented.dangerous_surface),
        "failures": oriented.failures,
    }
    _write(folder, tables | more, oriented.summary())


def _write(folder, tables, summary):
    write_in_both_formats(tables, folder)
    write_text(folder / "summary.txt", f"{summary}\n")


def _write_figure(folder, oriented, points, base, keys):
    models = pd.DataFrame(
        {
            "model": labels(oriented.models, "coverage" in keys).to_numpy(),
            "base": base.to_numpy(),
            "sigma_0": oriented.models["sigma_0"].to_numpy(),
            "verdict": oriented.dangerous_surface["verdict"].to_numpy(),
        }
    )
    svg = parallax_figure(points, models)
    if svg:
        write_text(folder / FIGURE, f"{svg}\n")


def _write_krames_figures(folder, oriented, y_parallaxes):
    """Draw the first models that have three points in each base-normal plane."""
    is_drawn = np.isfinite(oriented.contradiction["N_0"].to_numpy())
    is_drawn &= oriented.models["is_usable"].to_numpy(dtype=bool)
    drawn = oriented.models[is_drawn].head(MOST_KRAMES_FIGURES)
    names = labels(drawn, oriented.has_coverages)
    for model, name in zip(drawn.itertuples(), names, strict=True):
        svg = krames_figure(oriented, y_parallaxes, model.model_id, model.coverage)
        file = KRAMES_FIGURE.format(UNFIT.sub("-", name))
        write_text(folder / file, f"{svg}\n")
