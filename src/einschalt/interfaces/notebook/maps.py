"""A block on a map: points by their precision, vectors, ellipses, outlines of models.

Data are metres in the system of the results. Vectors and ellipses of one map share one
exaggeration, which stands at its scale bar.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.lines import Line2D
from mpl_toolkits.axes_grid1.anchored_artists import AnchoredSizeBar

from einschalt.foundations.arguments import described, is_choice
from einschalt.foundations.display_names import printable
from einschalt.foundations.errors import SettingsError, TableError
from einschalt.foundations.frame_columns import PLAN
from einschalt.foundations.language import figure, mark, numbers_set, translated
from einschalt.foundations.typesetting import length
from einschalt.foundations.units import RADIANS_PER_GON
from einschalt.interfaces.files.map_layers import LARGE
from einschalt.interfaces.notebook.axes import (
    APART,
    CHECK,
    CHOSEN,
    CONTROL,
    MAP_IN,
    MODEL,
    PRECISION,
    SUSPECT,
    axes_for,
    colour_bar,
    colours_of,
    key_below,
    map_frame,
    unit_for,
    write_title,
)
from einschalt.interfaces.notebook.claimed import error_column
from einschalt.interfaces.reports.figure_style import round_down
from einschalt.interfaces.reports.page_models import footprints
from einschalt.interfaces.reports.page_points import (
    GOLDEN_SECTION,
    coverage_differences,
)
from einschalt.theory.adjustment.ellipses import Ellipses, ellipse_outlines

LAYERS = (
    *("models", "points", "control", "differences"),
    *("coverage_differences", "ellipses"),
)
USUAL = ("points", "control", "differences")
MOST_SIGNS = 900
"""Vectors, or ellipses, that can be told apart."""
LONGEST_SHARE = 0.05
"""Of the map: how long a large sign is, where they are not dense."""
BAR_SHARE = 0.18  # of the width of the map
BAR_ROOM = 0.08  # of its height
KINDS = {
    "control": ("^", CONTROL, mark("control points")),
    "check": ("s", CHECK, mark("check points")),
}


@dataclass(frozen=True, eq=False)
class Signs:
    """Vectors [m] at points [m], or semi axes and azimuths of ellipses there."""

    xy: np.ndarray  # (n, 2)
    size: np.ndarray  # (n, 2): east and north, or semi axes
    colour: str
    name: str
    azimuth: np.ndarray | None = None  # [rad], of ellipses

    def reach(self):
        """Lengths of vectors, or of major axes [m]."""
        if self.azimuth is None:
            return np.hypot(*self.size.T)
        return 2.0 * self.size[:, 0]

    def thinned(self):
        """Rows that are drawn, evenly chosen, and how many there are."""
        is_known = np.isfinite(self.xy).all(axis=1) & np.isfinite(self.size).all(axis=1)
        rows = np.flatnonzero(is_known)
        part = (np.arange(len(rows)) * GOLDEN_SECTION) % 1.0
        return rows[part < MOST_SIGNS / max(len(rows), 1)], len(rows)


def block_map(ax, result, layers=USUAL, column=None):
    """Draw the layers that are asked for on a map."""
    layers = _checked(layers)
    column = error_column(result, column)
    xy = result.points[PLAN].to_numpy(dtype=float)
    located = xy[np.isfinite(xy).all(axis=1)]
    if not len(located):
        raise TableError("no point of this result has coordinates")
    ax, key = axes_for(ax, MAP_IN, layout="compressed"), []
    map_frame(ax, title=printable(result.block.name), extent=np.ptp(located, 0).max())
    ax.update_datalim(located)
    if "models" in layers:
        key += _draw_models(ax, result, xy)
    if "points" in layers:
        key += _draw_points(ax, result, xy, column)
    signs = [sign for name in layers if (sign := _signs(result, xy, name)) is not None]
    key += _draw_signs(ax, signs, located)
    if "control" in layers:
        key += _draw_known(ax, result.points, xy)
    key_below(ax, key)
    return ax


def difference_map(ax, result):
    """Draw how far the first two coverages lie apart at every point."""
    if _signs(result, _plane(result), "coverage_differences") is None:
        raise TableError(
            "this result has no differences of coverages",
            expected="two coverages in two steps",
        )
    ax = block_map(ax, result, ("coverage_differences", "control"))
    write_title(ax, translated("Differences of the coverages"))
    return ax


def _plane(result):
    return result.points[PLAN].to_numpy(dtype=float)


def _checked(layers):
    is_list = isinstance(layers, Iterable) and not isinstance(layers, str)
    asked = tuple(layers) if is_list else (layers,)
    unknown = [name for name in asked if not is_choice(name, LAYERS)]
    if unknown:
        raise SettingsError(
            f"layers = {described(unknown[0])}", expected=f"some of {', '.join(LAYERS)}"
        )
    return asked


def _draw_models(ax, result, xy):
    """Outline the models of the low flight, and those of any flight that failed."""
    corners, key = footprints(result), []
    if corners is None:
        return key
    is_known = np.isfinite(corners).all(axis=1)
    is_usable = result.models["is_usable"].astype(bool).to_numpy()
    is_low = (result.models["flight"] == "low_flight").to_numpy()
    shown = (
        (is_low & is_usable, MODEL, 0.45, mark("models of the low flight")),
        (~is_usable, CHECK, 1.2, mark("failed models")),
    )
    for is_in, colour, width, name in shown:
        rows = corners[is_in & is_known].astype(int)
        if len(rows):
            outlines = PolyCollection(
                xy[rows], facecolors="none", edgecolors=colour, linewidths=width
            )
            ax.add_collection(outlines)
            line = {"color": colour, "linewidth": width, "label": translated(name)}
            key.append(Line2D([], [], **line))
    return key


def _draw_points(ax, result, xy, column):
    """Draw the new points in the colours of their errors, and rings about suspects."""
    points = result.points
    is_new = (points["role"] == "new").to_numpy() & np.isfinite(xy).all(axis=1)
    errors = points.get(column, points["easting"] * np.nan).to_numpy(dtype=float)
    n_new, key = int(is_new.sum()), []
    size = float(np.clip(9000.0 / max(n_new, 1), 3.0, 30.0))
    dots = {"s": size, "linewidths": 0, "zorder": 2.5, "rasterized": n_new > 2000}
    is_known = is_new & np.isfinite(errors)
    unknown = is_new & ~is_known
    if unknown.any():
        ax.scatter(*xy[unknown].T, color="#6b7c85", **dots)
        name = translated("new points, error unknown")
        key.append(_mark("o", "#6b7c85", name))
    if is_known.any():
        unit = unit_for(colours_of(errors[is_known]).vmax)
        # the worst on top
        rows = np.flatnonzero(is_known)[np.argsort(errors[is_known], kind="stable")]
        values = unit.of(errors[rows])
        norm = colours_of(values)
        drawn = ax.scatter(*xy[rows].T, c=values, cmap=PRECISION, norm=norm, **dots)
        extend = "max" if values[-1] > norm.vmax else "neither"
        facts = {"column": column, "unit": unit.name}
        text = translated("{column} of the new points [{unit}]", **facts)
        colour_bar(ax, drawn, text, extend=extend)
    is_suspect = points.get("is_suspect", points["role"] == "").to_numpy(dtype=bool)
    is_suspect = is_suspect & np.isfinite(xy).all(axis=1)
    if is_suspect.any():
        ring = {"s": 60.0, "facecolors": "none", "linewidths": 1.3, "zorder": 4}
        ax.scatter(*xy[is_suspect].T, edgecolors=SUSPECT, **ring)
        key.append(_mark("o", SUSPECT, translated("suspect points"), face="none"))
    return key


def _draw_known(ax, points, xy):
    key = []
    for role, (marker, colour, name) in KINDS.items():
        is_in = (points["role"] == role).to_numpy() & np.isfinite(xy).all(axis=1)
        if is_in.any():
            line = {"color": colour, "markerfacecolor": "white", "markersize": 4.5}
            ax.plot(*xy[is_in].T, marker, markeredgewidth=0.9, zorder=3, **line)
            key.append(_mark(marker, colour, translated(name), face="white"))
    return key


def _mark(marker, colour, name, face=None):
    face = colour if face is None else face
    look = {"color": colour, "markerfacecolor": face, "markersize": 5}
    return Line2D([], [], linestyle="", marker=marker, label=name, **look)


def _signs(result, xy, layer):
    """Signs of a layer, or None where the result has none, or the layer is another."""
    points = result.points
    if layer == "differences" and "difference_easting" in points:
        size = points[["difference_easting", "difference_northing"]]
        size = size.where(points["role"] != "new").to_numpy(dtype=float)
        name = translated("densified − given")
        return Signs(xy, size, CHECK, name) if np.isfinite(size).any() else None
    if layer == "coverage_differences":
        apart, names = coverage_differences(result)
        if apart is None:
            return None
        # dollar signs of names begin no formula
        both = " − ".join(map(printable, names)).replace("$", r"\$")
        name = translated("coverage {both}", both=both)
        return Signs(xy, apart, APART, name) if np.isfinite(apart).any() else None
    if layer == "ellipses" and result.ellipses is not None and len(result.ellipses):
        table = result.ellipses
        at = table[PLAN].to_numpy(dtype=float)
        axes = table[["semi_major", "semi_minor"]].to_numpy(dtype=float)
        azimuth = table["azimuth_gon"].to_numpy(dtype=float) * RADIANS_PER_GON
        share = numbers_set(f"{100.0 * result.settings.confidence:g} %")
        name = translated("ellipses of {share}", share=share)
        return Signs(at, axes, CHOSEN, name, azimuth)
    return None


def _draw_signs(ax, signs, located):
    """Draw vectors and ellipses with one exaggeration, and its bar."""
    if not signs:
        return []
    chosen = [sign.thinned() for sign in signs]
    reach = [s.reach()[rows] for s, (rows, _) in zip(signs, chosen, strict=True)]
    factor, key = _exaggeration(np.ptp(located, axis=0).max(), reach), []
    for sign, (rows, n_all) in zip(signs, chosen, strict=True):
        at, size = sign.xy[rows], factor * sign.size[rows]
        look = {"linewidths": 0.9, "zorder": 3.5}
        if sign.azimuth is None:
            lines = np.stack([at, at + size], axis=1)
            ax.add_collection(LineCollection(lines, colors=sign.colour, **look))
            ax.scatter(*at.T, s=4.0, color=sign.colour, linewidths=0, zorder=3.5)
        else:
            outlines = ellipse_outlines(at, Ellipses(*size.T, sign.azimuth[rows]))
            look |= {"facecolors": "none", "edgecolors": sign.colour}
            ax.add_collection(PolyCollection(outlines, **look | {"linewidths": 0.5}))
        name = sign.name
        if len(rows) < n_all:
            facts = {"name": name, "n": len(rows), "n_all": n_all}
            name = translated("{name}, {n} of {n_all}", **facts)
        key.append(Line2D([], [], color=sign.colour, label=name))
    if any(one.any() for one in reach):
        _draw_bar(ax, factor, located)
    return key


def _exaggeration(extent, reach):
    """Round factor at which large signs are seen, and neighbours hardly touch.

    ``reach`` are the lengths of each layer's signs [m].
    """
    large = max(float(np.quantile(one, LARGE)) for one in reach)
    if not (extent > 0.0 and large > 0.0):
        return 1.0
    share = min(LONGEST_SHARE, 1.0 / np.sqrt(max(map(len, reach))))
    return round_down(share * extent / large)


def _draw_bar(ax, factor, located):
    error = round_down(BAR_SHARE * np.ptp(located, axis=0).max() / factor)
    facts = {"length": length(error), "factor": figure(factor, "g")}
    text = translated("{length} of errors, × {factor}", **facts)
    bar = AnchoredSizeBar(
        ax.transData,
        factor * error,
        text,
        "lower left",
        pad=0.3,
        sep=3,
        color=CHECK,
        label_top=True,
    )
    bar.patch.set(alpha=0.0, linewidth=0)
    bar.set_zorder(5)
    ax.add_artist(bar)
    low, high = ax.get_ylim()
    ax.set_ylim(low - BAR_ROOM * (high - low), high)
