"""From a block to densified coordinates: a list of calls."""

from einschalt.foundations.blas_threads import one_blas_thread
from einschalt.foundations.errors import GeometryError
from einschalt.foundations.language import in_english
from einschalt.foundations.limited_memory import (
    is_memory_limited,
    take_room_for_linear_algebra,
)
from einschalt.pipeline.assessment.choice import (
    AUTO,
    SIMULTANEOUS,
    TWO_STEP,
    solve_the_better_way,
)
from einschalt.pipeline.assessment.evidence.control.exchanged_control import (
    with_control_exchanged,
)
from einschalt.pipeline.assessment.evidence.images.exchanged_image_names import (
    with_exchanged_names,
)
from einschalt.pipeline.block.block import with_errors_as_shown
from einschalt.pipeline.block.memory import require_memory
from einschalt.pipeline.block.output_system import with_output_system
from einschalt.pipeline.densification.iteration import require_iterable
from einschalt.pipeline.densification.one_adjustment import (
    orient_flights,
    solve_in_one_adjustment,
)
from einschalt.pipeline.densification.residual_distribution import require_control
from einschalt.pipeline.densification.simultaneous import require_adjustable
from einschalt.pipeline.densification.two_steps import solve_in_two_steps
from einschalt.pipeline.progress import Stage, stage_reporter
from einschalt.pipeline.result import DensificationResult, Stopwatch
from einschalt.stages.stage4_error_propagation import require_rigorous

SOLVERS = {TWO_STEP: solve_in_two_steps, SIMULTANEOUS: solve_in_one_adjustment}


@in_english
def densify(
    block,
    settings=None,
    *,
    progress=None,
    kind=DensificationResult,
    compares_methods=True,
):
    """Compute the coordinates of a block's points, as its settings say.

    In the two-step way of 1971: approximate coordinates from the high flight (or given
    ones), relative orientation where it is to be computed, every low-flight model onto
    all its points, error budget, mean of the coverages. Or all models of all flights
    in one adjustment. Or both, of which the better one is kept. Check points enter
    neither.

    Arguments, results and errors are those of :func:`einschalt.densify`, and these:

    Parameters
    ----------
    kind : type, optional
        DensificationResult, or a class that extends it.
    compares_methods : bool, optional
        Whether a result of two steps tells what one adjustment would give, if its
        block is small: some 0.1 s of the processor for sixty models, 0.5 s for three
        hundred. One adjustment always has the two steps beside it.
    """
    # pydantic makes copies and settings that nobody has checked
    settings = (settings or block.settings).updated({})
    report_progress = stage_reporter(progress)
    stopwatch = Stopwatch()
    with stopwatch.running(), one_blas_thread():
        if is_memory_limited():
            take_room_for_linear_algebra()
        _require_possible(block, settings)
        block = with_output_system(block, settings)
        report_progress(Stage.RELATIVE_ORIENTATION)
        flights = orient_flights(block, settings)
        block = with_errors_as_shown(block, settings.outliers)
        asked = block, settings, flights, report_progress
        try:
            solution, found = _solved(*asked)
        except GeometryError as error:
            named = _with_cause(error, block, settings, flights)
            if named is error:  # an error that is its own cause has no end
                raise
            raise named from error
        report_progress(Stage.DONE)
    found["compares_methods"] = compares_methods
    return kind(solution, stopwatch, **found)


def _solved(block, settings, flights, report_progress):
    """The solution by the method that was asked for, and what it has been chosen by."""
    asked = block, settings, flights, report_progress
    if settings.method != AUTO:
        return SOLVERS[settings.method](*asked), {}
    examined, choice = solve_the_better_way(*asked)
    return examined.solution, {"examined": examined, "choice": choice}


def _with_cause(error, block, settings, flights):
    """The error with exchanged names as its cause, if some are found; else the same."""
    named = with_exchanged_names(error, block, flights)
    if named is not error:
        return named

    def solve(corrected):
        _solved(corrected, settings, flights, lambda *_: None)

    return with_control_exchanged(error, block, flights, solve)


def _require_possible(block, settings):
    """Refuse settings that mean nothing for this block, before the work."""
    require_memory(block)
    require_control(block, settings)
    require_iterable(block, settings)
    require_rigorous(block, settings.weighting)
    if settings.method == SIMULTANEOUS:
        require_adjustable(block)
