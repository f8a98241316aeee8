"""The full covariance of a file of GNU Gama, read without the program."""

from xml.etree import ElementTree as ET

import numpy as np
import pandas as pd


def read_covariance(path):
    """Names of the points, and their covariance [m²], easting before northing."""
    root = ET.parse(path).getroot()
    points = list(root.iterfind(".//{*}coordinates/{*}point"))
    matrix = root.find(".//{*}coordinates/{*}cov-mat")
    dim, band = int(matrix.get("dim")), int(matrix.get("band"))
    values, whole = iter(matrix.text.split()), np.zeros((dim, dim))
    for row in range(dim):
        for column in range(row, min(row + band + 1, dim)):
            whole[row, column] = whole[column, row] = 1e-6 * float(next(values))
    assert next(values, None) is None
    assert root.find("{*}network").get("axes-xy") == "ne"
    width = dim // len(points)
    order = np.arange(dim).reshape(-1, width)[:, [1, 0, 2][:width]].ravel()
    table = pd.DataFrame({"point_id": [point.get("id") for point in points]})
    return table, whole[np.ix_(order, order)]
