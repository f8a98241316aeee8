"""Results handed over to other programs: a file for each, its kind by the suffix."""

import shutil
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.metadata import entry_points
from pathlib import Path
from typing import TYPE_CHECKING

from einschalt.foundations.arguments import StrPath, as_path
from einschalt.foundations.errors import (
    EinschaltError,
    FileError,
    SettingsError,
    raise_problems,
)
from einschalt.interfaces.files.atomic import said_as_file_error
from einschalt.interfaces.files.output_folder import InputFiles, Output
from einschalt.interfaces.files.table_output import write_file
from einschalt.interfaces.files.written_files import Source
from einschalt.interfaces.programs import (
    drawing,
    gama,
    kml,
    landxml,
    map_files,
    metashape_reference,
    pat_b,
    results_workbook,
    sinex,
)
from einschalt.interfaces.programs.handed_over import HandedOver, of_folder, of_result

if TYPE_CHECKING:
    from einschalt.pipeline.result import DensificationResult

PLUGINS = "einschalt.writers"
WRITERS = {
    ".dxf": drawing.write_dxf,
    ".xlsx": results_workbook.write_workbook,
    ".kml": kml.write_kml,
    ".shp": map_files.write_shapefile,
    ".parquet": map_files.write_geoparquet,
    ".xml": landxml.write_landxml,
    ".csv": metashape_reference.write_reference,
    ".con": pat_b.write_control,
    ".gkf": gama.write_gama,
    ".snx": sinex.write_sinex,
}


@dataclass(frozen=True)
class Exported:
    """A file that was written, and what is to be known of it."""

    path: Path
    notes: tuple[str, ...] = ()

    def __str__(self):
        return "; ".join([str(self.path), *self.notes])


def export(
    result: "DensificationResult | StrPath", *files: StrPath, overwrite: bool = False
) -> list[Exported]:
    """Write a result for other programs; the suffix of each file gives its format.

    Parameters
    ----------
    result : DensificationResult, str or Path
        Or the folder into which one was written.
    *files : str or Path
        .dxf (points, numbers, ellipses, residual vectors on layers), .xlsx (a sheet per
        table), .kml, .shp, .parquet (GeoParquet), .xml (LandXML), .csv (reference of
        Metashape), .con (control list of PAT-B), .gkf (GNU Gama) and .snx (SINEX), both
        with the covariance of the points.
    overwrite : bool, optional
        Replace files that are there; never those of the result.

    Returns
    -------
    list of Exported
        ``path`` and ``notes`` of each: what was drawn larger, which covariances it has,
        by which operation coordinates were brought over.

    Raises
    ------
    EinschaltError
        A format is not known or cannot hold the result, or a file is there already.
    """
    return list(each_exported(result, *files, overwrite=overwrite))


def each_exported(result, *files, overwrite=False) -> Iterator[Exported]:
    """Write as :func:`export` does, and give each file as soon as it is there.

    A file that is refused keeps no other from being written; its error comes last.
    """
    writers = [(as_path("file", file), writer_of(file)) for file in files]
    if not writers:
        raise SettingsError(
            "export was given no file",
            expected=", ".join(f"NAME{suffix}" for suffix in WRITERS),
            remedy="Name one or more files",
        )
    handed, inputs = _handed_over(result)
    source = Source("export", handed.name, tuple(inputs))
    output = Output(source, frozenset(), InputFiles(inputs), overwrite)
    problems = []
    for path, write in writers:
        try:
            written = _written(handed, path, write, output)
        except EinschaltError as error:
            problems.append(error)
        else:
            yield written
    raise_problems(problems)


def writer_of(file):
    """Function that writes files of a suffix; a FileError where there is none."""
    suffix = Path(file).suffix.lower()
    if suffix in WRITERS:
        return WRITERS[suffix]
    for point in entry_points(group=PLUGINS):
        if point.name == suffix:
            return point.load()
    raise FileError(
        f"suffix '{suffix}' is unknown" if suffix else "the suffix is missing",
        expected=", ".join(WRITERS),
        remedy="Name a file with one of these",
        file=Path(file).name,
    )


def _handed_over(result) -> tuple[HandedOver, list]:
    """The result with its files, which nothing may replace."""
    if hasattr(result, "solution"):
        return of_result(result), list(result.block.files)
    folder = as_path("result", result)
    handed = of_folder(folder)
    return handed, sorted(path for path in folder.iterdir() if path.is_file())


def _written(handed, path, write, output):
    """Write a file, and what belongs to it, each whole or not at all."""
    with tempfile.TemporaryDirectory(prefix="einschalt-export-") as folder:
        whole = Path(folder) / path.name
        with said_as_file_error(path):  # what belongs to it may have too long a name
            notes = write(handed, whole) or ()
        made = sorted(Path(folder).iterdir(), key=lambda one: one != whole)
        for one in made:
            write_file(path.with_name(one.name), output, _copying(one))
    return Exported(path, tuple(notes))


def _copying(made):
    return lambda place: shutil.copyfile(made, place)
