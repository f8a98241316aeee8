"""assessment.json: findings, and objects in the facts of each."""

from einschalt.foundations.result_files.part import FLIGHT, Part

FINDING = Part(
    places=("findings[]",),
    names={
        "code": "name of the finding, for einschalt explain CODE",
        "subject": "what the finding is about",
        "gravity": "how serious the finding is, as a number",
        "names": (
            "the models, points, flights or images that it is about, the worst first, "
            "at most 100"
        ),
        "statistic": "what was compared, in English; empty if nothing was",
        "observed": (
            "value of the statistic in SI units (lengths in metres, also in the "
            "image); null if there is none"
        ),
        "expected": (
            "expected value of the statistic, in the same unit; null if there is none"
        ),
        "probability": (
            "p-value: probability of a statistic this far from the expected one by "
            "chance; null if none was computed"
        ),
        "untested": "why something could not be tested; empty if it was tested",
        "remedy": (
            "code of the remedy, for einschalt explain CODE; empty if there is nothing "
            "to do, or the summary words one for each case"
        ),
        "facts": (
            "numbers and names that belong to the finding; which ones depends on the "
            "code"
        ),
        "explained_by": (
            "code of the finding that explains this one; empty if none does"
        ),
    },
    values={
        "subject": {
            "block": "the whole block",
            "flight": "one or both flights",
            "model": "single models",
            "point": "single points",
            "control point": "single control points, or all of them",
            "measurement": "single measurements",
        },
        "gravity": {
            "0": "note: nothing is wrong with the result",
            "1": "warning: part of the result is weak, or not checked",
            "2": (
                "grave: the stated precision is not supported, or coordinates are wrong"
            ),
        },
        "untested": {
            "no_check_points": "the block has no check points",
            "control_without_standard_errors": (
                "the control points have no standard errors"
            ),
        },
    },
)

FACT_MODELS = Part(
    places=("findings[].facts.critical", "findings[].facts.weak"),
    names={
        "n_models": "number of models",
        "models": "these models, each as [flight, model_id], at most 100",
    },
)

FACT_FLIGHTS = Part(
    places=("findings[].facts.flights[]",),
    names={
        "flight": FLIGHT,
        "given_um": "m_g as given, TOTAL [µm]",
        "estimated_um": "m_g as the measurements show it, TOTAL [µm]",
        "standard_error_um": "standard error of estimated_um [µm]",
        "far_out": (
            "share of the image points beyond three standard errors of the good ones; "
            "0.0027 is expected"
        ),
        "good_sigma_0": (
            "standard error of the good image coordinates, in the image [m]"
        ),
        "share": "share of the image points that are worse",
        "times_as_large": "how many times as large their errors are",
        "stretch": "affinity: relative excess of x over y",
        "stretch_error": "standard error of stretch",
        "shear": (
            "affinity: by how much the angle between x and y is smaller than a right "
            "angle [rad]"
        ),
        "shear_error": "standard error of shear [rad]",
        "bias": "error in a model that the affinity causes, TOTAL, RMS [m]",
        "axes": "axes that x and y are",
        "size": "displacement of the points by the curvature, TOTAL, RMS [m]",
    },
    values={
        "axes": {
            "machine": "as the model was measured",
            "ground": "easting and northing, whichever way models were turned",
        },
    },
)

FACT_TESTS = Part(
    places=("findings[].facts.rejected[]", "findings[].facts.tests[]"),
    names={
        "quantity": "quantity that was tested, by the names of claim.tests[]",
        "kind": "kind of the quantity; absent for heights",
        "n_points": "number of points",
        "observed": (
            "observed value: RMS, TOTAL in plan; without unit for correlation and "
            "region [m]"
        ),
        "predicted": "value that the stated precision predicts, in the same unit [m]",
        "p_value": (
            "probability of a value this large if the stated precision is correct; "
            "absent for heights"
        ),
    },
    values={
        "kind": {
            "correlation": "correlation of neighbouring residuals, without unit",
            "region": "shift of a region over its standard error, without unit",
            "residuals": "RMS of the residuals of the low flight",
            "rms": "RMS of the other differences",
        },
    },
)

FACT_EXCHANGES = Part(
    places=("findings[].facts.exchanges[]",),
    names={
        "flight": FLIGHT,
        "coverage": "coverage of the model in which the names are exchanged",
        "model_id": "model in which the names are exchanged",
        "points": "names of these points, mostly two, at most 100",
        "measured_as": "name under which each of them was measured",
        "n_points": "number of these points",
        "last": "last of these points in the model",
        "is_slip": "whether the names of successive rows have slipped by one",
        "apart": (
            "largest distance of a point from the one whose name it has; null if one "
            "of them has no coordinates [m]"
        ),
        "is_by_other_flight": (
            "whether the other flight shows it, and not the fit of the model: then "
            "both m_0 are the distance of the two points from where that flight has "
            "them, RMS"
        ),
        "m_0": "m_0 of the model as measured, TOTAL [m]",
        "m_0_exchanged": "m_0 of the model with the names put right, TOTAL [m]",
        "is_everywhere": (
            "whether several models of the flight contain both points, and all of them "
            "have them exchanged"
        ),
        "images": (
            "photograph in which the names are exchanged; two if nothing tells which"
        ),
        "models": (
            "models with a point of the pair in such a photograph, each as [coverage, "
            "model_id]"
        ),
        "sigma_0": (
            "sigma_0 of the model that it spoils most, as measured, in the image; null "
            "if it could not be oriented [m]"
        ),
        "sigma_0_exchanged": (
            "sigma_0 of that model with the names put right, in the image [m]"
        ),
        "takes_part": (
            "whether these points take part in the computation; false if data snooping "
            "has removed them"
        ),
    },
)

FACT_TARGETS = Part(
    places=("findings[].facts.targets[]",),
    names={
        "point_id": "name of the point",
        "distance": "distance between both targets [m]",
        "n_models": "number of models of the low flight that show it",
        "flight": "flight that measured another target; empty if nothing tells which",
        "p_value": "p-value of the clearest model, among all residuals (Bonferroni)",
    },
)

FACT_WRONG_POINTS = Part(
    places=("findings[].facts.wrong_points[]",),
    names={
        "point_id": "name of the point",
        "easting": "how far it is given too far to the east, by its models [m]",
        "northing": "how far it is given too far to the north, by its models [m]",
        "size": "length of that shift [m]",
        "standard_error": "standard error of each coordinate of the shift [m]",
        "n_models": (
            "number of models that agree about the point; of coverages where models "
            "share photographs"
        ),
        "control_is_alike": "whether control gives the point as wrong",
        "exchanged_with": (
            "point at whose given place it lies, while that one lies at its own; empty "
            "without one"
        ),
    },
)

FACT_REASONS = Part(
    places=("findings[].facts.reasons[]",),
    names={
        "flight": FLIGHT,
        "reason": "why the models failed, in English",
        "remedy": "what to do about it, in English; empty if there is nothing to do",
        "n_models": "number of models",
        "models": "their model_id, at most 10",
    },
)

PARTS = (
    FINDING,
    FACT_MODELS,
    FACT_FLIGHTS,
    FACT_TESTS,
    FACT_EXCHANGES,
    FACT_TARGETS,
    FACT_WRONG_POINTS,
    FACT_REASONS,
)
