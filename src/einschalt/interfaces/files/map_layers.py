"""What every layer of a map has, and how much small vectors are exaggerated on it."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
import pyarrow as pa

VECTOR_SHARE = 0.02  # length of a large residual vector in the extent of the block
LARGE = 0.9  # the share of residuals that are shorter than a large one


@dataclass(frozen=True, eq=False)
class Layer:
    """One layer: its attributes, its geometries, and what is said of it."""

    name: str
    attributes: pd.DataFrame
    geometries: pa.Array
    geometry_type: str
    description: str


def exaggeration(xy, shift):
    """Choose a round factor that makes vectors [m] visible on the map of points [m].

    1, 2 or 5 times a power of ten; 1 where there is nothing to enlarge.
    """
    xy = xy[np.isfinite(xy).all(axis=1)]
    length = np.hypot(*shift[np.isfinite(shift).all(axis=1)].T)
    extent = np.ptp(xy, axis=0).max() if len(xy) else 0.0
    large = np.quantile(length, LARGE) if len(length) else 0.0
    if not (extent > 0 and large > 0):
        return 1.0
    wanted = VECTOR_SHARE * extent / large
    power = 10.0 ** np.floor(np.log10(wanted))
    return float(max(step * power for step in (1, 2, 5) if step * power <= wanted))
