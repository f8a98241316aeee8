"""Relative orientations and forecasts of dangerous surfaces as a folder of tables."""

import numpy as np
import pandas as pd

from einschalt.interfaces.files.atomic import make_folder, write_text
from einschalt.interfaces.files.csv_tables import write_csv
from einschalt.interfaces.files.parquet_tables import write_parquet
from einschalt.interfaces.reports.parallax_figure import parallax_figure
from einschalt.theory.adjustment.least_squares import pooled_standard_error
from einschalt.theory.relative_orientation.parallax_equations import ELEMENTS

FIGURE = "residual_parallaxes.svg"


def write_forecast(forecast, folder):
    """Write the verdicts on the models of a planned flight.

    Parameters
    ----------
    forecast : SurfaceForecast
    folder : str or Path
        Made where it does not exist.

    Raises
    ------
    FileError
        The folder cannot be written.
    """
    folder = make_folder(folder)
    tables = {"dangerous_surface": forecast.models.reset_index()}
    _write(folder, tables, forecast.summary())


def write_parallax_orientation(oriented, y_parallaxes, folder):
    """Write orientations from y-parallaxes.

    Parameters
    ----------
    oriented : ParallaxOrientation
    y_parallaxes : DataFrame
        The measurements that it comes from.
    folder : str or Path
        Made where it does not exist.

    Raises
    ------
    FileError
        The folder cannot be written.
    """
    folder = make_folder(folder)
    keys = _keys(oriented.models, oriented.has_coverages)
    tables = {
        "models": oriented.models[[*keys, *oriented.models.columns.drop(KEYS)]],
        "parameters": _beside(keys, oriented.parameters),
        "cofactors": _long(keys, oriented.adjustment.cofactor, ELEMENTS[oriented.case]),
        "residuals": oriented.residuals,
        "contradiction": _beside(keys, oriented.contradiction),
        "dangerous_surface": _beside(keys, oriented.dangerous_surface),
        "failures": oriented.failures,
    }
    _write(folder, tables, oriented.summary())
    models, points = _figure_of_parallaxes(oriented, y_parallaxes)
    _write_figure(folder, points, models)


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


def _write(folder, tables, summary):
    for name, table in tables.items():
        write_csv(table, folder / f"{name}.csv")
        write_parquet(table, folder / f"{name}.parquet")
    write_text(folder / "summary.txt", f"{summary}\n")


def _write_figure(folder, points, models):
    svg = parallax_figure(points, models)
    if svg:
        write_text(folder / FIGURE, f"{svg}\n")
    else:
        (folder / FIGURE).unlink(missing_ok=True)


def _labels(frame, has_coverages):
    if not has_coverages:
        return frame["model_id"].astype(object)
    return (frame["coverage"] + ": " + frame["model_id"]).astype(object)


def _figure_of_parallaxes(oriented, y_parallaxes):
    names = list(_keys(oriented.models, oriented.has_coverages).columns)
    places = y_parallaxes[[*names, "point_id", "x", "y"]]
    points = oriented.residuals.merge(places, on=[*names, "point_id"])
    adjustment = oriented.adjustment
    is_known = np.isfinite(adjustment.sigma_0)
    redundancy = adjustment.redundancy[is_known]
    squares = adjustment.sigma_0[is_known] ** 2 * redundancy
    pooled = pooled_standard_error(squares, redundancy)
    points["model"] = _labels(points, oriented.has_coverages)
    points["standard_error"] = pooled * np.sqrt(points["redundancy_number"])
    models = pd.DataFrame(
        {
            "model": _labels(oriented.models, oriented.has_coverages).to_numpy(),
            "base": oriented.models["base"].to_numpy(),
            "sigma_0": oriented.models["sigma_0"].to_numpy(),
            "verdict": oriented.dangerous_surface["verdict"].to_numpy(),
        }
    )
    return models, points
