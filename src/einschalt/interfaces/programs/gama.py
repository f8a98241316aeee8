"""Points with their covariances as observed coordinates of GNU Gama, and back.

For the next adjustment: ``<coordinates>`` with ``<cov-mat>``, x the northing and y the
easting in metres, covariances in square millimetres. A result that is in memory is
written with its full covariance, one from a folder with that of each point.
"""

from xml.etree import ElementTree as ET

import numpy as np
import pandas as pd

from einschalt.interfaces.programs.foreign import Foreign, damaged
from einschalt.interfaces.programs.plain_xml import each, read_xml, xml_bytes

NAMESPACE = "http://www.gnu.org/software/gama/gama-local"
MM2 = 1e6
EXPECTED = "observed coordinates of gama-local with a cov-mat"
MOST_COORDINATES = 20_000


def write_gama(handed, path):
    """Write all points as observed coordinates; says how much covariance there is."""
    covariance, said = handed.covariance()
    width = handed.coordinates.shape[1]
    order = np.arange(len(covariance)).reshape(-1, width)
    order[:, :2] = order[:, 1::-1]  # x is the northing
    covariance = covariance[np.ix_(order.ravel(), order.ravel())]
    is_full = said.startswith("full")
    band = len(covariance) - 1 if is_full else width - 1
    root = ET.Element("gama-local", xmlns=NAMESPACE)
    network = ET.SubElement(root, "network")
    network.set("axes-xy", "ne")
    about = f"{handed.name}: densified points, {said}; system {handed.crs or 'local'}"
    ET.SubElement(network, "description").text = about
    ET.SubElement(network, "parameters", {"sigma-apr": "1", "sigma-act": "apriori"})
    part = ET.SubElement(network, "points-observations")
    letters = "xyz"[:width]
    names = [str(name) for name in handed.points["point_id"]]
    for name in names:
        ET.SubElement(part, "point", id=name, adj=letters)
    group = ET.SubElement(part, "coordinates")
    for name, (east, north, *height) in zip(names, handed.coordinates, strict=True):
        place = {"x": f"{north:.5f}", "y": f"{east:.5f}"}
        place |= {"z": f"{height[0]:.5f}"} if height else {}
        ET.SubElement(group, "point", {"id": name, **place})
    matrix = ET.SubElement(group, "cov-mat", dim=str(len(covariance)), band=str(band))
    matrix.text = _rows(MM2 * covariance, band)
    path.write_bytes(xml_bytes(root))
    return [said]


def _rows(matrix, band):
    """Upper triangle row by row, as far as the band reaches."""
    rows = [
        " ".join(f"{value:.9g}" for value in matrix[k, k : k + band + 1])
        for k in range(len(matrix))
    ]
    return "\n" + "\n".join(rows) + "\n"


def is_gama(head):
    """Whether the first bytes of a file look so."""
    return b"<gama-local" in head


def read_gama(file) -> Foreign:
    """Read observed coordinates, and the covariance of each point.

    The full covariance is :func:`read_covariance`'s.
    """
    table, covariance = read_covariance(file)
    width = 3 if "height" in table else 2
    at = np.arange(len(table))
    own = covariance.reshape(len(table), width, len(table), width)[at, :, at, :]
    columns = {
        "standard_error_m": np.sqrt(own[:, 0, 0] + own[:, 1, 1]),
        "standard_error_easting": np.sqrt(own[:, 0, 0]),
        "standard_error_northing": np.sqrt(own[:, 1, 1]),
        "covariance_en": own[:, 0, 1],
    }
    if width == 3:
        columns["standard_error_height"] = np.sqrt(own[:, 2, 2])
        columns["covariance_eh"], columns["covariance_nh"] = own[:, 0, 2], own[:, 1, 2]
    note = f"{file.source}: covariances between points are left out"
    return Foreign({"control_points": table.assign(**columns)}, None, (note,))


def read_covariance(file):
    """Points and their full covariance [m²], easting before northing.

    (table, (n_points · n_coordinates, n_points · n_coordinates)).
    """
    root = read_xml(file.data, file.source, EXPECTED)
    group = next(each(root, "coordinates"), None)
    matrix = None if group is None else next(each(group, "cov-mat"), None)
    if matrix is None:
        raise damaged(file.source, "holds no coordinates with a cov-mat", EXPECTED)
    points = list(each(group, "point"))
    letters = "yxz" if all(p.get("z") for p in points) else "yx"
    try:
        xyz = np.array([[float(p.get(c)) for c in letters] for p in points])
        dim, band = int(matrix.get("dim")), int(matrix.get("band"))
        values = np.array((matrix.text or "").split(), dtype=float)
    except (TypeError, ValueError) as error:
        raise damaged(file.source, f"a number is missing: {error}", EXPECTED) from error
    if not np.isfinite(xyz).all() or not np.isfinite(values).all() or band < 0:
        raise damaged(file.source, "a number is not finite", EXPECTED)
    n_values = sum(
        min(band, dim - 1 - k) + 1 for k in range(min(dim, MOST_COORDINATES))
    )
    if dim != xyz.size or dim > MOST_COORDINATES or len(values) != n_values:
        found = f"has {len(values)} covariances of {xyz.size} coordinates, dim {dim}"
        raise damaged(file.source, found, f"{n_values} of a band of {band}")
    whole = _whole(values, dim, band) / MM2
    order = np.arange(dim).reshape(-1, len(letters))
    order[:, :2] = order[:, 1::-1]
    names = ["easting", "northing", "height"][: len(letters)]
    table = pd.DataFrame(xyz, columns=names)
    table.insert(0, "point_id", [point.get("id") for point in points])
    return table, whole[np.ix_(order.ravel(), order.ravel())]


def _whole(values, dim, band):
    whole, start = np.zeros((dim, dim)), 0
    for row in range(dim):
        count = min(band, dim - 1 - row) + 1
        whole[row, row : row + count] = values[start : start + count]
        start += count
    return np.triu(whole) + np.triu(whole, 1).T
