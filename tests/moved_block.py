"""A block at another place, whose control is given in a system of its own."""

import json

import numpy as np
import pandas as pd
import pyproj

CONTROL = "control_points.csv"
PLANE = ["easting", "northing"]


def moved_block(block, crs, place, of_points=None, *, settings="", height=None):
    """The small block at another place and in another system, and its control there.

    The coordinates of the control points are written in a system of their own.
    """
    to_crs = pyproj.Transformer.from_crs("OGC:CRS84", crs, always_xy=True)
    frame = pd.read_csv(block.path / CONTROL, dtype={"point_id": str})
    frame[PLANE] += np.array(to_crs.transform(*place)) - frame[PLANE].mean()
    if height is not None:
        frame["height"] = height
    given = frame.copy()
    if of_points is not None:
        own = pyproj.CRS(of_points)
        names = [*PLANE, *(["height"] if len(own.axis_info) == 3 else [])]
        way = pyproj.Transformer.from_crs(crs, own, always_xy=True)
        given[names] = np.column_stack(way.transform(*frame[names].to_numpy().T))
        if own.is_geographic:
            columns = dict(zip(PLANE, ("longitude", "latitude"), strict=True))
            given = given.rename(columns=columns)
        crs_line = f"crs = {json.dumps(of_points)}"  # WKT has quotes of its own
        block.replace("block.toml", f'"{CONTROL}"', f'"{CONTROL}"\n{crs_line}')
    given.to_csv(block.path / CONTROL, index=False)
    text = block.read("block.toml").replace('crs = "EPSG:31255"', f'crs = "{crs}"', 1)
    block.write("block.toml", f"{text}\n[settings]\n{settings}\n")
    return frame
