"""What to say of gross errors and of wrong sizes of errors."""

from einschalt.pipeline.summary.suggestion import filled
from einschalt.pipeline.summary.wording import two_figures

REMEDIES = {
    "measure_again": "Measure them again",
    "measure_again_or_snoop": 'Measure them again, or set outliers = "snoop"',
    "measure_rejected_again": (
        "Measure them again; all stand in gross_measurements.csv"
    ),
    "measure_again_see_coverages": (
        "Measure them again; the values of their coverages stand in coverages.csv"
    ),
    "look_for_gross_errors_and_exchanged_names": (
        "Look for gross errors and for exchanged names"
    ),
    "check_worst_control": (
        "Check the first one and its measurements: a wrong one spoils the others"
    ),
    "check_control": "Check their coordinates and names",
    "check_control_or_snoop": (
        'Check their coordinates and names, or set outliers = "snoop"'
    ),
    "look_for_gross_errors": "Look for gross errors",
    "give_that_m_g": "Give that figure, if no gross error made it",
    "give_at_least_that_m_g": "Give at least that figure, if no gross error made it",
    "set_again": "Set them again: their mean is wrong",
}
KEY = "(flight, coverage, model, point)"
CONTRADICTS = (
    "{{n_points:count control point}} that {} the block, by up to {{largest:length}}: "
    "{{names:names of n_points}}. Kept, they make the new points near them worse than "
    "claimed"
)


def control_against_block(finding):
    """Which control points, and what they do to the points near them."""
    is_one = finding.facts["n_points"] == 1
    return filled(
        CONTRADICTS.format("contradicts" if is_one else "contradict"), finding
    )


def wrong_measuring_errors(finding):
    """Both figures of each flight."""
    return two_figures(finding.facts["flights"], "the measurements show")


def settings_that_scatter(finding):
    """Both figures of each flight."""
    return two_figures(finding.facts["flights"], "repeated settings scatter by")


WORDS = {
    "suspect_observations": (
        "{n_observations:count residual} of up to {largest:length} that chance does "
        f"not explain, worst first {KEY}: "
        "{observations:observations of n_observations}"
    ),
    "gross_measurements": (
        "{n_observations:count measurement}, off by up to {largest:length} from what "
        f"the other models of the flight say, took no part, worst first {KEY}: "
        "{observations:observations of n_observations}"
    ),
    "coverages_that_differ": (
        "{n_points:count point} with coverages that differ by up to "
        "{largest:length}, more than they may: {names:names of n_points}"
    ),
    "points_that_differ": (
        "{n_points:count point} with values more than {times_usual:.0f} times as "
        "widely scattered as the median of {median:length} (spread_total): "
        "{names:names of n_points}; up to {largest:length}"
    ),
    "control_that_contradicts": (
        "{n_points:count control point} missed by up to {largest:length} where "
        "predicted without themselves, more than chance explains, worst first: "
        "{names:names of n_points}"
    ),
    "control_set_aside": (
        "{n_points:count control point} set aside, for contradicting the block, by up "
        "to {largest:length}: {names:names of n_points}"
    ),
    "control_against_block": control_against_block,
    "wrong_measuring_errors": wrong_measuring_errors,
    "settings_that_scatter": settings_that_scatter,
    "scattered_points": (
        "{n_points:count point} with settings up to {widest_um:number} µm apart in the "
        "image (total, one setting), which chance does not explain, worst first "
        f"{KEY}: {{observations:observations of n_points}}"
    ),
}
