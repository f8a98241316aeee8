"""Diagrams of a result on axes of matplotlib; the numbers are those of the report.

Each takes axes, or None for new ones, and the result, and gives the axes back. Where
there is nothing to draw it raises a TableError that says why.
"""

import numpy as np
from matplotlib.ticker import MaxNLocator

from einschalt.foundations.errors import TableError
from einschalt.foundations.language import mark, numbers_set, translated
from einschalt.foundations.typesetting import length, number, per_cent
from einschalt.interfaces.notebook.axes import (
    APART,
    CHECK,
    CONTROL,
    EDGE,
    FLIGHT_COLOURS,
    PRECISION,
    SOURCE_COLOURS,
    axes_for,
    colours_of,
    frame,
    key_below,
    unit_for,
)
from einschalt.interfaces.notebook.claimed import claimed_errors
from einschalt.interfaces.reports import page_plots
from einschalt.interfaces.reports.error_unit import usual_error
from einschalt.pipeline.summary.wording import flight_name

FEWEST_BINS, MOST_BINS = 8, 44
MOST_LARGE = 4.0
"""Times the 90 % quantile of m_0: what is larger is drawn at the upper edge."""
MARKS = ((mark("median"), 0.5), ("95 %", 0.95))


def precision(ax, result, column=None):
    """Histogram of the standard errors of the new points."""
    column, errors = claimed_errors(result, column)
    colours = colours_of(errors)
    unit = unit_for(colours.vmax)
    n_bins = int(np.clip(2.0 * np.sqrt(len(errors)), FEWEST_BINS, MOST_BINS))
    edges = np.linspace(colours.vmin, colours.vmax, n_bins + 1)
    counts, _ = np.histogram(np.minimum(errors, colours.vmax), edges)
    ax = axes_for(ax)
    middles = (edges[:-1] + edges[1:]) / 2.0
    width = unit.of(edges[1] - edges[0])
    bars = ax.bar(unit.of(middles), counts, 0.92 * width)
    for bar, error in zip(bars, middles, strict=True):
        bar.set_color(PRECISION(colours(error)))
    rms = float(np.sqrt(np.mean(errors**2)))
    marks = [(name, float(np.quantile(errors, part))) for name, part in MARKS]
    _mark(ax, unit, [*marks, ("RMS", rms)], colours.vmax)
    x, n_out = f"{column} [{unit.name}]", int((errors > colours.vmax).sum())
    if n_out:
        x = translated("{axis}; the last bar holds {n} beyond it", axis=x, n=n_out)
    title = mark("Precision of {n:new point|new points}")
    frame(ax, title=translated(title, n=len(errors)), x=x, y=translated("points"))
    ax.yaxis.set_major_locator(MaxNLocator(integer=True))
    return ax


def _mark(ax, unit, marks, most):
    """Draw values as lines, with a key; those beyond the axis are in the key alone."""
    styles = ("-", (0, (5, 2)), (0, (1, 1.5)))
    for (name, value), style in zip(marks, styles, strict=True):
        x = [unit.of(value)] if value <= most else []
        label = f"{numbers_set(translated(name))} {length(value)}"
        line = {"color": EDGE, "linestyle": style, "linewidth": 1.3, "label": label}
        if x:
            ax.axvline(x[0], **line)
        else:
            ax.plot([], [], **line)
    ax.legend(frameon=False, fontsize="small")


def residuals(ax, result):
    """Histogram of the residuals in standard deviations of their flight."""
    given = _known(page_plots.standardised_residuals(result.residuals), RESIDUALS)
    ax = _histogram(axes_for(ax), given)
    said = translated(
        "Residuals of the models, {n:coordinate|coordinates}", n=given["n"]
    )
    x = translated("residual / its standard deviation in the flight")
    frame(ax, title=said, x=f"{x}{_far(given)}", y=translated("values"))
    return ax


def parallaxes(ax, result):
    """Histogram of the parallaxes that relative orientations leave."""
    given = _known(page_plots.residual_parallaxes(result), PARALLAXES)
    ax = _histogram(axes_for(ax), given)
    said = translated("Residual parallaxes, {n:value|values}", n=given["n"])
    size = length(given["scale"])
    x = translated("parallax / its RMS of {size} in the image", size=size)
    frame(ax, title=said, x=f"{x}{_far(given)}", y=translated("values"))
    return ax


def _histogram(ax, given):
    edges = np.array(given["edges"])
    ax.stairs(given["counts"], edges, fill=True, color=APART, alpha=0.55)
    x = np.linspace(edges[0], edges[-1], 201)
    bell = given["n"] * (edges[1] - edges[0]) * np.exp(-(x**2) / 2.0)
    line = {"color": CHECK, "linewidth": 1.2, "label": translated("normal")}
    ax.plot(x, bell / np.sqrt(2.0 * np.pi), **line)
    ax.legend(frameon=False, fontsize="small")
    ax.set_xlim(edges[0], edges[-1])
    return ax


def _far(given):
    if not given["n_far"]:
        return ""
    message = mark("({n:value|values} beyond ±5 in the outer bars)")
    return f" {translated(message, n=given['n_far'])}"


def quantiles(ax, result):
    """Quantiles of the residuals beside those of the normal distribution."""
    given = _known(page_plots.standardised_residuals(result.residuals), RESIDUALS)
    ax = axes_for(ax, (4.6, 4.6))
    expected, observed = np.array(given["expected"]), np.array(given["observed"])
    end = 1.05 * max(np.abs(expected).max(), np.abs(observed).max())
    ax.plot([-end, end], [-end, end], color=EDGE, linewidth=1.0)
    ax.plot(expected, observed, "o", color=CONTROL, markersize=3)
    frame(
        ax,
        title=translated(
            "Normal Q–Q of {n:residual coordinate|residual coordinates}", n=given["n"]
        ),
        x=translated("expected [standard deviations]"),
        y=translated("observed [standard deviations]"),
    )
    ax.set(xlim=(-end, end), ylim=(-end, end), aspect="equal")
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_locator(MaxNLocator(7, steps=[1, 2, 5, 10]))
    return ax


def m_0_per_model(ax, result):
    """m_0 of every model in the order of the models, a colour for each flight."""
    models = result.models
    m_0 = models["m_0"].to_numpy(dtype=float)
    is_known = np.isfinite(m_0)
    if not is_known.any():
        raise _nothing("m_0 of its models", "models with redundancy")
    top = min(m_0[is_known].max(), MOST_LARGE * np.quantile(m_0[is_known], 0.9))
    unit = unit_for(np.median(m_0[is_known]))
    ax, place = axes_for(ax), np.arange(1, len(models) + 1)
    for flight, colour in FLIGHT_COLOURS.items():
        is_own = is_known & (models["flight"] == flight).to_numpy()
        if not is_own.any():
            continue
        median = float(np.median(m_0[is_own]))
        facts = {"flight": flight_name(flight), "length": length(median)}
        name = translated("{flight}, median {length}", **facts)
        heights = unit.of(np.minimum(m_0[is_own], top))
        ax.plot(place[is_own], heights, "o", color=colour, markersize=3.5, label=name)
        ends = place[is_own][[0, -1]]
        ax.plot(ends, 2 * [unit.of(median)], color=colour, linewidth=1.0)
    _draw_failed(ax, models, place, unit.of(np.minimum(m_0, top)))
    n_out = int((m_0[is_known] > top).sum())
    title = translated("m_0 of {n:model|models}", n=int(is_known.sum()))
    if n_out:
        message = mark("{title}; {n} larger, at the upper edge")
        title = translated(message, title=title, n=n_out)
    y = translated("m_0, total [{unit}]", unit=unit.name)
    frame(ax, title=title, x=translated("models in their order"), y=y)
    ax.set_ylim(0.0, 1.06 * unit.of(top))
    ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    key_below(ax)
    return ax


def _draw_failed(ax, models, place, heights):
    has_failed = ~models["is_usable"].astype(bool).to_numpy()
    if has_failed.any():
        heights = np.where(np.isfinite(heights), heights, 0.0)[has_failed]
        message = mark("{n:failed model|failed models}")
        name = translated(message, n=int(has_failed.sum()))
        ax.plot(
            place[has_failed],
            heights,
            "x",
            color=CHECK,
            markersize=6,
            label=name,
            clip_on=False,
        )


def sources(ax, result):
    """Variance of the new points by its sources, from good points to bad."""
    given = _known(page_plots.sources_of_error(result), SOURCES)
    parts = np.array(given["classes"], dtype=float)
    unit = unit_for(usual_error(result))
    ax, bottom, place = axes_for(ax), np.zeros(len(parts)), np.arange(len(parts))
    named = zip(given["codes"], given["names"], given["shares"], strict=True)
    for k, (code, name, share) in enumerate(named):
        height = unit.of(unit.of(parts[:, k]))
        colour = SOURCE_COLOURS.get(code, EDGE)
        label = f"{name}, {per_cent(share)}"
        ax.bar(place, height, 0.84, bottom=bottom, color=colour, label=label)
        bottom = bottom + height
    ax.set_xticks(place, [number(error) for error in np.sqrt(bottom)])
    x = translated("total error [{unit}]", unit=unit.name)
    if len(parts) > 1:
        x = translated("tenths of them, from good to bad: {axis}", axis=x)
    frame(
        ax,
        title=translated("Sources of the error of the new points"),
        x=x,
        y=translated("variance [{unit}²]", unit=unit.name),
    )
    ax.grid(visible=False, axis="x")
    ax.tick_params(axis="x", length=0)
    key_below(ax, n_columns=2)
    return ax


def correlogram(ax, result):
    """Correlation of residuals by distance, and where it lies if the claim holds."""
    given = _known(page_plots.correlogram(result.claim.residuals), CORRELOGRAM)
    given = {name: np.array(values, dtype=float) for name, values in given.items()}
    ax = axes_for(ax)
    ax.axhline(0.0, color=EDGE, linewidth=0.7)
    ax.fill_between(
        *(given[name] for name in ("claimed_distance", "low", "high")),
        color=EDGE,
        alpha=0.25,
        linewidth=0,
        label=translated("where the claim holds, ±2 standard deviations"),
    )
    line = {"color": CONTROL, "markersize": 4, "label": translated("measured")}
    ax.plot(given["distance"], given["measured"], "o-", **line)
    frame(
        ax,
        title=translated("Correlation of residuals by distance"),
        x=translated("distance [m]"),
        y=translated("correlation"),
    )
    ax.set_xlim(0.0, None)
    ax.legend(frameon=False, fontsize="small")
    return ax


def neighbours(ax, result):
    """Precision of coordinate differences between neighbours, by their distance."""
    table = result.neighbours
    if table is None or not len(table):
        raise _nothing("precision of neighbours", "errors that were propagated")
    unit = unit_for(usual_error(result))
    ax, distance = axes_for(ax), table["distance"].to_numpy()
    shown = (
        ("standard_error_if_independent", EDGE, mark("if points shared no error")),
        ("standard_error_total", CONTROL, mark("propagated")),
    )
    for column, colour, name in shown:
        errors = table[column].to_numpy(dtype=float)
        label = f"{translated(name)}, {length(np.sqrt(np.mean(errors**2)))} RMS"
        dots = {"color": colour, "markersize": 2, "alpha": 0.5, "label": label}
        ax.plot(distance, unit.of(errors), "o", rasterized=True, **dots)
    frame(
        ax,
        title=translated(
            "Differences between {n:pair|pairs} of neighbours", n=len(table)
        ),
        x=translated("distance [m]"),
        y=translated("standard error, total [{unit}]", unit=unit.name),
    )
    ax.set_ylim(0.0, None)
    ax.legend(frameon=False, fontsize="small", markerscale=2.5)
    return ax


def paper(ax, result):
    """Standard errors after Kovarik's budget beside those that are claimed."""
    points = result.points[result.points["role"] == "new"]
    column = result.assessment.credible.column
    both = points[["standard_error_paper"]].assign(claimed=points.get(column)).dropna()
    if column == "standard_error_paper" or both.empty:
        raise _nothing("figure beside that of Kovarik's budget", "propagated errors")
    unit, ax = unit_for(usual_error(result)), axes_for(ax, (4.8, 4.8))
    by_paper, claimed = (unit.of(both.iloc[:, k].to_numpy()) for k in range(2))
    end = 1.05 * max(*(_most_of(values) for values in (by_paper, claimed)))
    ax.plot([0.0, end], [0.0, end], color=EDGE, linewidth=1.0)
    dots = {"color": CONTROL, "markersize": 2.2, "alpha": 0.5, "rasterized": True}
    ax.plot(np.minimum(claimed, end), np.minimum(by_paper, end), "o", **dots)
    share = float(np.mean(by_paper < claimed))
    frame(
        ax,
        title=translated(
            "Kovarik's figure is the smaller one at {share}", share=per_cent(share)
        ),
        x=f"{column} [{unit.name}]",
        y=f"standard_error_paper [{unit.name}]",
    )
    ax.set(xlim=(0.0, end), ylim=(0.0, end), aspect="equal")
    return ax


def _most_of(values):
    """Largest value, or nearly the largest where a few are far out."""
    return min(values.max(), 2.0 * np.quantile(values, 0.95))


RESIDUALS = "standardised residuals", "at least 20 residuals with redundancy"
PARALLAXES = "residual parallaxes", "at least 20 of relative orientations"
SOURCES = "sources of error", "errors that were propagated"
CORRELOGRAM = (
    "correlations of residuals",
    "two steps, and residuals at known distances",
)


def _known(given, words):
    if given is None:
        raise _nothing(*words)
    return given


def _nothing(what, expected):
    return TableError(f"this result has no {what}", expected=expected)
