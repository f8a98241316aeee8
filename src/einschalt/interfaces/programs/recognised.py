"""Files of other programs, known by their names and first bytes.

A format of one's own is an entry point of the group ``einschalt.readers``: its name is
a suffix such as ``.abc``, or a word for ``convert --format``; its object takes the path
and gives DataFrames by the names of their tables.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from importlib.metadata import entry_points
from pathlib import Path

from einschalt.foundations.errors import FileError, name_some
from einschalt.interfaces.files.input_files import (
    ReadFile,
    is_folder,
    is_there,
    read_once,
    require_file,
)
from einschalt.interfaces.programs import (
    bingo,
    blocks_exchange,
    colmap,
    drawing_points,
    field_books,
    gama,
    gdal_gcps,
    ign,
    jobxml,
    kml_points,
    landxml,
    leica_gsi,
    match_at,
    metashape_cameras,
    metashape_reference,
    micmac,
    opensfm_cameras,
    opensfm_tracks,
    opf,
    pat_b,
    photomodeler,
    pix4d,
    pix4d_cameras,
    sima,
    sinex,
)
from einschalt.interfaces.programs.foreign import Foreign, in_unit_of_system

PLUGINS = "einschalt.readers"
HEAD_BYTES = 4096
MOST_BYTES = 2**31


@dataclass(frozen=True)
class Format:
    """A kind of file: its name, what it is, how it is known and read."""

    name: str
    text: str
    read: Callable  # of a ReadFile, or of the path where is_folder
    suffixes: tuple[str, ...] = ()
    is_it: Callable | None = None  # of the first bytes; by suffix alone where None
    stems: tuple[str, ...] = ()  # names without suffix, which suffixes need


XML = (".xml", ".landxml")
TEXT = (".txt", ".csv")
BOOKS = (".sdr", ".raw", ".txt")
# their end can be told
CLOSED = (".vrt", ".tif", ".dxf", ".snx", ".json", ".p4d", ".opf", ".jxl", ".kml")
FORMATS = (
    Format("landxml", "LandXML", landxml.read_landxml, XML, landxml.is_landxml),
    Format("jobxml", "JobXML of Trimble", jobxml.read_jobxml, (".jxl",)),
    Format("kml", "KML", kml_points.read_kml, (".kml",)),
    Format("gsi", "GSI of Leica", leica_gsi.read_gsi, (".gsi",)),
    Format("sdr", "SDR of Sokkia", field_books.read_sdr, BOOKS, field_books.is_sdr),
    Format("nikon", "Nikon", field_books.read_nikon, BOOKS, field_books.is_nikon),
    Format("sima", "SIMA", sima.read_sima, (".sim", ".sima", ".txt"), sima.is_sima),
    Format("gama", "GNU Gama", gama.read_gama, (".gkf", *XML), gama.is_gama),
    Format("micmac", "MicMac", micmac.read_file, XML, micmac.is_xml),
    Format(
        "blocks-exchange",
        "BlocksExchange of ContextCapture",
        blocks_exchange.read_blocks,
        XML,
        blocks_exchange.is_blocks,
    ),
    Format(
        "metashape-cameras",
        "cameras of Metashape",
        metashape_cameras.read_cameras,
        XML,
        metashape_cameras.is_cameras,
    ),
    Format(
        "arcgis",
        "links of ArcGIS",
        gdal_gcps.read_arcgis,
        XML,
        lambda head: b"GeodataXform" in head,
    ),
    Format("vrt", "GCPs of a VRT of GDAL", gdal_gcps.read_vrt, (".vrt",)),
    Format("geotiff", "GCPs of a GeoTIFF", gdal_gcps.read_geotiff, (".tif", ".tiff")),
    Format("qgis", "points of QGIS", gdal_gcps.read_qgis, (".points",)),
    Format(
        "photomodeler",
        "PhotoModeler, DBAT",
        photomodeler.read_export,
        TEXT,
        photomodeler.is_export,
    ),
    Format(
        "metashape-reference",
        "reference of Metashape",
        metashape_reference.read_reference,
        TEXT,
        metashape_reference.is_reference,
    ),
    Format(
        "opensfm-tracks",
        "tracks of OpenSfM",
        opensfm_tracks.read_tracks,
        TEXT,
        opensfm_tracks.is_tracks,
    ),
    Format(
        "opensfm-cameras",
        "cameras of OpenSfM, ODM",
        opensfm_cameras.read_cameras,
        (".json",),
        opensfm_cameras.is_cameras,
    ),
    Format(
        "opf",
        "Open Photogrammetry Format",
        opf.read_project,
        (".opf", ".json"),
        opf.is_project,
    ),
    Format("pix4d", "Pix4Dmapper", pix4d.read_project, (".p4d",), pix4d.is_project),
    Format(
        "pix4d-cameras",
        "cameras of Pix4Dmapper",
        pix4d_cameras.read_parameters,
        (".txt",),
        pix4d_cameras.is_parameters,
    ),
    Format("dxf", "DXF", drawing_points.read_dxf, (".dxf",)),
    Format("sinex", "SINEX", sinex.read_sinex, (".snx",)),
    Format("ign-opk", "orientations of IGN", ign.read_opk, (".opk",)),
    Format("ign-xyz", "points of IGN", ign.read_xyz, (".xyz",)),
    Format("ign-app", "control of IGN", ign.read_app, (".app",)),
    Format("ign-mes", "image points of IGN", ign.read_mes, (".mes",)),
    Format("pat-b-control", "PAT-B", pat_b.read_control, (".con",)),
    Format("pat-b-images", "PAT-B", pat_b.read_photos, (".im",)),
    Format("pat-b-orientations", "PAT-B", pat_b.read_orientations, (".ori",)),
    Format("bingo-control", "BINGO", bingo.read_control, (".dat",), stems=("geoin",)),
    Format("bingo-images", "BINGO", bingo.read_images, (".dat",), stems=("image",)),
    Format("bingo-result", "BINGO", bingo.read_result, (".dat",), stems=("itera",)),
    Format(
        "match-at",
        "Match-AT of Inpho",
        match_at.read_project,
        (".prj",),
        match_at.is_project,
    ),
)
BY_NAME = {one.name: one for one in FORMATS}
# read where they are named: images are large and seldom have points, maps are mostly
# results, of einschalt as well
IF_NAMED = (".tif", ".tiff", ".kml")
SUFFIXES = tuple({suffix: None for one in FORMATS for suffix in one.suffixes})


def reader_of(path, name=None):
    """Function that reads a file or folder of another program; None for a table.

    ``name``: of the format, where it is said. A FileError where there is none of it, or
    the file is not there.
    """
    file, path = path, Path(path)
    if name is not None:
        return _named(name)
    if is_folder(path):
        return _of_folder(path)
    if not is_there(path):
        require_file(path, path.name)
    plugin = _plugin(path.suffix.lower())
    if plugin is not None:
        return plugin
    if micmac.is_homologous(path):
        return lambda given: micmac.read_homologous(Path(given))
    known = format_of(file)
    return None if known is None else _of_file(known)


def format_of(file) -> Format | None:
    """Format of a file, by its name and first bytes; None where it is none of these."""
    path = Path(file)
    head, suffix = head_of(file), path.suffix.lower()
    for one in FORMATS:
        is_known = suffix in one.suffixes
        is_known &= not one.stems or path.stem.casefold() in one.stems
        if is_known and (one.is_it is None or one.is_it(head)):
            return one
    return None


def read_foreign(path, name=None) -> Foreign:
    """Read a file or folder of another program; a FileError where it is none."""
    read = reader_of(path, name)
    if read is None:
        raise FileError(
            "is of no program that is known",
            expected=name_some(BY_NAME, len(BY_NAME)),
            remedy="Say the format",
            file=Path(path).name,
        )
    return in_unit_of_system(read(path), Path(path).name)


def _of_file(known):
    def read(path):
        _refuse_size(path)
        file = read_once(path, Path(path).name)
        found = known.read(file)
        is_text = not set(known.suffixes) & {*XML, *CLOSED}
        if not is_text or file.data.endswith((b"\n", b"\r")):
            return found
        # a list that is cut off within its last number looks sound
        note = f"{file.source}: ends without a line break: is its last line whole?"
        return replace(found, notes=(*found.notes, note))

    return read


def _refuse_size(path):
    """Refuse what would be read as a whole and is no list of points."""
    if isinstance(path, ReadFile) or not is_there(Path(path)):
        return
    n_bytes = Path(path).stat().st_size
    if n_bytes > MOST_BYTES:
        raise FileError(
            f"has {n_bytes} bytes",
            expected=f"at most {MOST_BYTES}",
            remedy="Export its points alone, or less at once",
            file=Path(path).name,
        )


def head_of(path):
    """First bytes of a file."""
    if isinstance(path, ReadFile):
        return path.data[:HEAD_BYTES]
    with require_file(path, path.name).open("rb") as file:
        return file.read(HEAD_BYTES)


def _of_folder(path):
    if colmap.is_model(path):
        return colmap.read_model
    if micmac.is_homologous(path):
        return micmac.read_homologous
    raise FileError(
        "is a folder, and no model of COLMAP or Homol of MicMac",
        expected="a file, or a folder with cameras.txt and images.txt",
        remedy="Name the file in it",
        file=path.name,
    )


def _named(name):
    if name in BY_NAME:
        return _of_file(BY_NAME[name])
    if name == "colmap":
        return colmap.read_model
    if name == "micmac-homol":
        return micmac.read_homologous
    plugin = _plugin(name)
    if plugin is not None:
        return plugin
    known = [*BY_NAME, "colmap", "micmac-homol"]
    raise FileError(
        f"format '{name}' is unknown",
        expected=name_some(known, len(known)),
        remedy="Correct the format",
    )


@cache  # a file of every installed package is read, and each table asks
def installed_readers():
    """Entry points of packages that read formats of their own."""
    return tuple(entry_points(group=PLUGINS))


def _plugin(name):
    """Reader of an installed package, by its suffix or its word."""
    for point in installed_readers():
        if point.name == name:
            return lambda path: _of_plugin(point, Path(path))
    return None


def _of_plugin(point, path):
    found = point.load()(path)
    return found if isinstance(found, Foreign) else Foreign(dict(found))
