"""What the tables of plans and their columns mean; column_meanings has the others."""

from einschalt.foundations.column_meanings import meaning_of
from einschalt.foundations.meanings_with_units import unit_and_meaning

PLAN_TABLES = {
    "plan": "precision before the flight, for every combination of what was asked",
    "best_scales": "scale at which the edge of a model is most precise",
    "break_even": "effort up to which measuring or denser points improve the edge",
    "plans": "plans that were estimated, the cheapest that reach the target first",
    "expected_points": "points of a layout, with their expected precision",
    "expected_values": "values of the points from every single model of a layout",
    "flight_lines": "lines that are flown over an area",
    "photographs": "photographs that are taken over an area",
    "control": "control points that are surveyed for an area",
    "effort": "what an area takes, and what it costs",
}
_CHOICES = {
    "scale_number": "scale number of the low flight, 8000 for 1:8000",
    "high_scale_number": "scale number of the high flight",
    "spacing": "mean distance of neighbouring points [m]",
    "m_0": "error of the approximate coordinates, TOTAL [m]",
    "m_g_um": "error of one pointing at a point in the image, TOTAL [µm]",
    "n_settings": "pointings at each point in each of its models",
    "n_coverages": "how often each flight covers the ground",
    "control_per_model": "control points in each model of the high flight",
}
_FLOWN = {
    "flying_height": "height of the low flight above ground [m]",
    "high_flying_height": "height of the high flight above ground [m]",
    "gsd": "ground sampling distance: size of a pixel on the ground [m]",
    "high_gsd": "ground sampling distance of the high flight [m]",
    "n_points": "points in a model of the low flight, a mean",
}
_PRECISION = {
    "m_g_ground": "error of a measured point on the ground, TOTAL [m]",
    "m_t_centre": "error from the transformation in the middle of a model [m]",
    "m_t_edge": "error from the transformation at the edge of a model [m]",
    "M_centre": "TOTAL in the middle of a model, by the formula of 1971 [m]",
    "M_edge": "TOTAL at the edge of a model, by the formula of 1971 [m]",
    "M_double": "TOTAL of the mean of two coverages, by the formula of 1971 [m]",
    "M_mean": "TOTAL of the mean of all coverages, by the formula of 1971 [m]",
    "expected_centre": "expected TOTAL of one model's value in its middle [m]",
    "expected_edge": "expected TOTAL of one model's value at its edge [m]",
    "expected_corner": "expected TOTAL of one model's value in its corners [m]",
    "expected_mean": "expected TOTAL of the mean of all values of a point [m]",
}
_SEARCHED = {
    "reached": "TOTAL at the place of the target, as it is judged (--by) [m]",
    "reached_expected": "expected TOTAL at the place of the target [m]",
    "reached_paper": "the same by the formula of 1971 [m]",
    "is_feasible": "whether the target is reached by the closed estimate",
    "is_efficient": "whether no other plan is cheaper and more precise",
    "limited_by": (
        "largest part of the error: measuring, noise, transformation or control"
    ),
    "images": "images that are flown, of both flights, estimated [1/km²]",
    "models": "models that are oriented, of both flights, estimated [1/km²]",
    "settings": "pointings at points, of both flights, estimated [1/km²]",
    "control_points": "control points that are surveyed, estimated [1/km²]",
    "cost": "cost in the currency of the prices, estimated [1/km²]",
}
_OF_AREA = {
    "line_id": "name of the flight line",
    "photo_id": "name of the photograph",
    "n_photographs": "photographs of the line",
    "length": "length of the line [m]",
    "azimuth": "direction of flight, from grid north, clockwise [°]",
    "start_easting": "ground coordinate to the east where the line begins [m]",
    "start_northing": "ground coordinate to the north where the line begins [m]",
    "end_easting": "ground coordinate to the east where the line ends [m]",
    "end_northing": "ground coordinate to the north where the line ends [m]",
    "flying_height": "height above the mean ground below [m]",
    "ground": "mean height of the ground below [m]",
    "altitude": "height of the camera in the height system [m]",
    "height_above_nadir": "height above what lies straight below the camera [m]",
    "n_models": "models of the high flight that hold the point",
    "standard_error_m": "error that is asked of it, TOTAL [m]",
    "item": "image, model, setting (a pointing at a point) or control_point",
    "amount": "how many the area takes",
    "price": "price of one",
}
_OF_LAYOUT = {
    "standard_error_total": "expected error by propagation, TOTAL [m]",
    "standard_error_paper": "error by the formula of 1971, TOTAL [m]",
    "n_models": "models of the low flight that hold the point",
    "position_u": "position along the strip in the model, −½ to ½",
    "position_v": "position across the strip in the model, −½ to ½",
}
_BREAK_EVEN = {
    "settings": "pointings at a point up to which measuring decides at the edge",
    "spacing_at_break_even": "spacing down to which denser points gain there [m]",
}
_AXES = ("scale_number", "spacing", "m_0", "m_g_um")
_BY_FORMULA = ("m_g_ground", "m_t_centre", "m_t_edge", "M_centre", "M_edge", "M_double")
PLAN_COLUMNS = {
    "plan": (*_AXES, "flying_height", "n_points", *_BY_FORMULA),
    "best_scales": (
        *(*_AXES[1:], "scale_number", "flying_height", "n_points"),
        *_BY_FORMULA,
    ),
    "break_even": (*_AXES, "settings", "spacing_at_break_even"),
    "plans": (
        *("scale_number", "spacing", "m_g_um", "n_settings", "n_coverages"),
        *("control_per_model", "high_scale_number", "flying_height"),
        *("high_flying_height", "gsd", "high_gsd", "n_points", "m_0", "M_centre"),
        *("M_edge", "M_mean", "expected_centre", "expected_edge"),
        *("expected_corner", "expected_mean"),
        *("limited_by", "images", "models", "settings", "control_points", "cost"),
        *("reached_expected", "reached_paper", "reached", "is_feasible"),
        "is_efficient",
    ),
    "expected_points": (
        *("point_id", "role", "standard_error_total", "standard_error_paper"),
        *("n_models", "easting", "northing"),
    ),
    "expected_values": (
        *("coverage", "model_id", "point_id", "position_u", "position_v"),
        *("standard_error_paper", "standard_error_total"),
    ),
    "flight_lines": (
        *("line_id", "flight", "coverage", "n_photographs", "length", "azimuth"),
        *("start_easting", "start_northing", "end_easting", "end_northing"),
        *("flying_height", "gsd", "ground", "altitude"),
    ),
    "photographs": (
        *("photo_id", "line_id", "flight", "coverage", "easting", "northing"),
        *("azimuth", "flying_height", "ground", "altitude", "height_above_nadir"),
    ),
    "control": (
        *("point_id", "easting", "northing", "height", "n_models", "standard_error_m"),
    ),
    "effort": ("item", "amount", "price", "cost"),
}
"""Their columns, in the order in which they are written."""
_MEANINGS = {
    **dict.fromkeys(("plan", "best_scales"), _CHOICES | _FLOWN | _PRECISION),
    "break_even": _CHOICES | _BREAK_EVEN,
    "plans": _CHOICES | _FLOWN | _PRECISION | _SEARCHED,
    **dict.fromkeys(("expected_points", "expected_values"), _OF_LAYOUT),
    **dict.fromkeys(("flight_lines", "photographs"), _FLOWN | _OF_AREA),
    "control": _OF_AREA,
    "effort": _OF_AREA | {"cost": "cost in the currency of the prices"},
}


def meaning_in_plan(column, table):
    """Unit and meaning of a column in a table of a plan.

    >>> meaning_in_plan("gsd", "plans")
    ('m', 'ground sampling distance: size of a pixel on the ground')
    """
    found = _MEANINGS[table].get(column)
    return unit_and_meaning(found) if found else meaning_of(column, table)
