"""What the curvature of the Earth would do to models of a block that is taken for flat.

A spatial block without a reference system may be a site with a plane of its own, where
nothing is curved, or a map of which nobody said so. Its heights tell the two apart only
where there are many control heights.
"""

import numpy as np

from einschalt.foundations.batches import segment_centred, segments_present
from einschalt.foundations.frame_columns import PLAN, values_of
from einschalt.foundations.key_columns import row_codes
from einschalt.foundations.projections import EARTH_RADIUS
from einschalt.stages.transformation_kinds import SPATIAL
from einschalt.theory.adjustment.tilted_planes import off_planes

FEWEST = 4  # points, of which three give shift and tilt


def bend_without_system(examined) -> float:
    """What straight models miss curved ground by, in height, RMS [m]; 0 if known.

    Of the spatial flight in which it is most: the distance from the middle squared by
    the Earth's diameter, less shift and tilt of each model. 0 with a reference system,
    and where the models are said to be as curved as the map.
    """
    block = examined.block
    if block.crs is not None or examined.settings.earth_curvature == "ignored":
        return 0.0
    places = examined.points.drop_duplicates("point_id").set_index("point_id")[PLAN]
    return max(
        (
            _bend_of(flight.model_table(), places)
            for flight in block.flights.values()
            if flight.transformation == SPATIAL
        ),
        default=0.0,
    )


def _bend_of(table, places):
    keys = [name for name in ("coverage", "model_id") if name in table]
    known = table[[*keys, "point_id"]].join(places, on="point_id").dropna()
    if known.empty:
        return 0.0
    parts = segments_present(row_codes([known[name] for name in keys]))
    plan = values_of(known, PLAN)[parts.order]
    away = segment_centred(plan, parts.start)
    falls = (away**2).sum(axis=1) / (2.0 * EARTH_RADIUS)
    left = off_planes(away, falls, parts.start)[parts.count[parts.group] >= FEWEST]
    return float(np.sqrt(np.mean(left**2))) if len(left) else 0.0
