"""The sheet that a map is drawn on: axes to scale, north up, keys, and its SVG text."""

import io
import re
from dataclasses import dataclass

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator

from einschalt.foundations.typesetting import length, number

INK = "#1c2b33"
FAINT = "#dfe5e8"
EDGE = "#6b7c85"
# a matplotlibrc that lies where the program is started (or of the user) plays no part
PLAIN = {
    name: value
    for name, value in dict.items(mpl.rcParamsDefault)
    if not name.startswith("backend")
}
STYLE = {
    **PLAIN,
    "font.family": "sans-serif",
    "font.size": 9.0,
    "axes.edgecolor": EDGE,
    "axes.labelcolor": INK,
    "axes.linewidth": 0.6,
    "xtick.color": INK,
    "ytick.color": INK,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "text.color": INK,
    # text stays text: it can be searched, copied, and takes the font of the page
    "svg.fonttype": "none",
    "svg.hashsalt": "einschalt",
}
FONT = 8.5
RASTER_DPI = 160
WIDTH_IN = 7.4
LARGEST_MAP_IN = np.array([6.5, 6.8])
LEFT_IN, TOP_IN, GAP_IN = 0.75, 0.12, 0.5
BELOW_IN = 0.55
BAR_IN = 0.95


@dataclass(frozen=True, eq=False)
class MapSheet:
    """A figure with a map, and room below it."""

    figure: Figure
    axes: Axes  # the map, in kilometres
    below: tuple[float, float, float, float]  # the room, in parts of the figure
    width_m: float  # of the map on the ground [m]
    size_in: np.ndarray  # (2,), of the map on the sheet [inch]

    @property
    def m_per_in(self):
        """Metres on the ground for an inch of the sheet."""
        return self.width_m / self.size_in[0]


def map_sheet(points, *, foot_in=0.05) -> MapSheet:
    """Make a sheet for a map of points [m]: equal scale in both axes, north up."""
    low, high = _extent_km(points[["easting", "northing"]].to_numpy(dtype=float) / 1e3)
    size = (high - low) * (LARGEST_MAP_IN / (high - low)).min()
    bottom_in = foot_in + BELOW_IN + GAP_IN
    height_in = size[1] + TOP_IN + bottom_in
    figure = svg_figure((WIDTH_IN, height_in))
    sheet = np.array([WIDTH_IN, height_in])
    axes = figure.add_axes((*(np.array([LEFT_IN, bottom_in]) / sheet), *(size / sheet)))
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    axes.set(xlabel="Easting [km]", ylabel="Northing [km]")
    for axis, extent in ((axes.xaxis, size[0]), (axes.yaxis, size[1])):
        axis.set_major_locator(MaxNLocator(max(int(extent), 2), steps=[1, 2, 5, 10]))
        axis.set_major_formatter(FuncFormatter(_tick))
    axes.tick_params(length=2.5)
    axes.grid(color=FAINT, linewidth=0.5)
    axes.set_axisbelow(True)
    below = np.array([[LEFT_IN, foot_in], [LARGEST_MAP_IN[0], BELOW_IN]]) / sheet
    width_m = float(high[0] - low[0]) * 1e3
    return MapSheet(figure, axes, tuple(below.ravel()), width_m, size)


def svg_figure(size_in, **options):
    """Figure that is written as SVG."""
    figure = Figure(figsize=size_in, **options)
    FigureCanvasSVG(figure)
    return figure


def _extent_km(place_km):
    low, high = place_km.min(axis=0), place_km.max(axis=0)
    longest = max((high - low).max(), 0.01)
    # a strip stays readable where its map is at least a third as wide as it is long
    size = np.maximum(high - low, longest / 3.0) * 1.08
    centre = (low + high) / 2.0
    return centre - size / 2.0, centre + size / 2.0


def _tick(value, _place):
    return f"{value:.3f}".rstrip("0").rstrip(".")


def round_down(value):
    """Round down to 1, 2, 3 or 5 times a power of ten.

    Examples
    --------
    >>> round_down(4837.0), round_down(0.021), round_down(9.99)
    (3000.0, 0.02, 5.0)
    """
    power = 10.0 ** np.floor(np.log10(value))
    # 3e-5 / 1e-5 is a little less than 3
    most = value / power * (1.0 + 1e-12)
    step = max(step for step in (1.0, 2.0, 3.0, 5.0) if step <= most)
    return float(f"{step * power:.0e}")


def draw_lengths(sheet, exaggeration):
    """Draw the scale bars of map and (exaggerated) vectors below the map."""
    axes = _key_axes(sheet)
    metres_per_in = sheet.m_per_in
    ground_m = round_down(BAR_IN * metres_per_in)
    vector_m = round_down(BAR_IN * metres_per_in / exaggeration)
    bars = (
        (ground_m, ground_m / metres_per_in, "map"),
        (
            vector_m,
            vector_m * exaggeration / metres_per_in,
            f"vectors × {number(exaggeration)}",
        ),
    )
    for bottom, (metres, wide, what) in zip((0.42, 0.12), bars, strict=True):
        draw_bar(axes, bottom, wide, f"{length(metres)} ({what})")


def draw_bar(axes, bottom, wide, text, *, color=INK, linewidth=1.4):
    """Draw a scale bar on axes in inches, and say what it is."""
    axes.plot([0.0, wide], [bottom, bottom], color=color, linewidth=linewidth)
    for end in (0.0, wide):
        tick = [bottom - 0.04, bottom + 0.04]
        axes.plot([end, end], tick, color=color, linewidth=0.8)
    axes.text(wide + 0.1, bottom, text, va="center", fontsize=FONT)


def draw_key(sheet, markers, lines):
    """Draw the key of markers (label, marker, colour) and lines (label, colour)."""
    axes = _key_axes(sheet)
    for row, (label, marker, colour) in enumerate(markers):
        face, size = (colour, 3.0) if marker == "o" else ("white", 5.0)
        axes.plot(
            2.6,
            _row(row),
            linestyle="",
            marker=marker,
            markersize=size,
            markeredgecolor=colour,
            markerfacecolor=face,
        )
        axes.text(2.73, _row(row), label, va="center", fontsize=FONT)
    for row, (label, colour) in enumerate(lines):
        axes.plot([3.72, 3.97], [_row(row)] * 2, color=colour, linewidth=1.4)
        axes.text(4.05, _row(row), label, va="center", fontsize=FONT, parse_math=False)


def _row(row):
    return 0.46 - 0.19 * row


def _key_axes(sheet):
    """Axes in inches over the room below the map."""
    axes = sheet.figure.add_axes(sheet.below)
    axes.set(xlim=(0.0, LARGEST_MAP_IN[0]), ylim=(0.0, BELOW_IN), autoscale_on=False)
    axes.axis("off")
    return axes


def svg_of(figure, name, title) -> str:
    """Write a figure as an ``<svg>`` element for a page.

    Its ids start with ``name``, so that two figures of one page do not share any; the
    title is said to those who cannot see the figure.
    """
    buffer = io.StringIO()
    nothing = dict.fromkeys(("Creator", "Date", "Format", "Type"))
    figure.savefig(buffer, format="svg", dpi=RASTER_DPI, metadata=nothing)
    text = buffer.getvalue()
    text = text[text.index("<svg") :].rstrip()
    text = re.sub(r'\b(id="|href="#|url\(#)', rf"\g<1>{name}-", text)
    text = text.replace("<svg ", f'<svg role="img" aria-labelledby="{name}-title" ', 1)
    place = text.index(">") + 1
    return f'{text[:place]}\n <title id="{name}-title">{title}</title>{text[place:]}'
