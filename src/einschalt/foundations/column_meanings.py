"""What every table and column means: for pages, workbooks and ``check --explain``.

Units and rules of the tables that are read stand in their schemas; here are the words,
and the units of the tables that are written.
"""

# by table, and by column: the unit where it is a number, and the meaning
TABLES = {
    "control_points": "points whose ground coordinates are given",
    "approximate_points": "approximate ground coordinates, instead of a high flight",
    "model_points": "points measured in the models of a flight",
    "y_parallaxes": "y-parallaxes measured in models, which orient them",
    "models": "models of a flight: their bases, or their images",
    "image_points": "points measured in images",
    "image_pairs": "points measured in both images of a model",
    "points": "densified points",
    "residuals": "residuals of the points in every model, transformed minus given",
    "orientations": "relative orientations",
    "orientation_residuals": "residuals of the relative orientations",
    "gross_measurements": "measurements that contradict the others, and took no part",
    "coverages": "coordinates of the points from each single coverage",
    "error_sources": "errors of each point by their sources",
    "neighbours": "precision of coordinate differences between neighbours",
    "ellipses": "confidence ellipses",
    "control_left_out": "control points, each predicted from all the others",
    "iterations": "moves of the points from iteration to iteration",
    "repeated_settings": "m_g from points that were set several times",
    "failures": "models that could not be used, and why",
}
RESULT_TABLES = (*list(TABLES)[7:9], "models", *list(TABLES)[9:])
INPUT_TABLES = tuple(list(TABLES)[:7])
_KEYS = {
    "point_id": ("", "name of the point, text that is kept as given"),
    "neighbour_id": ("", "name of the second point"),
    "model_id": ("", "name of the model"),
    "image_id": ("", "name of the image"),
    "left_image": ("", "name of the left image"),
    "right_image": ("", "name of the right image"),
    "coverage": ("", "coverage to which the model belongs"),
    "setting": ("", "number of the setting, if a point was set several times"),
    "flight": ("", "high_flight or low_flight"),
    "role": ("", "control, check or new; check points enter no adjustment"),
    "group": ("", "strip or part of a network whose points share a shift"),
}
_COORDINATES = {
    "easting": ("m", "ground coordinate to the east"),
    "northing": ("m", "ground coordinate to the north"),
    "height": ("m", "height"),
    "two_step_easting": ("m", "easting of the two steps, for comparison"),
    "two_step_northing": ("m", "northing of the two steps"),
    "two_step_height": ("m", "height of the two steps"),
    "distributed_easting": ("m", "part that comes from distributed residuals"),
    "distributed_northing": ("m", "part that comes from distributed residuals"),
    "x": ("mm", "model or image coordinate to the right, in the unit of the flight"),
    "y": ("mm", "model or image coordinate upwards"),
    "z": ("mm", "model coordinate, up"),
    "x_left": ("mm", "x in the left image"),
    "y_left": ("mm", "y in the left image"),
    "x_right": ("mm", "x in the right image"),
    "y_right": ("mm", "y in the right image"),
    "y_parallax": ("mm", "y-parallax at the point"),
    "base": ("mm", "length of the base, in the unit of the flight"),
    "n_settings": ("", "number of settings"),
    "settings_spread": ("mm", "spread of the settings about their mean, TOTAL"),
    "largest_move": ("m", "largest move of a point"),
    "move_rms": ("m", "root mean square of the moves, TOTAL"),
    "iteration": ("", "2 is the second pass"),
    "distance": ("m", "distance between the two points"),
}
_ERRORS = {
    "standard_error_m": (
        "m",
        "standard error, TOTAL: root of the sum of both variances",
    ),
    "standard_error_easting": ("m", "standard error of the easting"),
    "standard_error_northing": ("m", "standard error of the northing"),
    "standard_error_height": ("m", "standard error of the height"),
    "covariance_en": ("m²", "covariance of easting and northing"),
    "covariance_eh": ("m²", "covariance of easting and height"),
    "covariance_nh": ("m²", "covariance of northing and height"),
    "standard_error_total": ("m", "propagated standard error, TOTAL"),
    "standard_error_paper": ("m", "Kovarik's M of 1971, TOTAL; too small"),
    "standard_error_internal": ("m", "TOTAL, from differences of coverages alone"),
    "standard_error_checked": ("m", "the figure to believe, TOTAL"),
    "standard_error_height_checked": ("m", "the figure to believe for the height"),
    "standard_error_single": ("m", "of one value in one model, TOTAL"),
    "standard_error_difference": (
        "m",
        "propagated standard error of the difference, TOTAL",
    ),
    "standard_error_control": ("m", "TOTAL, from the control points alone"),
    "standard_error_high_flight": ("m", "TOTAL, from the high flight alone"),
    "standard_error_low_flight": ("m", "TOTAL, from the low flight alone"),
    "standard_error_orientation": ("m", "TOTAL, from the orientations alone"),
    "standard_error_own_deformation": ("m", "TOTAL, from deformations of models"),
    "standard_error_shared_bend": ("m", "TOTAL, from bends that models share"),
    "standard_error_control_groups": ("m", "TOTAL, from shifts of groups of control"),
    "standard_error_approximate_groups": ("m", "TOTAL, from shifts of groups of them"),
    "standard_error_reference_system": ("m", "TOTAL, from the change of system"),
    "standard_error_approximate_points": ("m", "TOTAL, from the approximate points"),
    "standard_error_distance": ("m", "standard error of the distance"),
    "standard_error_across": ("m", "standard error at right angles to the line"),
    "standard_error_if_independent": ("m", "TOTAL, if the points shared no error"),
    "largest_source": ("", "source of the largest part of the error"),
    "semi_major": ("m", "semi-major axis"),
    "semi_minor": ("m", "semi-minor axis"),
    "azimuth_gon": ("gon", "azimuth of the major axis, clockwise from north"),
    "confidence": ("", "probability that the true point lies inside"),
    "spread_total": ("m", "spread of the values about their mean, TOTAL"),
    "is_set_aside": ("", "control that contradicts the block, and takes no part"),
    "is_within_tolerance": ("", "whether the figure to believe keeps the tolerance"),
}
_TESTS = {
    "residual_easting": ("m", "residual of the easting, transformed minus given"),
    "residual_northing": ("m", "residual of the northing, transformed minus given"),
    "residual_height": ("m", "residual of the height, transformed minus given"),
    "difference_easting": ("m", "densified minus given"),
    "difference_northing": ("m", "densified minus given"),
    "difference_height": ("m", "densified minus given"),
    "leverage": ("", "share of the point in its own value, 0 to 1"),
    "redundancy_number": ("", "share of an error that shows in the residual, 0 to 1"),
    "w": ("", "residual divided by its standard error"),
    "p_value": ("", "probability of a value this large by chance"),
    "p_value_height": ("", "the same for the height"),
    "weight": ("", "final weight of the robust estimation"),
    "is_suspect": ("", "whether something contradicts it"),
    "minimal_detectable_bias": (
        "m",
        "gross error that is found with a probability of 80 %",
    ),
    "external_reliability": ("", "effect of such an error, in standard errors"),
    "residual_x_left": ("mm", "residual of x in the left image"),
    "residual_y_left": ("mm", "residual of y in the left image"),
    "residual_x_right": ("mm", "residual of x in the right image"),
    "residual_y_right": ("mm", "residual of y in the right image"),
    "residual": ("mm", "residual of the y-parallax, in the unit of the flight"),
    "n_models": ("", "number of models that gave a value"),
    "n_coverages": ("", "number of coverages that gave a value"),
}
_MODELS = {
    "transformation": ("", "affine, helmert, rigid or helmert_3d"),
    "case": ("", "independent, dependent_left or dependent_right"),
    "n_points": ("", "number of points"),
    "redundancy": ("", "observations minus unknowns"),
    "m_0": ("m", "standard error of a measured point, TOTAL"),
    "s_0": ("m", "standard error of one coordinate"),
    "sigma_0": ("mm", "standard error of one image coordinate or parallax"),
    "m_g_um": ("µm", "given error of a measured point, TOTAL"),
    "m_g_settings_um": ("µm", "the same, estimated from repeated settings"),
    "m_g_intersection_um": ("µm", "error of intersection, TOTAL"),
    "m_g_orientation_um": ("µm", "error that the orientation adds, TOTAL"),
    "standard_error_um": ("µm", "standard error of that figure"),
    "is_larger": ("", "whether it contradicts the given one"),
    "is_smaller": ("", "whether it is much smaller than the given one"),
    "is_usable": ("", "whether the model was used"),
    "is_converged": ("", "whether the iteration converged"),
    "is_ambiguous": ("", "whether another orientation fits as well"),
    "verdict": ("", "verdict on the dangerous surface: safe, weak, critical"),
    "inflation": ("", "tilt error relative to flat terrain"),
    "reason": ("", "why it was not used or not judged; empty where it was"),
    "stage": ("", "stage at which it failed"),
    "remedy": ("", "what can be done about it"),
    **dict.fromkeys(("a0", "b0"), ("m", "shift: E = a0 + a1 x + a2 y, N = b0 + …")),
    **dict.fromkeys(("a1", "a2", "b1", "b2"), ("", "E = a0 + a1 x + a2 y, N likewise")),
    **dict.fromkeys(("a", "b"), ("", "E = a x − b y + te, N = b x + a y + tn")),
    **dict.fromkeys(("te", "tn", "th"), ("m", "shift along easting, northing, height")),
    "scale": ("", "ground divided by model"),
    **dict.fromkeys(("omega", "phi", "kappa"), ("rad", "rotation about x, y, z")),
    **dict.fromkeys(("bx", "by", "bz"), ("mm", "component of the base")),
    **dict.fromkeys(("d_omega", "d_phi", "d_kappa"), ("rad", "correction")),
    **dict.fromkeys(("d_phi_1", "d_kappa_1"), ("rad", "correction, left centre")),
    **dict.fromkeys(("d_phi_2", "d_kappa_2"), ("rad", "correction, right centre")),
    **dict.fromkeys(("d_by", "d_bz"), ("mm", "correction of the base")),
}
MEANINGS = {**_KEYS, **_COORDINATES, **_ERRORS, **_TESTS, **_MODELS}
# where a table means another thing by a name
PARTICULAR = {
    ("neighbours", "standard_error_easting"): (
        "m",
        "standard error of the difference of eastings",
    ),
    ("neighbours", "standard_error_northing"): (
        "m",
        "standard error of the difference of northings",
    ),
    ("neighbours", "covariance_en"): ("m²", "covariance of both differences"),
    ("neighbours", "standard_error_total"): (
        "m",
        "standard error of both differences, TOTAL",
    ),
    ("coverages", "difference_easting"): ("m", "this coverage minus the others"),
    ("coverages", "difference_northing"): ("m", "this coverage minus the others"),
    ("coverages", "difference_height"): ("m", "this coverage minus the others"),
    ("control_left_out", "difference_easting"): ("m", "predicted minus given"),
    ("control_left_out", "difference_northing"): ("m", "predicted minus given"),
    ("control_left_out", "difference_height"): ("m", "predicted minus given"),
    ("repeated_settings", "n_settings"): ("", "settings of all these points"),
    ("repeated_settings", "redundancy"): ("", "settings minus points"),
    ("models", "redundancy"): ("", "equations minus parameters"),
    ("models", "phi"): ("rad", "rotation about y of the spatial transformation"),
    ("control_points", "role"): ("", "control (default) or check"),
    ("control_points", "standard_error_easting"): (
        "m",
        "of the easting; with the next columns, instead of the total in one adjustment",
    ),
}


def meaning_of(column, table=""):
    """Unit and meaning of a column; None where nobody has said it.

    >>> meaning_of("standard_error_total", "neighbours")
    ('m', 'standard error of both differences, TOTAL')
    """
    found = PARTICULAR.get((table, column)) or MEANINGS.get(column)
    if found is None and column.startswith("standard_error_"):
        source = column.removeprefix("standard_error_").replace("_", " ")
        return "m", f"TOTAL, from {source} alone"
    return found
