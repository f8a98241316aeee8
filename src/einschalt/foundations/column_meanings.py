"""What every table and column means: for pages, workbooks and ``check --explain``.

Units and rules of the tables that are read stand in their schemas; here are the words,
and the units of the tables that are written.
"""

from einschalt.foundations.meanings_with_units import unit_and_meaning

# by table, and by column
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
    "point_id": "name of the point, text that is kept as given",
    "neighbour_id": "name of the second point",
    "model_id": "name of the model",
    "image_id": "name of the image",
    "left_image": "name of the left image",
    "right_image": "name of the right image",
    "coverage": "coverage to which the model belongs",
    "setting": "number of the setting, if a point was set several times",
    "flight": "high_flight or low_flight",
    "role": "control, check or new; check points enter no adjustment",
    "group": "strip or part of a network whose points share a shift",
}
_COORDINATES = {
    "easting": "ground coordinate to the east [m]",
    "northing": "ground coordinate to the north [m]",
    "height": "height [m]",
    "two_step_easting": "easting of the two steps, for comparison [m]",
    "two_step_northing": "northing of the two steps [m]",
    "two_step_height": "height of the two steps [m]",
    "distributed_easting": "part that comes from distributed residuals [m]",
    "distributed_northing": "part that comes from distributed residuals [m]",
    "x": "model or image coordinate to the right, in the unit of the flight [mm]",
    "y": "model or image coordinate upwards [mm]",
    "z": "model coordinate, up [mm]",
    "x_left": "x in the left image [mm]",
    "y_left": "y in the left image [mm]",
    "x_right": "x in the right image [mm]",
    "y_right": "y in the right image [mm]",
    "y_parallax": "y-parallax at the point [mm]",
    "base": "length of the base, in the unit of the flight [mm]",
    "n_settings": "number of settings",
    "settings_spread": "spread of the settings about their mean, TOTAL [mm]",
    "largest_move": "largest move of a point [m]",
    "move_rms": "root mean square of the moves, TOTAL [m]",
    "iteration": "2 is the second pass",
    "distance": "distance between the two points [m]",
}
_ERRORS = {
    "standard_error_m": "standard error, TOTAL: root of the sum of both variances [m]",
    "standard_error_easting": "standard error of the easting [m]",
    "standard_error_northing": "standard error of the northing [m]",
    "standard_error_height": "standard error of the height [m]",
    "covariance_en": "covariance of easting and northing [m²]",
    "covariance_eh": "covariance of easting and height [m²]",
    "covariance_nh": "covariance of northing and height [m²]",
    "standard_error_total": "propagated standard error, TOTAL [m]",
    "standard_error_paper": "Kovarik's M of 1971, TOTAL; too small [m]",
    "standard_error_internal": "TOTAL, from differences of coverages alone [m]",
    "standard_error_checked": "the figure to believe, TOTAL [m]",
    "standard_error_height_checked": "the figure to believe for the height [m]",
    "standard_error_single": "of one value in one model, TOTAL [m]",
    "standard_error_difference": (
        "propagated standard error of the difference, TOTAL [m]"
    ),
    "standard_error_control": "TOTAL, from the control points alone [m]",
    "standard_error_high_flight": "TOTAL, from the high flight alone [m]",
    "standard_error_low_flight": "TOTAL, from the low flight alone [m]",
    "standard_error_orientation": "TOTAL, from the orientations alone [m]",
    "standard_error_own_deformation": "TOTAL, from deformations of models [m]",
    "standard_error_shared_bend": "TOTAL, from bends that models share [m]",
    "standard_error_control_groups": "TOTAL, from shifts of groups of control [m]",
    "standard_error_approximate_groups": "TOTAL, from shifts of groups of them [m]",
    "standard_error_reference_system": "TOTAL, from the change of system [m]",
    "standard_error_approximate_points": "TOTAL, from the approximate points [m]",
    "standard_error_distance": "standard error of the distance [m]",
    "standard_error_across": "standard error at right angles to the line [m]",
    "standard_error_if_independent": "TOTAL, if the points shared no error [m]",
    "largest_source": "source of the largest part of the error",
    "semi_major": "semi-major axis [m]",
    "semi_minor": "semi-minor axis [m]",
    "azimuth_gon": "azimuth of the major axis, clockwise from north [gon]",
    "confidence": "probability that the true point lies inside",
    "spread_total": "spread of the values about their mean, TOTAL [m]",
    "is_set_aside": "control that contradicts the block, and takes no part",
    "is_within_tolerance": "whether the figure to believe keeps the tolerance",
}
_TESTS = {
    "residual_easting": "residual of the easting, transformed minus given [m]",
    "residual_northing": "residual of the northing, transformed minus given [m]",
    "residual_height": "residual of the height, transformed minus given [m]",
    "difference_easting": "densified minus given [m]",
    "difference_northing": "densified minus given [m]",
    "difference_height": "densified minus given [m]",
    "leverage": "share of the point in its own value, 0 to 1",
    "redundancy_number": "share of an error that shows in the residual, 0 to 1",
    "w": "residual divided by its standard error",
    "p_value": "probability of a value this large by chance",
    "p_value_height": "the same for the height",
    "weight": "final weight of the robust estimation",
    "is_suspect": "whether something contradicts it",
    "minimal_detectable_bias": (
        "gross error that is found with a probability of 80 % [m]"
    ),
    "external_reliability": "effect of such an error, in standard errors",
    "residual_x_left": "residual of x in the left image [mm]",
    "residual_y_left": "residual of y in the left image [mm]",
    "residual_x_right": "residual of x in the right image [mm]",
    "residual_y_right": "residual of y in the right image [mm]",
    "residual": "residual of the y-parallax, in the unit of the flight [mm]",
    "n_models": "number of models that gave a value",
    "n_coverages": "number of coverages that gave a value",
}
_MODELS = {
    "transformation": "affine, helmert, rigid or helmert_3d",
    "case": "independent, dependent_left or dependent_right",
    "n_points": "number of points",
    "redundancy": "observations minus unknowns",
    "m_0": "standard error of a measured point, TOTAL [m]",
    "s_0": "standard error of one coordinate [m]",
    "sigma_0": "standard error of one image coordinate or parallax [mm]",
    "m_g_um": "given error of a measured point, TOTAL [µm]",
    "m_g_settings_um": "the same, estimated from repeated settings [µm]",
    "m_g_intersection_um": "error of intersection, TOTAL [µm]",
    "m_g_orientation_um": "error that the orientation adds, TOTAL [µm]",
    "standard_error_um": "standard error of that figure [µm]",
    "is_larger": "whether it contradicts the given one",
    "is_smaller": "whether it is much smaller than the given one",
    "is_usable": "whether the model was used",
    "is_converged": "whether the iteration converged",
    "is_ambiguous": "whether another orientation fits as well",
    "verdict": "verdict on the dangerous surface: safe, weak, critical",
    "inflation": "tilt error relative to flat terrain",
    "reason": "why it was not used or not judged; empty where it was",
    "stage": "stage at which it failed",
    "remedy": "what can be done about it",
    **dict.fromkeys(("a0", "b0"), "shift: E = a0 + a1 x + a2 y, N = b0 + … [m]"),
    **dict.fromkeys(("a1", "a2", "b1", "b2"), "E = a0 + a1 x + a2 y, N likewise"),
    **dict.fromkeys(("a", "b"), "E = a x − b y + te, N = b x + a y + tn"),
    **dict.fromkeys(("te", "tn", "th"), "shift along easting, northing, height [m]"),
    "scale": "ground divided by model",
    **dict.fromkeys(("omega", "phi", "kappa"), "rotation about x, y, z [rad]"),
    **dict.fromkeys(("bx", "by", "bz"), "component of the base [mm]"),
    **dict.fromkeys(("d_omega", "d_phi", "d_kappa"), "correction [rad]"),
    **dict.fromkeys(("d_phi_1", "d_kappa_1"), "correction, left centre [rad]"),
    **dict.fromkeys(("d_phi_2", "d_kappa_2"), "correction, right centre [rad]"),
    **dict.fromkeys(("d_by", "d_bz"), "correction of the base [mm]"),
}
MEANINGS = {**_KEYS, **_COORDINATES, **_ERRORS, **_TESTS, **_MODELS}
# where a table means another thing by a name
PARTICULAR = {
    (
        "neighbours",
        "standard_error_easting",
    ): "standard error of the difference of eastings [m]",
    (
        "neighbours",
        "standard_error_northing",
    ): "standard error of the difference of northings [m]",
    ("neighbours", "covariance_en"): "covariance of both differences [m²]",
    (
        "neighbours",
        "standard_error_total",
    ): "standard error of both differences, TOTAL [m]",
    ("coverages", "difference_easting"): "this coverage minus the others [m]",
    ("coverages", "difference_northing"): "this coverage minus the others [m]",
    ("coverages", "difference_height"): "this coverage minus the others [m]",
    ("control_left_out", "difference_easting"): "predicted minus given [m]",
    ("control_left_out", "difference_northing"): "predicted minus given [m]",
    ("control_left_out", "difference_height"): "predicted minus given [m]",
    ("repeated_settings", "n_settings"): "settings of all these points",
    ("repeated_settings", "redundancy"): "settings minus points",
    ("models", "redundancy"): "equations minus parameters",
    ("models", "phi"): "rotation about y of the spatial transformation [rad]",
    ("control_points", "role"): "control (default) or check",
    ("control_points", "standard_error_easting"): (
        "of the easting; with the next columns, instead of the total in one "
        "adjustment [m]"
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
    return None if found is None else unit_and_meaning(found)
