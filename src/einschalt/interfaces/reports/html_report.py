"""The report of a block as one HTML page that needs nothing else."""

from typing import NamedTuple

import numpy as np
from markupsafe import Markup

from einschalt.foundations.display_names import printable
from einschalt.foundations.kept_texts import retold
from einschalt.foundations.language import figure, language, mark, mark_each, translated
from einschalt.foundations.typesetting import (
    METRES_PER,
    MISSING,
    UNIT_TEXT,
    fixed,
    length,
    length_column,
    one_unit,
)
from einschalt.foundations.units import METRES_PER_MM
from einschalt.interfaces.provenance import within_block
from einschalt.interfaces.reports.error_unit import usual_error
from einschalt.interfaces.reports.packed_data import PackedData
from einschalt.interfaces.reports.page_models import pack_models
from einschalt.interfaces.reports.page_plots import plots
from einschalt.interfaces.reports.page_points import pack_points
from einschalt.interfaces.reports.page_templates import (
    TEMPLATES,
    sealed_parts,
    words_of_scripts,
)
from einschalt.interfaces.reports.precision_colours import STEPS
from einschalt.interfaces.reports.title_block import title_block
from einschalt.pipeline.assessment.credibility import Reason
from einschalt.pipeline.summary.sections import flights, precision
from einschalt.pipeline.summary.suggestions.catalogue import suggestions_of
from einschalt.pipeline.summary.summary import sections
from einschalt.pipeline.summary.verdict import verdict_on
from einschalt.pipeline.summary.wording import short_flight_name, transformation_name

MOST_MODELS = 500
WORST_MODELS = 100
WORST_ORIENTATIONS = 50
MOST_FAILURES = 200
MOST_KNOWN_POINTS = 20
MOST_SPREAD_POINTS = 20
IN_TEMPLATE = ("precision", "known_points", "flights")
"""Sections that have a place of their own in the page."""
PLOT_OF = {"error_sources": "sources", "claim": "correlogram"}
"""Plots that stand in sections of the summary."""


ROLES = mark_each({"new": "new", "control": "control", "check": "check"})
VERDICTS = mark_each({"critical": "critical", "weak": "weak", "safe": "safe"})
STAGES = mark_each(
    {
        "relative_orientation": "relative orientation",
        "approximate_coordinates": "approximate coordinates",
        "model_transformation": "model transformation",
        "adjustment": "adjustment",
    }
)
# of tables that are cut
LARGEST = mark("The largest {n} of {n_all:point|points}; the tables have the others.")
WORST = mark("The worst {n} of {n_all:model|models}; the tables have the others.")
FIRST = mark("The first {n} of {n_all:failure|failures}; the tables have the others.")


class Cut(NamedTuple):
    """A table that may show only its worst rows, and what it then says of that."""

    columns: tuple[str, ...]
    rows: list
    said: str = ""
    points: tuple = ()  # row of each row's point in the points of the result


def render(result, *, paper="auto") -> str:
    """Render the report of a densification as a page without external resources.

    Map, tables and plots are drawn by the page itself from data that lie in it; what
    has to be read stands in its text. All names are escaped. The same result gives the
    same page on the same day. ``paper``: size on which it is printed, "A4" or "letter",
    or "auto" for that of the printer.
    """
    told = result.assessment
    with one_unit(usual_error(result)) as unit:
        page = _told(told) | _tables(result)
    return TEMPLATES.get_template("report.html.j2").render(
        **page,
        block=result.block,
        notes=[retold(printable(note)) for note in result.block.notes],
        title_block=title_block(result),
        settings={
            name: MISSING if value in (None, "") else value
            for name, value in result.settings.model_dump().items()
        },
        sources={
            table: within_block(source)
            for table, source in result.block.sources.items()
        },
        claim=told.credible.column,
        data=Markup(page_data(result, unit)),
        **sealed_parts(paper),
    )


def _told(told):
    """What is said of the result: the words of its summary."""
    set_sections = sections(told)
    return {
        "verdict": verdict_on(told),
        "suggestions": suggestions_of(told.findings),
        "precision": set_sections["precision"],
        "caution": precision.caution(told.precision),
        "remarks": precision.all_remarks(
            told.precision,
            told.credible,
            told.credible_heights,
            is_untried=told.is_untried,
        ),
        "differences": set_sections["known_points"],
        "flights": set_sections["flights"],
        "approximations": (
            flights.approximation_remark(told.approximations),
            *flights.measured_error_remarks(told.flights),
        ),
        "orientation_remarks": flights.orientation_remarks(told.flights),
        "further": [
            (section, PLOT_OF.get(name, ""))
            for name, section in set_sections.items()
            if name not in IN_TEMPLATE
        ],
    }


def _tables(result):
    """Tables as text, for reading without scripts, and for paper."""
    claimed = result.assessment.credible.column
    return {
        "headline": _headline(result),
        "known_points": _known_points(result.points, claimed),
        "spread_points": _spread_points(result.points, claimed),
        "models": _models(result),
        "orientations": _orientations(result),
        "failures": _failures(result),
    }


def page_data(result, unit):
    """Everything that the page draws, compressed, as text."""
    claimed = result.assessment.credible.column
    packed = PackedData()
    packed.head |= {
        "unit": {"name": UNIT_TEXT.get(unit, unit), "metres": METRES_PER[unit]},
        "claim": claimed,
        "confidence": result.settings.confidence,
        "block": printable(result.block.name),
        "colours": STEPS,
        "plots": plots(result),
        "language": language(),
        "words": words_of_scripts(),
    }
    pack_points(packed, result, claimed)
    pack_models(packed, result)
    return packed.text()


def _headline(result):
    """Figures that stand large at the head of the page: number, and what it is."""
    figures, credible = result.figures, result.assessment.credible
    shown = [(figure(figures.n_new, "d"), translated("new points"))]
    if credible.is_lower_bound and np.isfinite(credible.value):
        text = translated("or worse, total: the stated precision is contradicted")
        shown.append((length(credible.value), text))
    elif credible.reason is Reason.ADJUSTED_ENLARGED:
        shown.append((length(credible.value), translated("total, enlarged by s_0")))
    elif np.isfinite(figures.mean_total):
        shown.append((length(figures.mean_total), translated("propagated, total")))
    spread = result.assessment.spread
    if spread is not None and not credible.is_lower_bound:
        most = length(spread.most)
        text = translated("median; 95th percentile {length}", length=most)
        shown.append((length(spread.median), text))
    if np.isfinite(figures.mean_paper):
        text = translated("by Kovarik’s budget, total")
        shown.append((length(figures.mean_paper), text))
    if np.isfinite(figures.mean_internal) and np.isnan(figures.mean_total):
        shown.append((length(figures.mean_internal), translated("internal, total")))
    if figures.n_check:
        message = mark("RMS at {n:check point|check points}, total")
        shown.append(
            (length(figures.check_rms), translated(message, n=figures.n_check))
        )
    elif figures.n_control:
        message = mark("RMS at {n:control point|control points}, total")
        shown.append(
            (length(figures.control_rms), translated(message, n=figures.n_control))
        )
    return shown


def _known_points(points, claimed):
    """Differences at control and check points, the largest first."""
    points = points.reset_index(drop=True)
    points = points[points["role"] != "new"]
    miss = np.hypot(points["difference_easting"], points["difference_northing"])
    order = miss.sort_values(ascending=False, kind="stable").index[:MOST_KNOWN_POINTS]
    shown = points.loc[order]
    metres = {
        translated("easting"): shown["difference_easting"],
        translated("northing"): shown["difference_northing"],
        translated("in plan"): miss.loc[order],
        translated("stated"): shown[claimed],
    }
    # one unit for all four, so that a row can be read across
    unit, texts = length_column(np.concatenate(list(metres.values())))
    parts = (texts[k * len(shown) : (k + 1) * len(shown)] for k in range(len(metres)))
    columns = {
        translated("point"): map(printable, shown["point_id"]),
        translated("role"): map(role_text, shown["role"]),
        **{f"{name} [{unit}]": part for name, part in zip(metres, parts, strict=True)},
    }
    return _cut(columns, len(points), LARGEST, shown.index)


def _spread_points(points, claim_column):
    """Points whose values lie farthest apart."""
    points = points.reset_index(drop=True)
    points = points[points["spread_total"].notna()]
    shown = points.nlargest(MOST_SPREAD_POINTS, "spread_total", keep="first")
    spread = length_column(shown["spread_total"])
    claimed = length_column(shown[claim_column])
    columns = {
        translated("point"): map(printable, shown["point_id"]),
        translated("role"): map(role_text, shown["role"]),
        translated("models"): map(_whole, shown["n_models"]),
        translated("coverages"): map(_whole, shown["n_coverages"]),
        f"{translated('spread')} [{spread.unit}]": spread.texts,
        f"{translated('stated')} [{claimed.unit}]": claimed.texts,
    }
    return _cut(columns, len(points), LARGEST, shown.index)


def role_text(role):
    """Write the role of a point."""
    return translated(ROLES.get(role, role))


def _models(result):
    """Every model, or the worst of many: those that failed, then by m_0."""
    models = result.models
    is_usable = models["is_usable"].astype(bool)
    shown = models
    if len(models) > MOST_MODELS:
        order = models.assign(usable=is_usable).sort_values(
            ["usable", "m_0"], ascending=[True, False], kind="stable"
        )
        shown = models.loc[order.index[:WORST_MODELS]]
    m_0, s_0 = length_column(shown["m_0"]), length_column(shown["s_0"])
    columns = {
        **_names(shown),
        translated("fit"): map(transformation_name, shown["transformation"]),
        translated("points"): map(_whole, shown["n_points"]),
        translated("redundancy"): map(_whole, shown["redundancy"]),
        f"m_0 [{m_0.unit}]": m_0.texts,
        f"s_0 [{s_0.unit}]": s_0.texts,
        translated("state"): map(_state, is_usable.loc[shown.index], shown["reason"]),
    }
    return _cut(columns, len(models), WORST)


def _orientations(result):
    """Relative orientations, the worst first: by verdict, then by sigma_0."""
    rows = result.orientations
    grave = rows["verdict"].map({"critical": 0, "weak": 1}).fillna(2)
    order = rows.assign(grave=grave).sort_values(
        ["grave", "sigma_0"], ascending=[True, False], kind="stable"
    )
    shown = order.head(WORST_ORIENTATIONS)
    sigma = length_column(shown["sigma_0"].astype(float) * METRES_PER_MM)
    columns = {
        **_names(shown),
        translated("verdict"): [
            translated(VERDICTS.get(verdict, verdict)) for verdict in shown["verdict"]
        ],
        translated("points"): map(_whole, shown["n_points"]),
        f"sigma_0 [{sigma.unit}]": sigma.texts,
        translated("tilt error relative to flat terrain"): [
            fixed(factor, 1) for factor in shown["inflation"]
        ],
        translated("reason"): map(_kept, shown["reason"]),
    }
    return _cut(columns, len(rows), WORST)


def _names(rows):
    """Columns that name a model."""
    return {
        translated("flight"): map(short_flight_name, rows["flight"]),
        translated("coverage"): map(printable, rows["coverage"]),
        translated("model"): map(printable, rows["model_id"]),
    }


def _state(is_usable, reason):
    if is_usable:
        return translated("usable")
    return translated("failed: {reason}", reason=_kept(reason))


def _kept(text):
    """A reason or remedy, which may name points."""
    return retold(printable(text))


def _failures(result):
    failures = result.failures
    shown = failures.head(MOST_FAILURES).fillna("")
    columns = {
        **_names(shown),
        translated("stage"): map(_stage, shown["stage"]),
        translated("reason"): map(_kept, shown["reason"]),
        translated("remedy"): map(_kept, shown["remedy"]),
    }
    return _cut(columns, len(failures), FIRST)


def _stage(name):
    title = name.partition("_")[2] or name
    return translated(STAGES[title]) if title in STAGES else _words(title)


def _cut(columns, n_all, message, points=()):
    """Table of columns by their headings, which says how many rows it leaves out."""
    rows, said = list(zip(*columns.values(), strict=True)), ""
    if len(rows) < n_all:
        said = translated(message, n=len(rows), n_all=n_all)
    return Cut(tuple(columns), rows, said, tuple(points))


def _words(name):
    return printable(name).replace("_", " ")


def _whole(value):
    return MISSING if not np.isfinite(value) else fixed(float(value), 0)
