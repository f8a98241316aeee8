"""Which tables and facts a block folder has: read and written by the same lists."""

from collections.abc import Callable
from dataclasses import dataclass

from einschalt.foundations import tables
from einschalt.interfaces.files.camera_toml import read_camera
from einschalt.interfaces.files.tables_by_suffix import understand_table

FLIGHT_TABLES = {
    "model_points": tables.MEASURED_MODEL_POINTS,
    "y_parallaxes": tables.Y_PARALLAXES,
    "base": tables.MODEL_BASES,
    "image_points": tables.IMAGE_POINTS,
    "models": tables.IMAGE_MODELS,
}
FLIGHT_FACTS = (
    "scale_number",
    "m_g_um",
    "transformation",
    "model_unit",
    "principal_distance_mm",
    "orientation_case",
    "orientation_method",
)
POINT_TABLES = {
    "control_points": tables.CONTROL_POINTS,
    "approximate_points": tables.APPROXIMATE_POINTS,
}


@dataclass(frozen=True)
class Readers:
    """How the files of a block are read: tables and cameras."""

    table: Callable = understand_table
    camera: Callable = read_camera
