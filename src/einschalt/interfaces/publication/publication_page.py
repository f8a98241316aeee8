"""The page of a publication: what it is, how good it is, and how to use it."""

from datetime import UTC, datetime

import numpy as np

from einschalt.foundations import typesetting
from einschalt.foundations.display_names import as_unicode
from einschalt.interfaces.provenance import versions
from einschalt.interfaces.publication.doubts import doubts_of
from einschalt.interfaces.publication.gtg_file import gridshift_step
from einschalt.interfaces.publication.proj_database import AUTHORITY

ELLIPSE_95 = np.sqrt(-2.0 * np.log(0.05))  # half axes over standard errors


def page(operations, frames, title, home, left_out, has_database):
    """Write the page (Markdown) of a publication.

    ``home`` is the folder in which its files stand when they are used.
    """
    parts = [
        _head(operations, frames, title),
        _how_good(operations),
        _left_out(left_out),
        _with_database(operations, frames, home) if has_database else NO_DATABASE,
        _with_strings(operations[0], home),
        _limits(operations, has_database),
    ]
    return as_unicode("\n\n".join(part for part in parts if part) + "\n")


def _head(operations, frames, title):
    counted = typesetting.count(len(operations), "transformation")
    kinds = sorted({_kind(one) for one in operations})
    between = f"from {frames.source_label} to {frames.target_label}"
    day = datetime.now(UTC).date().isoformat()
    return f"""\
# {frames.name}

{counted} of {title}, {" and ".join(kinds)}, {between}.

Estimated from identical points and published with einschalt on {day} (PROJ
{versions()["PROJ"]}). Coordinates are easting, northing everywhere. `operations.csv`
has each transformation as PROJ string and as WKT."""


def _kind(one):
    if one.grid is not None:
        return "affine with a grid of shifts on top"
    if one.is_distributed:
        return "linear in triangles of identical points"
    return "affine" if one.is_plane else "affine in space"


HOW_GOOD = """\
## How good it is

Identical points were held out, a tenth of them at a time, and predicted from the
others; of a single affine transformation each by itself. The error is the total one
(easting and northing together, RMS); PROJ is told it as the accuracy.

| name | identical points | held out | error [m] | area: west, south, east, north |
|---|---|---|---|---|"""
EXACT = """
Identical points themselves go exactly where they were measured. What all of them share,
such as an error of the new frame, no held-out point can show."""
SMOOTH = """
Identical points go where the grid says, not exactly where they were measured: of what
is theirs alone collocation takes nothing. The bands
`easting_offset_accuracy` and `northing_offset_accuracy` of the grid are the standard
errors of a new point at each place [m]: 95 in 100 held-out points lie within the
ellipse of {factor:.3f} times that size. What all identical points share, such as an
error of the new frame, no held-out point can show."""
LEFT_OUT = """\
## Points left out

{counted} took no part, since they contradict their neighbours, or the transformation
could not be undone with them; all stand in `left_out.csv`, the ten that deviate most
from their neighbours here.

| name | point | deviation [m] | reason |
|---|---|---|---|"""
NO_DATABASE = """\
There is no PROJ database: it would need a plane system of the ground that is tied to
the Earth, and transformations in plan."""
OUTSIDE_TRIANGLES = """\
Outside of the triangles nothing is known: PROJ gives an error or infinite coordinates.\
"""
OUTSIDE_GRID = """\
Beyond the identical points the grid goes on to its edges, where its accuracy bands say
how little is known; outside of it PROJ gives an error or infinite coordinates."""
OUTSIDE_HULL = """\
The PROJ strings and the database go on beyond the identical points, where their errors
grow; the triangles end at the hull."""
BALLPARK = """\
Without `only_best` and `allow_ballpark=False` PROJ takes the two frames for the same
there, and says nothing. So it does everywhere on the way to a geographic system other
than that of the target, such as EPSG:4326: go to the target first. Other plane systems
it reaches through the target's geographic one."""
CHECKED = """
Before anything was published, PROJ ran each form at the identical points and at others
between them, there and back: all agree with the result to 0.1 mm."""


def _how_good(operations):
    lines = [HOW_GOOD]
    for one in operations:
        error = f"{one.accuracy_m:.4f}" if np.isfinite(one.accuracy_m) else "not known"
        area = "–" if one.area is None else ", ".join(f"{x:.4f}°" for x in one.area)
        name = f"`{one.code}`" + (f" ({one.model})" if one.model else "")
        cells = name, len(one.source), one.n_held_out, error, area
        lines.append(f"| {' | '.join(map(str, cells))} |")
    lines += [f"\n**Before you use it:** {doubt}" for doubt in doubts_of(operations)]
    if any(one.given_net is not None for one in operations):
        lines.append(EXACT)
    if any(one.grid is not None for one in operations):
        lines.append(SMOOTH.format(factor=ELLIPSE_95))
    return "\n".join(lines)


def _left_out(left_out):
    if not len(left_out):
        return ""
    counted = typesetting.count(len(left_out), "identical point")
    rows = [
        f"| {row.operation} | {row.point_id} | {row.deviation:.3f} | {row.reason} |"
        for row in left_out.nlargest(10, "deviation").itertuples()
    ]
    return "\n".join([LEFT_OUT.format(counted=counted), *rows])


def _with_database(operations, frames, home):
    first = next(one for one in operations if one.is_plane)
    target = frames.target.to_authority(min_confidence=100)
    code = f"{AUTHORITY}:{first.code}"
    end = ":".join(target) if target else f"{code}_TARGET"
    database = home / f"{frames.name}.db"
    return f"""\
## By name: the PROJ database

Set the environment variable `PROJ_AUX_DB` before the program starts; nothing is copied,
and no network is asked. In Python:

```python
import os
os.environ["PROJ_AUX_DB"] = {str(database)!r}  # before pyproj is imported
from pyproj import Transformer
way = Transformer.from_crs(
    "{code}", "{end}", always_xy=True, only_best=True, allow_ballpark=False
)
```

In a shell, with points as lines of easting and northing, or with a file of features:

```
export PROJ_AUX_DB='{database}'
cs2cs --no-ballpark -f %.4f {code} {end} < points.txt
ogr2ogr -s_srs {code} -t_srs {end} new.gpkg old.gpkg
```

QGIS finds the operation when the variable is set under Settings, Options, System,
Environment. It knows the frame from a file whose system it is (`ogr2ogr -a_srs {code}
frame.gpkg old.gpkg`), or as a custom projection, whose definition is `{first.code}.wkt`
(format WKT). PROJ takes a database of its own layout
only; for one that refuses it publish again with `--proj-db` and the path of its
`proj.db`. Where an authority lists the northing first, `cs2cs` prints it first."""


def _with_strings(first, home):
    if first.grid is not None:
        return f"""\
## By its grid of shifts

`{first.code}.tif` is a GeoTIFF of PROJ's (GTG), linear along both axes of its cells of
{first.grid.cell:g} m, to be read by PROJ 9.4 and later, both ways:

```
echo easting northing | cct -z 0 -t 0 -d 4 +proj=pipeline +step {first.affine_step} \\
  +step {gridshift_step(home / f"{first.code}.tif")}
```"""
    if first.net is None:
        read = (
            "easting northing | cct -z 0 -t 0 -d 4" if first.is_plane else "x y z | cct"
        )
        return f"""\
## As a PROJ string

```
echo {read} +proj=pipeline +step {first.affine_step}
```"""
    triangles = home / f"{first.code}.json"
    return f"""\
## By its triangles

`{first.code}.json` is a file of PROJ's `tinshift` (7.2 and later), both ways:

```
echo easting northing | cct -z 0 -t 0 -d 4 +proj=tinshift '+file={triangles}'
```"""


def _limits(operations, has_database):
    said = [OUTSIDE_HULL]
    if any(one.grid is not None for one in operations):
        said = [OUTSIDE_GRID]
    elif any(one.is_distributed for one in operations):
        said = [OUTSIDE_TRIANGLES]
    if has_database:
        said.append(BALLPARK)
    return "\n".join(["## Outside", "", *said, CHECKED])
