"""Points with their covariances as observed coordinates of GNU Gama, and back.

For the next adjustment: ``<coordinates>`` with ``<cov-mat>``, in metres, covariances in
square millimetres; x is written as the northing and y as the easting. A result that is
in memory is written with its full covariance, one from a folder with that of each
point; enlarged as the errors to believe are, where the stated precision is not
supported.
"""

from dataclasses import dataclass
from xml.etree import ElementTree as ET

import numpy as np
import pandas as pd

from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import name_some
from einschalt.foundations.kept_texts import kept
from einschalt.foundations.number_parsing import is_number
from einschalt.foundations.projections import label_of
from einschalt.interfaces.files.damaged_files import damaged
from einschalt.interfaces.files.plain_xml import each, read_xml, xml_bytes
from einschalt.interfaces.programs.foreign import Foreign

NAMESPACE = "http://www.gnu.org/software/gama/gama-local"
MOST_ROWS = 2**31  # of a matrix that is announced
MM2 = 1e6
DEFAULT_AXES = "ne"
AXES_XY = ("ne", "sw", "es", "wn", "en", "nw", "se", "ws")  # of x, then of y
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
    """Read observed coordinates of all groups, and the covariance of each point.

    Axes are turned to the east and north by what ``axes-xy`` says of them.
    """
    root = read_xml(file.data, file.source, EXPECTED)
    groups, (order, signs) = _groups(root, file.source), _axes(root, file.source)
    table = _table(groups, order, signs)
    own = np.concatenate([one.own() for one in groups])[:, order][:, :, order]
    own = own * np.outer(signs, signs) + 0.0  # no zero with a sign
    columns = {
        "standard_error_m": np.sqrt(own[:, 0, 0] + own[:, 1, 1]),
        "standard_error_easting": np.sqrt(own[:, 0, 0]),
        "standard_error_northing": np.sqrt(own[:, 1, 1]),
        "covariance_en": own[:, 0, 1],
    }
    if "height" in table:
        columns["standard_error_height"] = np.sqrt(own[:, 2, 2])
        columns["covariance_eh"], columns["covariance_nh"] = own[:, 0, 2], own[:, 1, 2]
    notes = [f"{file.source}: covariances between points are left out"]
    notes += [*_told_axes(signs, file.source), *_told_fixed(root, table, file.source)]
    return Foreign({"control_points": table.assign(**columns)}, None, tuple(notes))


@dataclass(frozen=True, eq=False)
class _Group:
    """Observed coordinates with one covariance."""

    names: list  # of the points
    widths: np.ndarray  # how many coordinates each point has, 2 or 3
    xyz: np.ndarray  # (n_coordinates,), point after point, as the axes of the file
    covariances: np.ndarray  # rows of the upper triangle [m²]
    band: int

    def places(self):
        """Coordinates of each point, (n, 3); NaN where it has no height."""
        places = np.full((len(self.names), 3), np.nan)
        places[np.arange(3) < self.widths[:, None]] = self.xyz
        return places

    def own(self):
        """Covariance of each point by itself, (n, 3, 3) [m²]; NaN without a height."""
        counts = _counts(self.xyz.size, self.band)
        start = np.concatenate([[0], np.cumsum(counts)[:-1]])
        first = np.concatenate([[0], np.cumsum(self.widths)[:-1]])
        own = np.zeros((len(self.names), 3, 3))
        for one in range(3):
            for two in range(one, 3):
                has = self.widths > two
                if two - one <= self.band:
                    found = self.covariances[start[first[has] + one] + two - one]
                    own[has, one, two] = own[has, two, one] = found
                own[~has, one, two] = own[~has, two, one] = np.nan
        return own


def _groups(root, source):
    """All groups of observed coordinates."""
    groups = [_group(one, source) for one in each(root, "coordinates")]
    if not groups:
        raise damaged(source, "holds no coordinates with a cov-mat", EXPECTED)
    return groups


def _group(group, source):
    matrix = next(each(group, "cov-mat"), None)
    points = list(each(group, "point"))
    if matrix is None or not points:
        raise damaged(source, "holds no coordinates with a cov-mat", EXPECTED)
    letters = ["xyz" if point.get("z") else "xy" for point in points]
    try:
        xyz = [
            _number(point.get(letter))
            for point, own in zip(points, letters, strict=True)
            for letter in own
        ]
        dim, band = (min(int(matrix.get(n)), MOST_ROWS) for n in ("dim", "band"))
        values = np.array([_number(word) for word in (matrix.text or "").split()])
    except (TypeError, ValueError) as error:
        raise damaged(source, f"a number is missing: {error}", EXPECTED) from error
    xyz = np.array(xyz)
    if not np.isfinite(xyz).all() or not np.isfinite(values).all() or band < 0:
        raise damaged(source, "a number is not finite", EXPECTED)
    n_values = _counts(xyz.size, band).sum()
    if dim != xyz.size or len(values) != n_values:
        found = f"has {len(values)} covariances of {xyz.size} coordinates, dim {dim}"
        raise damaged(source, found, f"{n_values} of a band of {band}")
    names = [point.get("id") for point in points]
    return _Group(names, np.array([*map(len, letters)]), xyz, values / MM2, band)


def _axes(root, source):
    """Which of x, y, z is easting, northing, height, and the sign that each is to have.

    By ``axes-xy``; x is the northing where nothing is said, as gama-local takes it.
    """
    network = next(each(root, "network"), None)
    said = DEFAULT_AXES if network is None else network.get("axes-xy", DEFAULT_AXES)
    if said not in AXES_XY:
        found = f"axes-xy is {shortened(said)!r}"
        raise damaged(source, found, name_some(AXES_XY, len(AXES_XY)))
    is_east = [letter in "ew" for letter in said]
    order = [is_east.index(True), is_east.index(False), 2]
    signs = [-1.0 if letter in "sw" else 1.0 for letter in said]
    return order, np.array([signs[order[0]], signs[order[1]], 1.0])


def _table(groups, order, signs):
    """Points of all groups: easting, northing [, height where one has it]."""
    places = np.concatenate([one.places() for one in groups])[:, order] * signs
    table = pd.DataFrame(places, columns=["easting", "northing", "height"])
    table.insert(0, "point_id", [name for one in groups for name in one.names])
    has_heights = any((one.widths > 2).any() for one in groups)
    return table if has_heights else table.drop(columns="height")


def _told_axes(signs, source):
    """Note on axes to the south or west, one or none."""
    if (signs > 0.0).all():
        return []
    against = "south and west" if (signs[:2] < 0.0).all() else None
    against = against or ("west" if signs[0] < 0.0 else "south")
    note = (
        f"{source}: axes-xy has axes to the {against}: their coordinates are taken "
        "with the other sign"
    )
    return [note]


def _told_fixed(root, table, source):
    """Note on fixed points that are not observed as well, one or none."""
    known = set(table["point_id"])
    fixed = [
        str(point.get("id"))
        for point in each(root, "point")
        if point.get("fix") and point.get("id") not in known
    ]
    if not fixed:
        return []
    said = kept("{n:fixed point|fixed points}", n=len(fixed))
    note = (
        f"{source}: {said} without a covariance left out: {name_some(fixed, 8)}. Give "
        "them as observed coordinates with a cov-mat"
    )
    return [note]


def _number(word):
    """A number; float takes 1_0 for one, and digits of all scripts."""
    if word is None or not is_number(word):
        raise ValueError(repr(shortened(word)))
    return float(word)


def _counts(dim, band):
    """How many covariances each row has."""
    return np.minimum(band, dim - 1 - np.arange(dim)) + 1
