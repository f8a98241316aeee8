"""Axes that figures are drawn on: given ones, or those of a new figure.

Their words, frames and colours are those of the report; data stay in metres, so that
whoever draws more on a map can draw in the coordinates of the tables.
"""

from dataclasses import dataclass

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.ticker import FuncFormatter, MaxNLocator

from einschalt.foundations.arguments import require_kind
from einschalt.foundations.language import (
    figure,
    language,
    translated,
    written_in,
)
from einschalt.foundations.typesetting import METRES_PER, UNIT_TEXT, one_unit
from einschalt.interfaces.reports.axis_figures import set_figures
from einschalt.interfaces.reports.precision_colours import STEPS, error_range

FAINT, EDGE = "#dfe5e8", "#6b7c85"
CONTROL, CHECK, APART = "#0b4f8a", "#b4430b", "#1f7a68"
MODEL, SUSPECT, CHOSEN = "#8a5a9e", "#d6006c", "#1c2b33"
FLIGHT_COLOURS = {"high_flight": "#b0601a", "low_flight": "#237566"}
SOURCE_COLOURS = {
    **FLIGHT_COLOURS,
    "control": CONTROL,
    "orientation": MODEL,
    "own_deformation": "#7d6c1c",
    "shared_bend": "#a08a2b",
    "approximate_points": "#66757e",
    "reference_system": "#9aa7ae",
    "control_groups": "#5f8fc0",
    "approximate_groups": "#a8b2b8",
}
PRECISION = LinearSegmentedColormap.from_list(
    "einschalt_precision", np.array(STEPS) / 255.0
)
MAP_IN, PLOT_IN = (7.4, 6.4), (7.0, 3.9)
IN_KM = 2_000.0
"""Extent from which on the axes of a map count in kilometres [m]."""


@dataclass(frozen=True)
class Unit:
    """The unit in which errors are written."""

    name: str
    metres: float

    def of(self, metres):
        """Lengths in this unit."""
        return np.asarray(metres, dtype=float) / self.metres


def unit_for(metres) -> Unit:
    """Unit that suits a usual error; centimetres where none is known."""
    with one_unit(float(metres)) as name:
        return Unit(UNIT_TEXT.get(name, name), METRES_PER[name])


def axes_for(ax, size=PLOT_IN, layout="constrained") -> Axes:
    """Axes that were given, or those of a new figure of ``size`` [in]."""
    require_kind(
        "ax",
        ax,
        Axes | None,
        expected="axes of matplotlib",
        remedy="Make them with matplotlib.pyplot.subplots(), or leave ax out",
    )
    return ax if ax is not None else plt.subplots(figsize=size, layout=layout)[1]


def write_title(ax, text):
    """Write what is drawn; dollar signs of names are no formulas."""
    look = {"fontweight": "bold", "fontsize": "medium", "parse_math": False}
    ax.set_title(text, loc="left", **look)


def frame(ax, *, title, x, y):
    """Write title and words of the axes, and draw a quiet frame."""
    write_title(ax, title)
    ax.set_xlabel(x)
    ax.set_ylabel(y)
    ax.spines[["top", "right"]].set_visible(False)
    ax.grid(color=FAINT, linewidth=0.5)
    ax.set_axisbelow(True)
    for axis in (ax.xaxis, ax.yaxis):
        set_figures(axis)


def colour_bar(ax, drawn, text, **options):
    """Draw the key of colours beside the axes."""
    bar = ax.figure.colorbar(drawn, ax=ax, shrink=0.8, pad=0.02, **options)
    bar.set_label(text)
    set_figures(bar.long_axis)
    bar.outline.set_visible(False)


def map_frame(ax, *, title, extent):
    """Frame of a map whose data are metres: equal aspect, few round coordinates."""
    in_km = extent >= IN_KM
    unit = "km" if in_km else "m"
    frame(
        ax,
        title=title,
        x=translated("easting [{unit}]", unit=unit),
        y=translated("northing [{unit}]", unit=unit),
    )
    ax.set_aspect("equal")
    metres, spoken = 1e3 if in_km else 1.0, language()

    def place_text(value, _):
        with written_in(spoken):
            return figure(value / metres, ".12g")

    def readout(east, north):
        with written_in(spoken):
            places = {"east": figure(east, ".3f"), "north": figure(north, ".3f")}
            return translated("E {east}  N {north}", **places)

    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))
        axis.set_major_formatter(FuncFormatter(place_text))
    ax.format_coord = readout


def colours_of(errors) -> Normalize:
    """Range of colours of errors, as the report has it."""
    known = errors[np.isfinite(errors)]
    low, high = error_range(known) if known.size else (0.0, 1.0)
    return Normalize(low, high if high > low else 1.1 * low + 1e-9)


def key_below(ax, handles=None, n_columns=3):
    """Write the key of what is drawn below the axes."""
    if handles is None:
        handles, _ = ax.get_legend_handles_labels()
    if handles:
        ax.legend(
            handles=handles,
            loc="upper center",
            bbox_to_anchor=(0.5, -0.13),
            ncols=min(n_columns, len(handles)),
            frameon=False,
            fontsize="small",
        )
