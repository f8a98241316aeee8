"""What headline figures of results mean: in the JSON of densify, and in blocks.csv."""

from einschalt.foundations.plan_figure_meanings import Meaning

DENSIFY, BLOCKS = "densify --json", "batch --output, blocks.csv"
OF_DENSIFY = {
    "m_0_high": ("m", "m_0 of all models of the high flight together, TOTAL"),
    "m_0_low": ("m", "m_0 of all models of the low flight together, TOTAL"),
    "approximation_internal": (
        "m",
        (
            "TOTAL of the approximate coordinates, from the differences of the "
            "coverages of the high flight"
        ),
    ),
    "single_paper": ("m", "TOTAL of the value of one model by Kovarik's M, RMS"),
    "mean_paper": ("m", "TOTAL of the new points by Kovarik's M, RMS"),
    "mean_total": ("m", "propagated TOTAL of the new points, RMS"),
    "single_internal": (
        "m",
        "TOTAL of the value of one coverage, from the differences of the coverages",
    ),
    "mean_internal": (
        "m",
        "TOTAL of the new points, from the differences of the coverages, RMS",
    ),
    "control_rms": ("m", "densified minus given at control points, TOTAL, RMS"),
    "check_rms": ("m", "densified minus given at check points, TOTAL, RMS"),
    "shared_error": (
        "m",
        (
            "part of mean_total that all points share: error of the operation between "
            "reference systems"
        ),
    ),
    "credible": ("m", "the figure to use, TOTAL, as in the first line of the summary"),
    "claim_is_supported": (
        "",
        "whether nothing contradicts the stated precision; if not, it is a lower bound",
    ),
    "n_check": ("", "number of check points"),
    "n_models_high": ("", "number of models of the high flight"),
    "n_models_low": ("", "number of models of the low flight"),
    "n_failed": ("", "rows of failures.csv: models that could not be computed"),
    "n_suspects": (
        "",
        (
            "points with a suspected gross error, by their residuals or by their "
            "coverages"
        ),
    ),
}
OF_BLOCKS = {
    "outcome": ("", "done, skipped since nothing has changed, or failed"),
    "n_failed_models": OF_DENSIFY["n_failed"],
    "n_moved": (
        "",
        "points that moved by more than their standard error since the previous run",
    ),
    "largest_move": ("m", "largest movement of any point since the previous run"),
    "standard_error_credible": OF_DENSIFY["credible"],
}


def meanings_of_result(name) -> list[Meaning]:
    """Give what a name means among the headline figures of results."""
    named = ((DENSIFY, OF_DENSIFY), (BLOCKS, OF_BLOCKS))
    return [
        Meaning(place, *figures[name]) for place, figures in named if name in figures
    ]


def names_of_results() -> frozenset[str]:
    """Names of all headline figures that are explained here."""
    return frozenset((*OF_DENSIFY, *OF_BLOCKS))
