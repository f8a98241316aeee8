"""What the curvature of the Earth would do to models of a block that is taken for flat.

A spatial block without a reference system may be a site with a plane of its own, where
nothing is curved, or a map of which nobody said so. Its heights tell the two apart only
where there are many control heights.
"""

import numpy as np

from einschalt.foundations.batches import segment_sum
from einschalt.stages.curved_earth import SPATIAL

EARTH_RADIUS = 6.371e6  # metres
PLAN = ["easting", "northing"]
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
    known = known.sort_values(keys, kind="stable")
    sizes = known.groupby(keys, sort=True).size().to_numpy()
    start = np.concatenate([[0], np.cumsum(sizes)])
    away = _centred(known[PLAN].to_numpy(dtype=float), start)
    falls = _centred((away**2).sum(axis=1) / (2.0 * EARTH_RADIUS), start)
    normal = segment_sum(away[:, :, None] * away[:, None, :], start)
    tilt = np.einsum(
        "mij,mj->mi",
        np.linalg.pinv(normal, hermitian=True),
        segment_sum(away * falls[:, None], start),
    )
    left = falls - (away * np.repeat(tilt, sizes, axis=0)).sum(axis=1)
    left = left[np.repeat(sizes, sizes) >= FEWEST]
    return float(np.sqrt(np.mean(left**2))) if len(left) else 0.0


def _centred(values, start):
    sizes = np.diff(start)
    means = (segment_sum(values, start).T / sizes).T
    return values - np.repeat(means, sizes, axis=0)
