"""What every way of densification gives."""

from dataclasses import dataclass

import pandas as pd

from einschalt.pipeline.block.block import Block
from einschalt.pipeline.densification.figures import BlockFigures
from einschalt.pipeline.settings import Settings


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Solution:
    """Points of a block with everything that led to them, whichever way it was.

    Attributes
    ----------
    block : Block
        The input as it was checked.
    settings : Settings
    points : DataFrame
        point_id, easting, northing [, height] [, standard_error_easting,
        standard_error_northing, covariance_en, standard_error_total],
        standard_error_paper, standard_error_internal, n_models, n_coverages,
        spread_total, role (new, control, check), is_suspect (contradicted by
        coverages, residuals or given coordinates) [, is_set_aside (control that takes
        no part, of one adjustment)], difference_easting,
        difference_northing [, difference_height] (densified minus given, control and
        check points only) [, distributed_easting, distributed_northing (part of the
        coordinates that comes from the distribution of residuals)] [m]. In the order in
        which they first stand in the model points: of the low flight in two steps, of
        the high and then the low flight in one adjustment.
    models : DataFrame
        flight, coverage, model_id, transformation, n_points, redundancy, m_0, s_0,
        is_usable, reason, then the parameters.
    residuals : DataFrame
        flight, coverage, model_id, point_id, residual_easting, residual_northing
        [, residual_height] (transformed minus given) [m], leverage, redundancy_number,
        w, p_value, is_suspect (of the joint test of both coordinates).
    orientations : DataFrame
        flight, coverage, model_id, case, n_points, redundancy, sigma_0 [mm],
        is_converged, is_ambiguous (another orientation fits as well), verdict (on the
        dangerous surface: safe, weak, critical), inflation, reason,
        m_g_intersection_um, m_g_orientation_um, then the elements; no rows where
        nothing was oriented.
    orientation_residuals : DataFrame
        flight, coverage, model_id, point_id, then the residuals of stage 2 [mm] and,
        of images, weight, w, p_value, is_suspect; no rows where nothing was oriented.
    failures : DataFrame
        flight, coverage, model_id, stage, reason, remedy.
    gross_measurements : DataFrame
        flight, coverage, model_id, point_id, residual_easting, residual_northing
        [, residual_height] [m], w, p_value of the measurements that contradict the
        other models, and took no part.
    figures : BlockFigures
        Root mean squares over the new points, TOTAL [m].
    orientation_errors : dict of str to OrientationErrors, ImageErrors or None
        Of each flight that was oriented by y-parallaxes or formed from images.
    """

    block: Block
    settings: Settings
    points: pd.DataFrame
    models: pd.DataFrame
    residuals: pd.DataFrame
    orientations: pd.DataFrame
    orientation_residuals: pd.DataFrame
    failures: pd.DataFrame
    gross_measurements: pd.DataFrame
    figures: BlockFigures
    orientation_errors: dict
