"""What findings there are, and what each is about; made here of names and numbers."""

from einschalt.pipeline.assessment.finding import Finding, Gravity, Subject

BLOCK, FLIGHT, MODELS, POINTS, CONTROL, MEASUREMENTS = Subject
NOTE, WARNING, GRAVE = Gravity
# by code, the gravest first: what is lost, what is wrong, what is weak, not checked;
# single wrong points before what they make of a block
KINDS = {
    "exchanged_names": (MEASUREMENTS, GRAVE),
    "exchanged_image_names": (MEASUREMENTS, GRAVE),
    "exchanged_control": (CONTROL, GRAVE),
    "control_under_another_name": (CONTROL, GRAVE),
    "kept_gross_measurements": (MEASUREMENTS, GRAVE),
    "other_targets": (MEASUREMENTS, GRAVE),
    "wrong_approximate_points": (POINTS, GRAVE),
    "displaced_region": (POINTS, GRAVE),
    "measurements_given_twice": (MEASUREMENTS, GRAVE),
    "models_in_another_unit": (MODELS, GRAVE),
    "models_larger_than_film": (FLIGHT, GRAVE),
    "scale_numbers_contradicted": (FLIGHT, GRAVE),
    "stretched_models": (BLOCK, GRAVE),
    "failed_models": (MODELS, WARNING),
    "points_without_coordinates": (POINTS, WARNING),
    "orientations_without_convergence": (MODELS, WARNING),
    "models_near_a_dangerous_surface": (MODELS, WARNING),
    "image_points_that_contradict": (MEASUREMENTS, WARNING),
    "ambiguous_orientations": (MODELS, WARNING),
    "orientations_with_large_sigma_0": (MODELS, WARNING),
    "corrections_that_spoil": (FLIGHT, GRAVE),
    "models_upside_down": (MODELS, GRAVE),
    "lone_wrong_check_point": (POINTS, GRAVE),
    "suspect_check_points": (POINTS, WARNING),
    "control_against_block": (CONTROL, GRAVE),
    "control_set_aside": (CONTROL, WARNING),
    "control_that_contradicts": (CONTROL, WARNING),
    "claim_that_does_not_stand": (BLOCK, GRAVE),
    "check_points_beyond_claim": (BLOCK, GRAVE),
    "adjustment_that_misfits": (BLOCK, GRAVE),
    "deformed_models": (BLOCK, GRAVE),
    "block_that_shrinks": (BLOCK, GRAVE),
    "drift_without_control": (BLOCK, GRAVE),
    "iterations_that_spoil": (BLOCK, WARNING),
    "drift_that_nothing_tells": (BLOCK, WARNING),
    "check_points_better_than_claim": (BLOCK, NOTE),
    "control_points_beyond_claim": (CONTROL, WARNING),
    "shifted_block": (BLOCK, GRAVE),
    "heights_out_of_scale": (FLIGHT, GRAVE),
    "broken_heights": (CONTROL, GRAVE),
    "wrong_control_height": (CONTROL, GRAVE),
    "lone_wrong_height": (POINTS, GRAVE),
    "heights_beyond_claim": (BLOCK, GRAVE),
    "unseen_height_scale": (BLOCK, NOTE),
    "bent_models": (FLIGHT, NOTE),
    "curvature_untold": (BLOCK, WARNING),
    "high_flight_that_misfits": (FLIGHT, GRAVE),
    "contradicted_propagation": (BLOCK, GRAVE),
    "contradicted_budget": (BLOCK, GRAVE),
    "wrong_control_errors": (CONTROL, WARNING),
    "coverages_that_agree_too_well": (BLOCK, WARNING),
    "wrong_measuring_errors": (FLIGHT, WARNING),
    "image_points_worse_than_given": (FLIGHT, WARNING),
    "image_points_better_than_given": (FLIGHT, WARNING),
    "heavy_tails_of_image_points": (FLIGHT, WARNING),
    "settings_that_scatter": (FLIGHT, WARNING),
    "scattered_points": (MEASUREMENTS, WARNING),
    "film_affinity": (FLIGHT, WARNING),
    "curved_models": (FLIGHT, WARNING),
    "strained_network": (CONTROL, GRAVE),
    "broken_network": (CONTROL, GRAVE),
    "contradicting_control": (CONTROL, WARNING),
    "gross_measurements": (MEASUREMENTS, WARNING),
    "suspect_observations": (MEASUREMENTS, WARNING),
    "coverages_that_differ": (POINTS, WARNING),
    "points_that_differ": (POINTS, WARNING),
    "imprecise_points": (POINTS, WARNING),
    "models_with_large_m_0": (MODELS, WARNING),
    "all_models_mirrored": (BLOCK, NOTE),
    "mirrored_models": (MODELS, WARNING),
    "points_in_one_coverage": (POINTS, WARNING),
    "points_in_one_model": (POINTS, WARNING),
    "models_without_redundancy": (MODELS, WARNING),
    "no_check_points": (BLOCK, NOTE),
    "figure_left_out": (BLOCK, NOTE),
    "note_of_reading": (BLOCK, NOTE),
}
MOST_NAMED = 100
MODEL = ("flight", "model_id")
OBSERVATION = ("flight", "coverage", "model_id", "point_id")


def finding(code, *, names=(), **known) -> Finding:
    """Make a finding of one of the KINDS of its other fields, numbers made plain."""
    subject, gravity = KINDS[code]
    fields = {"subject": subject, "gravity": gravity, "names": first_names(names)}
    numbers = {"observed", "expected", "probability"} & set(known)
    plain = {name: float(known[name]) for name in numbers}
    return Finding(code, **fields | known | plain)


def weak_models(code, rows, *, remedy) -> Finding | None:
    """A finding on models that are rows of a table, if there are any."""
    if rows.empty:
        return None
    names, facts = rows["model_id"], models_of(rows)
    return finding(code, names=names, remedy=remedy, facts=facts)


def weak_points(code, ids, *, remedy, **facts) -> Finding | None:
    """A finding on points by their names, if there are any."""
    if ids.empty:
        return None
    facts = {"n_points": len(ids), **facts}
    return finding(code, names=ids, remedy=remedy, facts=facts)


def first_names(ids) -> tuple[str, ...]:
    """Take the first names of many, at most MOST_NAMED."""
    return tuple(str(name) for name in list(ids)[:MOST_NAMED])


def row_keys(rows, columns=OBSERVATION) -> tuple[tuple[str, ...], ...]:
    """Take what names the first rows of a table, at most MOST_NAMED."""
    first = rows[list(columns)].head(MOST_NAMED)
    return tuple(
        tuple(map(str, row)) for row in first.itertuples(index=False, name=None)
    )


def models_of(rows) -> dict:
    """Facts of models: how many, and which."""
    return {"n_models": len(rows), "models": row_keys(rows, MODEL)}
