"""assessment.json: errors that models or control points have in common."""

from einschalt.foundations.result_files.part import FLIGHT, Part

PATTERN_FACTS = Part(
    places=("patterns",),
    names={
        "patterns": "what was found",
        "untested": (
            "why strain of control was not tested; null if it was, or if there is "
            "nothing to report"
        ),
        "size": "size of a block that is too large, in English; otherwise empty",
    },
    values={
        "untested": {
            "errors of orientations bend models": (
                "errors of the orientations bend models, which would be mistaken "
                "for strain"
            ),
            "and the simultaneous adjustment knows their size": (
                "the same, but a simultaneous adjustment knows the size of these "
                "errors and tests each control point"
            ),
            "the block is too large": "the block is too large for the test",
        },
    },
)

PATTERNS = Part(
    places=("patterns.patterns",),
    names={
        "affinities": (
            "affinity that the models of a flight have in common, one object for each "
            "flight"
        ),
        "strain": (
            "pattern in the errors of the control points; null if it was not tested"
        ),
    },
)

AFFINITY = Part(
    places=("patterns.patterns.affinities[]",),
    names={
        "flight": FLIGHT,
        "stretch": "relative excess of x over y in the measured coordinates",
        "shear": (
            "by how much the angle between x and y is smaller than a right angle [rad]"
        ),
        "stretch_error": "standard error of stretch",
        "shear_error": "standard error of shear [rad]",
        "p_value": "p-value of the joint test of stretch and shear",
        "is_absorbed": "whether the transformation absorbs it, as affine does",
        "axes": "axes that x and y are",
        "bias": "error in a model that it causes if it is not absorbed, TOTAL, RMS [m]",
    },
    values={
        "axes": {
            "machine": "as the model was measured",
            "ground": "easting and northing, whichever way models were turned",
        },
    },
)

STRAIN = Part(
    places=("patterns.patterns.strain",),
    names={
        "size": "displacements of the control points, TOTAL, RMS [m]",
        "reach": "distance over which the displacements keep their direction [m]",
        "p_value": "p-value of the test against errors of the given sizes",
        "is_smooth": "whether larger errors of single points do not explain it as well",
        "n_control": "number of control points",
        "displacements": (
            "estimated displacement of each control point, the largest first"
        ),
    },
)

DISPLACEMENT = Part(
    places=("patterns.patterns.strain.displacements[]",),
    names={
        "point_id": "name of the control point",
        "easting": "displacement to the east [m]",
        "northing": "displacement to the north [m]",
    },
)

DEFORMATION = Part(
    places=("deformation",),
    names={
        "flights": (
            "deformation that the models of a flight share, one object for each flight"
        ),
        "belief": "which method is better founded, and why",
        "own_p_value": (
            "p-value of the test for deformations that each model has for itself; null "
            "if it was not tested"
        ),
        "is_spatial": (
            "whether the models are spatial: deformations that they share are told by "
            "what they do to heights"
        ),
        "is_shared_tested": (
            "whether deformations that all models of a flight share were tested"
        ),
        "is_own_detected": "whether deformations of single models were found",
        "is_own_modelled": "whether deformations of single models are modelled",
        "are_photographs": (
            "whether these are deformations of single photographs, which standard "
            "errors hold and coordinates are not corrected for"
        ),
        "check_rms_simultaneous": (
            "differences at the check points in the simultaneous adjustment, TOTAL, "
            "RMS; null if there are too few [m]"
        ),
        "check_rms_two_steps": (
            "differences at the check points in the two steps, TOTAL, RMS; null if "
            "there are too few [m]"
        ),
    },
    values={
        "belief": {
            "check points agree with the simultaneous adjustment": (
                "check points agree better with the simultaneous adjustment"
            ),
            "check points agree with the two steps": (
                "check points agree better with the two steps"
            ),
            "a deformation was found and is not modelled": (
                "the two steps are better founded"
            ),
            "models are deformed each in its own way": (
                "the two steps are better founded"
            ),
            "a deformation is modelled and nothing is left": (
                "the simultaneous adjustment is better founded"
            ),
            "what each model is deformed by for itself is modelled": (
                "the simultaneous adjustment is better founded"
            ),
            "photographs are bent for themselves, and errors include it": (
                "neither method is better founded"
            ),
            "too little redundancy to test for deformation": (
                "neither method is better founded"
            ),
            "no deformation shows": "the simultaneous adjustment is better founded",
        },
    },
)

FLIGHT_DEFORMATION = Part(
    places=("deformation.flights[]",),
    names={
        "flight": FLIGHT,
        "p_value": (
            "p-value of the test for a deformation that all models share; null if it "
            "was not tested"
        ),
        "size_middle": (
            "size of the shared deformation in the middle of the models, TOTAL, RMS; "
            "null if it was not tested [m]"
        ),
        "size_edge": (
            "size of the shared deformation at the edge of the models, TOTAL, RMS; "
            "null if it was not tested [m]"
        ),
        "is_modelled": "whether the shared deformation is modelled",
        "neighbour_correlation": (
            "correlation of the residuals of neighbouring points in a model, after "
            "what was modelled; null if it is not known"
        ),
        "own_edge": (
            "size of the deformations of single models at their edge, TOTAL in plan, "
            "RMS; 0 if none was found, null if they were not tested [m]"
        ),
        "own_edge_height": "the same in height; 0 for plane models [m]",
    },
)

CONTROL_STRAIN = Part(
    places=("control_strain",),
    names={
        "suspects": (
            "control points that the simultaneous adjustment contradicts, the worst "
            "first, at most 20; absent if none is suspect by itself"
        ),
        "n_suspects": "number of all these points; absent together with suspects",
        "is_set_aside": (
            "whether some of them take no part in the adjustment; absent together with "
            "suspects"
        ),
        "displacements": (
            "control points that a smooth strain displaces most, at most 8, each as "
            "[point_id, easting, northing], in metres; absent if single points are "
            "suspect"
        ),
        "n_control": (
            "number of control points that the strain was estimated from; absent "
            "together with displacements"
        ),
    },
)

SUSPECT_CONTROL = Part(
    places=("control_strain.suspects[]",),
    names={
        "point_id": "name of the control point",
        "easting": "error of the given easting that would explain it [m]",
        "northing": "error of the given northing that would explain it [m]",
        "height": "error of the given height that would; null in plan [m]",
        "w": "test statistic: error over its standard error",
        "p_value": "p-value of the test",
    },
)

PARTS = (
    PATTERN_FACTS,
    PATTERNS,
    AFFINITY,
    STRAIN,
    DISPLACEMENT,
    DEFORMATION,
    FLIGHT_DEFORMATION,
    CONTROL_STRAIN,
    SUSPECT_CONTROL,
)
