"""What each finding is, and what causes it: for ``einschalt explain``."""

from einschalt.foundations.language import mark_each

# each with what the summary lists it for
MEANINGS = mark_each(
    {
        "exchanged_names": (
            "Points of a model that were measured under each other's name."
        ),
        "exchanged_image_names": (
            "Two points of a photograph that were measured under each other's name."
        ),
        "exchanged_control": ("Control points lie where others of them are given."),
        "control_under_another_name": (
            "A control point lies far from where it is given, and a new point lies "
            "there."
        ),
        "kept_gross_measurements": (
            "Gross errors that take part in the computation, and spoil what is near "
            "them."
        ),
        "other_targets": (
            "Points for which the two flights have measured different targets."
        ),
        "wrong_approximate_points": (
            "Single given approximate points that lie elsewhere by all models that "
            "hold them."
        ),
        "displaced_region": (
            "Regions whose control points, or given approximate points, are displaced "
            "together, all of each by the same vector, against all others."
        ),
        "measurements_given_twice": (
            "Models or photographs that are copies of others."
        ),
        "models_in_another_unit": (
            "Models of flights with y-parallaxes whose coordinates are larger or "
            "smaller than those of the other models."
        ),
        "models_larger_than_film": (
            "Flights whose models no photograph of their scale holds: wrong units."
        ),
        "scale_numbers_contradicted": (
            "Flights whose photographs have another scale than their scale number."
        ),
        "stretched_models": (
            "Models of which one axis is stretched more than film can be."
        ),
        "failed_models": (
            "Models that gave no transformation, counted by their reason."
        ),
        "points_without_coordinates": (
            "Points that the low flight measured and no usable model holds."
        ),
        "orientations_without_convergence": (
            "Models whose relative orientation did not come to rest."
        ),
        "models_near_a_dangerous_surface": (
            "Models whose points hardly determine their relative orientation."
        ),
        "image_points_that_contradict": ("Image points that contradict their pair."),
        "ambiguous_orientations": (
            "Pairs whose points do not tell two orientations apart."
        ),
        "orientations_with_large_sigma_0": (
            "Models whose relative orientation fits far worse than those of their "
            "flight."
        ),
        "corrections_that_spoil": (
            "Flights whose models fit better without the correction by y-parallaxes."
        ),
        "models_upside_down": (
            "Spatial models that had to be turned over: mirror images of flat terrain."
        ),
        "lone_wrong_check_point": (
            "A single check point that makes the differences of all of them too large."
        ),
        "suspect_check_points": (
            "Check points that contradict the claim each by itself, though all of "
            "them together do not."
        ),
        "control_against_block": (
            "Control points that the simultaneous adjustment of all models contradicts."
        ),
        "control_set_aside": (
            "Control points that contradict the simultaneous adjustment and take no "
            "part in it."
        ),
        "control_that_contradicts": (
            "Control points that the others miss by more than chance explains."
        ),
        "claim_that_does_not_stand": (
            "Measurements that contradict what the claimed figure predicts."
        ),
        "check_points_beyond_claim": (
            "Differences at check points that are larger than the claimed figure."
        ),
        "adjustment_that_misfits": (
            "Residuals of the simultaneous adjustment that the given errors do not "
            "explain."
        ),
        "deformed_models": (
            "Models that are deformed, which one adjustment of all accumulates."
        ),
        "block_that_shrinks": (
            "A simultaneous adjustment that control does not hold against its own pull."
        ),
        "drift_without_control": (
            "A low flight that is repeated on its own coordinates, with no control "
            "point to hold it."
        ),
        "iterations_that_spoil": (
            "Iterations that make the points worse than one pass."
        ),
        "drift_that_nothing_tells": (
            "Iterations of which no figure shows how far the block has drifted."
        ),
        "check_points_better_than_claim": (
            "Differences at check points that are smaller than the claimed figure."
        ),
        "control_points_beyond_claim": (
            "Control points that the densified coordinates miss by more than is "
            "claimed."
        ),
        "shifted_block": (
            "Differences at known points with a mean that chance does not explain: "
            "drift."
        ),
        "heights_out_of_scale": (
            "Flights whose model heights do not have the scale of the given ones."
        ),
        "broken_heights": (
            "Control heights of which one part lies apart from the other, or bent ones."
        ),
        "wrong_control_height": (
            "The height of one control point that the others contradict."
        ),
        "lone_wrong_height": (
            "The height of a single known point that took no part and is far off, as "
            "no other is."
        ),
        "heights_beyond_claim": (
            "Heights of known points that are missed by more than the claim predicts."
        ),
        "unseen_height_scale": (
            "Given heights that do not tell whether the principal distance is right."
        ),
        "bent_models": (
            "Spatial models of a flight that are bent alike, and were corrected by it."
        ),
        "curvature_untold": (
            "Heights that a curved Earth would bend, where nobody says what the map is."
        ),
        "high_flight_that_misfits": (
            "Models of the high flight that fit worse than the given errors explain."
        ),
        "contradicted_propagation": (
            "Measured figures that are larger than the propagated one."
        ),
        "contradicted_budget": ("Coverages that differ more than the budget explains."),
        "wrong_control_errors": (
            "Control whose standard errors are stated much larger than the residuals "
            "show them."
        ),
        "coverages_that_agree_too_well": (
            "Coverages that differ by less than independent measurements would."
        ),
        "wrong_measuring_errors": (
            "Flights whose m_g, as it was given, is not that of the measurements."
        ),
        "image_points_worse_than_given": (
            "Flights whose image points are less precise than their m_g says. The "
            "other way round proves nothing: residuals see y-parallax only."
        ),
        "image_points_better_than_given": (
            "Flights whose image points are more precise than their m_g says, by "
            "residuals of relative orientation and by the block."
        ),
        "heavy_tails_of_image_points": (
            "Flights of whose image points a share is much worse than the others."
        ),
        "settings_that_scatter": (
            "Flights whose repeated settings lie farther apart than m_g allows."
        ),
        "scattered_points": (
            "Single points whose settings lie farther apart than m_g allows."
        ),
        "film_affinity": (
            "Flights whose models have an affinity that their transformation leaves."
        ),
        "curved_models": (
            "Flights whose models have a curvature in common, which the two steps "
            "leave in the points."
        ),
        "strained_network": (
            "Control points that are displaced together with their neighbours."
        ),
        "broken_network": (
            "Control of which one part lies apart from the other, or that is bent."
        ),
        "contradicting_control": (
            "Control points that contradict each other by more than their errors."
        ),
        "gross_measurements": (
            "Measurements that contradict the other models of their flight."
        ),
        "suspect_observations": (
            "Observations with residuals that chance does not explain: gross errors."
        ),
        "coverages_that_differ": (
            "Points whose coverages differ by more than chance explains: gross errors."
        ),
        "points_that_differ": (
            "Points whose models or coverages lie far apart: gross errors."
        ),
        "imprecise_points": (
            "Points that spoil the figure of the block, and the models that they lie "
            "in."
        ),
        "models_with_large_m_0": ("Models that fit far worse than their flight."),
        "all_models_mirrored": ("Affine models of a block that are all mirror images."),
        "mirrored_models": (
            "Affine models with a negative determinant, which no camera makes by "
            "itself. All of them may be mirrored by a left-handed machine. Where no "
            "reference system has let the coordinates pass, it may as well be control "
            "with its axes exchanged."
        ),
        "points_in_one_coverage": (
            "Points that no second coverage confirms, where the flight has one."
        ),
        "points_in_one_model": (
            "Points that not even a second model confirms, in a flight of one coverage."
        ),
        "models_without_redundancy": "Models that any residual escapes.",
        "no_check_points": ("Nothing from outside confirms the figures."),
        "figure_left_out": (
            "What is missing for the propagated figure, where it could be given."
        ),
        "note_of_reading": (
            "What was ignored, completed or reprojected when the block was read."
        ),
    }
)
CAUSES = mark_each(
    {
        "exchanged_names": (
            "Names of a model were exchanged in pairs, went round, or slipped by one "
            "row."
        ),
        "exchanged_image_names": (
            "Names were exchanged while the photograph was measured, or in its file."
        ),
        "exchanged_control": (
            "Names were exchanged in the list of control, have gone round or slipped "
            "by some rows, or the points were measured under each other's name "
            "everywhere."
        ),
        "control_under_another_name": (
            "The names of both points are exchanged in all measurements, or the list "
            "of control gives the coordinates of the other point."
        ),
        "kept_gross_measurements": (
            "outliers is keep, and measurements are wrong, or wrongly named."
        ),
        "other_targets": (
            "In all photographs of one flight another object was taken for the point."
        ),
        "wrong_approximate_points": (
            "A misprint, exchanged names or another target gave the point wrong "
            "coordinates."
        ),
        "displaced_region": (
            "The coordinates of these points come from another network, strip, "
            "photograph or system than the others."
        ),
        "measurements_given_twice": (
            "A table was read twice, or a coverage was copied instead of measured."
        ),
        "models_in_another_unit": (
            "The model points of a model, or its y-parallaxes and base, were given in "
            "another unit, such as feet or metres instead of millimetres."
        ),
        "models_larger_than_film": (
            "Control is not in metres, or scale_number is not that of the flight."
        ),
        "scale_numbers_contradicted": (
            "scale_number is mistyped, the principal distance is wrong, or control is "
            "not in metres."
        ),
        "stretched_models": (
            "One axis has another unit, or a decimal point at another place."
        ),
        "failed_models": (
            "Too few points in common with control or the approximate coordinates, or "
            "points that determine nothing, such as points on one line."
        ),
        "points_without_coordinates": "All models that hold the point failed.",
        "orientations_without_convergence": (
            "Gross errors in the image coordinates or parallaxes, or points that "
            "hardly determine the orientation."
        ),
        "models_near_a_dangerous_surface": (
            "The points and the projection centres lie near a dangerous surface, such "
            "as a valley whose slopes form a cylinder."
        ),
        "image_points_that_contradict": (
            "A point was measured or matched wrongly in one of both photographs, or "
            "under a wrong name."
        ),
        "ambiguous_orientations": (
            "Few points, or points at nearly one height, fit two orientations."
        ),
        "orientations_with_large_sigma_0": (
            "Gross errors in the image coordinates or y-parallaxes of these models."
        ),
        "corrections_that_spoil": (
            "The y-parallaxes have the opposite sign, or belong to other models."
        ),
        "models_upside_down": (
            "x, y or z has the wrong sign: the axes are left-handed."
        ),
        "lone_wrong_check_point": (
            "Its coordinates, its name or its measurements are wrong; less often the "
            "block is wrong there."
        ),
        "suspect_check_points": (
            "Their coordinates, names or measurements are wrong; less often the block "
            "is wrong there."
        ),
        "control_against_block": (
            "The coordinates or the name of the control point are wrong, or another "
            "point was measured."
        ),
        "control_set_aside": (
            "The coordinates or the name of the control point are wrong, or another "
            'point was measured; outliers is not "keep", so that it takes no part. '
            "Points that are off in one direction share an error, or other control "
            "does; so may either where many are set aside."
        ),
        "control_that_contradicts": (
            "The coordinates or the name of the control point are wrong, or another "
            "point was measured; its neighbours may only suffer from it."
        ),
        "claim_that_does_not_stand": (
            "Errors are larger than stated in block.toml, models are deformed, or "
            "approximate coordinates share errors."
        ),
        "check_points_beyond_claim": (
            "Some check points are wrong, or the block is less precise than the "
            "stated errors let expect."
        ),
        "adjustment_that_misfits": (
            "Gross errors, wrong control, wrong units, deformed models, or stated "
            "errors that are too small."
        ),
        "deformed_models": (
            "Film, camera or relative orientation deforms the models, which the "
            "settings leave as they are."
        ),
        "block_that_shrinks": (
            "Control lies on one side only, or there is little of it: errors of the "
            "measured coordinates then change the scale of the block."
        ),
        "drift_without_control": (
            "iterations is larger than 1, and no model of the low flight contains "
            "control."
        ),
        "iterations_that_spoil": (
            "Too few models of the low flight contain control: errors accumulate from "
            "model to model."
        ),
        "drift_that_nothing_tells": (
            "Fewer than half of the models of the low flight contain control, and the "
            "errors of the block are not stated."
        ),
        "check_points_better_than_claim": (
            "m_g_um or the stated standard errors are larger than the errors are."
        ),
        "control_points_beyond_claim": (
            "Some control points are wrong, their network is strained, or their own "
            "errors are not stated."
        ),
        "shifted_block": (
            "Control and check points are in different reference systems or networks, "
            "or the block drifts."
        ),
        "heights_out_of_scale": (
            "The principal distance, the base or the unit of z is wrong."
        ),
        "broken_heights": (
            "Heights come from two levelling networks or datums, or the curvature of "
            "the Earth was not treated."
        ),
        "wrong_control_height": (
            "The height is mistyped, or belongs to another point, such as the top of "
            "a mark instead of the ground."
        ),
        "lone_wrong_height": (
            "Its height, its name or its measurements are wrong; less often heights "
            "of the block are wrong there."
        ),
        "heights_beyond_claim": (
            "Heights of known points are wrong, or m_g_um or the stated errors are "
            "too small."
        ),
        "unseen_height_scale": (
            "Control lies at nearly one height, the new points do not."
        ),
        "bent_models": (
            "Distortion of the lens or the plotter, or a curved Earth that was left in."
        ),
        "curvature_untold": ("block.toml names no reference system (crs)."),
        "high_flight_that_misfits": (
            "Gross errors in the high flight or its control, or stated errors that "
            "are too small."
        ),
        "contradicted_propagation": (
            "m_g_um of the low flight is too small, or gross errors enlarge the "
            "differences."
        ),
        "contradicted_budget": (
            "m_g_um of the low flight is too small, or gross errors enlarge the "
            "differences."
        ),
        "wrong_control_errors": (
            "standard_error_m is in another unit than metres, or a guess that is far "
            "too large; control then counts too little, and the points become worse."
        ),
        "coverages_that_agree_too_well": (
            "Measurements of one coverage were copied or transferred to another, or "
            "m_g_um is too large."
        ),
        "wrong_measuring_errors": (
            "m_g_um is not that of the instrument and observer, or gross errors "
            "enlarge the estimate."
        ),
        "image_points_worse_than_given": (
            "m_g_um is too small, the camera file is wrong, or there are gross errors."
        ),
        "image_points_better_than_given": (
            "m_g_um is too large, a guess or the figure of another instrument, or "
            "photographs were copied."
        ),
        "heavy_tails_of_image_points": (
            "Some points were matched or measured wrongly, as by automatic matching."
        ),
        "settings_that_scatter": (
            "m_g_um is too small, or gross errors are among the repeated pointings."
        ),
        "scattered_points": (
            "One of the pointings was made at another detail or under a wrong name."
        ),
        "film_affinity": (
            "Film shrinks differently along and across its length; a helmert or rigid "
            "transformation leaves that in the model."
        ),
        "curved_models": (
            "The lens, film or plotter displaces points by the square or cube of their "
            "place in the model, in all models alike."
        ),
        "strained_network": (
            "The network of the control is strained: neighbours were determined "
            "together."
        ),
        "broken_network": (
            "Control comes from two networks, surveys or reference systems."
        ),
        "contradicting_control": (
            "Some control points are wrong, or standard_error_m of control is too "
            "small."
        ),
        "gross_measurements": (
            "Another point was measured, or under a wrong name; outliers is not "
            '"keep", so that they take no part.'
        ),
        "suspect_observations": (
            "A point was measured wrongly or under a wrong name, or its approximate "
            "coordinates are wrong."
        ),
        "coverages_that_differ": (
            "A point was measured wrongly or under a wrong name in one coverage."
        ),
        "points_that_differ": (
            "A point was measured wrongly or under a wrong name in one model."
        ),
        "imprecise_points": (
            "Their models have little control or few tie points, or the points lie "
            "outside of them."
        ),
        "models_with_large_m_0": ("Gross errors in the model, or wrong control in it."),
        "all_models_mirrored": (
            "The axes of the machine are left-handed, or easting and northing of "
            "control are exchanged."
        ),
        "mirrored_models": (
            "Names of points are exchanged in these models, or points lie nearly on "
            "one line."
        ),
        "points_in_one_coverage": (
            "They were measured in one coverage, or their models of the other failed."
        ),
        "points_in_one_model": (
            "They lie outside of the overlap of the models, or were measured in one "
            "model only."
        ),
        "models_without_redundancy": (
            "The model has as many points as its transformation needs, and no more."
        ),
        "no_check_points": ("No point of the block has the role check."),
        "figure_left_out": ("The control points have no standard_error_m."),
        "note_of_reading": (
            "A table was understood in one way, completed or reprojected."
        ),
    }
)
