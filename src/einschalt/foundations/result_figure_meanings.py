"""What headline figures of results mean: in the JSON of densify, and in blocks.csv."""

from einschalt.foundations.meanings_with_units import unit_and_meaning
from einschalt.foundations.plan_figure_meanings import Meaning

DENSIFY, BLOCKS = "densify --json", "batch --output, blocks.csv"
OF_DENSIFY = {
    "m_0_high": "m_0 of all models of the high flight together, TOTAL [m]",
    "m_0_low": "m_0 of all models of the low flight together, TOTAL [m]",
    "approximation_internal": (
        "TOTAL of the approximate coordinates, from the differences of the coverages "
        "of the high flight [m]"
    ),
    "single_paper": "TOTAL of the value of one model by Kovarik's M, RMS [m]",
    "mean_paper": "TOTAL of the new points by Kovarik's M, RMS [m]",
    "mean_total": "propagated TOTAL of the new points, RMS [m]",
    "single_internal": (
        "TOTAL of the value of one coverage, from the differences of the coverages [m]"
    ),
    "mean_internal": (
        "TOTAL of the new points, from the differences of the coverages, RMS [m]"
    ),
    "control_rms": "densified minus given at control points, TOTAL, RMS [m]",
    "check_rms": "densified minus given at check points, TOTAL, RMS [m]",
    "shared_error": (
        "part of mean_total that all points share: error of the operation between "
        "reference systems [m]"
    ),
    "credible": "the figure to use, TOTAL, as in the first line of the summary [m]",
    "claim_is_supported": (
        "whether nothing contradicts the stated precision; if not, it is a lower bound"
    ),
    "n_check": "number of check points",
    "n_models_high": "number of models of the high flight",
    "n_models_low": "number of models of the low flight",
    "n_failed": "rows of failures.csv: models that could not be computed",
    "n_suspects": (
        "points with a suspected gross error, by their residuals or by their coverages"
    ),
}
OF_BLOCKS = {
    "outcome": "done, skipped since nothing has changed, or failed",
    "n_failed_models": OF_DENSIFY["n_failed"],
    "n_moved": (
        "points that moved by more than their standard error since the previous run"
    ),
    "largest_move": "largest movement of any point since the previous run [m]",
    "standard_error_credible": OF_DENSIFY["credible"],
}


def meanings_of_result(name) -> list[Meaning]:
    """Give what a name means among the headline figures of results."""
    named = ((DENSIFY, OF_DENSIFY), (BLOCKS, OF_BLOCKS))
    return [
        Meaning(place, *unit_and_meaning(figures[name]))
        for place, figures in named
        if name in figures
    ]


def names_of_results() -> frozenset[str]:
    """Names of all headline figures that are explained here."""
    return frozenset((*OF_DENSIFY, *OF_BLOCKS))
