"""The Python interface: blocks and results that can also be written.

The lower floors compute and touch no files; here their objects learn to write
themselves.
"""

import os
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import pandas as pd

from einschalt.foundations.arguments import (
    StrPath,
    as_path,
    described,
    require_choice,
    require_kind,
    require_text,
)
from einschalt.foundations.errors import (
    EinschaltError,
    FileError,
    SettingsError,
    name_some,
    raise_problems,
)
from einschalt.foundations.known_fields import with_known_fields
from einschalt.foundations.language import language as active_language
from einschalt.foundations.language import written_in
from einschalt.foundations.projections import read_source_crs
from einschalt.foundations.tables import CONTROL_POINTS, check_table
from einschalt.foundations.told_fields import with_fields_of
from einschalt.interfaces.files.answers_in_python import OF_ARGUMENTS
from einschalt.interfaces.files.block_writing import write_block
from einschalt.interfaces.files.input_files import companions, read_once
from einschalt.interfaces.files.points_of_systems import require_columns, schema_in
from einschalt.interfaces.files.result_folder import write_report, write_result
from einschalt.interfaces.files.tables_by_suffix import understand_table
from einschalt.interfaces.files.understood_tables import Said, answered_elsewhere
from einschalt.interfaces.files.written_angles import WAYS
from einschalt.interfaces.notebook import cards
from einschalt.interfaces.notebook.geodataframe import points_with_geometry
from einschalt.interfaces.notebook.result_plots import ResultPlots
from einschalt.interfaces.programs import block_tables
from einschalt.pipeline import densify as computed
from einschalt.pipeline import result as results
from einschalt.pipeline.block import block as checked
from einschalt.pipeline.densification.solution import Solution
from einschalt.pipeline.settings import Settings

if TYPE_CHECKING:
    import geopandas

    from einschalt.interfaces.programs.export import Exported
    from einschalt.interfaces.publication.publish import Publication


@with_fields_of(checked.Block)
@with_known_fields
@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class Block(checked.Block):
    """The checked tables of one survey, which can be written as a folder.

    EinschaltError where something stops the computation; several faults come together.
    """

    def write(self, folder: StrPath, *, overwrite: bool = False) -> None:
        """Write the block as a folder that :func:`read_block` reads.

        Parameters
        ----------
        folder : str or Path
            Made where it does not exist.
        overwrite : bool, optional
            Replace the files of a block that stands there; never files that this
            block was read from.

        Raises
        ------
        FileError
            A file is there already, or the folder cannot be written.
        """
        write_block(self, as_path("folder", folder), overwrite=overwrite)

    def _repr_html_(self) -> str:
        return cards.block_card(self)


@with_fields_of(Solution)
@dataclass(frozen=True, eq=False, repr=False)
class DensificationResult(results.DensificationResult):
    """Densified coordinates of a block, which can be written as a folder.

    With ``output_crs`` tables of points are in that system; ``covariance_between`` and
    ``errors`` stay in the system of the block, in which all is computed.
    """

    @property
    def plot(self) -> ResultPlots:
        """Figures on axes of matplotlib: ``result.plot.map()`` and others."""
        return ResultPlots(self)

    def write(
        self,
        folder: StrPath,
        *,
        ellipse_scale: float | None = None,
        report: bool = True,
        paper: Literal["a4", "letter"] | None = None,
        overwrite: bool = False,
    ) -> None:
        """Write tables, GeoPackage, report, summary and provenance into a folder.

        All files are written, or none; provenance.json comes last.

        Parameters
        ----------
        folder : str or Path
            Made where it does not exist. An older result of the same block is
            replaced.
        ellipse_scale : float, optional
            How much larger the confidence ellipses are drawn in block.gpkg. The
            default is a round factor that makes them visible.
        report : bool, optional
            Whether report.html is written; without it the rest is there sooner.
        paper : {"a4", "letter"}, optional
            Print the report on this paper as well, into report.pdf; it takes an
            installed Chromium.
        overwrite : bool, optional
            Replace what einschalt did not write, what has been changed since, and
            results of another block. Files that the block was read from are never
            replaced.

        Raises
        ------
        FileError
            Something would be lost, or the folder cannot be written.
        SettingsError
            The scale is not positive, or the report cannot be printed.
        """
        write_result(
            self,
            as_path("folder", folder),
            ellipse_scale=ellipse_scale,
            report=report,
            paper=paper,
            overwrite=overwrite,
        )

    def report(
        self, path: StrPath, *, overwrite: bool = False, language: str | None = None
    ) -> None:
        """Write the report alone: one self-contained HTML page.

        Parameters
        ----------
        path : str or Path
            Of the page.
        overwrite : bool, optional
            Replace a file that is there; never what the block was read from.
        language : str, optional
            "en" or "de"; left out, the one of ``written_in``, else English.

        Raises
        ------
        FileError
            A file is there, or it cannot be written.
        SettingsError
            There is no such language.
        """
        with written_in(language or active_language()):
            write_report(self, as_path("path", path), overwrite=overwrite)

    def to_geodataframe(self) -> "geopandas.GeoDataFrame":
        """Points with their geometry and reference system, for geopandas.

        It takes the extra ``notebook`` of the package.

        Returns
        -------
        GeoDataFrame
            The columns of ``points``, and ``geometry``: x is the east, y the north, z
            the height of points that have one; missing for points without coordinates.
            Its ``crs`` is that of the results.

        Raises
        ------
        FileError
            geopandas is not installed.
        """
        return points_with_geometry(self)

    def _repr_html_(self) -> str:
        return cards.result_card(self)

    def publish(self, name: str, folder: StrPath, **options: Any) -> "Publication":
        """Write the transformation of every model for PROJ, GDAL and QGIS.

        Parameters
        ----------
        name : str
            The models are found as ``EINSCHALT:NAME_flight_coverage_model``.
        folder : str or Path
            Made where it does not exist.
        **options
            As of :func:`einschalt.publish`.

        Returns
        -------
        Publication

        Raises
        ------
        EinschaltError
            No model can be published, or something would be lost in the folder.
        """
        # imported when something is published: other results do not wait for it
        from einschalt.interfaces.publication.publish import (  # noqa: PLC0415
            publish_densification,
        )

        folder = as_path("folder", folder)
        return publish_densification(self, name, folder, **options)

    def export(self, *files: StrPath, overwrite: bool = False) -> "list[Exported]":
        """Write the result for other programs; the suffix of a file gives its format.

        Parameters
        ----------
        *files : str or Path
            As of :func:`einschalt.export`.
        overwrite : bool, optional
            Replace files that are there; never what the block was read from.

        Returns
        -------
        list of Exported

        Raises
        ------
        EinschaltError
            A format is not known or cannot hold the result, or a file is there.
        """
        # imported when something is handed over: all formats are
        from einschalt.interfaces.programs.export import export  # noqa: PLC0415

        return export(self, *files, overwrite=overwrite)


def read_block(path: StrPath, settings: Mapping[str, Any] | None = None) -> Block:
    """Read a block from its folder and check it.

    Parameters
    ----------
    path : str or Path
        The folder, or its block.toml.
    settings : Mapping, optional
        Settings that go before those of block.toml, such as
        ``{"crs_accuracy_m": 2.0}`` or ``{"grids": "grids"}``.

    Returns
    -------
    Block

    Raises
    ------
    EinschaltError
        Something in the input stops the computation; several faults come together.
    """
    require_kind("settings", settings, Mapping | None, expected="a dict of settings")
    return block_tables.read_block(as_path("path", path), settings, kind=Block)


def read_points(
    path: StrPath,
    columns: Mapping[str, str] | None = None,
    layer: str | None = None,
    *,
    sheet: str | None = None,
    decimal: Literal[",", "."] | None = None,
    crs: str | None = None,
    angles: Literal["degrees", "D.MMSS"] | None = None,
) -> pd.DataFrame:
    """Read ground points from a table, a sheet or a layer, by any known column names.

    Parameters
    ----------
    path : str or Path
        .csv, .txt, .tsv, .parquet, .xlsx, .ods, .gpkg, .shp or .geojson; or a file of
        another program that einschalt convert reads, such as .dxf or LandXML.
    columns : Mapping, optional
        What columns are called: ``{"easting": "Rechtswert"}``. Usual names in twenty
        languages are known (docs/tables.md).
    layer, sheet : str, optional
        Of a file that has several.
    decimal : {",", "."}, optional
        Where the numbers of the table do not tell.
    crs : str, optional
        System of the coordinates: it tells what Y and X are, and their unit.
        Of a geographic one longitude and latitude are read.
    angles : {"degrees", "D.MMSS"}, optional
        How these are written, where neither the header nor the numbers tell:
        47.123456 is 47°12'34.56" as D.MMSS.

    Returns
    -------
    DataFrame
        point_id, easting, northing [, height, standard_error_m, role …], or longitude
        and latitude in place of the two where a layer is geographic. ``attrs`` has
        ``notes`` (how it was understood) and ``crs`` (that a layer states, or None).

    Raises
    ------
    EinschaltError
        Something is wrong, or has two meanings; several faults come together.
    """
    require_kind("columns", columns, Mapping | None, expected="a dict of names")
    columns = dict(columns or {})
    for name, column in columns.items():
        require_text("columns", name, expected="names, as text")
        require_text("columns", column, expected="names, as text")
    texts = {"layer": layer, "sheet": sheet, "decimal": decimal, "crs": crs}
    texts |= {"angles": angles}
    for name, text in texts.items():
        if text is not None:
            require_text(name, text, expected="a text, or nothing")
    if decimal is not None:
        require_choice("decimal", decimal, (",", "."))
    if angles is not None:
        require_choice("angles", angles, WAYS)
    schema, system = CONTROL_POINTS, None if crs is None else read_source_crs(crs)
    schema = schema if system is None else schema_in(schema, system)
    path = as_path("path", path)
    if columns == {} and layer is None and sheet is None:
        foreign = block_tables.found_in(path, crs=crs)
        if foreign is not None:
            return _foreign_points(foreign, path, crs)
    beside = tuple(read_once(one, one.name) for one in companions(path))
    said = Said(columns, sheet, layer, decimal, crs, angles=angles)
    try:
        table = understand_table(path, schema, said, beside=beside)
    except EinschaltError as error:
        raise answered_elsewhere(error, OF_ARGUMENTS) from None
    if table.crs is not None:
        is_geographic = {"longitude", "latitude"} <= set(table.frame)
        own = read_source_crs(table.crs)
        schema = schema_in(CONTROL_POINTS, own) if is_geographic else CONTROL_POINTS
    elif system is not None:
        require_columns(table.frame, system, path.name)
    found = check_table(table.frame, schema, source=path.name)
    raise_problems([answered_elsewhere(one, OF_ARGUMENTS) for one in found.problems])
    given = [name for name in found.frame if name in table.frame]
    frame = found.frame[given].reset_index(drop=True)
    frame.attrs = {"notes": (*table.notes, *found.notes), "crs": table.crs}
    return frame


def _foreign_points(found, path, crs):
    """Points of a file of another program, as read_points gives them."""
    if "control_points" not in found.tables:
        raise FileError(
            f"holds {name_some(found.tables) or 'no tables'}, and no ground points",
            expected="points with coordinates on the ground",
            remedy="Write its tables with einschalt convert",
            file=path.name,
        )
    table = found.tables["control_points"].copy()
    table.attrs = {"notes": found.notes, "crs": found.crs or crs}
    return table


def densify(
    block: checked.Block,
    settings: Settings | None = None,
    *,
    progress: Callable[[str, float], object] | None = None,
) -> DensificationResult:
    """Compute the coordinates of a block's points, with their precision.

    Parameters
    ----------
    block : Block
    settings : Settings, optional
        The block's own where left out.
    progress : callable, optional
        Called with the title of each stage and the fraction that is done.

    Returns
    -------
    DensificationResult
        A model that fails is a row of ``failures`` and does not stop the rest.

    Raises
    ------
    GeometryError
        Not one model of a flight could be used, or the block needs more memory than
        there is.
    SettingsError
        The settings ask for what this block cannot have.

    See Also
    --------
    densify_many : many blocks, each in a separate process.
    """
    if not isinstance(block, checked.Block):
        raise SettingsError(
            f"densify was given a {type(block).__name__}",
            expected="a Block",
            remedy="Read it with read_block, or make it with Block",
        )
    if not isinstance(settings, Settings | None):
        raise SettingsError(
            f"settings is a {type(settings).__name__}",
            expected="Settings",
            remedy="Write Settings(coverage_mean=…)",
        )
    _require_callable(progress, "the title of a stage and a fraction")
    return computed.densify(
        block, settings, progress=progress, kind=DensificationResult
    )


def densify_many(
    blocks: StrPath | Iterable[StrPath],
    output: StrPath,
    *,
    scheduler: str | None = None,
    settings: Settings | dict[str, Any] | None = None,
    workers: int | None = None,
    memory_gb: float | None = None,
    time_limit_s: float | None = None,
    which: Literal["changed", "unfinished", "failed", "all"] = "changed",
    overwrite: bool = False,
    progress: Callable[[Any], object] | None = None,
) -> pd.DataFrame:
    """Compute many blocks, each in a separate process, and write their results.

    Parameters
    ----------
    blocks : str, Path or iterable of these
        Folders of blocks; or one folder, below which all blocks are found.
    output : str or Path
        Gets a folder for each block, named after the block's, and blocks.csv,
        blocks.parquet and blocks.html.
    scheduler : str, optional
        Address of a Dask scheduler, ``tcp://host:port``, whose workers compute.
    settings : Settings or dict, optional
        In place of the blocks' own; a dict replaces only the fields that it has.
    workers : int, optional
        Processes on this computer, one per core where left out.
    memory_gb : float, optional
        What each block may use [GB]; on a cluster too, where each worker then computes
        in a process of its own.
    time_limit_s : float, optional
        What each block may take [s]: after that it is given up, and is a row that
        says so.
    which : {"changed", "unfinished", "failed", "all"}, optional
        What is computed: blocks without a result of their present input, settings and
        version; of these not the ones that an interrupted run has seen fail; only
        those that failed; or every block.
    overwrite : bool, optional
        Replace what lies in the folders of the results and is not theirs; never files
        that a block is read from.
    progress : callable, optional
        Called after each block with ``row``, ``n_done``, ``n_all`` and
        ``seconds_left`` as attributes of one object.

    Returns
    -------
    DataFrame
        One row per block: block, outcome (done, skipped, failed), stage, reason,
        remedy, n_points, standard_error_total, standard_error_paper,
        standard_error_internal (RMS over the new points, TOTAL [m]), seconds,
        n_suspects, n_failed_models, n_moved, largest_move [m],
        standard_error_credible (the figure to believe [m]), claim_is_supported (False
        where it is a lower bound, since something contradicts the claim; None where
        nothing tests it).

    Raises
    ------
    EinschaltError
        The call is wrong, the output cannot be written, or another batch runs in it. A
        block that fails is a row.
    """
    # imported when there is a batch: each block alone would wait for it
    from einschalt.interfaces.batch import batch_run  # noqa: PLC0415

    output = as_path("output", output)
    blocks = _folders_of(blocks, output)
    given = _given_settings(settings)
    _require_callable(progress, "the news after each block")
    engine = chosen_engine(scheduler, workers, memory_gb, time_limit_s)
    options = {"given": given, "which": which, "overwrite": overwrite}
    batch_run.plan_batch(blocks, output, **options)  # what is wrong is said before
    with batch_run.batch_folder(output) as folder:
        plan = batch_run.plan_batch(blocks, folder, **options)
        return batch_run.run_batch(plan, engine, progress=progress)


def _folders_of(blocks, output):
    """Folders of the blocks: those that are given, or all below the one that is."""
    if isinstance(blocks, (str, os.PathLike)):
        from einschalt.interfaces.batch import block_search  # noqa: PLC0415

        return block_search.find_blocks(as_path("blocks", blocks), output)
    expected = "a folder below which the blocks lie, or a list of the blocks' folders"
    require_kind("blocks", blocks, Iterable, expected=expected)
    return [as_path("blocks", block) for block in blocks]


def _given_settings(settings):
    """What goes before the settings of each block, checked before the work."""
    if isinstance(settings, Settings):
        return settings.model_dump()
    given = {} if settings is None else settings
    require_kind(
        "settings", given, dict, expected="Settings, or a dict of some of them"
    )
    try:
        Settings(**given)
    except TypeError:
        raise SettingsError(
            f"settings = {described(given)}", expected="names of settings as its keys"
        ) from None
    return given


def _require_callable(progress, news):
    if not (progress is None or callable(progress)):
        raise SettingsError(
            f"progress = {described(progress)}", expected=f"a function of {news}"
        )


def chosen_engine(scheduler=None, workers=None, memory_gb=None, time_limit_s=None):
    """Engine of a cluster where a scheduler is named, else of this computer.

    ``scheduler`` is an address ``tcp://host:port`` of Dask; ``workers`` are processes,
    one per core where left out. A task may use so much ``memory_gb`` [GB]; one that
    takes longer than ``time_limit_s`` [s] is given up.
    """
    # imported when there is a batch, as above
    from einschalt.pipeline.batch import dask_engine, local_engine  # noqa: PLC0415

    limits = {"memory_gb": memory_gb, "time_limit_s": time_limit_s}
    if scheduler is None:
        return local_engine.LocalEngine(workers, **limits)
    if workers is not None:
        raise SettingsError(
            "workers are given beside a scheduler",
            expected="as many workers as the cluster was started with",
            remedy="Leave them out, or the scheduler",
        )
    return dask_engine.DaskEngine(scheduler, **limits)
