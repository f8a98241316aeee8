"""How large errors of image points are where some of them are much worse than others.

m_g is what good points are measured with. What a share of worse ones makes of adjusted
points is the root mean square of all errors, and not their most frequent size: least
squares have the covariance σ² (AᵀA)⁻¹ with the variance σ² of whatever distribution
(Gauss and Markov), of a normal one or not. Its estimate is Σ v² / Σ r.
"""

import numpy as np

from einschalt.foundations.units import UM_PER_MM
from einschalt.theory.adjustment.global_tests import ratio_p_value
from einschalt.theory.adjustment.least_squares import SQRT2, pool_standard_errors
from einschalt.theory.adjustment.significance import FINDING_SIGNIFICANCE

# an image point lies in two models at most of its strip: their residuals repeat it
MODELS_OF_IMAGE = 2
# sigma_0 of a model over the median, beyond which it is not oriented rightly
LARGE_SIGMA = 3.0


def errors_as_shown(image_pairs, principal_distance, m_g_um, outliers):
    """Root mean square of the errors of image points over their stated size.

    Parameters
    ----------
    image_pairs : DataFrame
        As :func:`orient_from_images` takes them.
    principal_distance : float
        [mm].
    m_g_um : float
        TOTAL, as stated [µm].
    outliers : str
        Points that contradict their pair do not count: they are named, taken out or
        have hardly any weight. Where they are kept, and are no few gross errors but the
        tail of many, they count.

    Returns
    -------
    over_given : float
        1 where chance explains what they exceed the stated size by.
    tails : tuple of float
        Share of the worse ones of these points, and how many times they are worse.
        None instead of both where errors are as stated.
    """
    # imported where photographs are oriented: other blocks do not wait for it
    from einschalt.stages.relative_orientation.orient_from_images import (  # noqa: PLC0415
        orient_from_images,
    )
    from einschalt.theory.relative_orientation.tails_of_pairs import (  # noqa: PLC0415
        LEAST_FAR_OUT,
        find_tails_of_pairs,
        tails_of_residuals,
    )

    used = orient_from_images(image_pairs, principal_distance, outliers="snoop")
    if outliers == "keep":
        ordinary = orient_from_images(image_pairs, principal_distance)
        tails = tails_of_residuals(ordinary.pairs.orientation)
        if tails is not None and tails.far_out > LEAST_FAR_OUT:
            used = ordinary
    over_given = _over_given(used, m_g_um)
    tails = find_tails_of_pairs(used.points, used.pairs.orientation)
    is_sure = tails is not None and tails.p_value < FINDING_SIGNIFICANCE
    if over_given == 1.0 and not is_sure:
        return None
    return over_given, (0.0, 1.0) if tails is None else (tails.share, tails.factor)


def _over_given(oriented, m_g_um):
    """Root mean square over the stated size, 1 where chance explains it."""
    models = oriented.models[oriented.is_oriented & (oriented.models["redundancy"] > 0)]
    if models.empty:
        return 1.0
    sigma_0 = models["sigma_0"].to_numpy(dtype=float)
    redundancy = models["redundancy"].to_numpy(dtype=float)
    is_usual = sigma_0 <= LARGE_SIGMA * np.median(sigma_0)
    sigma = pool_standard_errors(sigma_0[is_usual], redundancy[is_usual])
    ratio = SQRT2 * sigma * UM_PER_MM / m_g_um
    degrees = redundancy[is_usual].sum() / MODELS_OF_IMAGE
    is_larger = ratio > 1.0 and ratio_p_value(ratio, degrees) < FINDING_SIGNIFICANCE
    return float(ratio) if is_larger else 1.0
