"""Style of the figures that matplotlib draws, their scale bars, and their SVG text."""

import io
import re

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

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


def svg_figure(size_in, **options):
    """Figure that is written as SVG."""
    figure = Figure(figsize=size_in, **options)
    FigureCanvasSVG(figure)
    return figure


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


def draw_bar(axes, bottom, wide, text, color):
    """Draw a scale bar on axes in inches, and say what it is."""
    axes.plot([0.0, wide], [bottom, bottom], color=color, linewidth=1.6)
    for end in (0.0, wide):
        tick = [bottom - 0.04, bottom + 0.04]
        axes.plot([end, end], tick, color=color, linewidth=0.8)
    axes.text(wide + 0.1, bottom, text, va="center", fontsize=FONT)


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
