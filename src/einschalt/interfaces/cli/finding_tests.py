"""How each finding is tested, and what may be done: for ``einschalt explain``."""

from einschalt.foundations.language import mark_each

TESTS = mark_each(
    {
        "exchanged_names": (
            "Whether m_0 of a model that fits badly becomes usual when the names of "
            "two of its points are exchanged, when those of successive rows move by "
            "one row, or after two or three exchanges. And whether both flights have "
            "two points at each other's place."
        ),
        "exchanged_image_names": (
            "Each model with a bad relative orientation is oriented again for every "
            "pair of its points, exchanged in either photograph: sigma_0 must come "
            "down to 3 times the median of the flight and to a fifth, in all models of "
            "the photograph."
        ),
        "exchanged_control": (
            "Control that an adjustment of all models in plan refuses: whether points "
            "lie where others of them are given, to a fifth of their distance; and "
            "whether the block with the names put right misses its control by a fifth "
            "of what it did."
        ),
        "control_under_another_name": (
            "Whether a new point lies where a control point is given that itself lies "
            "elsewhere."
        ),
        "kept_gross_measurements": (
            "What the other models of the flight contradict in a simultaneous "
            "adjustment of it; and which findings are gone without these "
            "measurements, or that nothing but weak geometry is found."
        ),
        "other_targets": (
            "Whether all models of the low flight, each fitted without the point, "
            "agree that it lies elsewhere than in the high flight."
        ),
        "wrong_approximate_points": (
            "The correction of each approximate point in an adjustment of all models "
            "onto them, the worst taken out one by one, against chance in all of them "
            "together and the median of all; the models that hold the point must "
            "agree about it."
        ),
        "displaced_region": (
            "The shift of round regions of all sizes, of all on one side of lines, and "
            "of bands, in an adjustment of all models onto control, or onto the "
            "approximate points, against chance in all of them together; without it no "
            "smooth pattern may be left."
        ),
        "measurements_given_twice": (
            "Whether points of two models or photographs have identical coordinates "
            "to the last digit."
        ),
        "models_in_another_unit": (
            "The scale of each model on the ground against the median of its flight, "
            "if three quarters of at least 4 models agree within a factor of 2.5."
        ),
        "models_larger_than_film": (
            "The diameter of the median model on the ground, divided by scale_number, "
            "against the diagonal of the largest film."
        ),
        "scale_numbers_contradicted": (
            "The scale of the photographs, from image coordinates and ground, against "
            "scale_number."
        ),
        "stretched_models": (
            "The common ratio of the scales of both axes against the largest that "
            "film can have."
        ),
        "failed_models": (
            "Whether the orientation and the transformation of each model can be "
            "computed."
        ),
        "points_without_coordinates": (
            "Whether each measured point of the low flight is in a usable model."
        ),
        "orientations_without_convergence": (
            "Whether the iterations of the relative orientation come to rest."
        ),
        "models_near_a_dangerous_surface": (
            "The standard error of omega against that on flat terrain."
        ),
        "image_points_that_contradict": (
            "The residual of each image point of a relative orientation, standardized."
        ),
        "ambiguous_orientations": (
            "Whether a second orientation fits about as well as the first."
        ),
        "orientations_with_large_sigma_0": (
            "sigma_0 of each orientation against the median of its flight."
        ),
        "corrections_that_spoil": (
            "m_0 of the flight with the corrections against m_0 without them."
        ),
        "models_upside_down": (
            "Whether a spatial model fits only when it is turned over."
        ),
        "lone_wrong_check_point": (
            "Whether the check points agree with the stated precision when the worst "
            "of them is left out."
        ),
        "suspect_check_points": (
            "The difference at each check point against its standard error, that of "
            "the given coordinates included."
        ),
        "control_against_block": (
            "The correction that the adjustment gives to each control point, against "
            "its standard error."
        ),
        "control_set_aside": (
            "The correction that the adjustment gives to each control point, against "
            "its standard error; of several points, whether they are off in one "
            "direction, as independent errors are not, and whether they are more than "
            "two fifths of the control, or with heights that stand out more than a "
            "quarter of it."
        ),
        "control_that_contradicts": (
            "Each control point is predicted without itself; the difference is "
            "compared with its standard error."
        ),
        "claim_that_does_not_stand": (
            "Residuals, differences of coverages, known points and the correlation of "
            "neighbours against what the stated precision predicts."
        ),
        "check_points_beyond_claim": (
            "RMS of the differences at the check points against the stated precision "
            "and their own standard errors."
        ),
        "adjustment_that_misfits": "s_0 of the adjustment against 1.",
        "deformed_models": (
            "Whether the residuals of models have a common second-order pattern, and "
            "which method predicts known points better."
        ),
        "block_that_shrinks": (
            "The displacement of the new points by that against their standard errors."
        ),
        "drift_without_control": (
            "The number of control points in the low flight that hold the repeated "
            "transformations."
        ),
        "iterations_that_spoil": (
            "The propagated precision after all iterations against that after one."
        ),
        "drift_that_nothing_tells": (
            "The share of models with control; the precision cannot be propagated."
        ),
        "check_points_better_than_claim": (
            "RMS of the differences at the check points against the stated precision "
            "and their own standard errors."
        ),
        "control_points_beyond_claim": (
            "RMS of the differences at the control points against the stated "
            "precision and their own standard errors."
        ),
        "shifted_block": (
            "The mean difference at check points, or at control points, against 0."
        ),
        "heights_out_of_scale": (
            "Whether height differences at control points that were left out grow "
            "with the height; without a high flight, residuals at the given points."
        ),
        "broken_heights": (
            "Whether height differences at control points that were left out, or "
            "corrections of heights in the adjustment of all models, have a step or a "
            "bend."
        ),
        "wrong_control_height": (
            "Whether a single control point that was left out explains the height "
            "differences."
        ),
        "lone_wrong_height": (
            "Each height of a known point that took no part, against its standard "
            "error; the others agree with theirs and are nearer than chance makes them."
        ),
        "heights_beyond_claim": (
            "Differences of height at check points and at control that was left out, "
            "against their standard errors."
        ),
        "unseen_height_scale": (
            "The error of the scale of model heights that would be noticed in 80 of "
            "100 cases, against 0.02, and what it does to the new points against the "
            "stated precision of their heights."
        ),
        "bent_models": (
            "Terms of a lens, or quadratic heights, that all models of a flight share, "
            "in an adjustment of all of them (F test)."
        ),
        "curvature_untold": (
            "What the curvature of the Earth would bend heights by in a model, "
            "against their standard error."
        ),
        "high_flight_that_misfits": (
            "m_0 of the high flight against what m_g_um and the errors of control "
            "explain."
        ),
        "contradicted_propagation": (
            "The larger of the paper's and the internal figure against the propagated "
            "one."
        ),
        "contradicted_budget": (
            "The internal figure, from differences of coverages, against Kovarik's "
            "budget."
        ),
        "wrong_control_errors": (
            "The residuals of control, or its differences when it is left out, against "
            "their stated errors; then the errors with which one adjustment has the "
            "residuals that it should have."
        ),
        "coverages_that_agree_too_well": (
            "RMS of the differences of coverages against what the stated errors let "
            "expect."
        ),
        "wrong_measuring_errors": (
            "m_g as estimated from the residuals (variance components) against m_g_um."
        ),
        "image_points_worse_than_given": (
            "m_g as estimated from the residuals of relative orientation against "
            "m_g_um."
        ),
        "image_points_better_than_given": (
            "m_g as estimated from the residuals of relative orientation against "
            "m_g_um, and the residuals of the flight in one adjustment, or the "
            "differences of its coverages, against what m_g_um explains."
        ),
        "heavy_tails_of_image_points": (
            "The share of residuals beyond three standard errors of the good points "
            "against that of a normal distribution."
        ),
        "settings_that_scatter": (
            "The spread of repeated pointings at all points of a flight against m_g_um."
        ),
        "scattered_points": (
            "The spread of the repeated pointings at each point against m_g_um."
        ),
        "film_affinity": (
            "A common stretch and shear in the residuals of all models of a flight."
        ),
        "curved_models": (
            "Quadratic and cubic terms of each flight, in an adjustment of all models "
            "with control, against a strain of the control network."
        ),
        "strained_network": (
            "Whether the displacements of control points are larger than their "
            "standard errors, and alike among neighbours."
        ),
        "broken_network": (
            "Whether the corrections of the control points have a step or a bend."
        ),
        "contradicting_control": (
            "The corrections of all control points against their standard errors; "
            "where approximate points agree among themselves, what two steps onto "
            "these miss control by, but for a similarity."
        ),
        "gross_measurements": (
            "The residual of each measurement in an adjustment of all models of its "
            "flight."
        ),
        "suspect_observations": (
            "The residual of each point of a transformation, standardized, and "
            "whether the worst stands out of all."
        ),
        "coverages_that_differ": (
            "The difference of the coverages of each point against its standard error "
            "(setting screening)."
        ),
        "points_that_differ": (
            "spread_total of each point against the median of all, and against its "
            "propagated size."
        ),
        "imprecise_points": (
            "The standard error of each new point against the median of all."
        ),
        "models_with_large_m_0": (
            "m_0 of each model against that of its flight, and against its propagated "
            "size."
        ),
        "all_models_mirrored": (
            "The sign of the determinant of each affine transformation."
        ),
        "mirrored_models": (
            "The sign of the determinant of each affine transformation."
        ),
        "points_in_one_coverage": "The number of coverages of each point.",
        "points_in_one_model": "The number of models of each point.",
        "models_without_redundancy": "The redundancy of each transformation.",
        "no_check_points": (
            "The number of check points; without them the precision is checked from "
            "inside only."
        ),
        "figure_left_out": (
            "Whether the sizes of all errors are stated, which propagation needs."
        ),
        "note_of_reading": ("Nothing: it reports what was done with a file."),
    }
)
# codes of remedies: of the summary, or of the table below
REMEDIES_OF = {
    "exchanged_names": ("put_the_names_right", "compare_names_of_both_flights"),
    "exchanged_image_names": ("put_the_names_right",),
    "exchanged_control": ("exchange_control_names", "put_control_names_right"),
    "control_under_another_name": ("correct_control_name",),
    "kept_gross_measurements": ("measure_again_or_snoop",),
    "other_targets": ("compare_targets",),
    "wrong_approximate_points": ("correct_or_take_out_points",),
    "displaced_region": (
        *("correct_region_or_give_group", "correct_control", "compare_both_parts"),
    ),
    "measurements_given_twice": ("take_copies_out",),
    "models_in_another_unit": ("convert_these_models",),
    "models_larger_than_film": ("look_at_units_and_scale_number",),
    "scale_numbers_contradicted": ("look_at_units_of_control", "correct_scale_number"),
    "stretched_models": ("look_at_units_of_each_axis",),
    "failed_models": ("see_each_reason",),
    "points_without_coordinates": ("look_at_their_models",),
    "orientations_without_convergence": ("look_for_gross_errors_of_orientation",),
    "models_near_a_dangerous_surface": ("measure_points_elsewhere",),
    "image_points_that_contradict": (
        "measure_again_or_snoop",
        "taken_out",
        "weighted_down",
    ),
    "ambiguous_orientations": ("measure_more_points",),
    "orientations_with_large_sigma_0": ("look_for_gross_errors_of_orientation",),
    "corrections_that_spoil": ("turn_sign_of_y_parallax",),
    "models_upside_down": ("turn_sign_of_x_or_y",),
    "lone_wrong_check_point": ("check_lone_point", "correct_check_name"),
    "suspect_check_points": ("check_far_points",),
    "control_against_block": ("check_control_or_snoop",),
    "control_set_aside": ("check_control", "check_all_control"),
    "control_that_contradicts": ("check_worst_control",),
    "claim_that_does_not_stand": (
        "doubt_sizes_of_errors",
        "doubt_independence",
        "doubt_check_points_too",
        "doubt_far_control",
        "shared_errors_as_stated",
        "shared_errors_beyond_stated",
    ),
    "check_points_beyond_claim": ("check_far_points", "trust_check_points"),
    "adjustment_that_misfits": (
        "look_for_names_control_and_units",
        "give_larger_errors",
    ),
    "deformed_models": ("believe_the_two_steps",),
    "block_that_shrinks": ("give_control_on_the_far_side",),
    "drift_without_control": ("one_pass_or_measure_control",),
    "iterations_that_spoil": ("one_pass_or_more_control",),
    "drift_that_nothing_tells": ("one_pass_or_more_control",),
    "check_points_better_than_claim": ("give_smaller_errors",),
    "control_points_beyond_claim": (
        "check_far_points",
        "look_for_wrong_control",
        "state_control_errors",
    ),
    "shifted_block": ("look_at_reference_system",),
    "heights_out_of_scale": ("check_principal_distance",),
    "broken_heights": ("check_height_network",),
    "wrong_control_height": ("check_that_height",),
    "lone_wrong_height": ("check_lone_height",),
    "heights_beyond_claim": ("check_heights",),
    "unseen_height_scale": ("make_sure_of_principal_distance",),
    "bent_models": ("calibrate",),
    "curvature_untold": ("give_system",),
    "high_flight_that_misfits": ("look_for_gross_errors_or_give_larger_ones",),
    "contradicted_propagation": ("raise_m_g",),
    "contradicted_budget": ("raise_m_g",),
    "wrong_control_errors": (
        "check_unit_of_control_errors",
        "give_that_standard_error",
    ),
    "coverages_that_agree_too_well": ("look_for_copies_or_lower_m_g",),
    "wrong_measuring_errors": (
        "look_for_gross_errors",
        "check_scale_and_independence",
        "give_that_m_g",
    ),
    "image_points_worse_than_given": ("give_that_m_g_or_a_larger_one",),
    "image_points_better_than_given": ("give_a_smaller_m_g",),
    "heavy_tails_of_image_points": (
        "weigh_wrong_points_down",
        "wrong_points_weigh_less",
    ),
    "settings_that_scatter": ("give_at_least_that_m_g",),
    "scattered_points": ("set_again",),
    "film_affinity": ("set_affine",),
    "curved_models": ("adjust_or_calibrate",),
    "strained_network": ("check_network_or_adjust", "check_network"),
    "broken_network": (
        "correct_control",
        "compare_both_parts",
        "check_network_in_parts",
    ),
    "contradicting_control": ("look_for_wrong_control_or_raise_errors",),
    "gross_measurements": ("measure_rejected_again",),
    "suspect_observations": (
        "measure_again_or_snoop",
        "measure_excluded_again",
        "measure_again",
    ),
    "coverages_that_differ": ("measure_again_see_coverages",),
    "points_that_differ": ("look_for_gross_errors_and_exchanged_names",),
    "imprecise_points": ("measure_more_control_there",),
    "models_with_large_m_0": ("look_at_residuals",),
    "all_models_mirrored": ("exchange_axes_unless_left_handed",),
    "mirrored_models": ("look_for_exchanged_names",),
    "points_in_one_coverage": ("nothing_confirms_them",),
    "points_in_one_model": ("nothing_confirms_them",),
    "models_without_redundancy": ("gross_errors_cannot_be_seen",),
    "no_check_points": ("give_check_points",),
    "figure_left_out": ("give_standard_errors_of_control",),
    "note_of_reading": ("read_what_was_done",),
}
# of findings whose remedies the summary words for each block
FURTHER_REMEDIES = mark_each(
    {
        "see_each_reason": ("Each reason in the summary has a remedy of its own"),
        "set_affine": ('Set transformation = "affine" for these flights'),
        "read_what_was_done": (
            "Read what was done, and change the file if it is wrong"
        ),
    }
)
