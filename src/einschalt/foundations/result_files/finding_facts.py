"""assessment.json: facts of findings; which of them one has depends on its code."""

from einschalt.foundations.result_files.part import Part

FACTS = Part(
    places=("findings[].facts",),
    names={
        "n_points": (
            "number of points that the finding is about, or that were compared; of "
            "measurements_given_twice those with equal coordinates"
        ),
        "n_models": (
            "number of models that the finding is about; of failed_models all that "
            "were measured; of drift findings all usable ones"
        ),
        "n_control": (
            "number of control points that were examined; of displaced_region those in "
            "the region"
        ),
        "n_observations": "number of measurements that the finding is about",
        "observations": (
            "the worst measurements, each as [flight, coverage, model_id, point_id]"
        ),
        "models": (
            "the worst models, each as [flight, model_id]; of imprecise_points their "
            "model_id alone"
        ),
        "image_points": "the worst image points, each as [flight, model_id, point_id]",
        "flights": "one object for each flight that the finding is about",
        "flight": (
            "flight that is worst; of other_targets the one that measured another "
            "target, empty if nothing tells which"
        ),
        "largest": (
            "largest of the residuals, differences, distances, standard errors or "
            "moves that the finding is about; TOTAL in plan, with the height if it has "
            "one [m]"
        ),
        "median": "median of all points, TOTAL [m]",
        "rms": "differences at the known points, TOTAL, RMS [m]",
        "rms_exchanged": (
            "the same with the names of the control points put right, TOTAL, RMS [m]"
        ),
        "slipped_rows": (
            "number of rows by which names of a list have slipped, 0 if they have not"
        ),
        "last": "last of these points in the list",
        "lost": "point whose coordinates are not given, empty if there is none",
        "nameless": (
            "name under which the coordinates of a point stand that is not in the "
            "list, empty if there is none"
        ),
        "given_as": "name under which the coordinates of each of the points are given",
        "claimed": (
            "expected RMS of these differences by the stated precision, TOTAL; of "
            "strained_network the TOTAL of the new points [m]"
        ),
        "claimed_with_strain": (
            "TOTAL of the new points with the strain added; null if their figure is "
            "not known [m]"
        ),
        "ratio": (
            "observed over expected size: differences at known points, m_0 of the high "
            "flight, or coordinates of a model"
        ),
        "ratio_to_claimed": (
            "displacement by the block's own pull over the stated precision"
        ),
        "n_far": (
            "number of points that contradict the stated precision each by itself, "
            "while the others do not; otherwise 0"
        ),
        "n_others": "number of the other check points",
        "rms_of_others": (
            "RMS of the other points alone, of all if n_far is 0, TOTAL; null if there "
            "are none [m]"
        ),
        "miss": "how far the worst control point lies from its given coordinates [m]",
        "away": (
            "how far the new point under the other name lies from these given "
            "coordinates; null if none lies there [m]"
        ),
        "role": (
            "role of the points whose mean difference is not zero, or of the one whose "
            "height is far off"
        ),
        "easting": "component to the east of the shift, step or mean difference [m]",
        "northing": "component to the north of the shift, step or mean difference [m]",
        "size": (
            "length of the shift or of the pattern in control; of strained_network the "
            "RMS, TOTAL; without unit for heights_out_of_scale [m]"
        ),
        "moved": (
            "how far the new points are moved by it, RMS, TOTAL in plan or height; of "
            "drift findings the sum over all passes [m]"
        ),
        "kind": "kind of the pattern",
        "is_beside_given": (
            "whether it is approximate points, which agree among themselves, that "
            "control contradicts"
        ),
        "is_told_apart": (
            "whether errors of all points that are larger by one factor do not explain "
            "it as well"
        ),
        "per_cent": (
            "of heights_out_of_scale the error of the height scale, of "
            "unseen_height_scale the one that would be noticed, of stretched_models "
            "the stretch [%]"
        ),
        "moved_per_cent": (
            "how far one per cent of it moves the heights of the new points, RMS [m]"
        ),
        "principal_distance_mm": (
            "of heights_out_of_scale the principal distance that would explain it; "
            "null if flights have none, or several [mm]"
        ),
        "largest_per_cent": "largest stretch that film can have [%]",
        "reach": "distance over which the displacements keep their direction [m]",
        "displacements": (
            "the largest displacements, each as [point_id, easting, northing], in "
            "metres"
        ),
        "points": (
            "points of the region, those nearest to its middle first, at most 100"
        ),
        "n_given": "number of all given points of that kind",
        "given": "what is displaced, by the name of its table",
        "height_of": "whose height is wrong, by the name of its table",
        "where": "part of all these points in which the region lies",
        "part_is_told": (
            "whether it is known that the region is displaced, and not the others"
        ),
        "standard_error": "standard error of each coordinate of the shift [m]",
        "middle_easting": "easting of the middle of the region [m]",
        "middle_northing": "northing of the middle of the region [m]",
        "extent": "largest extent of the region along easting or northing [m]",
        "control": (
            "control points in the region, at most 100; of a region of control the "
            "check points that are displaced with it"
        ),
        "control_is_alike": (
            "whether the control points in the region are displaced as well"
        ),
        "is_scattered": "whether the points of the region lie among the others",
        "wrong_points": (
            "the approximate points that are wrong, one object for each, the worst "
            "first, at most 100"
        ),
        "further_regions": "the other displaced regions, each with the same names",
        "rejected": "tests that contradict the stated precision, one object for each",
        "tests": "tests whose value is smaller than predicted, one object for each",
        "believed": "standard error of the heights to use, RMS [m]",
        "has_images": "whether the flight was measured in photographs",
        "bend": "height error of flat models on curved ground [m]",
        "stated": (
            "stated standard error of the heights; of wrong_control_errors that of "
            "control in plan, TOTAL, RMS [m]"
        ),
        "shown": "the same as the residuals show it [m]",
        "error_of_shown": "standard error of shown [m]",
        "unit": "unit that would explain the stated figure; empty if it would be none",
        "propagated": (
            "propagated TOTAL of the new points, RMS; null if errors were not "
            "propagated [m]"
        ),
        "paper": "TOTAL of the new points by Kovarik's M, RMS [m]",
        "internal": (
            "TOTAL of the new points, from the differences of the coverages, RMS [m]"
        ),
        "propagated_once": (
            "propagated TOTAL of the new points after the first pass, RMS; null if "
            "errors were not propagated [m]"
        ),
        "propagated_now": (
            "propagated TOTAL of the new points after the last pass, RMS; null if "
            "errors were not propagated [m]"
        ),
        "n_models_held": "number of models that contain a held control point",
        "m_0": "m_0 of all models of the high flight together, TOTAL [m]",
        "explained": "m_0 that the given errors explain, TOTAL [m]",
        "m_0_corrected": (
            "m_0 of the flight with the correction by y-parallaxes, TOTAL [m]"
        ),
        "m_0_uncorrected": (
            "m_0 of the flight without the correction by y-parallaxes, TOTAL [m]"
        ),
        "largest_m_0": "largest m_0 of a model, TOTAL [m]",
        "times_usual": (
            "limit: multiple of the usual value beyond which a point or model is "
            "reported"
        ),
        "largest_sigma_0": (
            "largest sigma_0 of a relative orientation, in the image [m]"
        ),
        "critical": (
            "models on a dangerous surface: their points do not determine the "
            "orientation"
        ),
        "weak": (
            "models near a dangerous surface: their points hardly determine the "
            "orientation"
        ),
        "inflation": (
            "largest standard error of omega over that on flat terrain; null if it is "
            "infinite"
        ),
        "s_0": "standard error of unit weight; 1 if the errors are as large as given",
        "redundancy": "redundancy of the adjustment",
        "worst": "point with the largest displacement",
        "belief": "which method is better founded, and why",
        "check_rms_simultaneous": (
            "differences at the check points in the simultaneous adjustment, TOTAL, "
            "RMS; null if there are too few [m]"
        ),
        "check_rms_two_steps": (
            "differences at the check points in the two steps, TOTAL, RMS; null if "
            "there are too few [m]"
        ),
        "n_undecided": (
            "number of points whose measurements contradict each other, so that all "
            "are reported"
        ),
        "undecided": "names of these points, at most 100",
        "are_alike": (
            "whether the control points that were set aside are wrong in the same way, "
            "so that the others may be wrong instead"
        ),
        "are_many": (
            "whether so many control points were set aside that the others may be "
            "wrong instead"
        ),
        "n_exchanges": (
            "number of models with exchanged names; of photographs, number of pairs"
        ),
        "exchanges": "models, or pairs in photographs, the worst first, at most 100",
        "takes_part": (
            "whether one of the exchanged pairs takes part in the computation"
        ),
        "explains": "codes of the findings that this one explains",
        "targets": (
            "the points, one object for each, those farthest apart first, at most 100"
        ),
        "n_pairs": "number of pairs of models or photographs that are copies",
        "pairs": (
            "these pairs, each as two lists [flight, coverage, model or image], at "
            "most 10"
        ),
        "enlargement": (
            "factor by which the errors of means are larger because of the copies"
        ),
        "n_failed": "number of models that could not be computed",
        "n_reasons": "number of different reasons",
        "reasons": "models by flight and reason, the most frequent first, at most 20",
        "n_mirrored": "number of mirrored models",
        "n_affine": "number of models with an affine transformation",
        "diameter": "diameter of the median model on the ground [m]",
        "scale_number": "scale number of that flight, as given",
        "on_film_mm": "diameter of the median model in its photograph [mm]",
        "largest_mm": "largest diagonal of a photograph [mm]",
        "found": "scale number from image coordinates and ground coordinates",
        "n_in_one_model": "how many of the points lie in one model only",
        "widest_um": "largest standard deviation of a pointing among these points [µm]",
        "note": "what was ignored, filled in or reprojected while reading, in English",
    },
    values={
        "role": {
            "check": "check points",
            "control": "control points",
        },
        "kind": {
            "point": "one point by itself",
            "step": "all points on one side of a line",
            "group": "points among the others, all by the same: a list",
            "bend": "a quadratic strain",
            "scale": "heights of models against those of control",
        },
        "given": {
            "approximate_points": "given approximate points",
            "control_points": "control points",
        },
        "height_of": {
            "approximate_points": "given approximate points",
            "control_points": "control points",
        },
        "where": {
            "north": "in the north",
            "north_east": "in the north-east",
            "east": "in the east",
            "south_east": "in the south-east",
            "south": "in the south",
            "south_west": "in the south-west",
            "west": "in the west",
            "north_west": "in the north-west",
            "middle": "in the middle",
            "scattered": "scattered among the others",
        },
        "belief": {
            "check_points_simultaneous": (
                "check points agree better with the simultaneous adjustment"
            ),
            "check_points_two_steps": "check points agree better with the two steps",
            "deformation_left": "a deformation was found and is not modelled",
            "models_differ": "each model is deformed in its own way",
            "deformation_modelled": "a deformation is modelled, and none is left",
            "own_deformations_modelled": "the deformation of each model is modelled",
            "untested": "there is too little redundancy to test for deformation",
            "no_deformation": "no deformation was found",
        },
    },
)

PARTS = (FACTS,)
