"""Which tables and facts a block folder has: read and written by the same lists."""

from einschalt.foundations import tables

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
