"""Which judges look at a block, and the order in which their findings are told."""

from einschalt.pipeline.assessment.finding import Finding
from einschalt.pipeline.assessment.findings import (
    claim,
    iterations,
    known_points,
    models,
    notes,
    orientations,
    precision,
    suspects,
    systematic_errors,
)

MODULES = (
    models,
    orientations,
    claim,
    precision,
    iterations,
    known_points,
    suspects,
    systematic_errors,
    notes,
)
TWO_STEP = tuple(judge for module in MODULES for judge in module.TWO_STEP)
SIMULTANEOUS = tuple(judge for module in MODULES for judge in module.SIMULTANEOUS)

# the gravest first: what is lost, what is wrong, what is weak, what is not checked
ORDER = (
    "exchanged_names",
    "failed_models",
    "points_without_coordinates",
    "orientations_without_convergence",
    "models_near_a_dangerous_surface",
    "image_points_that_contradict",
    "ambiguous_orientations",
    "orientations_with_large_sigma_0",
    "corrections_that_spoil",
    "models_upside_down",
    "claim_that_does_not_stand",
    "adjustment_that_misfits",
    "deformed_models",
    "block_that_shrinks",
    "drift_without_control",
    "iterations_that_spoil",
    "drift_that_nothing_tells",
    "check_points_beyond_claim",
    "check_points_better_than_claim",
    "control_against_block",
    "control_set_aside",
    "control_points_beyond_claim",
    "control_that_contradicts",
    "shifted_block",
    "high_flight_that_misfits",
    "contradicted_propagation",
    "contradicted_budget",
    "wrong_measuring_errors",
    "image_points_worse_than_given",
    "settings_that_scatter",
    "scattered_points",
    "film_affinity",
    "strained_network",
    "contradicting_control",
    "gross_measurements",
    "suspect_observations",
    "coverages_that_differ",
    "points_that_differ",
    "imprecise_points",
    "models_with_large_m_0",
    "all_models_mirrored",
    "mirrored_models",
    "points_in_one_coverage",
    "points_in_one_model",
    "models_without_redundancy",
    "no_check_points",
    "figure_left_out",
    "note_of_reading",
)
_RANK = {code: rank for rank, code in enumerate(ORDER)}


def findings_of(examined, judges) -> tuple[Finding, ...]:
    """Let judges look for everything that the user of a result should know.

    Each gives a finding, several in a tuple, or None. In the order of ORDER.
    """
    found = []
    for judge in judges:
        finding = judge(examined)
        if finding is not None:
            found += finding if isinstance(finding, tuple) else (finding,)
    return tuple(sorted(found, key=lambda finding: _RANK[finding.code]))
