"""Points with their covariances as observed coordinates of GNU Gama, and back.

For the next adjustment: ``<coordinates>`` with ``<cov-mat>``, x the northing and y the
easting in metres, covariances in square millimetres. A result that is in memory is
written with its full covariance, one from a folder with that of each point; enlarged
as the errors to believe are, where the stated precision is not supported.
"""

from xml.etree import ElementTree as ET

import numpy as np
import pandas as pd

from einschalt.foundations.display_names import shortened
from einschalt.foundations.number_parsing import is_number
from einschalt.foundations.projections import label_of
from einschalt.interfaces.files.damaged_files import damaged
from einschalt.interfaces.files.plain_xml import each, read_xml, xml_bytes
from einschalt.interfaces.programs.foreign import Foreign
from einschalt.interfaces.programs.handed_over import MOST_FULL

NAMESPACE = "http://www.gnu.org/software/gama/gama-local"
MOST_ROWS = 2**31  # of a matrix that is announced
MM2 = 1e6
EXPECTED = "observed coordinates of gama-local with a cov-mat"


def write_gama(handed, path):
    """Write all points as observed coordinates; says how much covariance there is."""
    width = handed.coordinates.shape[1]
    exchanged = np.eye(width)[[1, 0, 2][:width]]  # x is the northing
    covariance = handed.covariance()
    said = str(covariance)
    covariance = covariance.turned(np.tile(exchanged, (len(covariance.own), 1, 1)))
    root = ET.Element("gama-local", xmlns=NAMESPACE)
    network = ET.SubElement(root, "network")
    network.set("axes-xy", "ne")
    system = "local" if handed.crs is None else label_of(handed.crs)
    notes = [said, *handed.told_enlargement]
    about = f"{handed.name}: densified points, {'; '.join(notes)}; system {system}"
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
    n_coordinates = handed.coordinates.size
    band = width - 1 if covariance.full is None else n_coordinates - 1
    matrix = ET.SubElement(group, "cov-mat", dim=str(n_coordinates), band=str(band))
    matrix.text = _rows(_upper(covariance), n_coordinates)
    path.write_bytes(xml_bytes(root))
    return notes


def _upper(covariance):
    """Rows of the upper triangle from the diagonal on, as far as the band reaches."""
    if covariance.full is not None:
        yield from (row[k:] for k, row in enumerate(covariance.full))
        return
    width = covariance.own.shape[1]
    for own in covariance.own:
        for axis in range(width):
            yield np.pad(own[axis, axis:], (0, axis))


def _rows(rows, n_coordinates):
    """Text of the rows; the last ones end with the matrix."""
    lines = [
        " ".join(f"{MM2 * value:.9g}" for value in row[: n_coordinates - k])
        for k, row in enumerate(rows)
    ]
    return "\n" + "\n".join(lines) + "\n"


def is_gama(head):
    """Whether the first bytes of a file look so."""
    return b"<gama-local" in head


def read_gama(file) -> Foreign:
    """Read observed coordinates, and the covariance of each point.

    The full covariance is :func:`read_covariance`'s.
    """
    table, values, band = _points_and_values(file)
    width = 3 if "height" in table else 2
    own = _own(values, len(table), width, band)
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
    table, values, band = _points_and_values(file)
    width = 3 if "height" in table else 2
    dim = width * len(table)
    if dim > MOST_FULL:
        found = f"has {dim} coordinates, whose covariances are {dim * dim} numbers"
        raise damaged(file.source, found, f"at most {MOST_FULL}")
    whole, start = np.zeros((dim, dim)), 0
    for row, count in enumerate(_counts(dim, band)):
        whole[row, row : row + count] = values[start : start + count]
        start += count
    whole = np.triu(whole) + np.triu(whole, 1).T
    order = np.arange(dim).reshape(-1, width)
    order[:, :2] = order[:, 1::-1]
    return table, whole[np.ix_(order.ravel(), order.ravel())]


def _points_and_values(file):
    """Points, the covariances as they stand [m²], and how far their band reaches."""
    root = read_xml(file.data, file.source, EXPECTED)
    group = next(each(root, "coordinates"), None)
    matrix = None if group is None else next(each(group, "cov-mat"), None)
    if matrix is None:
        raise damaged(file.source, "holds no coordinates with a cov-mat", EXPECTED)
    points = list(each(group, "point"))
    letters = "yxz" if all(p.get("z") for p in points) else "yx"
    try:
        xyz = np.array([[_number(p.get(c)) for c in letters] for p in points])
        dim, band = (min(int(matrix.get(n)), MOST_ROWS) for n in ("dim", "band"))
        values = np.array([_number(word) for word in (matrix.text or "").split()])
    except (TypeError, ValueError) as error:
        raise damaged(file.source, f"a number is missing: {error}", EXPECTED) from error
    if not np.isfinite(xyz).all() or not np.isfinite(values).all() or band < 0:
        raise damaged(file.source, "a number is not finite", EXPECTED)
    n_values = _counts(xyz.size, band).sum()
    if dim != xyz.size or len(values) != n_values:
        found = f"has {len(values)} covariances of {xyz.size} coordinates, dim {dim}"
        raise damaged(file.source, found, f"{n_values} of a band of {band}")
    names = ["easting", "northing", "height"][: len(letters)]
    table = pd.DataFrame(xyz, columns=names)
    table.insert(0, "point_id", [point.get("id") for point in points])
    return table, values / MM2, band


def _number(word):
    """A number; float takes 1_0 for one, and digits of all scripts."""
    if word is None or not is_number(word):
        raise ValueError(repr(shortened(word)))
    return float(word)


def _counts(dim, band):
    """How many covariances each row has."""
    return np.minimum(band, dim - 1 - np.arange(dim)) + 1


def _own(values, n_points, width, band):
    """Covariance of each point by itself, easting first, (n_points, n, n) [m²]."""
    counts = _counts(n_points * width, band)
    start = np.concatenate([[0], np.cumsum(counts)[:-1]]).reshape(n_points, width)
    own = np.zeros((n_points, width, width))
    for one in range(width):
        for two in range(one, min(width, one + band + 1)):
            own[:, one, two] = own[:, two, one] = values[start[:, one] + two - one]
    order = [1, 0, 2][:width]
    return own[:, order][:, :, order]
