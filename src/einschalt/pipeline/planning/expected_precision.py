"""The precision that a planned block will have, before anything is measured.

Not by the formula of 1971, which takes for independent what is not: the block is laid
out as it would be flown, and the errors of control and of both flights are carried
through every stage. They depend on where points lie and which models hold them, hardly
on what is measured; so a layout is enough.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from einschalt.foundations import typesetting
from einschalt.foundations.errors import GeometryError, SettingsError
from einschalt.foundations.language import (
    figure,
    in_english,
    mark,
    mark_each,
    translated,
)
from einschalt.foundations.typesetting import length, number, scale, wrapped
from einschalt.pipeline.densify import densify
from einschalt.pipeline.planning.flight_design import MOST_ON_THE_GROUND, FlightDesign
from einschalt.pipeline.settings import Settings
from einschalt.pipeline.simulation.simulate_block import simulate_block
from einschalt.stages.results import Result
from einschalt.stages.stage4_error_propagation import propagate_values
from einschalt.theory.planning.kovarik_precision import (
    PlannedPrecision,
    mean_of_coverages,
)

# places in a model, −½ to ½ from edge to edge, as DensificationResult has them
CENTRE_WITHIN, EDGE_BEYOND, CORNER_BEYOND = 0.2, 0.4, 0.35
SOURCES = ("control", "high_flight", "low_flight")
SOURCE_TEXT = {
    "control": "control",
    "high_flight": "measuring in the high flight",
    "low_flight": "measuring in the low flight",
}
PARTS = mark_each(
    {
        "control": "control {length}",
        "high_flight": "measuring in the high flight {length}",
        "low_flight": "measuring in the low flight {length}",
    }
)
HOW_EXPECTED = mark(
    "expected: errors of control and both flights carried through all stages on this "
    "layout. formula: M of 1971 with the leverages of the same points; rule of 1971: "
    "the planning table with the block's m_0, {m_0}."
)


@dataclass(frozen=True)
class ExpectedFigures:
    """Root mean squares, TOTAL [m]; NaN where there is no such point."""

    mean: float  # final coordinates of the new points, mean of all coverages
    worst: float  # 95 % of the new points are better
    # one model's value: anywhere, in the middle (|u| and |v| below 0.2), at the edge
    # (one of them above 0.4), in a corner (both above 0.35) of its extent
    single: float
    single_centre: float
    single_edge: float
    single_corner: float
    # the same after Kovarik's formula, with the leverages of these points
    paper_mean: float
    paper_single: float
    paper_centre: float
    paper_edge: float
    paper_corner: float
    m_0: float  # what the transformations of the low flight would show


@dataclass(frozen=True, eq=False, repr=False)
class ExpectedPrecision(Result):
    """What a planned block will be worth."""

    design: FlightDesign
    # point_id, easting, northing (from the centre of the area), role,
    # standard_error_total, standard_error_paper, n_models [m]
    points: pd.DataFrame
    # every low-flight model's value of every point: coverage, model_id, point_id,
    # position_u, position_v, standard_error_total, standard_error_paper [m]
    values: pd.DataFrame
    figures: ExpectedFigures
    # what control and both flights contribute to the new points, root mean square,
    # TOTAL [m]
    parts: dict[str, float]
    formula: PlannedPrecision  # after Kovarik's formula and edge, with the block's m_0
    n_high_models: int
    n_low_models: int
    n_control: int

    @property
    def verdict(self) -> str:
        """How good the new points will be, in a sentence."""
        return _verdict(self)

    def summary(self) -> str:
        """Return the expected precision beside that of the formula of 1971."""
        return _summary(self)


@in_english
def expect_precision(design, *, coverage_mean="all", seed=0) -> ExpectedPrecision:
    """Compute the precision of a planned block by propagation on its layout.

    ``seed`` is that of the layout: points are displaced at random about a lattice.
    EinschaltError where models would hold too few points.

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
    block = simulate_block(seed=seed, geometry=design.geometry(), noise=design.noise())
    return expect_of_block(block, design, coverage_mean=coverage_mean)


def expect_of_block(block, design, *, coverage_mean="all") -> ExpectedPrecision:
    """Compute the precision of a simulated block: of a design, on a layout of its."""
    # a layout has neither gross errors nor deformed models to look for
    asked = {"screening": "off", "model_deformation": "ignored", "weighting": "plain"}
    settings = Settings(coverage_mean=coverage_mean, **asked)
    result = densify(block, settings)
    solution = result.solution
    points = solution.points  # not judged: nothing has been measured
    if not (points["role"] == "new").any():
        raise GeometryError(
            "all points of the area would be control points",
            expected="some that are to be densified",
            remedy="Give a smaller spacing, or a larger area",
        )
    point_ids = solution.model_points["low_flight"]["point_id"]
    of_values = _total(propagate_values(solution.propagation, point_ids).covariance)
    values = _values(block, result, of_values)
    is_new = (points["role"] == "new").to_numpy()
    parts = {
        source: _rms(_total(result.errors.parts[source])[is_new]) for source in SOURCES
    }
    roles = points["role"].value_counts()
    m_0 = result.figures.m_0_low
    return ExpectedPrecision(
        design=design,
        points=_points(block, points),
        values=values,
        figures=_figures(points, values, m_0),
        parts=parts,
        formula=design.after_kovarik(m_0),
        n_high_models=len(solution.high.transformation.models),
        n_low_models=len(solution.low.models),
        n_control=int(roles.get("control", 0)),
    )


def _total(covariance):
    return np.sqrt(np.trace(covariance, axis1=1, axis2=2))


def _rms(errors):
    errors = np.asarray(errors, dtype=float)
    return float(np.sqrt(np.mean(errors**2))) if errors.size else np.nan


def _values(block, result, totals):
    """Values with the precision of each; models that were not usable have none."""
    rows = block.low_flight.points_to_fit[["coverage", "model_id", "point_id"]]
    propagated = rows.assign(standard_error_total=totals)
    shown = [*rows.columns, "position_u", "position_v", "standard_error_paper"]
    return result.single_values[shown].merge(propagated, on=list(rows.columns))


def _points(block, points):
    geometry = block.geometry
    names = ["point_id", "role", "standard_error_total", "standard_error_paper"]
    true = block.truth.set_index("point_id").loc[points["point_id"]]
    return points[[*names, "n_models"]].assign(
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


def _figures(points, values, m_0):
    new = points[points["role"] == "new"]
    total = values["standard_error_total"].to_numpy()
    paper = values["standard_error_paper"].to_numpy()
    zones = zones_of(values)
    return ExpectedFigures(
        mean=_rms(new["standard_error_total"]),
        worst=float(np.quantile(new["standard_error_total"], 0.95)),
        single=_rms(total),
        **{f"single_{zone}": _rms(total[is_in]) for zone, is_in in zones.items()},
        paper_mean=_rms(new["standard_error_paper"]),
        paper_single=_rms(paper),
        **{f"paper_{zone}": _rms(paper[is_in]) for zone, is_in in zones.items()},
        m_0=m_0,
    )


def _verdict(expected):
    figures = expected.figures
    return translated(
        "Expected precision of {n:new point|new points}: {mean} (total, {coverages}); "
        "95 % are better than {worst}",
        n=int((expected.points["role"] == "new").sum()),
        mean=length(figures.mean),
        coverages=_coverages(expected.design.n_coverages),
        worst=length(figures.worst),
    )


def _summary(expected):
    figures, formula = expected.figures, expected.formula
    coverages = _coverages(expected.design.n_coverages)
    of_mean = mean_of_coverages(
        formula.M_centre, formula.M_edge, expected.design.n_coverages
    )
    rows = [
        _row(
            translated("one model, middle"), "single_centre", figures, formula.M_centre
        ),
        _row(translated("one model, edge"), "single_edge", figures, formula.M_edge),
        _row(translated("one model, corner"), "single_corner", figures, np.nan),
        _row(coverages, "mean", figures, float(of_mean)),
    ]
    header = [
        translated("[cm, total]"),
        translated("expected"),
        translated("formula"),
        translated("rule of 1971"),
    ]
    parts = ", ".join(
        translated(PARTS[source], length=length(value))
        for source, value in expected.parts.items()
    )
    return "\n".join(
        [
            expected.verdict,
            *_warnings(expected),
            "",
            typesetting.table(rows, header=header),
            _prose(translated(HOW_EXPECTED, m_0=length(figures.m_0))),
            "",
            _prose(translated("It comes from {parts}.", parts=parts)),
            _prose(_layout_text(expected)),
        ]
    )


def _prose(text):
    return wrapped(text, first="  ", indent="    ")


def _row(label, name, figures, by_rule):
    propagated = getattr(figures, name)
    formula = getattr(
        figures, name.replace("single_", "paper_").replace("mean", "paper_mean")
    )
    cells = (100.0 * float(value) for value in (propagated, formula, by_rule))
    return [label, *(typesetting.fixed(value, 1) for value in cells)]


def _coverages(n_coverages):
    if n_coverages == 1:
        return translated("one coverage")
    number_word = typesetting.number_word(n_coverages)
    return translated("mean of {number} coverages", number=number_word)


def _layout_text(expected):
    design = expected.design
    return translated(
        "Layout: {size} km, points {apart}; high flight {high}, m_g {high_m_g} µm, "
        "{n_high:model|models} on {n_control:control point|control points} of "
        "{control_error}; low flight {low}, m_g {m_g} µm, {n_low:model|models}, "
        "{kind}.",
        size=" x ".join(figure(side / 1e3, ".3g") for side in design.extent),
        apart=_apart(design),
        high=scale(design.scale_of_high_flight),
        high_m_g=number(design.noise().high_m_g_um),
        n_high=expected.n_high_models,
        n_control=expected.n_control,
        control_error=length(design.control_standard_error),
        low=scale(design.scale_number),
        m_g=number(design.m_g_um),
        n_low=expected.n_low_models,
        kind=design.kind,
    )


def _apart(design):
    message = mark("{spacing} m apart")
    if design.layout_spacing > design.spacing:
        message = mark("{spacing} m apart instead of {wanted}, which hardly matters")
    return translated(
        message,
        spacing=number(design.layout_spacing, 3),
        wanted=figure(design.spacing, "g"),
    )


def _warnings(expected):
    design = expected.design
    thinned = (design.layout_spacing / design.spacing) ** 2
    share = expected.n_control / (thinned * len(expected.points))
    if share <= MOST_ON_THE_GROUND:
        return []
    said = translated(
        "{n} of {n_all} points are control: little is left to be densified. Fly the "
        "high flight higher: its models need less then.",
        n=expected.n_control,
        n_all=len(expected.points),
    )
    return [_prose(said)]
