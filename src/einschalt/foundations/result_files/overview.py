"""assessment.json: the block, the method, and the figure to use."""

from einschalt.foundations.result_files.part import Part

FILE = Part(
    places=("",),
    names={
        "block": "the block by name, size and settings",
        "choice": 'which method was kept, and why; null unless method = "auto"',
        "better": "the other method, if it is known to be better; otherwise null",
        "is_untried": (
            "whether a simultaneous adjustment may be better and was not computed; "
            "always false in a simultaneous adjustment"
        ),
        "causes": (
            "codes of the findings that explain others, the one that explains most "
            "first"
        ),
        "findings": "problems and notes, the most serious first",
        "credible": "the figure of the new points to use, and why",
        "credible_heights": (
            "the figure of the heights to use; null if the points have no heights"
        ),
        "claim_is_supported": (
            "whether nothing contradicts the stated precision and no finding is grave; "
            "null if nothing tests it"
        ),
        "precision": "all figures of the new points, by method",
        "spread": (
            "distribution of the standard errors if a few points dominate the RMS; "
            "otherwise null"
        ),
        "claim": "tests of the stated precision in plan against the measurements",
        "height_claim": (
            "tests of the stated precision of the heights against the measurements"
        ),
        "known_points": "densified minus given coordinates at control and check points",
        "flights": "what each flight measured, and how well its models fit",
        "approximations": "origin and precision of the approximate coordinates",
        "repeated_settings": (
            "m_g from repeated pointings, one object for each flight that has them"
        ),
        "patterns": "affinity of film and strain of control",
        "error_sources": (
            "contribution of each source to the error of the new points; null if "
            "errors were not propagated"
        ),
        "neighbours": (
            "precision of coordinate differences between neighbouring points; null if "
            "errors were not propagated"
        ),
        "iterations": (
            "passes of the low flight onto its own coordinates; null if one pass was "
            "asked for"
        ),
        "distribution": (
            "moves of the points by the distribution of residuals; null if residuals "
            "were not distributed"
        ),
        "tolerance": "which points keep the tolerance; null without a tolerance",
        "deformation": (
            "deformations of the models in a simultaneous adjustment; null if nothing "
            "was tested"
        ),
        "control_strain": (
            "control points that contradict the block, or a strain of their network; "
            "null if none was found, or nothing was tested"
        ),
    },
)

BLOCK = Part(
    places=("block",),
    names={
        "name": "name of the block",
        "crs": "reference system of the block; null if none was given",
        "n_models": "number of models of all flights, as measured",
        "n_failed_models": "number of models that could not be computed",
        "chosen_settings": (
            "settings that differ from the defaults, each as [name, value]"
        ),
    },
)

CHOICE = Part(
    places=("choice", "better"),
    names={
        "method": "method that was kept (choice), or that is better (better)",
        "reason": "why this method was selected",
        "two_step": "the figure of the two steps; null if they are not possible",
        "simultaneous": (
            "the figure of the simultaneous adjustment; null if it is not possible"
        ),
        "obstacle": (
            "why the other method is not possible, as an English sentence; empty if it "
            "is"
        ),
        "n_two_step": (
            "new points of the two steps; null if only one method is possible"
        ),
        "n_simultaneous": "new points of the simultaneous adjustment; likewise",
    },
    values={
        "method": {
            "two_step": "the two-step method of Kovarik 1971",
            "simultaneous": "the simultaneous adjustment of all models",
        },
        "reason": {
            "only_way": "the other method is not possible",
            "supported": (
                "the measurements contradict the figure of the other method only"
            ),
            "smaller": "its figure is the smaller one",
            "more_models": "the figures are alike, and it uses more models",
            "more_points": "the other method leaves many points without coordinates",
            "wrong_control": (
                "one adjustment shows what a wrong control point does, which the two "
                "steps of one flight do not test"
            ),
            "heights": (
                "the heights of the other method are known to be much worse, by more "
                "than its plan is better"
            ),
            "left_out": (
                "the measurements contradict its figure, but control points that "
                "were left out lie nearer to it"
            ),
            "contradicted": (
                "the measurements contradict the figures of both methods, so the "
                "default is kept"
            ),
            "known_points": (
                "sizes of errors are not known, but known points that took no part, "
                "or were left out, lie nearer to it"
            ),
            "only_figure": "the other method has no figure",
            "no_figure": (
                "neither method has a figure, or both lack the same error, so the "
                "default is kept"
            ),
        },
    },
)

CREDIBLE = Part(
    places=(
        "credible",
        "choice.two_step",
        "choice.simultaneous",
        "better.two_step",
        "better.simultaneous",
    ),
    names={
        "value": (
            "TOTAL of the new points, RMS: the figure to use; null if none is known [m]"
        ),
        "is_lower_bound": (
            "whether the points may be worse than value by an unknown amount"
        ),
        "column": "column of points that states the standard error of single points",
        "factor": (
            "factor by which that column is enlarged for single points; at least 1"
        ),
        "reason": "why this is the figure to use",
        "doubt": (
            "why the coordinates of the whole block are doubtful; empty if they are not"
        ),
        "elsewhere": (
            "value for the points that no displaced region has moved, and that no "
            "model with a wrong approximate point holds; null without any of these, or "
            "if nothing tells which part is displaced; beside a new point under the "
            "name of left_aside the figure with that put right [m]"
        ),
        "left_aside": (
            "names of the known points that the figure leaves aside, the worst first: "
            "they took no part and are far off, as no other known point is"
        ),
        "left_aside_by": (
            "how far the first of them is off, TOTAL; null without one [m]"
        ),
    },
    values={
        "column": {
            "standard_error_total": "the propagated error",
            "standard_error_paper": (
                "the error by Kovarik's budget; in a simultaneous adjustment: no "
                "error is known, and there is no such column"
            ),
        },
        "reason": {
            "propagated": (
                "the propagated figure: it includes errors that points share, and "
                "nothing contradicts it"
            ),
            "contradicted": (
                "measurements contradict the propagated figure; value is a lower bound"
            ),
            "budget": (
                "Kovarik's budget: nothing else is known, and nothing contradicts it"
            ),
            "assumed": (
                "errors of given approximate points are assumed to be independent, "
                "and nothing contradicts that"
            ),
            "budget_contradicted": (
                "measurements contradict Kovarik's budget; value is a lower bound"
            ),
            "stated": (
                "the stated errors of approximate points are included, which models "
                "have absorbed and residuals do not show"
            ),
            "adjusted": "the figure of the simultaneous adjustment",
            "adjusted_unknown": (
                "the simultaneous adjustment gives no figure, since the size of an "
                "error is unknown"
            ),
            "adjusted_enlarged": (
                "the figure of the simultaneous adjustment, enlarged since its "
                "residuals show larger errors"
            ),
            "adjusted_contradicted": (
                "known points, residuals, control or deformed models contradict the "
                "simultaneous adjustment; value is a lower bound"
            ),
            "unknown": "no figure is known",
            "displaced": (
                "a region of given points is displaced, and its effect is added to "
                "the rest"
            ),
            "wrong_points": (
                "single given points are wrong, and their effect is added to the rest"
            ),
            "exchanged_control": (
                "control points are under each other's name, and the effect is added "
                "to the figure with the names put right"
            ),
            "exchanged_names": (
                "points of a model were measured under each other's name, and the "
                "effect is added to the figure with the names put right"
            ),
        },
        "doubt": {
            "mirrored": (
                "all models are mirrored, and no reference system tells the axes apart"
            ),
            "stretched": (
                "one axis of the models is stretched against the other by more than "
                "film or paper can be"
            ),
            "upside_down": "nearly all spatial models are upside down",
            "larger_than_film": (
                "models are larger than a photograph of the given scale"
            ),
            "out_of_scale": (
                "the photographs of all flights contradict the scale of the ground "
                "coordinates"
            ),
        },
    },
)

HEIGHTS = Part(
    places=("credible_heights",),
    names={
        "value": (
            "standard error of the heights of the new points, RMS: the figure to use; "
            "null if none is known [m]"
        ),
        "is_lower_bound": (
            "whether the heights may be worse than value by an unknown amount"
        ),
        "factor": (
            "factor by which standard_error_height of single points is enlarged; at "
            "least 1"
        ),
    },
)

SPREAD = Part(
    places=("spread",),
    names={
        "rms": "TOTAL of the new points (standard_error_checked), RMS [m]",
        "median": "the same, median [m]",
        "most": "the same, 95 % quantile: 95 of 100 points are better [m]",
    },
)

PARTS = (
    FILE,
    BLOCK,
    CHOICE,
    CREDIBLE,
    HEIGHTS,
    SPREAD,
)
