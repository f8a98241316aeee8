"""assessment.json: figures of precision, and where errors come from."""

from einschalt.foundations.result_files.part import Part

PRECISION = Part(
    places=("precision",),
    names={
        "single": "figures of one value of a point; two steps only",
        "mean": "figures of the mean of all values of a point; two steps only",
        "n_new": "number of new points",
        "n_coverages": "number of coverages of the low flight",
        "coverage_mean": (
            "setting coverage_mean: which values form the mean of a point; two steps "
            "only"
        ),
        "carried": "which errors were propagated; null if none were; two steps only",
        "shared": (
            "error common to several points that Kovarik's M does not include; two "
            "steps only"
        ),
        "heights": "precision of the heights; null if the points have no heights",
        "total": (
            "propagated TOTAL of the new points, RMS; null if unstated says why; "
            "simultaneous only [m]"
        ),
        "two_steps": (
            "figures of the mean in the two steps; null if they are not possible; "
            "simultaneous only"
        ),
        "impossible": (
            "why the two steps are not possible, as an English sentence; empty if they "
            "are; simultaneous only"
        ),
        "two_steps_keep_set_aside": (
            "whether the two steps hold control points that the adjustment set aside; "
            "simultaneous only"
        ),
        "comparison": (
            "differences between the coordinates by both methods; null if no point has "
            "both; simultaneous only"
        ),
        "has_high_flight": "whether the block has a high flight; simultaneous only",
        "s_0": (
            "standard error of unit weight; 1 if the errors are as large as given; "
            "simultaneous only"
        ),
        "redundancy": "redundancy of the adjustment; simultaneous only",
        "is_oriented": (
            "whether errors of relative orientations are included; simultaneous only"
        ),
        "estimated": (
            "groups of measurements whose errors were estimated, each as [group, "
            "standard error of a coordinate in metres]; null if all were taken as "
            "given; simultaneous only"
        ),
        "height_errors": (
            "error of measured heights as the residuals show it, each as [flight, "
            "standard error in metres]; simultaneous only"
        ),
        "n_centres": (
            "number of photographs whose projection centres tie the models; "
            "simultaneous only"
        ),
        "unstated": (
            "why no standard errors are given, in English; empty if they are; "
            "simultaneous only"
        ),
    },
    values={
        "coverage_mean": {
            "all": "the values of all models",
            "most_central": "per coverage the value of the most central model",
        },
        "carried": {
            "control and measurements": (
                "errors of control and of the measurements in the models"
            ),
            "and those of the orientations by y-parallaxes": (
                "errors of control, of the measurements and of relative "
                "orientations by y-parallaxes"
            ),
            "image points through relative orientation": (
                "errors of control and of image points, through relative orientation"
            ),
            "errors of approximate points and of the low flight": (
                "errors of given approximate points and of measurements in the low "
                "flight"
            ),
        },
        "shared": {
            "the transformation of the high flight": (
                "error of the transformation of the high flight"
            ),
            "what a model lacks on its control points": (
                "absolute-orientation error of each model of the low flight"
            ),
            "errors of given neighbouring points, as they were stated": (
                "errors common to neighbouring approximate points, of stated size"
            ),
            "errors of given neighbouring points, of unknown size": (
                "errors common to neighbouring approximate points, of unknown size"
            ),
            "shifts of groups of given points, which no residual shows": (
                "shifts of groups of given points, of unknown size"
            ),
        },
        "unstated": {
            "points were moved by the distribution of residuals": (
                "residual_distribution has moved the points after the adjustment"
            ),
        },
    },
)

PRECISION_FIGURES = Part(
    places=("precision.single", "precision.mean", "precision.two_steps"),
    names={
        "total": (
            "propagated TOTAL, RMS; null if errors were not propagated, and always in "
            "precision.single [m]"
        ),
        "paper": "TOTAL by Kovarik's M, RMS; null if it is not known [m]",
        "internal": (
            "TOTAL from the differences of the coverages, RMS; null without such "
            "differences [m]"
        ),
    },
)

PRECISION_HEIGHTS = Part(
    places=("precision.heights",),
    names={
        "total": (
            "standard error of the heights of the new points, RMS; null if it is not "
            "known [m]"
        ),
        "is_from_images": (
            "whether all flights are measured in images; otherwise the errors of "
            "measured heights are estimated from the differences of the models"
        ),
    },
)

COMPARISON = Part(
    places=("precision.comparison",),
    names={
        "rms": "coordinates of both methods, differences in plan, RMS [m]",
        "largest": "largest of these differences [m]",
        "worst": "point with the largest difference",
    },
)

ERROR_SOURCES = Part(
    places=("error_sources",),
    names={
        "sources": "one object for each source, the largest first",
        "total": "TOTAL of the new points from all sources together, RMS [m]",
        "total_with_half_the_largest": "the same if the largest source were halved [m]",
    },
)

SOURCE = Part(
    places=("error_sources.sources[]",),
    names={
        "source": "source of error",
        "total": "TOTAL of the new points from this source alone, RMS [m]",
        "share": "share of the variance, from 0 to 1",
    },
    values={
        "source": {
            "control": "given coordinates of the control points",
            "control_groups": "shifts of groups of control points",
            "approximate_points": "given approximate points",
            "approximate_groups": "shifts of groups of approximate points",
            "high_flight": "measurements in the high flight",
            "low_flight": "measurements in the low flight",
            "orientation": "relative orientation",
            "reference_system": "operation between reference systems",
            "own_deformation": "deformation of each model",
            "shared_bend": "bend that all models of a flight share",
        },
    },
)

NEIGHBOURS = Part(
    places=("neighbours",),
    names={
        "n_pairs": "number of pairs of neighbouring points",
        "median_distance": "median distance of the pairs [m]",
        "total": "propagated TOTAL of the coordinate difference of a pair, RMS [m]",
        "total_if_independent": "the same if the points shared no error [m]",
    },
)

PARTS = (
    PRECISION,
    PRECISION_FIGURES,
    PRECISION_HEIGHTS,
    COMPARISON,
    ERROR_SOURCES,
    SOURCE,
    NEIGHBOURS,
)
