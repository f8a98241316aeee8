"""The simultaneous adjustment: all models of all flights with the control at once."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property, partial

import numpy as np
import pandas as pd

from einschalt.foundations.arguments import require_choice
from einschalt.foundations.errors import GeometryError
from einschalt.stages.results import (
    OUTLIERS,
    Estimates,
    FlightsResult,
    failures_table,
)
from einschalt.stages.simultaneous.determined_part import (
    begun_part,
    determined_part,
    part_of,
    places_of,
)
from einschalt.stages.simultaneous.failed_models import (
    STAGE,
    failed_models,
)
from einschalt.stages.simultaneous.height_columns import centre_table
from einschalt.stages.simultaneous.image_errors import (
    Covariances,
    DrawnFigures,
    covariances,
    has_images,
    variance_by_norm,
)
from einschalt.stages.simultaneous.observations import BlockTables
from einschalt.stages.simultaneous.outlier_removal import (
    clean_part,
    stands_without_gross_errors,
    weigh_part,
)
from einschalt.stages.simultaneous.own_deformation import (
    bent_part,
    find_own_deformation,
    is_detected,
)
from einschalt.stages.simultaneous.photograph_bends import (
    find_photograph_bends,
    with_photograph_bends,
)
from einschalt.stages.simultaneous.searches import Searches
from einschalt.stages.simultaneous.shared_bends import find_shared_bends
from einschalt.stages.simultaneous.shared_control import with_group_sizes
from einschalt.stages.simultaneous.summary_text import summary_text
from einschalt.stages.simultaneous.tables import (
    common_table,
    control_table,
    deformation_table,
    model_table,
    parameter_cofactors,
    point_table,
    residual_table,
    scale_table,
)
from einschalt.theory.adjustment.least_squares import pool_standard_errors
from einschalt.theory.adjustment.significance import GROSS_ERROR_SIGNIFICANCE
from einschalt.theory.block_adjustment import determinacy
from einschalt.theory.block_adjustment.block_solution import BlockSolution
from einschalt.theory.block_adjustment.common_border import UndeterminedTermsError
from einschalt.theory.block_adjustment.common_parameters import CommonTerms
from einschalt.theory.block_adjustment.errors_in_variables import displacement_by_design
from einschalt.theory.block_adjustment.gross_error_search import (
    adjust_without_far_measurements,
)
from einschalt.theory.block_adjustment.gross_errors import (
    NORMS,
    ContradictedModelError,
    examine_control,
    norms_of,
)
from einschalt.theory.block_adjustment.model_deformation import examine_deformation
from einschalt.theory.block_adjustment.spatial_solution import (
    NoConvergenceError,
    SpatialSolution,
)

COMPONENTS = ("given", "estimated")
DEFORMATIONS = ("ignored", "tested", "modelled")
GIVEN_UP = {
    NoConvergenceError: determinacy.RESTLESS,
    ContradictedModelError: determinacy.CONTRADICTED,
}


@dataclass(frozen=True)
class AdjustmentOptions:
    """How a block is adjusted."""

    # deformations that the models of a flight share
    common: tuple[CommonTerms, ...] = ()
    # what happens to gross errors: keep, snoop, huber or tukey
    outliers: str = "keep"
    # probability with which a model without gross errors has a suspect, and with which
    # a flight without deformation seems to have one
    significance: float = GROSS_ERROR_SIGNIFICANCE
    # what happens to further ones: ignored, tested or, where the test finds them,
    # modelled
    deformation: str = "ignored"
    # whether control and flights have the errors that were given, or the estimated ones
    # that their residuals show; heights of spatial models always have the latter
    variance_components: str = "given"

    def __post_init__(self):
        """Check the words."""
        require_choice("deformation", self.deformation, DEFORMATIONS)
        require_choice("variance_components", self.variance_components, COMPONENTS)
        require_choice("outliers", self.outliers, OUTLIERS)


@dataclass(frozen=True, eq=False, repr=False)
class WholeControl:
    """A block as it was adjusted before control that contradicts it was set aside."""

    solution: BlockSolution | SpatialSolution
    draw: Callable[[], Covariances]

    @cached_property
    def drawn(self) -> DrawnFigures:
        """What is known of it by drawn errors, as of a BlockAdjustment."""
        return self.draw().figures


@dataclass(frozen=True, eq=False, repr=False)
class BlockAdjustment(FlightsResult):
    """A block that was adjusted simultaneously.

    Attributes
    ----------
    points : DataFrame
        point_id, easting, northing, standard_error_easting, standard_error_northing,
        covariance_en, standard_error_total, n_models, n_coverages, spread_total, role
        (new, control, and of a Block check), difference_easting, difference_northing
        (adjusted minus given) [m]; of spatial models also height,
        standard_error_height, covariance_eh, covariance_nh, difference_height. Standard
        errors take the errors of the observations as given (σ_0 = 1); of models from
        images those of the image points, and of control that shares errors these,
        drawn 800 times in the order of the names (known to 2.5 %).
    models : DataFrame
        flight, coverage, model_id, transformation, n_points, redundancy (sum of the
        redundancy numbers), m_0 (total), s_0 (per coordinate; both in plan) [m],
        is_usable, reason, then the parameters.
    residuals : DataFrame
        flight, coverage, model_id, point_id, residual_easting, residual_northing
        (transformed less adjusted) [m], leverage, redundancy_number, w, p_value,
        is_suspect, minimal_detectable_bias, external_reliability [m]; of spatial
        models also residual_height, and the last three for the height.
    control : DataFrame
        point_id, difference_easting, difference_northing (adjusted minus given),
        standard_error_given (total), redundancy_number, w, p_value, is_suspect,
        is_set_aside (a suspect that takes no part: outliers is not "keep"),
        strain_easting, strain_northing: the error of the given coordinates that
        explains the difference [m].
    common : DataFrame
        flight, term, value, standard_error, of the deformations that the models of a
        flight share; a ratio for film_affinity and film_shear, otherwise model units
        at the edge of the model. Of spatial models ``dz:…`` likewise, ``lens:…`` in mm
        at the largest radius of the images: what they were corrected by, and
        parameters of the models lead from corrected coordinates.
    deformations : DataFrame
        flight, n_terms, f_statistic, p_value, is_detected, is_modelled, size,
        size_middle, size_edge (of the displacement, RMS, total) [m],
        neighbour_correlation, is_alike (residuals of neighbouring points in a model,
        after what was modelled), own_size_edge (of the deformations that each model has
        for itself, RMS, total) [m], own_p_value (of all flights together),
        own_is_modelled; no rows where this was ignored.
    height_scales : DataFrame
        flight, ratio (what model heights are too large by), p_value, moved_height (of
        points without a given height, by all flights together, RMS) [m] of spatial
        models whose heights are out of scale, the clearest first; it is not corrected,
        and not looked for where deformations are ignored.
    failures : DataFrame
        flight, coverage, model_id, stage, reason, remedy.
    s_0 : float
        Standard error of unit weight; 1 where the errors are as large as given. Of
        models from images compared with what errors of that size make of the residuals.
    redundancy : int
    tables : BlockTables
        Everything that was given.
    solution : BlockSolution or SpatialSolution
        Of the part of the block that could be determined.
    components : DataFrame
        group (control, flights; plan, height and projection centres of spatial
        models; image points behind them, if estimated),
        standard_error_m (median, of one coordinate), factor (the errors that
        residuals show, over those that were given; of a group that was not estimated,
        one step towards them, which falls short where a given size is far off: 0.34
        for 0.25), factor_standard_error (NaN of such a step where given sizes are
        refuted: ``variance_components="estimated"`` has both), redundancy, is_estimated
        (the block was adjusted with it).
    centres : DataFrame
        flight, image_id, easting, northing, height, their standard errors, n_models of
        the projection centres of spatial models [m]; no rows where they are not known.
    kept : ndarray of int
        Row of ``models`` of each model that the solution has.
    without_suspects : DataFrame
        point_id, easting, northing [, height] [m]: where the points lie without the
        control that contradicts the block, if that takes part; otherwise no rows.
    loses_no_others : bool
        Of a robust norm: whether it is known that an adjustment of the same tables
        without gross errors gives up no other models.
    drawn : DrawnFigures
        ``fits`` of each flight with models from images: its ``m_0`` [m] if all errors
        are as large as stated, and the degrees of freedom of the square. They share
        photographs, so that no sum of single errors tells it. ``control_heights``: the
        covariance of the scores of the heights of control, where it was drawn [1/m²];
        ``control_in_plan``: the same in plan.
        ``points``: which point of ``tables`` each one of ``solution`` is.
    whole : WholeControl or None
        The block with the control that was set aside, if any was.
    """

    points: pd.DataFrame
    models: pd.DataFrame
    residuals: pd.DataFrame
    control: pd.DataFrame
    common: pd.DataFrame
    deformations: pd.DataFrame
    failures: pd.DataFrame
    s_0: float
    redundancy: int
    tables: BlockTables
    solution: BlockSolution | SpatialSolution
    components: pd.DataFrame
    centres: pd.DataFrame
    kept: np.ndarray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    without_suspects: pd.DataFrame = field(default_factory=pd.DataFrame)
    loses_no_others: bool = False
    drawn: DrawnFigures = field(default_factory=DrawnFigures)
    height_scales: pd.DataFrame = field(default_factory=pd.DataFrame)
    whole: "WholeControl | None" = None

    @cached_property
    def estimates(self) -> Estimates:
        """Parameters of the models: Estimates, for unit weight σ_0 = 1."""
        cofactors, names = parameter_cofactors(self.solution)
        everything = np.full((len(self.models), *cofactors.shape[1:]), np.nan)
        everything[self.kept] = cofactors
        return Estimates(
            names=names,
            cofactors=everything,
            unit_error=np.ones(len(self.models)),
            is_usable=self.models["is_usable"].to_numpy(),
        )

    @cached_property
    def displacements(self) -> pd.DataFrame | None:
        """What errors of model coordinates move the points by, in the mean.

        DataFrame: point_id, easting, northing [m], as ``points``. Standard errors do
        not hold it; it is small where control holds the block. None of spatial models.
        """
        if self.tables.is_spatial:
            return None
        easting, northing = displacement_by_design(self.solution).T
        return self.points[["point_id"]].assign(easting=easting, northing=northing)

    def m_0_of(self, flight: str) -> float:
        """m_0 of all models of a flight (total) [m]; NaN without redundancy."""
        is_it = (self.models["flight"] == flight) & self.models["is_usable"]
        models = self.models[is_it]
        return pool_standard_errors(models["m_0"], models["redundancy"])

    def summary(self) -> str:
        """Say how good the points are, and what contradicts."""
        return summary_text(self)


def simultaneous_adjustment(tables, options=None, searches=None) -> BlockAdjustment:
    """Adjust all models of all flights with the control at once.

    What cannot be determined is a row of ``failures``; the rest is adjusted.
    ``searches`` are Searches that all adjustments of these tables share.
    GeometryError where nothing can be determined, or spatial models do not converge.
    """
    options = options or AdjustmentOptions()
    searches = searches or Searches(are_kept=False)
    try:
        return _adjust_tables(tables, options, searches)
    except UndeterminedTermsError as error:
        raise GeometryError(
            "The points of the models do not determine the deformation that they share",
            expected="points in many places of the models",
            remedy="Leave deformation out, or models of the kind affine",
            stage=STAGE,
        ) from error
    except NoConvergenceError as error:
        raise _no_convergence(_still_moving(tables, error)) from error


def _no_convergence(model):
    return GeometryError(
        "The simultaneous adjustment of the spatial models does not converge",
        expected="models that stand upright but for some degrees, without "
        "exchanged names of points",
        remedy='Set method = "two_step", and look at the residuals of its models',
        model=model,
        stage=STAGE,
    )


def _still_moving(tables, error):
    """Name of the model that moved most in the end; None where nothing tells it."""
    part, _ = determined_part(tables)
    if part.observations.n_models != error.n_models:  # without others by then
        return None
    return tables.models["model_id"].iloc[part.models[error.model]]


def _adjust_tables(tables, options, searches):
    """Adjust the models that can be placed; one that cannot is given up by itself.

    Where that would be half of them, it is the block that cannot be adjusted: the first
    that was given up is named.
    """
    tables = with_known_groups(tables, options.significance)
    part, verdicts = determined_part(tables)
    n_most, given_up = np.count_nonzero(verdicts.is_fine) // 2, []
    while True:
        try:
            adjusted = _adjust_part(tables, part, verdicts, options, searches)
            return replace(adjusted, loses_no_others=False) if given_up else adjusted
        except (NoConvergenceError, ContradictedModelError) as error:
            placed = np.flatnonzero(verdicts.is_fine)
            if error.n_models != len(placed):  # of an adjustment of some of them
                raise
            given_up.append(placed[error.model])
            if len(given_up) > n_most:
                name = tables.models["model_id"].iloc[given_up[0]]
                raise _no_convergence(name) from error
            verdicts.verdict[given_up[-1]] = GIVEN_UP[type(error)]
            part = part_of(tables, verdicts)


def _adjust_part(tables, part, verdicts, options, searches):
    part, begun, search = begin_search(tables, part, verdicts, options, searches)
    tests, begun, weighed, cleaned = _cleaned(tables, part, begun, options, search)
    bends = find_shared_bends(tables, weighed, options)
    if bends.modelled is not None:
        try:
            bent = bends.given_to(part)
            again = begun.readjusted(bent.observations)
            weighed = weigh_part(tables, bent, again, options)
            part, begun, cleaned = bent, again, clean_part(weighed, options)
        except UndeterminedTermsError:  # once gross errors are out
            bends = replace(bends, modelled=None)
            weighed = weigh_part(tables, part, begun, options)
    # its sizes stand beside those of the random errors, which must be known before
    both = [weighed]
    own = find_own_deformation(tables, weighed, begun.solution, options.deformation)
    if options.deformation == "modelled" and is_detected(own):
        part = bent_part(part, weighed, own)
        begun = begun.readjusted(part.observations)
        weighed = weigh_part(tables, part, begun, options)
        cleaned = clean_part(weighed, options)
        both.append(weighed)
    photographs = find_photograph_bends(tables, weighed, options.deformation)
    if options.deformation == "modelled":
        weighed = with_photograph_bends(weighed, photographs)
    own = own if photographs is None else photographs
    judge = partial(_judged, tables, weighed, cleaned, verdicts, options)
    snoops = options.outliers == "snoop"
    result = searches.followed(weighed, judge) if snoops else judge()
    found = tests, bends, own
    return replace(
        result,
        common=common_table(tables, result.solution, bends),
        deformations=deformation_table(tables, result.solution, found, options),
        height_scales=scale_table(tables, bends),
        loses_no_others=_loses_no_others(tables, both, options),
    )


def begin_search(tables, part, verdicts, options, searches):
    """Part and block to begin with, and ``search()`` that weighs it.

    Without gross errors, unless these are kept: adjustments of the tables share that.
    """
    part, begun = begun_part(tables, part, verdicts, options)
    search = partial(weigh_part, tables, part, begun, options)
    if options.outliers != "keep":
        models = verdicts.verdict.tobytes()
        key = models, options.common, options.significance, options.variance_components
        search = partial(searches.weighed, key, search)
    return part, begun, search


def _judged(tables, weighed, cleaned, verdicts, options):
    """Result of an adjustment without its deformations, control judged by it."""
    control = examine_control(cleaned.solution, options.significance)
    if options.outliers == "keep":
        return _result(tables, weighed, cleaned, verdicts, control, options)
    whole = cleaned.solution
    cleaned = replace(cleaned, solution=control.without)
    result = _result(tables, weighed, cleaned, verdicts, control, options)
    if not control.is_suspect.any():
        return result
    draw = partial(covariances, tables, weighed.part, weighed.image_sizes, whole)
    return replace(result, whole=WholeControl(whole, draw))


def _loses_no_others(tables, weighed, options):
    """Whether it is known that no other models are lost without gross errors.

    Plane ones are lost before these are looked for, spatial ones as well where an
    adjustment does not come to an end.
    """
    if options.outliers not in NORMS or has_images(tables):
        return False
    is_plane = not tables.is_spatial
    return is_plane or stands_without_gross_errors(weighed, options.significance)


def _cleaned(tables, part, begun, options, search):
    """Deal with gross errors and with deformations that the models of a flight share.

    A gross error passes for a deformation, or hides one: where there are some, the
    tests are made once more without them. ``search()`` looks for gross errors without
    any deformation.
    """
    solution = begun.solution
    tests, found = _examined(solution, options)
    if found is solution:
        weighed = search()
    else:
        begun = begun.continued(found, part.observations)
        weighed = weigh_part(tables, part, begun, options)
    cleaned = clean_part(weighed, options)
    if not tests or not (cleaned.is_out.any() or options.outliers in NORMS):
        return tests, begun, weighed, cleaned
    start = cleaned.solution
    if start.terms != solution.terms:
        start = start.with_terms(solution.terms)
    tests, again = _examined(start, options)
    if again.terms != found.terms:
        modelled = solution.with_terms(again.terms)
        begun = begun.continued(modelled, part.observations)
        weighed = weigh_part(tables, part, begun, options)
        cleaned = clean_part(weighed, options)
    return tests, begun, weighed, cleaned


def with_known_groups(tables, significance):
    """Give groups of control shifts of the size that an adjustment of all shows."""

    def adjust(tables):
        part, _ = determined_part(tables)
        return adjust_without_far_measurements(part.observations, significance).solution

    return with_group_sizes(tables, adjust, significance)


def _examined(solution, options):
    """Tests of all flights for deformations; the block with those to be modelled.

    A deformation of one flight bends the points, and with them the others. So the
    clearest is modelled before the other flights are tested.
    """
    if options.deformation == "ignored" or not isinstance(solution, BlockSolution):
        return (), solution
    untested = set(np.unique(solution.observations.flight).tolist())
    is_modelled = options.deformation == "modelled"
    tests, found = {}, solution
    while untested:
        now = {k: examine_deformation(found, k) for k in sorted(untested)}
        tests.update(now)
        clearest = min(now, key=lambda k: np.nan_to_num(now[k].p_value, nan=1.0))
        if not now[clearest].p_value < options.significance:
            break
        untested.remove(clearest)
        if untested or is_modelled:
            others = (t for t in found.terms if t.flight != clearest)
            found = found.with_terms((*others, now[clearest].terms))
    return [tests[k] for k in sorted(tests)], found if is_modelled else solution


def _of_norm(tables, weighed, options):
    """Covariances of the points of an adjustment with a robust norm.

    Those without gross errors, by least squares, times the variance of the norm.
    """
    given = tables, weighed.part, weighed.image_sizes
    d = weighed.part.observations.control.shape[1]
    norms = [NORMS[name][d] for name in norms_of(options.outliers)]
    ratio = variance_by_norm(*given, weighed.block, norms)
    return covariances(*given, weighed.block.solution).points * ratio


def _result(tables, weighed, cleaned, verdicts, control, options):
    part, solution = weighed.part, cleaned.solution
    rows = failed_models(tables, verdicts)
    failures = failures_table([row[1:] for row in rows])
    failures.insert(0, "flight", np.array([row[0] for row in rows], dtype=object))
    reasons = np.full(len(tables.models), "", dtype=object)
    reasons[~verdicts.is_fine] = [row[4] for row in rows]
    known = covariances(tables, part, weighed.image_sizes, solution)
    if options.outliers in NORMS and has_images(tables):
        known = replace(known, points=_of_norm(tables, weighed, options))
    points = point_table(tables, part, cleaned, known.points)
    residuals = residual_table(
        tables, part, cleaned, control, options.significance, known.residuals
    )
    is_centre = tables.is_centre[part.points]
    of_centre = is_centre[solution.observations.point]
    return BlockAdjustment(
        points=points[~is_centre].reset_index(drop=True),
        models=model_table(tables, part, cleaned, reasons),
        residuals=residuals[~of_centre].reset_index(drop=True),
        control=control_table(
            tables, part, solution, control, is_set_aside=options.outliers != "keep"
        ),
        common=pd.DataFrame(),
        deformations=pd.DataFrame(),
        failures=failures,
        s_0=solution.s_0 / np.sqrt(known.unit_variance),
        redundancy=solution.redundancy,
        tables=tables,
        solution=solution,
        components=weighed.table,
        centres=centre_table(points, is_centre),
        kept=part.models,
        without_suspects=_without_suspects(tables, part, control, options),
        drawn=known.figures,
    )


def _without_suspects(tables, part, control, options):
    """Coordinates without control that contradicts the block and takes part."""
    if options.outliers != "keep" or not control.is_suspect.any():
        return pd.DataFrame()
    return places_of(tables, part, control.without)
