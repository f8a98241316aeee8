"""assessment.json: whether the stated precision is supported, and the tolerance."""

from einschalt.foundations.result_files.part import Part

CLAIM = Part(
    places=("claim", "height_claim"),
    names={
        "tests": (
            "one object for each quantity that was tested; empty if nothing could be "
            "tested, and in claim of a simultaneous adjustment"
        ),
        "assumption": "what the prediction only assumes; empty if nothing",
        "untested_regions": (
            "why displaced regions of given approximate points were not looked for; "
            "empty if they were, or if there is no need"
        ),
        "detectable_shift": (
            "how far a region may be displaced without being found; null if none was "
            "looked for, or one was found"
        ),
        "paper": (
            "coverage differences against Kovarik's budget; null if there are no such "
            "differences or no budget, in a simultaneous adjustment and in "
            "height_claim"
        ),
    },
    values={
        "assumption": {
            "independent_approximations": (
                "the errors of given approximate coordinates are independent"
            ),
            "perfect_orientations": "relative orientations are free of error",
        },
        "untested_regions": {
            "orientations": "errors of relative orientations bend the models",
            "too_many": "there are too many approximate points for the test",
        },
    },
)

CLAIM_TEST = Part(
    places=(
        "claim.tests[]",
        "claim.paper",
        "height_claim.tests[]",
        "height_claim.paper",
    ),
    names={
        "name": "quantity that was tested",
        "n_points": "number of points",
        "observed": (
            "observed value: RMS, TOTAL in plan; without unit if is_length is false [m]"
        ),
        "predicted": "value that the stated precision predicts, in the same unit [m]",
        "p_value": (
            "probability of a value this large if the stated precision is correct; "
            "two-sided for the residuals if approximate_m_0_m is given"
        ),
        "is_length": (
            "whether observed and predicted are metres; false for the correlation and "
            "for the shift over its standard error"
        ),
    },
    values={
        "name": {
            "coverage differences": "differences of the coverages of the low flight",
            "coverage differences, high flight": (
                "differences of the coverages of the high flight"
            ),
            "residuals of the low flight": (
                "residuals of the low flight, mean of the models of each point"
            ),
            "correlation of neighbouring residuals": (
                "Moran's I of the residuals of neighbouring points"
            ),
            "shift of a region / standard error": (
                "shift of the clearest region of given approximate points over its "
                "standard error"
            ),
            "control points, each left out": (
                "control points, each predicted from all others"
            ),
            "check points": "densified minus given at check points",
            "control points": (
                "densified minus given at control points that took no part"
            ),
        },
    },
)

SHIFT = Part(
    places=("claim.detectable_shift", "height_claim.detectable_shift"),
    names={
        "median": (
            "shift of a region of at least a tenth of the points that is found in 80 "
            "of 100 cases: median of all such regions; null if nothing ties them to "
            "the others [m]"
        ),
        "largest": (
            "the same for the region that is determined worst; null if nothing ties it "
            "to the others [m]"
        ),
    },
)

KNOWN_POINTS = Part(
    places=("known_points",),
    names={
        "differences": (
            "densified minus given coordinates, each as [quantity, number of points, "
            "RMS in metres (TOTAL)]; quantities without points are left out"
        ),
        "left_out": (
            "control points, each predicted from all others; null if none could be "
            "left out"
        ),
    },
    values={
        "differences": {
            "control points": "control points",
            "control points, each left out": (
                "control points, each predicted from all others"
            ),
            "check points": "check points",
        },
    },
)

LEFT_OUT = Part(
    places=("known_points.left_out",),
    names={
        "normalized_square": (
            "mean of the squared differences over their expected value; 1 if the "
            "standard errors are correct"
        ),
        "worst": "up to three points with the smallest p-value, the smallest first",
        "largest": "difference at the first of these points, TOTAL [m]",
    },
)

TOLERANCE_FACTS = Part(
    places=("tolerance",),
    names={
        "tolerance": "limits that were asked for",
        "figure": "figure that decides whether a point passes",
        "roles": "points that pass and fail, one object for each role",
        "suspects": (
            "points that do not pass because a gross error is suspected, the first 100"
        ),
        "n_suspects": "number of all these points",
        "n_control_beyond": (
            "number of control points with a difference beyond "
            "tolerance.tolerance.control; null if no such limit is set, or without "
            "control"
        ),
        "n_control": "number of control points",
    },
)

TOLERANCE = Part(
    places=("tolerance.tolerance",),
    names={
        "title": 'ordinance that sets the limits, or "as set"',
        "point": "largest standard error that a point may have, TOTAL [m]",
        "control": "largest difference at a control point; null if none is set [m]",
    },
)

CHECKED_FIGURE = Part(
    places=("tolerance.figure",),
    names={
        "column": (
            "column of points that is compared with the limit, times factor; empty if "
            "no figure is known"
        ),
        "factor": (
            "factor by which that column is enlarged, since measurements exceed it; at "
            "least 1"
        ),
        "is_supported": (
            "whether the measurements support the figure; if not, no point passes"
        ),
        "is_tested": "whether any measurement could have contradicted the figure",
        "is_told": (
            "if regions are displaced: whether it is known which points lie in them; "
            "otherwise true"
        ),
    },
    values={
        "column": {
            "standard_error_total": "the propagated error",
            "standard_error_paper": "the error by Kovarik's budget",
        },
    },
)

ROLE = Part(
    places=("tolerance.roles[]",),
    names={
        "role": "role of the points",
        "n_pass": "number of points within the tolerance",
        "n_fail": "number of points beyond the tolerance",
        "largest": (
            "largest standard_error_checked of these points, TOTAL; null if none is "
            "known [m]"
        ),
    },
    values={
        "role": {
            "new": "new points",
            "control": "control points",
            "check": "check points",
        },
    },
)

PARTS = (
    CLAIM,
    CLAIM_TEST,
    SHIFT,
    KNOWN_POINTS,
    LEFT_OUT,
    TOLERANCE_FACTS,
    TOLERANCE,
    CHECKED_FIGURE,
    ROLE,
)
