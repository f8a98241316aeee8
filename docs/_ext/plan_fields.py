"""Fields of the classes of plans, on their pages of the Python interface.

Their sources say them in comments, which no page shows. Types and defaults are those of
the classes; a test asks for every field.
"""

import dataclasses

import einschalt as es

OF_BOTH = {
    "kind": "how models are fitted: affine, helmert or rigid",
    "image_format": "side of the image, or its sides along and across the strip [m]",
    "principal_distance": "principal distance [m]",
    "forward_overlap": "overlap of consecutive images, 0 to 1",
    "side_overlap": "overlap of neighbouring strips, 0 to 1",
    "control_standard_error": "TOTAL error of control in plan [m]",
}
FIELDS = {
    "FlightDesign": {
        "scale_number": "denominator of the image scale of the low flight",
        "spacing": "mean distance of points [m]",
        "m_g_um": "TOTAL error of a point measured in the low flight, in the image "
        "[µm]; of the mean, where it is set several times",
        **OF_BOTH,
        "n_coverages": "coverages of both flights, 1 to 4",
        "coverage_shift": "shift of a coverage against the one before, in bases; "
        "1/n_coverages if left out",
        "high_scale_number": "denominator of the high flight; 1.875 times that of the "
        "low flight if left out, as in 1971",
        "high_m_g_um": "m_g of the high flight [µm]; that of the low flight if "
        "left out",
        "control_per_model": "control points in each high-flight model, 5 or 9",
        "width": "extent of the area from west to east [m]; enough for three "
        "high-flight images if left out",
        "height": "the same from south to north [m]",
        "most_work": "size of the layout (values times pairs of models at a point) "
        "beyond which its points are thinned",
    },
    "PlanChoices": {
        "scale_number": "denominators of the image scale of the low flight",
        "spacing": "mean distances of points [m]",
        "m_g_um": "TOTAL errors of one pointing in the low flight, in the image [µm]",
        "high_over_low": "scale number of the high flight over that of the low flight",
        "n_settings": "pointings at each point, in both flights",
        "n_coverages": "coverages of both flights; one shows no gross error",
        "control_per_model": "control points in each high-flight model, 5 or 9",
    },
    "PlanFrame": {
        **OF_BOTH,
        "high_over_low_m_g": "m_g of the high flight over that of the low flight",
        "costs": "prices by which plans are ranked: PlanCosts",
        "max_height": "height above ground that both flights keep below [m]; None: no "
        "limit",
        "sampled_um": "size of a pixel in the image [µm], for the GSD; None: film",
        "shares_control": "whether control lies where it serves most models, as in a "
        "plan over an area, and not in the corners of every neat model",
        "extent": "length and width [m] and size [m²] of the ground, whose border "
        "takes models and control as well; None: endless",
    },
    "PlanCosts": {
        "image": "price of an image that is flown",
        "model": "price of a model that is oriented",
        "setting": "price of a pointing at a point",
        "control_point": "price of a control point that is surveyed",
    },
}


def attributes_of(name):
    """Section of numpydoc with the fields of a class: a list of lines."""
    lines = ["", "Attributes", "----------"]
    for field in dataclasses.fields(getattr(es, name)):
        kind = getattr(field.type, "__name__", None) or str(field.type)
        if not isinstance(field.type, type):
            kind = str(field.type)
        lines += [f"{field.name} : {kind}{_default(field)}"]
        lines.append(f"    {_capital(FIELDS[name][field.name])}.")
    return lines


def _default(field):
    if field.default is not dataclasses.MISSING:
        return f", default {field.default!r}"
    if field.default_factory is not dataclasses.MISSING:
        return f", default {field.default_factory.__name__}()"
    return ""


def _capital(text):
    is_word = text[:2].islower()
    return text[:1].upper() + text[1:] if is_word and "_" not in text[:4] else text


def add_fields(_app, what, name, _object, _options, lines):
    """Add the fields to the docstring of a class that has them here."""
    short = name.rpartition(".")[2]
    if what == "class" and short in FIELDS:
        lines += attributes_of(short)


def setup(app):
    """Add them before numpydoc reads the docstring."""
    app.connect("autodoc-process-docstring", add_fields, priority=100)
    return {"parallel_read_safe": True}
