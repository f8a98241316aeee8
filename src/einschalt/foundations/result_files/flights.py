"""assessment.json: flights, approximate coordinates, and how points moved."""

from einschalt.foundations.result_files.part import FLIGHT, Part

EACH_FLIGHT = Part(
    places=("flights[]",),
    names={
        "name": FLIGHT,
        "scale_number": "denominator of the image scale, as given",
        "transformation": "transformation of the models onto the ground",
        "n_models": "number of models, as measured",
        "n_usable": "number of models that were transformed and take part",
        "m_g_um": "m_g as given, TOTAL, in the image [µm]",
        "m_g_ground": "m_g as given, TOTAL, on the ground [m]",
        "m_0": "m_0 of all models together, TOTAL; null if it is not known [m]",
        "orientation": (
            "relative orientations of the flight; null if nothing was oriented"
        ),
        "shown_m_g": (
            "m_g as the measurements of both flights show it; null if they do not"
        ),
        "is_curved": (
            "whether models were corrected for the curvature of the Earth or the scale "
            "of the map"
        ),
    },
    values={
        "transformation": {
            "affine": "affine transformation in plan",
            "helmert": "similarity transformation in plan",
            "rigid": "shift and rotation in plan, without a scale",
            "helmert_3d": "spatial similarity transformation",
        },
    },
)

ORIENTATION = Part(
    places=("flights[].orientation",),
    names={
        "n_models": "number of models that were oriented",
        "sigma_0": (
            "standard error of one observation (image coordinate or y-parallax), all "
            "models together, in the image; null without redundancy [m]"
        ),
        "is_from_images": (
            "whether the models were oriented from image coordinates; otherwise from "
            "y-parallaxes"
        ),
        "image_points": (
            "m_g of the image points as given and as their residuals show it; null "
            "without images or without redundancy"
        ),
        "m_g_intersection_um": (
            "part of m_g of a model point that comes from the intersection of rays, "
            "RMS over the models; null if it is not known [µm]"
        ),
        "m_g_orientation_um": (
            "part of m_g of a model point that comes from errors of the orientation, "
            "RMS over the models; null if it is not known [µm]"
        ),
    },
)

COMPONENT = Part(
    places=("flights[].shown_m_g", "flights[].orientation.image_points"),
    names={
        "given": "m_g as given, TOTAL [µm]",
        "estimated": "m_g as the measurements show it, TOTAL [µm]",
        "standard_error": "standard error of estimated [µm]",
    },
)

APPROXIMATIONS = Part(
    places=("approximations",),
    names={
        "n_points": "number of approximate points",
        "is_given": "whether they were given; otherwise the high flight was computed",
        "total": (
            "their TOTAL, as stated or from the differences of the coverages of the "
            "high flight; null if it is not known [m]"
        ),
    },
)

REPEATED = Part(
    places=("repeated_settings[]",),
    names={
        "flight": FLIGHT,
        "n_points": "number of points that were set several times",
        "n_settings": "number of their pointings together",
        "m_g_um": "m_g of one pointing as given, TOTAL [µm]",
        "m_g_settings_um": (
            "m_g of one pointing as the pointings of a point show it, TOTAL [µm]"
        ),
        "standard_error_um": "standard error of m_g_settings_um [µm]",
        "is_larger": "whether m_g_settings_um is significantly larger than m_g_um",
        "is_smaller": "whether m_g_settings_um is significantly smaller than m_g_um",
        "settings_each": "mean number of pointings at a point",
        "mean_if_rest_is_model_um": (
            "m_g of the mean of a point's pointings, if the rest of the given m_g "
            "comes from film, lens and model, TOTAL [µm]"
        ),
        "mean_as_taken_um": "m_g of that mean as it was assumed, m_g / √k, TOTAL [µm]",
        "m_g_that_makes_it_so_um": (
            "m_g to give so that the mean has mean_if_rest_is_model_um [µm]"
        ),
    },
)

ITERATIONS = Part(
    places=("iterations",),
    names={
        "moves": (
            "moves of the points, each pass as [pass, largest move in metres, point, "
            "RMS in metres]"
        ),
        "is_converged": "whether the passes ended because nothing moved any more",
        "least_move": "move below which the passes end [m]",
        "most_passes": "maximum number of passes, as set",
        "n_held": "number of control points that were held",
        "n_models_held": "number of models that contain a held control point",
        "n_models": "number of usable models of the low flight",
        "total_of_one_pass": (
            "propagated TOTAL of the new points after the first pass, RMS; null if "
            "errors were not propagated [m]"
        ),
        "total": (
            "propagated TOTAL of the new points after the last pass, RMS; null if "
            "errors were not propagated [m]"
        ),
    },
)

DISTRIBUTION = Part(
    places=("distribution",),
    names={
        "way": "setting residual_distribution",
        "moves": (
            "moves of the points, each role as [role, number of points, RMS in metres, "
            "largest in metres]"
        ),
        "is_propagated": "whether the moved points have propagated standard errors",
    },
    values={
        "way": {
            "natural_neighbour": "from the natural neighbours, weighted by area",
            "inverse_distance": "from all control points, weighted by 1 / distance²",
            "multiquadric": "a smooth surface of Hardy's multiquadrics",
        },
    },
)

PARTS = (
    EACH_FLIGHT,
    ORIENTATION,
    COMPONENT,
    APPROXIMATIONS,
    REPEATED,
    ITERATIONS,
    DISTRIBUTION,
)
