"""The error that decides on the unit of a page or figure."""

import numpy as np


def usual_error(result) -> float:
    """Error by whose size the unit of errors is chosen [m]; NaN where none is known."""
    credible, figures = result.assessment.credible.value, result.figures
    known = (credible, figures.mean_paper, figures.mean_internal, figures.check_rms)
    return next((value for value in known if np.isfinite(value)), np.nan)
