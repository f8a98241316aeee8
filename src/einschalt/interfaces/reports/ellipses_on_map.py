"""Confidence ellipses on the maps of the report."""

import numpy as np
from matplotlib.collections import PolyCollection

from einschalt.foundations.typesetting import number
from einschalt.foundations.units import RADIANS_PER_GON
from einschalt.interfaces.reports.map_sheet import round_down
from einschalt.theory.adjustment.ellipses import Ellipses, ellipse_outlines

MOST_ELLIPSES = 600
MOST_DRAWN_AS_PATHS = 2500


def draw_ellipses(sheet, table, exaggeration, colour):
    """Draw rows of ``result.ellipses``, so much larger, about points of a map."""
    axes_km = table[["semi_major", "semi_minor"]].to_numpy() * exaggeration / 1e3
    azimuth = table["azimuth_gon"].to_numpy() * RADIANS_PER_GON
    place_km = table[["easting", "northing"]].to_numpy() / 1e3
    outlines = ellipse_outlines(place_km, Ellipses(*axes_km.T, azimuth))
    sheet.axes.add_collection(
        PolyCollection(
            outlines,
            facecolors="none",
            edgecolors=colour,
            linewidths=0.5,
            zorder=3,
            rasterized=len(outlines) > MOST_DRAWN_AS_PATHS,
        ),
        autolim=False,
    )


def evenly_thinned(table):
    """Choose at most so many points that their ellipses can be told apart.

    One point of each cell of a grid, where there are too many.
    """
    if len(table) <= MOST_ELLIPSES:
        return table
    xy = table[["easting", "northing"]].to_numpy(dtype=float)
    return table.iloc[one_of_each_cell(xy, MOST_ELLIPSES)]


def one_of_each_cell(xy, most):
    """Choose, by row, one place of each cell of a grid of about so many cells."""
    extent = np.ptp(xy, axis=0)
    cell = np.sqrt(extent.prod() / most) or extent.max() / most
    cells = np.floor((xy - xy.min(axis=0)) / (1.05 * cell)).astype(int)
    return np.unique(cells, axis=0, return_index=True)[1]


def ellipse_exaggeration(sheet, table):
    """Round factor at which an ellipse hardly reaches its neighbour."""
    largest = float(table["semi_major"].quantile(0.95))
    area_m2 = np.prod(sheet.size_in) * sheet.m_per_in**2
    reach_m = 0.7 * np.sqrt(area_m2 / len(table))
    return round_down(reach_m / largest) if largest > 0.0 else 1.0


def ellipse_label(result, exaggeration):
    """Say what ellipses are drawn, and how large."""
    percent = number(100.0 * result.settings.confidence, 3).removesuffix(".0")
    return f"{percent} % confidence ellipses × {exaggeration:g}"
