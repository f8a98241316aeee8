"""Publication: a folder with everything by which others use a transformation."""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from einschalt.foundations.arguments import described
from einschalt.foundations.coordinate_operations import system_label
from einschalt.foundations.errors import SettingsError, name_some
from einschalt.foundations.frame_columns import PLAN
from einschalt.foundations.kept_texts import retold
from einschalt.foundations.language import figure, mark, translated
from einschalt.foundations.published_systems import operation_wkt
from einschalt.foundations.typesetting import wrapped
from einschalt.interfaces.files.atomic import write_text
from einschalt.interfaces.files.csv_tables import write_csv
from einschalt.interfaces.files.output_folder import InputFiles, Output, write_folder
from einschalt.interfaces.files.written_files import FAILURE, PROVENANCE, Source
from einschalt.interfaces.provenance import provenance_of_tables
from einschalt.interfaces.publication.doubts import doubts_of
from einschalt.interfaces.publication.gtg_file import gridshift_step, write_gtg
from einschalt.interfaces.publication.operations_of_results import (
    Frames,
    left_out_of,
    operations_of_block,
    operations_of_fit,
)
from einschalt.interfaces.publication.proj_database import (
    AUTHORITY,
    frame_wkt,
    require_database,
    require_grids_are_read,
    write_database,
)
from einschalt.interfaces.publication.publication_page import page
from einschalt.interfaces.publication.return_check import (
    require_database_returns,
    require_text_returns,
)
from einschalt.interfaces.publication.stated_systems import (
    require_places,
    require_system_of_block,
    require_systems,
)
from einschalt.interfaces.publication.tinshift_file import (
    tinshift_step,
    write_tinshift,
)
from einschalt.pipeline.assessment.evidence.fits.bent_models import bent_flights_of
from einschalt.stages.results import Result

PAGE, OPERATIONS, LEFT_OUT = "README.md", "operations.csv", "left_out.csv"
BLOCK_TABLES = ("models", "residuals", "points")
NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]{1,39}")
RESERVED = {Path(name).stem for name in (PROVENANCE, FAILURE)}  # files are NAME.json
DEVICE = re.compile(r"con|prn|aux|nul|(com|lpt)[0-9]", re.IGNORECASE)  # of Windows


@dataclass(frozen=True, eq=False, repr=False)
class Publication(Result):
    """What was published.

    Attributes
    ----------
    name : str
    folder : Path
    operations : DataFrame
        code, model, accuracy (of held-out points, TOTAL) [m], n_points, n_held_out,
        west, south, east, north [degrees], triangles, grid (files, empty where there
        are none), proj (PROJ string), wkt (CoordinateOperation).
    left_out : DataFrame
        operation, point_id, deviation [m], reason.
    database : Path or None
        The auxiliary PROJ database; None where the ground has no system, or the
        transformation is spatial.
    doubts : tuple of str
        What should be known before they are used: which no held-out point checks, and
        which miss them by far.
    """

    name: str
    folder: Path
    operations: pd.DataFrame
    left_out: pd.DataFrame
    database: Path | None
    doubts: tuple[str, ...] = ()

    def summary(self) -> str:
        """Say what was published, how good it is, and where to read on."""
        message = mark(
            "{name}: {n:transformation|transformations} published, and checked there "
            "and back"
        )
        lines = [translated(message, name=self.name, n=len(self.operations))]
        low, high = self.operations["accuracy"].min(), self.operations["accuracy"].max()
        if np.isfinite(low):
            span = figure(low, ".4f")
            if low != high:
                facts = {"low": span, "high": figure(high, ".4f")}
                span = translated("{low} to {high}", **facts)
            lines.append(translated("held-out points (total)  {span} m", span=span))
        for doubt in self.doubts:
            said = translated("warning: {doubt}", doubt=retold(doubt))
            lines.append(wrapped(said, indent="  "))
        if len(self.left_out):
            message = mark("{n:identical point|identical points} left out, see {file}")
            lines.append(translated(message, n=len(self.left_out), file=LEFT_OUT))
        if self.database is not None:
            message = mark("PROJ finds {code} with PROJ_AUX_DB={database}")
            code = f"{AUTHORITY}:{self.operations['code'].iloc[0]}"
            lines.append(translated(message, code=code, database=self.database))
        page = translated("How to use it: {page}", page=self.folder / PAGE)
        return "\n".join([*lines, page])


def require_name(name):
    """Refuse a name that PROJ and file systems would not take as it is."""
    if not (isinstance(name, str) and NAME.fullmatch(name)):
        raise SettingsError(
            f"the name of a publication is {described(name)}",
            expected="a letter, then letters, digits, - or _, 2 to 40 in all",
        )
    if name.casefold() in RESERVED or DEVICE.fullmatch(name):
        raise SettingsError(
            f"the name of a publication is {name}, as a file of another kind is called",
            expected="a name of its own, such as that of the old frame",
        )


def publish_operations(
    operations,
    frames,
    folder,
    *,
    files=(),
    title,
    installed_at=None,
    proj_db=None,
    overwrite=False,
) -> Publication:
    """Write operations in every form, after PROJ has run each of them both ways.

    ``files``: what the result was read from; ``title``: of the result, for people;
    ``installed_at``: the folder in which the files will stand when they are used, where
    that is another one; empty where PROJ shall search for them in its own folders.
    ``proj_db``: database of the PROJ that is to use them, where that is another one.
    """
    folder = Path(folder)
    name = frames.name
    if proj_db is not None:
        require_database(Path(proj_db))
        if any(one.grid is not None for one in operations):
            require_grids_are_read(Path(proj_db))
    home = _where(folder) if installed_at is None else Path(installed_at)
    names = _names_of_files(operations, name)
    output = Output(Source("publish", name), names, InputFiles(files), overwrite)
    plane = [one for one in operations if one.is_plane]
    has_database = frames.target is not None and bool(plane)
    done = []

    def write(staging):
        staging = staging.absolute()  # PROJ would search for another one
        _write_triangles(operations, frames, staging)
        _write_grids(operations, frames, staging)
        table = _checked_table(operations, staging, home)
        left_out = left_out_of(operations)
        write_csv(table, staging / OPERATIONS)
        if len(left_out):
            write_csv(left_out, staging / LEFT_OUT, decimals={"deviation": 4})
        database = staging / f"{name}.db" if has_database else None
        if has_database:
            _write_checked_database(plane, frames, database, home, proj_db)
            for one in plane:
                write_text(staging / f"{one.code}.wkt", frame_wkt(one) + "\n")
        done.append((table, left_out))
        text = page(operations, frames, title, home, left_out, has_database)
        write_text(staging / PAGE, text)

    facts = provenance_of_tables("publish", output.inputs.signed())
    write_folder(folder, output, facts, write)
    database = home / f"{name}.db" if has_database else None
    return Publication(name, folder, *done[0], database, doubts_of(operations))


def _where(folder):
    """Whole path of a folder; without .. in it, which a link may lead elsewhere."""
    whole = folder.absolute()
    return whole.resolve() if ".." in whole.parts else whole


def _names_of_files(operations, name):
    """Every file that may be written, each of them once."""
    names = [f"{name}.db", PAGE, OPERATIONS, LEFT_OUT, PROVENANCE]
    for one in operations:
        names += [f"{one.code}{suffix}" for suffix in (".json", ".tif", ".wkt")]
    taken = [file.casefold() for file in names]
    twice = [file for file in names if taken.count(file.casefold()) > 1]
    if twice:  # the one would be written over the other
        raise SettingsError(
            f"the publication would write {name_some(sorted(set(twice)))} twice",
            expected="another name",
        )
    return frozenset(names)


def _write_triangles(operations, frames, folder):
    target = frames.target
    ends = frames.target_label
    if target is not None and target.to_authority(min_confidence=100):
        ends = ":".join(target.to_authority(min_confidence=100))
    for one in operations:
        if one.net is not None:
            write_tinshift(
                folder / f"{one.code}.json",
                one.net,
                name=one.title,
                description=f"{one.title}, from {frames.source_label} to "
                f"{frames.target_label}; held-out points: {_said(one.accuracy_m)}",
                systems=(f"{AUTHORITY}:{one.code}", ends),
            )


def _write_grids(operations, frames, folder):
    for one in operations:
        if one.grid is not None:
            area = f"{one.title}, from {frames.source_label} to {frames.target_label}"
            write_gtg(
                folder / f"{one.code}.tif",
                one.grid,
                name=one.code,
                area=area,
                target=frames.target,
            )


def _said(accuracy):
    return f"{accuracy:.4f} m" if np.isfinite(accuracy) else "none"


def _checked_table(operations, staging, home):
    """Each operation as text, after PROJ has run it; the files are in ``staging``."""
    for one in operations:
        _require_returns(one, staging)
    return pd.DataFrame([_row(one, home) for one in operations])


def _require_returns(one, staging):
    """Let PROJ run an operation in each form, with its files where they are now."""
    texts = _texts(one, staging)
    require_text_returns(one, "PROJ string", texts["proj"])
    require_text_returns(one, "WKT", texts["wkt"])
    if one.net is not None and not one.is_distributed:
        triangles = tinshift_step(staging / f"{one.code}.json")
        require_text_returns(one, "triangles", triangles)


def _row(one, home):
    area = one.area or (np.nan,) * 4
    return {
        "code": one.code,
        "model": one.model,
        "accuracy": one.accuracy_m,
        "n_points": len(one.source),
        "n_held_out": one.n_held_out,
        **dict(zip(("west", "south", "east", "north"), area, strict=True)),
        "triangles": "" if one.net is None else f"{one.code}.json",
        "grid": "" if one.grid is None else f"{one.code}.tif",
        **_texts(one, home),
    }


def _texts(one, place):
    """An operation as PROJ string and WKT, with its files in a folder."""
    pipeline = f"+proj=pipeline +step {_step(one, place)}"
    ends, method = (one.frame, one.system), one.method(pipeline)
    wkt = operation_wkt(one.title, ends, method, one.accuracy_m, one.area)
    return {"proj": pipeline, "wkt": wkt}


def _step(one, place):
    if one.grid is not None:
        shifts = gridshift_step(place / f"{one.code}.tif")
        return f"{one.affine_step} +step {shifts}"
    if one.is_distributed:
        return tinshift_step(place / f"{one.code}.json")
    return one.affine_step


@dataclass(frozen=True, eq=False)
class _Entry:
    """An operation as the database takes it."""

    code: str
    title: str
    frame: object
    system: object
    steps: str
    accuracy_m: float | None
    area: tuple


def _write_checked_database(operations, frames, path, home, proj_db):
    """Write the database; before, one whose files lie where they are now is checked."""
    target = frames.target
    code = target.to_authority(min_confidence=100)
    code = ":".join(code) if code else f"{AUTHORITY}:{operations[0].code}_TARGET"
    description = f"from {frames.source_label} to {system_label(target)}"
    for place, like in ((path.parent, None), (home, proj_db)):
        path.unlink(missing_ok=True)
        entries = [
            _Entry(
                one.code,
                one.title,
                one.frame,
                one.system,
                _step(one, place),
                one.accuracy_m if np.isfinite(one.accuracy_m) else None,
                one.area,
            )
            for one in operations
        ]
        write_database(path, entries, target, description=description, like=like)
        if place == path.parent:
            require_database_returns(operations, code, path)


def publish_fit(fit, name, folder, *, crs=None, source_crs=None, **options):
    """Publish a ModelTransformation; see :func:`einschalt.publish`."""
    require_name(name)
    require_systems(crs, source_crs)
    frames = Frames(name, crs, source_crs)
    observed = fit.observed
    require_places(
        pd.DataFrame(observed.source[:, :2], columns=["x", "y"]),
        pd.DataFrame(observed.target[:, :2], columns=["easting", "northing"]),
        frames,
    )
    title = f"identical points ({fit.kind})"
    return publish_operations(
        operations_of_fit(fit, frames), frames, folder, title=title, **options
    )


def publish_block(
    tables, name, folder, *, own_crs, crs=None, source_crs=None, bent=(), **options
):
    """Publish the models of a block.

    ``tables`` as :func:`operations_of_block`; ``own_crs``: system of the block, or
    None, into which its models lead. Another ``crs`` would put them elsewhere.
    """
    require_name(name)
    require_system_of_block(crs, source_crs, own_crs)
    frames = Frames(name, own_crs or crs)
    require_places(None, tables["points"][PLAN].dropna(), frames)
    operations = operations_of_block(tables, frames, bent)
    return publish_operations(operations, frames, folder, **options)


def publish_densification(
    result, name, folder, *, crs=None, source_crs=None, **options
):
    """Publish the models of a DensificationResult; see :func:`einschalt.publish`."""
    deformation = result.assessment.deformation
    flights = () if deformation is None else deformation.flights
    bent = {flight.flight for flight in flights if flight.is_modelled}
    bent |= {each.flight for each in bent_flights_of(result.examination)}
    # models lead to the system of the block, whatever that of the results
    tables = {name: getattr(result.examination, name) for name in BLOCK_TABLES}
    return publish_block(
        tables,
        name,
        folder,
        own_crs=result.block.crs,
        crs=crs,
        source_crs=source_crs,
        title=title_of_block(result.block.name),
        bent=sorted(bent),
        files=result.block.files,
        **options,
    )


def title_of_block(name):
    """What is published of a block, for people."""
    return f"the models of the block {name}"
