"""The result that users hold: a solution, what was judged of it, and its summary."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from operator import attrgetter
from time import perf_counter
from typing import Any, Literal

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from einschalt.foundations.blas_threads import one_blas_thread
from einschalt.foundations.language import language as active_language
from einschalt.foundations.language import written_in
from einschalt.pipeline.assessment.assess import Assessment, assess
from einschalt.pipeline.assessment.choice import MethodChoice
from einschalt.pipeline.assessment.evidence.claim import Claim
from einschalt.pipeline.assessment.evidence.leave_one_out import LeftOutControl
from einschalt.pipeline.assessment.evidence.systematic_errors import SystematicPatterns
from einschalt.pipeline.assessment.evidence.variance_components import BlockComponents
from einschalt.pipeline.assessment.examination import Examination, examine
from einschalt.pipeline.block.block import Block
from einschalt.pipeline.block.output_system import OutputSystem, output_system_of
from einschalt.pipeline.densification.figures import BlockFigures
from einschalt.pipeline.densification.iteration import Iteration
from einschalt.pipeline.densification.one_adjustment import SimultaneousSolution
from einschalt.pipeline.densification.two_steps import TwoStepSolution
from einschalt.pipeline.result_parts import (
    CachedTable,
    FormerPart,
    Part,
    ToldOnRequest,
)
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.summary.summary import summarize
from einschalt.pipeline.summary.verdict import verdict
from einschalt.stages.coverage_screening import CoverageScreening
from einschalt.stages.error_propagation.covariances import PropagatedErrors
from einschalt.stages.error_propagation.error_model import ErrorModel
from einschalt.stages.results import Result
from einschalt.stages.simultaneous.adjustment import BlockAdjustment
from einschalt.stages.stage1_approximate_coordinates import ApproximateCoordinates
from einschalt.stages.stage3_model_transformation import ModelTransformation
from einschalt.stages.stage5_double_coverage import CoverageMean


def _told(part: str) -> CachedTable[pd.DataFrame]:
    """A table with coordinates, vectors or covariances, in the system of the results.

    ``part``: where it stands in the system of the block.
    """
    name = part.rpartition(".")[2]

    def table(self: "DensificationResult") -> pd.DataFrame:
        found = attrgetter(part)(self)
        return found if self.output_system is None else self._in_output_system(found)

    known = CachedTable(table)
    known.__doc__ = f"Table ``{name}``, in the system of the results."
    return known


@dataclass
class Stopwatch:
    """Adds up the time of everything that was computed for one result."""

    seconds: float = 0.0

    @contextmanager
    def running(self) -> Iterator[None]:
        """Add the time that is spent inside."""
        started = perf_counter()
        try:
            yield
        finally:
            self.seconds += perf_counter() - started


@dataclass(frozen=True, eq=False, repr=False)
class DensificationResult(Result):
    """Densified coordinates of a block, with everything that led to them.

    Its tables are those of the solution: ``models``, ``residuals``, ``orientations``,
    ``orientation_residuals``, ``failures``, ``gross_measurements``, ``figures`` are
    described in :class:`einschalt.pipeline.densification.solution.Solution`;
    ``single_values``, ``approximations``, ``coverages``, ``iterations`` in
    :class:`einschalt.pipeline.densification.two_steps.TwoStepSolution`.

    With ``output_crs`` tables of points are in that system; ``covariance_between`` and
    ``errors`` stay in the system of the block, in which all is computed.

    Attributes
    ----------
    solution : TwoStepSolution or SimultaneousSolution
        What was computed.
    stopwatch : Stopwatch
        How long it took; runs again while it is judged.
    examined : Examination, optional
        Of the solution, where there is one already.
    choice : MethodChoice, optional
        With ``method = "auto"``: which way was taken, and why.
    compares_methods : bool, optional
        Whether the assessment of two steps computes what one adjustment of a small
        block would give; otherwise it only says that this can be asked for.
    """

    solution: TwoStepSolution | SimultaneousSolution
    stopwatch: Stopwatch = field(default_factory=Stopwatch)
    examined: Examination | None = None
    choice: MethodChoice | None = None
    compares_methods: bool = True

    block = Part[Block]("solution.block")
    settings = Part[Settings]("solution.settings")
    models = Part[pd.DataFrame]("solution.models")
    residuals = _told("solution.residuals")
    orientations = Part[pd.DataFrame]("solution.orientations")
    orientation_residuals = Part[pd.DataFrame]("solution.orientation_residuals")
    orientation_errors = Part[dict[str, Any]]("solution.orientation_errors")
    failures = Part[pd.DataFrame]("solution.failures")
    gross_measurements = _told("solution.gross_measurements")
    figures = Part[BlockFigures]("solution.figures")
    single_values = _told("solution.single_values")
    approximations = _told("solution.approximations")
    coverages = _told("solution.coverages")
    iterations = _told("solution.iterations")

    errors = Part[PropagatedErrors | None]("examination.errors")
    claim = Part[Claim]("examination.claim")
    components = Part[BlockComponents | None]("examination.components")
    patterns = Part[SystematicPatterns]("examination.patterns")
    repeated_settings = Part[pd.DataFrame]("examination.repeated_settings")
    reliability = Part[pd.DataFrame]("examination.reliability")
    error_sources = _told("examination.error_sources")
    block_error_sources = Part[pd.DataFrame]("examination.block_error_sources")
    neighbours = _told("examination.neighbours")
    neighbour_precision = ToldOnRequest("examination.neighbour_precision")
    # in the system of the block, whatever output_crs is
    covariance_between = Part[Callable[[Any], NDArray[np.float64]]](
        "examination.covariance_between"
    )
    left_out_control = Part[LeftOutControl | None]("examination.left_out_control")
    control_left_out = _told("examination.control_left_out")
    ellipses = _told("examination.ellipses")
    confidence_ellipses = ToldOnRequest("examination.confidence_ellipses")

    high = FormerPart[ApproximateCoordinates]()
    low = FormerPart[ModelTransformation]()
    means = FormerPart[CoverageMean]()
    model_points = FormerPart[dict[str, pd.DataFrame]]()
    propagation = FormerPart[ErrorModel]()
    iteration = FormerPart[Iteration]()
    screening = FormerPart[CoverageScreening]()

    @cached_property
    def examination(self) -> Examination:
        """What the measurements say of the solution, each part computed when asked."""
        if self.examined is not None and self.examined.solution is self.solution:
            return self.examined
        examined = examine(self.solution)
        vars(examined)["is_of_result"] = True  # as a field would be kept
        return examined

    @CachedTable
    def points(self) -> pd.DataFrame:
        """Points of the solution, each of them judged: DataFrame.

        Columns as of the class, with ``standard_error_checked`` (the figure to believe,
        TOTAL [m]: enlarged where measurements exceed it), and ``is_within_tolerance``
        where a tolerance is set. ``is_suspect`` holds points as well that were measured
        under another name, and known points that contradict the claim. In the system of
        the results (``output_crs``). Their order differs between the methods: join
        results by ``point_id``.
        """
        with one_blas_thread():  # they may be asked for before the assessment
            found = self.examination.judged
        return found if self.output_system is None else self._in_output_system(found)

    @cached_property
    def output_system(self) -> OutputSystem | None:
        """The way into the system of the results; None where it is the block's."""
        return output_system_of(self.block, self.settings)

    @property
    def crs(self) -> str | None:
        """Name of the system of the results; None where the block has none."""
        return self.block.crs if self.output_system is None else self.output_system.crs

    def _in_output_system(self, table):
        """A table of the results, or None, in the system of the results."""
        return self.output_system.told(table, self._positions)

    @cached_property
    def _positions(self):
        """Best known coordinates of all points by name, in the system of the block."""
        known = self.solution.points, self.solution.approximations
        tables = [*known, self.block.control_points]
        table = pd.concat([one for one in tables if one is not None])
        return table.drop_duplicates("point_id").set_index("point_id")

    @CachedTable
    def control_points(self) -> pd.DataFrame | None:
        """Control points of the block, in the system of the results, or None."""
        found = self.block.control_points
        return found if self.output_system is None else self._in_output_system(found)

    @cached_property
    def assessment(self) -> Assessment:
        """What is to be thought of the result, judged once: Assessment."""
        with self.stopwatch.running(), one_blas_thread():
            return assess(self)

    @property
    def simultaneous(self) -> BlockAdjustment | None:
        """BlockAdjustment with ``method = "simultaneous"``, else None."""
        return getattr(self.solution, "adjustment", None)

    @property
    def two_step(self) -> TwoStepSolution | None:
        """With ``method = "simultaneous"``: the two steps, where they are possible."""
        beside = getattr(self.solution, "two_step", None)
        return beside if beside is not None and beside.is_possible else None

    @property
    def seconds(self) -> float:
        """Time of everything that was computed, assessment included [s]."""
        return self.stopwatch.seconds

    def to_statsmodels(
        self,
        model_id: str,
        coverage: str | None = None,
        *,
        flight: Literal["low_flight", "high_flight"] = "low_flight",
    ) -> Any:
        """Results object of statsmodels for one model of the two steps.

        Parameters
        ----------
        model_id : str
        coverage : str, optional
            Needed where two coverages have a model of that name.
        flight : {"low_flight", "high_flight"}

        Returns
        -------
        RegressionResultsWrapper
            Of WLS, with an equation for each coordinate of each point (``resid`` is
            given less transformed); coordinates are reduced to the centroids, as
            ``to_statsmodels`` of what :func:`einschalt.transform_models` gives.

        Raises
        ------
        SettingsError
            There is no such flight.
        TableError
            There is no such model, or there is one in each of several coverages.
        GeometryError
            The model, or its flight, was not transformed by itself.
        """
        # statsmodels takes longer to import than most blocks to be computed
        from einschalt.stages.regression_results import (  # noqa: PLC0415
            regression_of_flight,
        )

        steps = getattr(self.solution, "two_step", self.solution)
        high, low = getattr(steps, "high", None), getattr(steps, "low", None)
        return regression_of_flight(high, low, model_id, coverage, flight)

    def __repr__(self) -> str:
        """Return the verdict alone; ``print`` shows the summary."""
        return f"<{type(self).__name__} {verdict(self.assessment)}>"

    def summary(self, *, language: str | None = None) -> str:
        """Return verdict, problems and suggestions, then numbers.

        ``language``: "en" or "de"; left out, the one of ``written_in``, else English.
        """
        with written_in(language or active_language()):
            return summarize(self)
