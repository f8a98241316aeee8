"""What is printed of the expected precision of a planned block."""

import numpy as np

from einschalt.foundations import typesetting
from einschalt.foundations.language import figure, mark, mark_each, translated
from einschalt.foundations.typesetting import length, number, scale, wrapped
from einschalt.pipeline.planning.estimate.text import KIND_TEXT
from einschalt.pipeline.planning.flights.points_in_models import MOST_ON_THE_GROUND
from einschalt.theory.planning.kovarik_precision import mean_of_coverages

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
MEANS = mark_each(
    {
        "plain": "The mean of a point's values is the plain one.",
        "weighted": "The mean of a point's values has the weights 1 / M².",
        "rigorous": "The expected mean of a point's values is that of least variance, "
        "which densify takes by default; that of formula and rule is the plain one.",
    }
)


def describe_verdict(expected) -> str:
    """Say how good the new points will be, in a sentence."""
    figures = expected.figures
    coverages = _coverages(expected.design.n_coverages)
    if expected.design.n_coverages == 1:  # beside the values of single models
        coverages = translated("one coverage, mean of the models of each point")
    return translated(
        "Expected precision of {n:new point|new points}: {mean} (total, {coverages}); "
        "95 % are better than {worst}",
        n=int((expected.points["role"] == "new").sum()),
        mean=length(figures.mean),
        coverages=coverages,
        worst=length(figures.worst),
    )


def describe_expected(expected) -> str:
    """Set the expected precision beside that of the formula of 1971."""
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
            _prose(translated(MEANS[expected.weighting])),
            "",
            _prose(translated("Contributions: {parts}.", parts=parts)),
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
        kind=translated(KIND_TEXT[design.kind]),
    )


def _warnings(expected):
    design = expected.design
    thinned = (design.layout_spacing / design.spacing) ** 2
    share = expected.n_control / (thinned * len(expected.points))
    if share < MOST_ON_THE_GROUND:
        return []
    said = translated(
        "{n} of {n_all} points are control: little is left to be densified. Fly the "
        "high flight higher, where that is allowed: its models need less then.",
        n=expected.n_control,
        n_all=len(expected.points),
    )
    return [_prose(said)]


def _coverages(n_coverages):
    if n_coverages == 1:
        return translated("one coverage")
    number_word = typesetting.number_word(n_coverages)
    return translated("mean of {number} coverages", number=number_word)


def _apart(design):
    message = mark("{spacing} m apart")
    if design.layout_spacing > design.spacing:
        message = mark("{spacing} m apart instead of {wanted}, which hardly matters")
    return translated(
        message,
        spacing=number(design.layout_spacing, 3),
        wanted=figure(design.spacing, "g"),
    )
