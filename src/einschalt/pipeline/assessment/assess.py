"""What is to be thought of a result: judged once, told by others."""

from dataclasses import dataclass
from functools import singledispatch

import numpy as np

from einschalt.foundations.language import in_english
from einschalt.pipeline.assessment.causes.broken_heights import with_broken_heights
from einschalt.pipeline.assessment.causes.film_affinity import with_film_affinity
from einschalt.pipeline.assessment.causes.kept_gross_errors import (
    with_broken_network,
    with_kept_gross_errors,
    with_other_targets,
    with_points_put_off,
    with_wrong_control,
    with_wrong_height,
    with_wrong_names,
)
from einschalt.pipeline.assessment.causes.ranked import (
    ranked_causes,
    with_causes,
    with_shared_errors,
)
from einschalt.pipeline.assessment.choice import (
    MethodChoice,
    adjustment_beside,
    better_beside,
    is_tried,
    is_untried,
)
from einschalt.pipeline.assessment.credibility import CredibleFigure
from einschalt.pipeline.assessment.credible_heights import CredibleHeights
from einschalt.pipeline.assessment.evidence.claim import Claim
from einschalt.pipeline.assessment.examination import (
    SimultaneousExamination,
    TwoStepExamination,
)
from einschalt.pipeline.assessment.facts.block import BlockFacts, block_facts
from einschalt.pipeline.assessment.facts.control_strain import (
    DisplacedControlFacts,
    SuspectControlFacts,
    displaced_control_facts,
    suspect_control_facts,
)
from einschalt.pipeline.assessment.facts.flights import (
    ApproximationFacts,
    FlightFacts,
    approximation_facts,
    flight_facts,
)
from einschalt.pipeline.assessment.facts.known_points import (
    KnownPointFacts,
    known_point_facts,
)
from einschalt.pipeline.assessment.facts.model_deformation import DeformationFacts
from einschalt.pipeline.assessment.facts.moves import (
    DistributionFacts,
    IterationFacts,
    distribution_facts,
    iteration_facts,
)
from einschalt.pipeline.assessment.facts.patterns import PatternFacts, pattern_facts
from einschalt.pipeline.assessment.facts.precision import (
    SimultaneousPrecision,
    TwoStepPrecision,
    simultaneous_precision,
    two_step_precision,
)
from einschalt.pipeline.assessment.facts.precision_of_points import (
    ErrorSourceFacts,
    NeighbourFacts,
    SpreadFacts,
    error_source_facts,
    neighbour_facts,
    spread_facts,
)
from einschalt.pipeline.assessment.facts.repeated_settings import (
    RepeatedSettingFacts,
    repeated_setting_facts,
)
from einschalt.pipeline.assessment.facts.tolerance import (
    ToleranceFacts,
    tolerance_facts,
)
from einschalt.pipeline.assessment.finding import Finding, Gravity
from einschalt.pipeline.assessment.findings.catalogue import (
    SIMULTANEOUS,
    TWO_STEP,
    findings_of,
)
from einschalt.pipeline.assessment.plain_values import plain
from einschalt.pipeline.assessment.tolerance import tolerance_of


@dataclass(frozen=True, eq=False, repr=False)
class Assessment:
    """Everything that is to be known of a result besides its tables."""

    block: BlockFacts
    # with method = "auto": which way was taken, and why
    choice: MethodChoice | None
    # the other method, where it is known to be better than the one that was taken
    better: MethodChoice | None
    is_untried: bool  # whether one adjustment of all models may gain, and was not made
    causes: tuple[str, ...]  # codes of findings that explain others, most of them first
    findings: tuple[Finding, ...]  # the gravest first
    credible: CredibleFigure  # the figure to believe, and why
    credible_heights: CredibleHeights | None  # None where points have no heights
    # whether the stated precision stands: nothing contradicts it, no finding is grave;
    # None where nothing tests it
    claim_is_supported: bool | None
    precision: TwoStepPrecision | SimultaneousPrecision  # all figures of the new points
    spread: SpreadFacts | None  # where a few points make the figure
    claim: Claim  # tests of the stated precision against the measurements
    height_claim: Claim  # the same of heights
    known_points: KnownPointFacts
    flights: tuple[FlightFacts, ...]
    approximations: ApproximationFacts
    repeated_settings: tuple[RepeatedSettingFacts, ...]
    patterns: PatternFacts
    error_sources: ErrorSourceFacts | None
    neighbours: NeighbourFacts | None
    iterations: IterationFacts | None
    distribution: DistributionFacts | None
    tolerance: ToleranceFacts | None
    deformation: DeformationFacts | None
    # None where it was not asked for, or nothing shows
    control_strain: SuspectControlFacts | DisplacedControlFacts | None

    def to_dict(self) -> dict:
        """Everything in plain values, as it is written to assessment.json."""
        return plain(self)


@in_english
def assess(result) -> Assessment:
    """Judge a result."""
    examined = result.examination
    of_its_way = _of_its_way(examined)
    is_grave = any(found.gravity is Gravity.GRAVE for found in of_its_way["findings"])
    return Assessment(
        block=block_facts(examined),
        choice=result.choice,
        causes=ranked_causes(of_its_way["findings"]),
        spread=spread_facts(result.points),
        credible=examined.credible,
        credible_heights=examined.credible_heights,
        claim_is_supported=_is_supported(examined, is_grave=is_grave),
        claim=examined.claim,
        height_claim=examined.height_claim,
        known_points=known_point_facts(examined),
        flights=flight_facts(examined),
        approximations=approximation_facts(examined),
        repeated_settings=repeated_setting_facts(examined),
        patterns=pattern_facts(examined),
        error_sources=error_source_facts(examined),
        neighbours=neighbour_facts(examined),
        iterations=iteration_facts(examined),
        distribution=distribution_facts(examined),
        deformation=examined.deformation,
        tolerance=tolerance_facts(
            result.points, tolerance_of(examined.settings), examined.checked
        ),
        **of_its_way,
        **_of_other_method(examined, is_asked_for=result.compares_methods),
    )


def _is_supported(examined, *, is_grave):
    heights = examined.credible_heights
    is_bound = heights is not None and heights.is_lower_bound
    if examined.credible.is_lower_bound or is_bound or is_grave:
        return False
    if not np.isfinite(examined.credible.value):  # there is no claim
        return None
    is_tested = bool(examined.claim.tests) or examined.known_check.count > 0
    if isinstance(examined, SimultaneousExamination):  # s_0 is its test
        is_tested = is_tested or examined.adjustment.redundancy > 0
    return True if is_tested else None


def _of_other_method(examined, *, is_asked_for):
    if isinstance(examined, SimultaneousExamination):  # the two steps stand beside it
        return {"better": better_beside(examined), "is_untried": False}
    is_compared = is_asked_for and is_tried(examined)
    return {
        "better": adjustment_beside(examined) if is_compared else None,
        "is_untried": is_untried(examined) and not is_compared,
    }


def _with_gross_errors(examined, judges, findings):
    """Put what follows from wrong control, or from wrong measurements, under these."""
    # it looks like anything else, and so does what a height does to its models
    findings = with_wrong_names(examined, judges, findings)
    findings = with_wrong_height(examined, judges, findings)
    findings = with_points_put_off(examined, judges, findings)
    findings = with_broken_network(examined, judges, findings)
    findings = with_broken_heights(examined, judges, findings)
    findings = with_film_affinity(examined, judges, findings)
    # single measurements are named more surely than targets, or control
    findings = with_kept_gross_errors(examined, judges, findings)
    findings = with_other_targets(examined, judges, findings)
    return with_wrong_control(examined, judges, findings)


@singledispatch
def _of_its_way(examined):
    """What is judged of one way of densification only, or of each in its own way."""
    raise TypeError(type(examined).__name__)


@_of_its_way.register
def _(examined: TwoStepExamination):
    found = with_causes(
        findings_of(examined, TWO_STEP), examined.exchanged_names, is_coupled=False
    )
    return {
        "findings": with_shared_errors(_with_gross_errors(examined, TWO_STEP, found)),
        "precision": two_step_precision(examined),
        "control_strain": displaced_control_facts(examined),
    }


@_of_its_way.register
def _(examined: SimultaneousExamination):
    found = with_causes(
        findings_of(examined, SIMULTANEOUS),
        examined.exchanged_names,
        is_coupled=examined.settings.outliers == "keep",
    )
    return {
        "findings": _with_gross_errors(examined, SIMULTANEOUS, found),
        "precision": simultaneous_precision(examined),
        "control_strain": suspect_control_facts(examined),
    }
