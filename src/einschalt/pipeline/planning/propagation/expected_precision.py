"""The precision that a planned block will have, before anything is measured.

Not by the formula of 1971, which takes for independent what is not: the block is laid
out as it would be flown, and the errors of control and of both flights are carried
through every stage. They depend on where points lie and which models hold them, hardly
on what is measured; so a layout is enough.
"""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
import pandas as pd

from einschalt.foundations.blas_threads import one_blas_thread
from einschalt.foundations.errors import GeometryError, SettingsError
from einschalt.foundations.language import in_english, mark_each
from einschalt.pipeline.planning.flights.flight_design import FlightDesign
from einschalt.pipeline.planning.propagation.expected_text import (
    describe_expected,
    describe_verdict,
)
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.simulate_block import FLIGHTS, set_scene
from einschalt.stages.error_propagation.plane_flights import (
    GivenControl,
    PlaneFlight,
    UnusableModelError,
    propagate_flights,
)
from einschalt.stages.results import Result
from einschalt.stages.value_weights import WEIGHTED
from einschalt.theory.planning.kovarik_precision import PlannedPrecision

# places in a model, −½ to ½ from edge to edge, as DensificationResult has them
CENTRE_WITHIN, EDGE_BEYOND, CORNER_BEYOND = 0.2, 0.4, 0.35
SOURCES = ("control", "high_flight", "low_flight")
SOURCE_TEXT = mark_each(
    {
        "control": "control",
        "high_flight": "measuring in the high flight",
        "low_flight": "measuring in the low flight",
    }
)


@dataclass(frozen=True)
class ExpectedFigures:
    """Root mean squares, TOTAL [m]; NaN where there is no such point.

    Attributes
    ----------
    mean : float
        Of the final coordinates of the new points, mean of all coverages [m].
    worst : float
        95 % of the new points are better [m].
    single, single_centre, single_edge, single_corner : float
        Of one model's value [m]: anywhere, in the middle (u and v within 0.2 of it), at
        the edge (one of them above 0.4), in a corner (both above 0.35) of its extent.
    paper_mean, paper_single, paper_centre, paper_edge, paper_corner : float
        The same after Kovarik's formula [m], with the leverages of these points and
        plain means.
    m_0 : float
        What the transformations of the low flight would show [m].
    """

    mean: float
    worst: float
    single: float
    single_centre: float
    single_edge: float
    single_corner: float
    paper_mean: float
    paper_single: float
    paper_centre: float
    paper_edge: float
    paper_corner: float
    m_0: float


@dataclass(frozen=True, eq=False, repr=False)
class ExpectedPrecision(Result):
    """What a planned block will be worth.

    Attributes
    ----------
    design : FlightDesign
        The flights that were laid out.
    points : DataFrame
        point_id, easting, northing (from the centre of the area) [m], role,
        standard_error_total, standard_error_paper (TOTAL) [m], n_models.
    values : DataFrame
        Every low-flight model's value of every point: coverage, model_id, point_id,
        position_u, position_v (−½ to ½ from edge to edge of the model),
        standard_error_total, standard_error_paper (TOTAL) [m].
    figures : ExpectedFigures
        Root mean squares, TOTAL [m]: ``mean`` and ``worst`` of the new points,
        ``single``, ``single_centre``, ``single_edge``, ``single_corner`` of one model's
        value; ``paper_…`` of the formula of 1971; ``m_0``.
    parts : dict of str to float
        What control, high_flight and low_flight contribute to the new points, root mean
        square, TOTAL [m].
    formula : PlannedPrecision
        After Kovarik's formula and edge, with the block's m_0 [m].
    n_high_models, n_low_models, n_control : int
        Models of both flights, and control points.
    weighting : {"plain", "weighted", "rigorous"}
        Mean of a point's values.
    """

    design: FlightDesign
    points: pd.DataFrame
    values: pd.DataFrame
    figures: ExpectedFigures
    parts: dict[str, float]
    formula: PlannedPrecision
    n_high_models: int
    n_low_models: int
    n_control: int
    weighting: str

    @property
    def verdict(self) -> str:
        """How good the new points will be, in a sentence."""
        return describe_verdict(self)

    def summary(self) -> str:
        """Return the expected precision beside that of the formula of 1971."""
        return describe_expected(self)


@in_english
def expect_precision(
    design, *, coverage_mean="all", weighting="auto", seed=0
) -> ExpectedPrecision:
    """Compute the precision of a planned block by propagation on its layout.

    ``coverage_mean`` and ``weighting`` are those of Settings, ``seed`` is that of the
    layout: points are displaced at random about a lattice. EinschaltError where models
    would hold too few points.

    Notes
    -----
    The covariance is L Σ Lᵀ with L the operators of all stages
    (docs/theory/propagation.md). What it cannot know are errors that no size was given
    for: deformed models, a strained network, gross errors.

    Examples
    --------
    >>> expected = expect_precision(
    ...     FlightDesign(scale_number=8000, spacing=300, m_g_um=5)
    ... )
    >>> round(100 * expected.figures.paper_mean) < round(100 * expected.figures.mean)
    True
    """
    if not isinstance(design, FlightDesign):
        raise SettingsError(
            f"design is a {type(design).__name__}",
            expected="a FlightDesign",
            remedy="Write FlightDesign(scale_number=…, spacing=…, m_g_um=…)",
        )
    means = {"coverage_mean": coverage_mean, "weighting": weighting}
    return propagate_design(design, **means, seed=seed).expected


@dataclass(frozen=True, eq=False)
class PropagatedBlock:
    """A planned block whose final points are propagated, its values when asked for.

    To tell whether a plan keeps its target, the final points are mostly enough.
    """

    design: FlightDesign
    weighting: str  # of a point's values: "plain", "weighted", "rigorous"
    errors: np.ndarray  # of points that new ones are like, TOTAL [m]
    counts: np.ndarray  # as how many new points each of them counts
    n_high_models: int
    n_low_models: int
    # what control and both flights contribute, root mean square, TOTAL [m]
    parts: dict[str, float]
    # gives points and values of ExpectedPrecision, and the m_0 of the low flight;
    # made of a function of the module, so that plans can be pickled
    details: Callable[[], tuple[pd.DataFrame, pd.DataFrame, float]]

    @property
    def mean(self) -> float:
        """Root mean square of the errors of the new points, TOTAL [m]."""
        return _rms(self.errors, self.counts)

    @property
    def share_of_control(self) -> float:
        """Part of the variance of the new points that control makes."""
        return (self.parts["control"] / self.mean) ** 2

    @cached_property
    def expected(self) -> ExpectedPrecision:
        """All that is expected of the block, also of every single value."""
        points, values, m_0 = self.details()
        return ExpectedPrecision(
            design=self.design,
            points=points,
            values=values,
            figures=_figures(self.mean, points, values, m_0),
            parts=self.parts,
            formula=self.design.after_kovarik(m_0),
            n_high_models=self.n_high_models,
            n_low_models=self.n_low_models,
            n_control=int((points["role"] == "control").sum()),
            weighting=self.weighting,
        )


def propagate_design(design, *, seed=0, **means) -> PropagatedBlock:
    """Lay a design out and propagate it; as :func:`expect_precision`."""
    geometry = on_a_plane(design.geometry())
    geometry = replace(geometry, point_spacing=float(design.spacing))
    given = geometry, design.noise(), seed
    set_anew = partial(set_scene, *given, spacing=design.layout_spacing)
    return propagate_scene(set_anew, design, **means)


def on_a_plane(geometry):
    """Give a geometry without a map projection: what that bends is no error."""
    return replace(geometry, crs=None)


@in_english
def propagate_scene(
    set_anew, design, *, coverage_mean="all", weighting="auto"
) -> PropagatedBlock:
    """Propagate the errors of a design in a scene, which ``set_anew`` sets.

    By arrays where that is enough: all models usable, and means of all values, plain
    ones or those of least variance. Otherwise through the stages of :func:`densify`.
    """
    means = Settings(coverage_mean=coverage_mean, weighting=weighting)
    weighting = means.weighting_with(covariances_are_known=True)
    propagated = None
    with one_blas_thread():
        if coverage_mean == "all" and weighting != WEIGHTED:
            with suppress(UnusableModelError):
                propagated = _by_arrays(set_anew(), design, weighting)
        if propagated is None:
            block = set_anew().measured("Planned (simulated)")
            propagated = _through_stages(block, design, means)
    if not propagated.counts.any():
        raise GeometryError(
            "all points of the area would be control points",
            expected="some that are to be densified",
            remedy="Give a smaller spacing, or a larger area",
        )
    return propagated


def _by_arrays(scene, design, weighting):
    stands_for = (design.layout_spacing / design.spacing) ** 2
    high, low = (_plane_flight(scene, flight, stands_for) for flight in FLIGHTS)
    flights = propagate_flights(high, low, _control_of(scene), weighting)
    total = _total(flights.errors.covariance)
    is_control = scene.is_control[flights.point]
    details = partial(_details_of_arrays, scene, flights)
    numbers = (scene.layouts[flight].n_models for flight in FLIGHTS)
    # of those for which control stands, it is one: the others are new, and like it
    counts = np.where(is_control, stands_for - 1.0, stands_for)
    parts = _parts(flights.parts, counts)
    return PropagatedBlock(design, weighting, total, counts, *numbers, parts, details)


def _details_of_arrays(scene, flights):
    is_control = scene.is_control[flights.point]
    points = pd.DataFrame(
        {
            "point_id": scene.ground.point_id[flights.point],
            "role": np.where(is_control, "control", "new"),
            "standard_error_total": _total(flights.errors.covariance),
            "standard_error_paper": flights.paper_of_points,
            "n_models": flights.n_models,
        }
    )
    points = _placed(points, scene.truth(), scene.geometry)
    return points, _table_of_values(scene, flights), flights.m_0


def _plane_flight(scene, flight, stands_for):
    layout, height = scene.layouts[flight], flight.removesuffix("_flight")
    if not np.bincount(layout.model, minlength=layout.n_models).all():
        raise UnusableModelError
    kind, xy = scene.geometry.transformation_kind, scene.plane_measured(flight)
    m_g_um = scene.stated_m_g_um(height)
    rows = layout.model, layout.point, xy
    given = kind, layout.scale_number, m_g_um, *rows, stands_for
    return PlaneFlight(*given, scene.to_measure(flight).enlarged)


def _control_of(scene):
    point = np.flatnonzero(scene.is_control)
    if not np.isin(point, scene.layouts["high_flight"].point).all():
        raise UnusableModelError
    geometry = scene.geometry
    plane = scene.truth()[["easting", "northing"]].to_numpy()
    plane = (plane + scene.errors_of_given()[:, :2])[point]
    return GivenControl(point, plane, scene.stated_error, geometry.crs)


def _table_of_values(scene, flights):
    layout, position = scene.layouts["low_flight"], flights.position
    return pd.DataFrame(
        {
            "coverage": layout.coverage_id[layout.model],
            "model_id": layout.model_id[layout.model],
            "point_id": scene.ground.point_id[layout.point],
            "position_u": position[:, 0],
            "position_v": position[:, 1],
            "standard_error_paper": flights.paper_of_values,
            "standard_error_total": _total(flights.errors_of_values.covariance),
        }
    )


def _through_stages(block, design, means):
    # imported where it is needed: it takes along all that measured blocks may need
    from einschalt.pipeline.densify import densify  # noqa: PLC0415

    # a layout has neither gross errors nor deformed models to look for
    asked = {"screening": "off", "model_deformation": "ignored"}
    result = densify(block, means.updated(asked))
    solution = result.solution
    points = solution.points  # not judged: nothing has been measured
    counts = (points["role"] == "new").to_numpy(dtype=float)
    return PropagatedBlock(
        design,
        means.weighting_with(covariances_are_known=True),
        points["standard_error_total"].to_numpy(),
        counts,
        len(solution.high.transformation.models),
        len(solution.low.models),
        _parts(solution.errors.parts, counts),
        partial(_details_of_stages, block, solution),
    )


def _details_of_stages(block, solution):
    # imported where it is needed, as above
    from einschalt.stages.stage4_error_propagation import (  # noqa: PLC0415
        propagate_values,
    )

    names = ["point_id", "role", "standard_error_total", "standard_error_paper"]
    points = solution.points[[*names, "n_models"]]
    placed = _placed(points, block.truth, block.geometry)
    point_ids = solution.model_points["low_flight"]["point_id"]
    of_values = _total(propagate_values(solution.propagation, point_ids).covariance)
    values = _values(block, solution.single_values, of_values)
    if solution.means.is_rigorous:
        placed["standard_error_paper"] = _of_plain_means(placed, solution.means.used)
    return placed, values, solution.figures.m_0_low


def _parts(parts, counts):
    return {source: _rms(_total(parts[source]), counts) for source in SOURCES}


def _total(covariance):
    return np.sqrt(np.trace(covariance, axis1=1, axis2=2))


def _rms(errors, counts=None):
    """Root mean square, each error as often as it counts; NaN of none."""
    errors = np.asarray(errors, dtype=float)
    counts = np.ones(errors.size) if counts is None else counts
    is_counted = counts > 0.0
    errors, counts = errors[is_counted], counts[is_counted]
    return float(np.sqrt(counts @ errors**2 / counts.sum())) if errors.size else np.nan


def _values(block, single_values, totals):
    """Values with the precision of each; models that were not usable have none."""
    rows = block.low_flight.points_to_fit[["coverage", "model_id", "point_id"]]
    propagated = rows.assign(standard_error_total=totals)
    shown = [*rows.columns, "position_u", "position_v", "standard_error_paper"]
    return single_values[shown].merge(propagated, on=list(rows.columns))


def _of_plain_means(points, values):
    """M of 1971 of each point, whose mean is the plain one of some values."""
    of_point = values.groupby("point_id")["standard_error_paper"]
    paper = of_point.agg(lambda errors: np.sqrt(np.sum(errors**2)) / len(errors))
    return paper.loc[points["point_id"]].to_numpy()


def _placed(points, truth, geometry):
    true = truth.set_index("point_id").loc[points["point_id"]]
    return points.assign(
        easting=true["easting"].to_numpy() - geometry.centre_easting,
        northing=true["northing"].to_numpy() - geometry.centre_northing,
    )


def zones_of(values):
    """Which values lie in the middle, at the edge and in the corners of their models.

    Arrays of bool by the name of the zone; ``values`` has position_u, position_v.
    """
    away = values[["position_u", "position_v"]].abs().to_numpy()
    return {
        "centre": (away < CENTRE_WITHIN).all(axis=1),
        "edge": (away > EDGE_BEYOND).any(axis=1),
        "corner": (away > CORNER_BEYOND).all(axis=1),
    }


def _figures(mean, points, values, m_0):
    new = points[points["role"] == "new"]
    total = values["standard_error_total"].to_numpy()
    paper = values["standard_error_paper"].to_numpy()
    zones = zones_of(values)
    return ExpectedFigures(
        mean=mean,
        worst=float(np.quantile(new["standard_error_total"], 0.95)),
        single=_rms(total),
        **{f"single_{zone}": _rms(total[is_in]) for zone, is_in in zones.items()},
        paper_mean=_rms(new["standard_error_paper"]),
        paper_single=_rms(paper),
        **{f"paper_{zone}": _rms(paper[is_in]) for zone, is_in in zones.items()},
        m_0=m_0,
    )
