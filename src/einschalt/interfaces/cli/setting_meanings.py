"""What each value of a setting means: for ``einschalt explain``."""

from einschalt.foundations.column_words import folded
from einschalt.foundations.language import mark, mark_each, translated
from einschalt.pipeline.settings import Settings

PLACE = mark("in [settings] of block.toml, or {option} of densify and batch")
# of block.toml, beside the fields of Settings
KEYS = mark_each(
    {
        "transformation": ("Transformation of the models of a flight onto the ground."),
        "orientation_case": (
            "Which bundles of rays a relative orientation from y-parallaxes moves."
        ),
        "orientation_method": (
            "How a relative orientation is computed from y-parallaxes."
        ),
        "model_unit": ("Unit of model coordinates and bases."),
        "convention": ("Axes, units and signs of a camera file ([camera])."),
    }
)
# by setting and value
VALUES = {
    "method": mark_each(
        {
            "two_step": (
                "the two-step method of Kovarik 1971: the high flight gives "
                "approximate coordinates, onto which each model of the low flight "
                "is transformed by itself"
            ),
            "simultaneous": (
                "all models of all flights and the control in one adjustment"
            ),
            "auto": (
                "both are computed, and the one is kept that the measurements "
                "support best"
            ),
        }
    ),
    "coverage_mean": mark_each(
        {
            "all": ("every model that contains a point gives it a value"),
            "most_central": (
                "per coverage the model alone in which the point lies nearest to "
                "the centre, as in 1971"
            ),
        }
    ),
    "weighting": mark_each(
        {
            "auto": (
                "rigorous if the size of every error is known and all models are "
                "used, otherwise plain"
            ),
            "plain": ("arithmetic mean: all values of a point count alike"),
            "weighted": ("weights 1 / M², M being the error of the budget"),
            "rigorous": (
                "mean of least variance by the propagated covariances of the "
                "values, which a badly determined model does not spoil"
            ),
        }
    ),
    "outliers": mark_each(
        {
            "keep": ("gross errors are only reported; every measurement takes part"),
            "snoop": (
                "data snooping after Baarda: the worst measurement of each "
                "low-flight model is removed until none is suspect"
            ),
            "huber": (
                "robust estimation after Huber: large residuals get less weight, "
                "but never none"
            ),
            "tukey": (
                "robust estimation after Tukey (biweight): large residuals get less "
                "weight, very large ones none"
            ),
        }
    ),
    "screening": mark_each(
        {
            "propagated": (
                "limit from the propagated precision of the difference of two coverages"
            ),
            "practice_1968": (
                "three standard errors as estimated from all differences, as in the "
                "double coverages of 1968"
            ),
            "off": "coverages are not compared",
        }
    ),
    "model_deformation": mark_each(
        {
            "modelled": ("deformations are modelled if a test finds them"),
            "tested": ("deformations are tested for and reported, but not modelled"),
            "ignored": "neither tested for nor modelled",
        }
    ),
    "earth_curvature": mark_each(
        {
            "treated": (
                "models are corrected for the curvature of the Earth and the scale "
                "of the map, if crs is given"
            ),
            "ignored": (
                "not corrected: the measuring program has done it, or the "
                "coordinates are those of a plane"
            ),
        }
    ),
    "variance_components": mark_each(
        {
            "given": ("errors of control and flights as given in block.toml"),
            "estimated": (
                "errors of control and flights as estimated from their residuals"
            ),
        }
    ),
    "residual_distribution": mark_each(
        {
            "none": ("residuals of control points are not distributed"),
            "natural_neighbour": (
                "each point receives those of its natural neighbours, weighted by area"
            ),
            "inverse_distance": (
                "each point receives those of all control points, weighted by 1 / "
                "distance²"
            ),
            "multiquadric": (
                "a smooth surface of Hardy's multiquadrics through all residuals"
            ),
        }
    ),
    "tolerance": mark_each(
        {
            "none": "no point is judged by a limit",
            "vermv_1994": (
                "7 cm: densification points in the Austrian surveying ordinance of "
                "1994, § 7"
            ),
            "vermv_2010": (
                "4 cm: survey points in the Austrian surveying ordinance of 2010, § 6"
            ),
            "vermv_2016": (
                "4 cm: points that are not measured by GNSS in the Austrian "
                "surveying ordinance of 2016, § 6; at control points 5 cm"
            ),
        }
    ),
    "transformation": mark_each(
        {
            "affine": (
                "affine transformation in plan: six parameters, each axis with its "
                "own scale and direction; needs 3 points"
            ),
            "helmert": (
                "similarity (Helmert) transformation in plan: shift, rotation and "
                "one scale; needs 2 points"
            ),
            "rigid": ("shift and rotation in plan, the scale is kept; needs 2 points"),
            "helmert_3d": (
                "spatial Helmert transformation: three shifts, three rotations and "
                "one scale; gives heights; needs 3 points"
            ),
        }
    ),
    "orientation_case": mark_each(
        {
            "independent": ("both bundles of rays rotate, the base stays"),
            "dependent_left": ("only the left bundle rotates and shifts"),
            "dependent_right": ("only the right bundle rotates and shifts"),
        }
    ),
    "orientation_method": mark_each(
        {
            "least_squares": ("least squares of all parallaxes, after Hallert"),
            "krames": (
                "formulas of Krames from two base-normal planes, without normal "
                "equations"
            ),
            "gruber": ("the optical-mechanical procedure of Gruber, point by point"),
        }
    ),
    "model_unit": mark_each(
        {
            "mm": "millimetres",
            "cm": "centimetres",
            "m": "metres",
            "um": "micrometres",
        }
    ),
    "convention": mark_each(
        {
            "opencv": ("a camera as OpenCV has it: pixels, from the upper left corner"),
            "metashape": (
                "a camera as Metashape has it: pixels, from the middle of the image"
            ),
            "mm": ("a metric camera as its calibration has it: millimetres"),
            "micmac": (
                "a camera as MicMac has it: pixels, distorted about a centre of its own"
            ),
        }
    ),
}


def explained_settings(term):
    """Explain a setting, or a value of settings: one text for each; none of others."""
    wanted = folded(term)
    texts = [_setting(name) for name in names_of_settings() if folded(name) == wanted]
    for name, values in VALUES.items():
        texts += [_value(name, one) for one in values if folded(one) == wanted]
    return texts


def names_of_settings():
    """Names of the settings that are explained here: all but those of tables."""
    return (*Settings.model_fields, *KEYS)


def settings_with_values():
    """Each setting with the values that it may have by name, as a line of a list."""
    lines = []
    for name in names_of_settings():
        values = ", ".join(VALUES.get(name, ()))
        lines.append(f"{name}: {values}" if values else name)
    return lines


def names_of_values():
    """Every value that a setting may have by name, once."""
    return tuple(dict.fromkeys(one for values in VALUES.values() for one in values))


def _setting(name):
    known = Settings.model_fields.get(name)
    said = translated(KEYS[name] if known is None else known.description)
    lines = [translated("{name} (setting)", name=name), f"  {said}"]
    for value, meaning in VALUES.get(name, {}).items():
        lines.append(f"  {value}: {translated(meaning)}")
    if known is not None and known.default not in ("", None):
        lines.append("  " + translated("default: {value}", value=str(known.default)))
    if known is not None:
        option = "--" + name.replace("_", "-")
        lines.append("  " + translated(PLACE, option=option))
    return "\n".join(lines)


def _value(name, value):
    title = translated("{value} (value of {name})", value=value, name=name)
    return f"{title}\n  {translated(VALUES[name][value])}"
