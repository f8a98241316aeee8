"""A result as a folder: tables, map, report, summary, and where all of it comes from.

provenance.json is taken away first and written last: where it stands, the folder is
complete.
"""

import json
from pathlib import Path

from einschalt.foundations.errors import FileError
from einschalt.interfaces.files.atomic import (
    make_folder,
    said_as_file_error,
    write_text,
)
from einschalt.interfaces.files.csv_tables import write_csv
from einschalt.interfaces.files.ellipse_layer import require_scale
from einschalt.interfaces.files.geopackage import write_geopackage
from einschalt.interfaces.files.input_files import checksum
from einschalt.interfaces.files.parquet_tables import write_parquet
from einschalt.interfaces.provenance import provenance
from einschalt.interfaces.reports.html_report import render
from einschalt.pipeline.summary.summary import lasting_summary

PROVENANCE = "provenance.json"
TABLES = ("points", "models", "residuals", "orientations")
IF_ANY = (
    "orientation_residuals",
    "gross_measurements",
    "coverages",
    "error_sources",
    "neighbours",
    "ellipses",
    "control_left_out",
    "iterations",
    "repeated_settings",
)
FIRST_COLUMNS = {
    "points": (
        "point_id",
        "easting",
        "northing",
        "height",
        "standard_error_easting",
        "standard_error_northing",
        "standard_error_height",
        "covariance_en",
        "standard_error_total",
        "standard_error_paper",
        "standard_error_internal",
        "standard_error_checked",
        "is_within_tolerance",
        "n_models",
        "n_coverages",
        "spread_total",
        "role",
        "is_suspect",
        "difference_easting",
        "difference_northing",
        "difference_height",
        "distributed_easting",
        "distributed_northing",
    ),
    "models": (
        "flight",
        "coverage",
        "model_id",
        "transformation",
        "n_points",
        "redundancy",
        "m_0",
        "s_0",
        "is_usable",
        "reason",
    ),
    "residuals": (
        "flight",
        "coverage",
        "model_id",
        "point_id",
        "residual_easting",
        "residual_northing",
        "residual_height",
        "leverage",
        "redundancy_number",
        "w",
        "p_value",
        "is_suspect",
    ),
    "orientations": ("flight", "coverage", "model_id"),
    "orientation_residuals": ("flight", "coverage", "model_id", "point_id"),
    "gross_measurements": ("flight", "coverage", "model_id", "point_id"),
    "coverages": ("point_id", "coverage", "easting", "northing"),
    "error_sources": ("point_id", "standard_error_total"),
    "neighbours": ("point_id", "neighbour_id", "distance"),
    "ellipses": ("point_id", "easting", "northing"),
    "control_left_out": ("point_id", "difference_easting", "difference_northing"),
    "iterations": ("iteration", "largest_move", "point_id", "move_rms"),
    "repeated_settings": ("flight", "n_points", "n_settings", "redundancy"),
    "failures": ("flight", "coverage", "model_id", "stage", "reason", "remedy"),
}
# what people read: 0.1 mm of a coordinate, 0.01 mm of an error; Parquet has it all
DECIMALS = {
    "easting": 4,
    "northing": 4,
    "height": 4,
    "spread": 4,
    "largest_move": 5,
    "move_rms": 5,
    "difference": 4,
    "residual": 5,
    "standard_error": 5,
    "m_0": 5,
    "s_0": 5,
    "distance": 3,
    "semi_major": 5,
    "semi_minor": 5,
    "azimuth_gon": 2,
    "leverage": 6,
    "redundancy_number": 6,
    "w": 3,
    "p_value": 6,
}


def write_result(result, folder, *, ellipse_scale=None):
    """Write everything that a result holds.

    Parameters
    ----------
    result : DensificationResult
    folder : str or Path
        Made where it does not exist; files of an older result are replaced.
    ellipse_scale : float, optional
        How much larger the confidence ellipses are drawn in block.gpkg.

    Raises
    ------
    FileError
        The folder cannot be written. Every file that stands in it is whole.
    SettingsError
        The scale is not positive.
    """
    refuse_block_folder(folder)
    require_scale(ellipse_scale)
    folder = make_folder(folder)
    with said_as_file_error(folder / PROVENANCE):
        (folder / PROVENANCE).unlink(missing_ok=True)
    written = _write_tables(result, folder)
    write_geopackage(result, folder / "block.gpkg", ellipse_scale=ellipse_scale)
    write_text(folder / "report.html", render(result))
    write_text(folder / "summary.txt", lasting_summary(result))
    written += ["block.gpkg", "report.html", "summary.txt"]
    outputs = {name: checksum(folder / name) for name in written}
    origin = {**provenance(result), "outputs": outputs}
    text = json.dumps(origin, indent=2, ensure_ascii=False, allow_nan=False)
    write_text(folder / PROVENANCE, text + "\n")


def refuse_block_folder(folder):
    """Refuse a folder that holds a block as the place for results.

    Tables of a block and of a result have the same names: its measurements would be
    overwritten.

    Parameters
    ----------
    folder : str or Path

    Raises
    ------
    FileError
        It holds a block.
    """
    if (Path(folder) / "block.toml").exists():
        raise FileError(
            "the folder holds a block, whose tables would be overwritten",
            expected="a folder of its own for the results",
            remedy="Name another folder",
            file=folder,
        )


def _write_tables(result, folder):
    written = []
    for name in IF_ANY:  # an older result may have had it
        for suffix in (".csv", ".parquet"):
            with said_as_file_error(folder / f"{name}{suffix}"):
                (folder / f"{name}{suffix}").unlink(missing_ok=True)
    # a table of its own where there is anything in it
    further = [name for name in IF_ANY if len(getattr(result, name))]
    for name in (*TABLES, *further, "failures"):
        frame = _ordered(getattr(result, name), FIRST_COLUMNS[name])
        decimals = {column: _decimals(column) for column in frame.columns}
        write_csv(frame, folder / f"{name}.csv", decimals=decimals)
        written.append(f"{name}.csv")
        if name != "failures":
            write_parquet(frame, folder / f"{name}.parquet")
            written.append(f"{name}.parquet")
    return written


def _ordered(frame, first):
    known = [name for name in first if name in frame.columns]
    return frame[[*known, *(name for name in frame.columns if name not in known)]]


def _decimals(column):
    """Decimals of a column by its name, or by the word that it begins with."""
    if column in DECIMALS:
        return DECIMALS[column]
    for word in ("standard_error", "residual", "difference", "spread"):
        if column.startswith(f"{word}_"):
            return DECIMALS[word]
    return None
