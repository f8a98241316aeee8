"""Maps of the local page, as SVG: points by their precision, and vectors."""

import numpy as np

from einschalt.foundations.language import translated
from einschalt.foundations.typesetting import length
from einschalt.interfaces.reports.precision_colours import STEPS, error_range

WIDTH, MARGIN = 720.0, 40.0  # of the drawing
FOOT = 60.0
ROOM = 4.0  # beside a vector
HIGHEST = 720.0
MOST_VECTORS = 2_000
LONGEST = 40.0  # of a vector that is as 95 % of them


def precision_map(points, claim="standard_error_total"):
    """Map of points [m] coloured by a standard error [m], with its scale of colours."""
    x, y, height = _laid_out(points)
    error = points[claim].to_numpy(dtype=float)
    low, high = error_range(error)
    span = max(high - low, 1e-12)
    steps = np.clip((error - low) / span * len(STEPS), 0, len(STEPS) - 1).astype(int)
    is_control = (points["role"] == "control").to_numpy()
    radius = float(np.clip(0.35 * WIDTH / np.sqrt(len(points)), 2.0, 9.0))
    marks = [
        f'<circle class="c{step}" cx="{px:.1f}" cy="{py:.1f}" r="{radius:.1f}"/>'
        for px, py, step in zip(x, y, steps, strict=True)
    ]
    side = max(radius, 3.0)
    marks += [
        f'<rect class="control" x="{px - side:.1f}" y="{py - side:.1f}" '
        f'width="{2 * side:.1f}" height="{2 * side:.1f}"/>'
        for px, py in zip(x[is_control], y[is_control], strict=True)
    ]
    title = translated("Expected precision of the points")
    return _svg(title, (0.0, 0.0, WIDTH, height), [*marks, *_key(low, high, height)])


def _key(low, high, height):
    """Scale of colours below the map."""
    top, width = height - FOOT, 30.0
    boxes = [
        f'<rect class="c{k}" x="{MARGIN + k * width:.0f}" y="{top:.0f}" '
        f'width="{width:.0f}" height="10"/>'
        for k in range(len(STEPS))
    ]
    said = translated(
        "{low} to {high}, total; squares are control points",
        low=length(low),
        high=length(high),
    )
    return [*boxes, f'<text x="{MARGIN:.0f}" y="{top + 36:.0f}">{said}</text>']


def vectors(moved):
    """Map of differences [m] at points [m], the largest drawn; with their scale."""
    x, y, height = _laid_out(moved)
    shown = slice(0, MOST_VECTORS)  # the largest come first
    usual = float(np.quantile(moved["total"], 0.95)) or float(moved["total"].max())
    factor = LONGEST / usual if usual > 0.0 else 0.0
    dx = np.clip(factor * moved["d_easting"].to_numpy(), -4 * LONGEST, 4 * LONGEST)
    dy = np.clip(-factor * moved["d_northing"].to_numpy(), -4 * LONGEST, 4 * LONGEST)
    marks = [
        f'<circle class="place" cx="{px:.1f}" cy="{py:.1f}" r="1.2"/>'
        for px, py in zip(x, y, strict=True)
    ]
    marks += [
        f'<path class="vector" d="M{px:.1f} {py:.1f}l{vx:.1f} {vy:.1f}"/>'
        for px, py, vx, vy in zip(x[shown], y[shown], dx[shown], dy[shown], strict=True)
    ]
    ends_x, ends_y = x[shown] + dx[shown], y[shown] + dy[shown]
    height = max(height, _most(ends_y, 0.0) + FOOT)  # its scale stands below all
    top = height - FOOT + 14.0
    said = translated("{length}: second minus first", length=length(usual))
    marks += [
        f'<path class="vector" d="M{MARGIN:.0f} {top:.0f}h{LONGEST:.0f}"/>',
        f'<text x="{MARGIN + LONGEST + 10:.0f}" y="{top + 4:.0f}">{said}</text>',
    ]
    # a vector at the edge may lead out of the map
    left, right = -_most(-ends_x, 0.0), _most(ends_x, WIDTH)
    above = -_most(-ends_y, 0.0)
    box = (left, above, right - left, height - above)
    return _svg(translated("Differences of the points"), box, marks)


def _most(values, least):
    """The largest value with some room, at least ``least``."""
    return max(float(values.max(initial=-np.inf)) + ROOM, least)


def _laid_out(points):
    """Places of points in the drawing, and its height."""
    east = points["easting"].to_numpy(dtype=float)
    north = points["northing"].to_numpy(dtype=float)
    wide, high = np.ptp(east) or 1.0, np.ptp(north) or 1.0
    room = WIDTH - 2.0 * MARGIN
    factor = min(room / wide, (HIGHEST - 2.0 * MARGIN) / high)
    left = MARGIN + 0.5 * (room - factor * wide)
    x = left + factor * (east - east.min())
    y = MARGIN + factor * (north.max() - north)
    return x, y, factor * high + 2.0 * MARGIN + FOOT


def _svg(title, box, marks):
    shown = " ".join(f"{number:.0f}" for number in box)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" class="drawing" role="img" '
        f'aria-label="{title}" viewBox="{shown}">'
        f"{''.join(marks)}</svg>"
    )
