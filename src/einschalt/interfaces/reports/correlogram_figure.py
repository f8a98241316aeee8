"""Correlation of the low flight's residuals by distance, as SVG text."""

import matplotlib as mpl
import numpy as np

from einschalt.interfaces.reports.map_sheet import (
    INK,
    STYLE,
    WIDTH_IN,
    svg_figure,
    svg_of,
)

EXPECTED = "#c9d6db"
OBSERVED = "#b4430b"
HEIGHT_IN = 2.3
SPREAD = 2.0  # standard deviations of the draws to either side


def correlogram_figure(result) -> str:
    """Draw the correlation of residuals by distance over what the claim predicts.

    An ``<svg>`` element; empty where no correlation was computed.
    """
    field = result.claim.residuals
    if field is None or not len(field.correlogram.distance):
        return ""
    observed, expected = field.correlogram, field.expected
    with mpl.rc_context(STYLE):
        figure = svg_figure((WIDTH_IN, HEIGHT_IN), layout="constrained")
        axes, distance = figure.add_subplot(), expected.distance
        mean = expected.correlation.mean(axis=1)
        spread = SPREAD * expected.correlation.std(axis=1, ddof=1)
        axes.fill_between(
            distance,
            mean - spread,
            mean + spread,
            color=EXPECTED,
            linewidth=0,
            label="where the claim holds (±2 standard deviations)",
        )
        axes.plot(
            observed.distance,
            observed.correlation,
            "o-",
            color=OBSERVED,
            label="measured",
        )
        axes.axhline(0.0, color=INK, linewidth=0.6)
        axes.set(
            xlabel="distance [m]",
            ylabel="correlation",
            xlim=(0.0, 1.05 * float(np.max(observed.distance))),
        )
        axes.spines[["top", "right"]].set_visible(False)
        axes.legend(frameon=False, fontsize=8)
        return svg_of(figure, "correlogram", "Correlation of residuals by distance")
