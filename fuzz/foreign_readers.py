"""Readers of files of other programs, of shapefiles, and of areas and terrain."""

from functools import partial

from einschalt.foundations.errors import FileError
from einschalt.interfaces.files.area_files import read_area
from einschalt.interfaces.files.height_files import read_heights
from einschalt.interfaces.programs.block_tables import found_in
from einschalt.interfaces.programs.recognised import read_foreign
from fuzz import foreign_files
from fuzz.judges import judge_text
from fuzz.sound_files import (
    HEIGHTS_TIFF,
    HEIGHTS_XYZ,
    TABLES,
    TIED,
    as_area,
    as_shapefile,
)

CRS = "EPSG:31255"


def of_foreign_files():
    """Readers of one file, known by its name, alone or with others beside it.

    Yields
    ------
    str, str, sequence of (str or bytes), callable, float
        Name, file, seeds, what reads it, and how often it has its turn.
    """
    for name, (text, _, _) in foreign_files.READ.items():
        yield f"foreign {name}", name, (text,), _foreign, 1
    for name, text in foreign_files.MORE.items():
        yield f"foreign {name}", name, (text,), _foreign, 1
    yield "foreign a.tif", "a.tif", (TIED,), _foreign, 1
    markers = {"markers.xml": foreign_files.MARKERS}
    markers["gcp_list.txt"] = foreign_files.GCP_LIST
    for name, text in markers.items():
        yield f"foreign {name}", name, (text,), _markers, 1
    for name, seeds in foreign_files.TOGETHER.items():
        yield f"foreign {name}", name, seeds, _reader_of(name), 1
    tracks = partial(_beside, read=_foreign, name="tracks.csv")
    sizes = (foreign_files.RECONSTRUCTION,)
    yield "sizes of tracks", "reconstruction.json", sizes, tracks, 1


def of_shapefiles(read):
    """Readers of a shapefile, of which each part may be the changed one.

    Parameters
    ----------
    read : callable
        Takes the path of the .shp.

    Yields
    ------
    str, str, sequence of bytes, callable, float
        As of :func:`of_foreign_files`.
    """
    for suffix, data in _shapefile().items():
        of_shp = partial(_beside, read=read, name="t.shp")
        yield f"points.shp, its {suffix}", f"t{suffix}", (data,), of_shp, 1


def of_terrain():
    """Readers of areas to be flown over, and of heights below them.

    Yields
    ------
    str, str, sequence of (str or bytes), callable, float
        As of :func:`of_foreign_files`.
    """
    for suffix in (".gpkg", ".geojson"):
        yield f"area{suffix}", f"area{suffix}", (as_area(suffix),), _area, 1
    for name, seed in (("heights.tif", HEIGHTS_TIFF), ("heights.xyz", HEIGHTS_XYZ)):
        yield name, name, (seed,), partial(read_heights, crs=CRS), 1


def write_beside(file, folder):
    """Write the files that a file is read with.

    Parameters
    ----------
    file : str
        Its path in the folder.
    folder : Path
    """
    (folder / file).parent.mkdir(exist_ok=True)
    for name, text in foreign_files.BESIDE.get(file, {}).items():
        (folder / name).write_text(text, encoding="utf-8")
    parts = _shapefile() if file.startswith("t.") else {}
    if file.removeprefix("t") in parts:
        for suffix, data in parts.items():
            (folder / f"t{suffix}").write_bytes(data)


def _shapefile():
    return as_shapefile(TABLES["approximate_points.csv"])


def _reader_of(name):
    if name in foreign_files.COLMAP:
        return lambda path: _foreign(path.parent)
    if name in foreign_files.OPF_FILES:
        return partial(_beside, read=_foreign, name="project.opf")
    if name == "reconstruction.json":
        return partial(_beside, read=_markers, name="gcp.json")
    return _markers if name == "gcp.json" else _foreign


def _beside(path, *, read, name):
    """Read the file that another one belongs to."""
    read(path.with_name(name))


def _foreign(path):
    _judge(read_foreign(path))


def _markers(path):
    found = found_in(path)
    if found is None:  # no longer known by what stands in it: a plain table
        raise FileError("is of no program that is known", file=path.name)
    _judge(found)


def _judge(found):
    for note in found.notes:
        judge_text(note)


def _area(path):
    read_area(path, crs=CRS)
