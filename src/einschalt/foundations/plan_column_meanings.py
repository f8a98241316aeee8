"""What the tables of plans and their columns mean; column_meanings has the others."""

from einschalt.foundations.column_meanings import meaning_of

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
    "scale_number": ("", "scale number of the low flight, 8000 for 1:8000"),
    "high_scale_number": ("", "scale number of the high flight"),
    "spacing": ("m", "mean distance of neighbouring points"),
    "m_0": ("m", "error of the approximate coordinates, TOTAL"),
    "m_g_um": ("µm", "error of one pointing at a point in the image, TOTAL"),
    "n_settings": ("", "pointings at each point in each of its models"),
    "n_coverages": ("", "how often each flight covers the ground"),
    "control_per_model": ("", "control points in each model of the high flight"),
}
_FLOWN = {
    "flying_height": ("m", "height of the low flight above ground"),
    "high_flying_height": ("m", "height of the high flight above ground"),
    "gsd": ("m", "ground sampling distance: size of a pixel on the ground"),
    "high_gsd": ("m", "ground sampling distance of the high flight"),
    "n_points": ("", "points in a model of the low flight, a mean"),
}
_PRECISION = {
    "m_g_ground": ("m", "error of a measured point on the ground, TOTAL"),
    "m_t_centre": ("m", "error from the transformation in the middle of a model"),
    "m_t_edge": ("m", "error from the transformation at the edge of a model"),
    "M_centre": ("m", "TOTAL in the middle of a model, by the formula of 1971"),
    "M_edge": ("m", "TOTAL at the edge of a model, by the formula of 1971"),
    "M_double": ("m", "TOTAL of the mean of two coverages, by the formula of 1971"),
    "M_mean": ("m", "TOTAL of the mean of all coverages, by the formula of 1971"),
    "expected_centre": ("m", "expected TOTAL of one model's value in its middle"),
    "expected_edge": ("m", "expected TOTAL of one model's value at its edge"),
    "expected_corner": ("m", "expected TOTAL of one model's value in its corners"),
    "expected_mean": ("m", "expected TOTAL of the mean of all values of a point"),
}
_SEARCHED = {
    "reached": ("m", "TOTAL at the place of the target, as it is judged (--by)"),
    "reached_expected": ("m", "expected TOTAL at the place of the target"),
    "reached_paper": ("m", "the same by the formula of 1971"),
    "is_feasible": ("", "whether the target is reached by the closed estimate"),
    "is_efficient": ("", "whether no other plan is cheaper and more precise"),
    "limited_by": (
        "",
        "largest part of the error: measuring, noise, transformation or control",
    ),
    "images": ("1/km²", "images that are flown, of both flights, estimated"),
    "models": ("1/km²", "models that are oriented, of both flights, estimated"),
    "settings": ("1/km²", "pointings at points, of both flights, estimated"),
    "control_points": ("1/km²", "control points that are surveyed, estimated"),
    "cost": ("1/km²", "cost in the currency of the prices, estimated"),
}
_OF_AREA = {
    "line_id": ("", "name of the flight line"),
    "photo_id": ("", "name of the photograph"),
    "n_photographs": ("", "photographs of the line"),
    "length": ("m", "length of the line"),
    "azimuth": ("°", "direction of flight, from grid north, clockwise"),
    "start_easting": ("m", "ground coordinate to the east where the line begins"),
    "start_northing": ("m", "ground coordinate to the north where the line begins"),
    "end_easting": ("m", "ground coordinate to the east where the line ends"),
    "end_northing": ("m", "ground coordinate to the north where the line ends"),
    "flying_height": ("m", "height above the mean ground below"),
    "ground": ("m", "mean height of the ground below"),
    "altitude": ("m", "height of the camera in the height system"),
    "height_above_nadir": ("m", "height above what lies straight below the camera"),
    "n_models": ("", "models of the high flight that hold the point"),
    "standard_error_m": ("m", "error that is asked of it, TOTAL"),
    "item": ("", "image, model, setting (a pointing at a point) or control_point"),
    "amount": ("", "how many the area takes"),
    "price": ("", "price of one"),
}
_OF_LAYOUT = {
    "standard_error_total": ("m", "expected error by propagation, TOTAL"),
    "standard_error_paper": ("m", "error by the formula of 1971, TOTAL"),
    "n_models": ("", "models of the low flight that hold the point"),
    "position_u": ("", "position along the strip in the model, −½ to ½"),
    "position_v": ("", "position across the strip in the model, −½ to ½"),
}
_BREAK_EVEN = {
    "settings": ("", "pointings at a point up to which measuring decides at the edge"),
    "spacing_at_break_even": ("m", "spacing down to which denser points gain there"),
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
    "effort": _OF_AREA | {"cost": ("", "cost in the currency of the prices")},
}


def meaning_in_plan(column, table):
    """Unit and meaning of a column in a table of a plan.

    >>> meaning_in_plan("gsd", "plans")
    ('m', 'ground sampling distance: size of a pixel on the ground')
    """
    return _MEANINGS[table].get(column) or meaning_of(column, table)
