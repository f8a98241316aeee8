"""Krames' construction as SVG text: both base-normal planes of a six-point model.

In each plane the circle of zero parallax has its diameter from the projection centre 0
to the fundamental point G. The perpendicular from G meets the ray of a point on this
circle; the point lies S below the perpendicular, and its parallax is -S dω. So all
parallaxes of a plane are seen at once, to one scale.
"""

from dataclasses import dataclass
from html import escape

import matplotlib as mpl
import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Circle
from matplotlib.ticker import MaxNLocator

from einschalt.foundations import tables
from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import GeometryError
from einschalt.foundations.language import mark, translated
from einschalt.foundations.typesetting import number
from einschalt.foundations.units import RADIANS_PER_GON
from einschalt.interfaces.reports.axis_figures import set_figures
from einschalt.interfaces.reports.figure_style import (
    EDGE,
    FAINT,
    INK,
    STYLE,
    svg_figure,
    svg_of,
)
from einschalt.stages.results import row_of_model
from einschalt.theory.relative_orientation.six_points import number_six_points

POSITIVE, NEGATIVE = "#0b4f8a", "#b4430b"
CIRCLE = "#2f8f7a"
SMALL = 8.0
WIDTH_IN, LEFT_IN, RIGHT_IN, GAP_IN = 7.4, 0.5, 0.1, 0.35
TOP_IN, FOOT_IN = 0.42, 0.98
LARGEST_IN = 5.2
SUPERSCRIPTS = ("⁰", "ᵇ")
PLANES = (mark("Plane x = 0, left centre"), mark("Plane x = b, right centre"))
ZERO = mark("circle of zero parallax")
FARTHEST = 2.5
"""G is shown up to so many times the distance of the farthest point."""


def krames_figure(oriented, y_parallaxes, model_id, coverage=None) -> str:
    """Draw the construction of a model's fundamental points as an ``<svg>`` element.

    ``coverage`` is needed where two coverages have a model of that name. GeometryError
    where the model does not have three points in each of the planes x = 0 and x = base.
    """
    construction = _Construction.of(oriented, y_parallaxes, model_id, coverage)
    with mpl.rc_context(STYLE):
        figure = _drawn(construction)
        message = mark("Krames' construction for model {name}")
        title = translated(message, name=shortened(construction.model_id))
        return svg_of(figure, "krames", escape(title, quote=False))


@dataclass(frozen=True, eq=False)
class _Construction:
    """What is drawn, by plane: (2,) or (2, 3)."""

    model_id: str
    names: np.ndarray
    y: np.ndarray
    z: np.ndarray
    parallax: np.ndarray
    Y: np.ndarray
    Z: np.ndarray
    d_omega: np.ndarray
    delta_omega: float
    w: float

    @classmethod
    def of(cls, oriented, y_parallaxes, model_id, coverage):
        """Gather a model's points and what was found from them."""
        place = row_of_model(oriented.models, model_id, coverage)
        found = oriented.contradiction.iloc[place]
        model = oriented.models.iloc[place]
        if not np.isfinite(found["N_0"]):
            raise GeometryError(
                "it has no three points in each of the planes x = 0 and x = base",
                expected="six points, for Krames' construction",
                model=model_id,
            )
        rows = tables.with_coverage(y_parallaxes)
        is_own = rows["model_id"].astype(str) == model["model_id"]
        is_own &= rows["coverage"].astype(str) == model["coverage"]
        own = rows[is_own]
        own = own.iloc[number_six_points(own[["x", "y", "z"]].to_numpy(dtype=float))]
        by_plane = {
            column: own[column].to_numpy(dtype=float).reshape(2, 3)
            for column in ("y", "z", "y_parallax")
        }
        return cls(
            model_id=model["model_id"],
            names=own["point_id"].astype(str).to_numpy().reshape(2, 3),
            y=by_plane["y"],
            z=by_plane["z"],
            parallax=by_plane["y_parallax"],
            Y=found[["Y_0", "Y_b"]].to_numpy(dtype=float),
            Z=found[["Z_0", "Z_b"]].to_numpy(dtype=float),
            d_omega=found[["d_omega_0", "d_omega_b"]].to_numpy(dtype=float),
            delta_omega=found["delta_omega"],
            w=found["w"],
        )

    @property
    def size(self):
        """Distance of the farthest point from its projection centre."""
        return np.hypot(self.y, self.z).max()

    @property
    def has_point(self):
        """Whether G is near enough to be drawn, (2,)."""
        distance = np.hypot(self.Y, self.Z)
        return np.isfinite(distance) & (distance <= FARTHEST * self.size)

    @property
    def _near(self):
        """G where it is drawn, NaN where it lies as far as infinity."""
        return np.where(self.has_point, [self.Y, self.Z], np.nan)

    @property
    def on_perpendicular(self):
        """Height of the perpendicular from G above or below each point, (2, 3)."""
        Y, Z = self._near
        return Z[:, None] + self.y / self.z * (Y[:, None] - self.y)

    @property
    def feet(self):
        """Feet of the perpendiculars, on the rays and on the circle, (2, 3, 2)."""
        points = np.stack([self.y, self.z], axis=-1)
        Y, Z = self._near
        along = self.y * Y[:, None] + self.z * Z[:, None]
        return points * (along / (self.y**2 + self.z**2))[..., None]


def _drawn(construction):
    """Both planes side by side, in one scale."""
    low, high = _extent(construction)
    wide = (WIDTH_IN - LEFT_IN - RIGHT_IN - GAP_IN) / 2.0
    tall = min(wide * (high[1] - low[1]) / (high[0] - low[0]), LARGEST_IN)
    sheet = np.array([WIDTH_IN, tall + TOP_IN + FOOT_IN])
    figure = svg_figure(tuple(sheet))
    for plane in range(2):
        corner = np.array([LEFT_IN + plane * (wide + GAP_IN), FOOT_IN])
        box = (*(corner / sheet), *(np.array([wide, tall]) / sheet))
        axes = figure.add_axes(box)
        _draw_frame(axes, low, high, is_left=plane == 0)
        _draw_plane(axes, construction, plane)
    _draw_foot(figure, construction, sheet)
    return figure


def _extent(construction):
    """Lower and upper corner of what both panels show: y, z."""
    size = construction.size
    corners = [np.stack([construction.y, construction.z], axis=-1).reshape(-1, 2)]
    corners.append(np.zeros((1, 2)))
    for plane in np.flatnonzero(construction.has_point):
        G = np.array([construction.Y[plane], construction.Z[plane]])
        # the whole circle: its centre, and its radius to all sides
        corners.append(G / 2.0 + np.hypot(*G) / 2.0 * np.array([[-1, -1], [1, 1]]))
        tips = construction.on_perpendicular[plane]
        corners.append(np.column_stack([construction.y[plane], tips]))
    corners = np.vstack(corners)
    # the parallaxes of the wings are written outside of them
    margin = np.array([0.3, 0.14]) * size
    return corners.min(axis=0) - margin, corners.max(axis=0) + margin


def _draw_frame(axes, low, high, *, is_left):
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    axes.set_adjustable("datalim")
    axes.spines[:].set_visible(False)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
        set_figures(axis)
    axes.tick_params(length=0, labelsize=SMALL, labelcolor=EDGE, labelleft=is_left)
    axes.grid(color=FAINT, linewidth=0.5)
    axes.set_axisbelow(True)
    axes.axhline(0.0, color=EDGE, linewidth=0.6)
    axes.axvline(0.0, color=EDGE, linewidth=0.6)


def _draw_plane(axes, construction, plane):
    sign = SUPERSCRIPTS[plane]
    tilt = number(construction.d_omega[plane] / RADIANS_PER_GON, 3)
    title = f"{translated(PLANES[plane])}\ndω{sign} = {_signed(tilt)} gon"
    axes.set_title(title, fontsize=9.0, loc="left", linespacing=1.4)
    for y, z in zip(construction.y[plane], construction.z[plane], strict=True):
        axes.plot([0.0, y], [0.0, z], color=EDGE, linewidth=0.7, zorder=2)
    if construction.has_point[plane]:
        _draw_circle(axes, construction, plane)
    else:
        _say_where(axes, construction, plane)
    _draw_points(axes, construction, plane)
    axes.plot(0.0, 0.0, "o", markersize=7, markeredgecolor=INK, color="white", zorder=6)
    axes.plot(0.0, 0.0, ".", markersize=3, color=INK, zorder=7)


def _say_where(axes, construction, plane):
    """Say where G is when it is off the sheet."""
    Y, Z = construction.Y[plane], construction.Z[plane]
    G = f"G{SUPERSCRIPTS[plane]}"
    text = translated("{G} lies at infinity: the plane shows no tilt", G=G)
    if np.isfinite(Y) and np.isfinite(Z):
        where = f"y = {_signed(number(Y, 3))}, z = {_signed(number(Z, 3))}"
        text = translated("{G} lies off the sheet, at {where}", G=G, where=where)
    axes.text(
        *(0.5, 0.98, text),
        transform=axes.transAxes,
        ha="center",
        va="top",
        color=CIRCLE,
        fontsize=SMALL,
        zorder=8,
        bbox={"fc": "white", "ec": "none", "alpha": 0.85, "pad": 1.0},
    )


def _draw_circle(axes, construction, plane):
    """The circle, its diameter, and the perpendiculars from G to the rays."""
    G = np.array([construction.Y[plane], construction.Z[plane]])
    radius = float(np.hypot(*G)) / 2.0
    axes.add_patch(Circle(G / 2.0, radius, fc=CIRCLE, alpha=0.07, ec="none", zorder=1))
    axes.add_patch(
        Circle(G / 2.0, radius, fill=False, ec=CIRCLE, linewidth=1.2, zorder=3)
    )
    axes.plot([0.0, G[0]], [0.0, G[1]], ":", color=CIRCLE, linewidth=1.0, zorder=2)
    for j in range(3):
        y, z = construction.y[plane, j], construction.z[plane, j]
        foot, tip = construction.feet[plane, j], construction.on_perpendicular[plane, j]
        # from G to the farther one of foot and tip, and both lie on one line
        line = np.array([G, foot, [y, tip]])
        line = line[np.argsort(line @ np.array([z, -y]))]
        axes.plot(*line.T, color=CIRCLE, linewidth=0.7, zorder=3)
        axes.plot([0.0, foot[0]], [0.0, foot[1]], color=EDGE, linewidth=0.7, zorder=2)
        _draw_right_angle(axes, foot, np.array([y, z]), G - foot, construction.size)
    axes.plot(*G, "o", markersize=6, markeredgecolor=CIRCLE, color="white", zorder=6)
    _label(axes, G, G / 2.0, f"G{SUPERSCRIPTS[plane]}", CIRCLE)


def _draw_right_angle(axes, corner, ray, towards, size):
    length = np.hypot(*towards)
    if length < 0.05 * size:
        return
    one = -ray / np.hypot(*ray) * 0.03 * size
    other = towards / length * 0.03 * size
    mark = np.array([corner + one, corner + one + other, corner + other])
    axes.plot(*mark.T, color=CIRCLE, linewidth=0.6, zorder=3)


def _draw_points(axes, construction, plane):
    """The points, with their parallaxes as the distances S from the perpendiculars."""
    has_point = construction.has_point[plane]
    for j in range(3):
        place = np.array([construction.y[plane, j], construction.z[plane, j]])
        p = construction.parallax[plane, j]
        colour = POSITIVE if p > 0.0 else NEGATIVE if p < 0.0 else INK
        tip = construction.on_perpendicular[plane, j] if has_point else place[1]
        bar = {"linewidth": 2.6, "solid_capstyle": "butt", "zorder": 4}
        axes.plot([place[0]] * 2, [place[1], tip], color=colour, **bar)
        axes.plot(*place, "o", markersize=5.5, color=INK, zorder=6)
        name = shortened(construction.names[plane, j], 8)
        aside = -1.0 if place[0] < -0.25 * construction.size else 1.0
        away = 1.0 if tip < place[1] else -1.0
        _write(axes, place, name, (0.0, 9.0 * away), INK, weight="bold")
        middle = np.array([place[0], (place[1] + tip) / 2.0])
        _write(axes, middle, _signed(number(p, 3)), (6.0 * aside, 0.0), colour)


def _write(axes, place, text, offset, colour, **style):
    """Write beside a place, ``offset`` in points of print, over a white ground."""
    sides = {-1.0: "right", 0.0: "center", 1.0: "left"}
    usual = {"ha": sides[np.sign(offset[0])], "fontsize": SMALL}
    axes.annotate(
        text,
        place,
        xytext=offset,
        textcoords="offset points",
        va="center",
        color=colour,
        parse_math=False,
        zorder=8,
        bbox={"fc": "white", "ec": "none", "alpha": 0.7, "pad": 0.6},
        **{**usual, **style},
    )


def _label(axes, place, away_from, text, colour):
    """Write beside a point, on the side that looks away from another place."""
    towards = 12.0 * (place - away_from) / np.hypot(*(place - away_from))
    _write(axes, place, text, tuple(towards), colour, ha="center", fontsize=9.5)


def _draw_foot(figure, construction, sheet):
    handles = [
        Line2D([], [], color=EDGE, linewidth=0.7, label=translated("ray")),
        Line2D([], [], color=CIRCLE, linewidth=1.2, label=translated(ZERO)),
        Line2D([], [], color=POSITIVE, linewidth=2.6, label="p > 0"),
        Line2D([], [], color=NEGATIVE, linewidth=2.6, label="p < 0"),
    ]
    figure.legend(
        handles=handles,
        loc="lower left",
        bbox_to_anchor=(LEFT_IN / sheet[0], 0.47 / sheet[1]),
        ncols=4,
        frameon=False,
        fontsize=SMALL,
        borderpad=0.0,
        borderaxespad=0.0,
    )
    delta = _signed(number(construction.delta_omega / RADIANS_PER_GON, 3))
    w, sigma_0 = construction.w, number(abs(construction.w) / np.sqrt(12.0))
    rule = translated(
        "A point lies S below the perpendicular from G on its ray; p = −S dω."
    )
    facts = {"delta": delta, "w": _signed(number(w, 3))}
    result = translated("Contradiction dω⁰ − dωᵇ = {delta} gon;  w = {w}", **facts)
    lines = (rule, f"{result},  σ₀ = |w|/√12 = {sigma_0}")
    for height_in, line in zip((0.27, 0.09), lines, strict=True):
        figure.text(*(np.array([LEFT_IN, height_in]) / sheet), line, fontsize=SMALL)


def _signed(text):
    if text.strip("0.,") == "":
        return "0"
    return text.replace("-", "−") if text.startswith("-") else f"+{text}"
