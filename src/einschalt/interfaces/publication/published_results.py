"""Results that can be published: a fitted transformation, and results in a folder."""

import json
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from einschalt.foundations.arguments import StrPath, as_path, require_choice
from einschalt.foundations.errors import FileError, SettingsError
from einschalt.foundations.projections import label_of
from einschalt.interfaces.files.written_files import PROVENANCE
from einschalt.interfaces.publication.publish import (
    BLOCK_TABLES,
    Publication,
    publish_block,
    publish_fit,
    title_of_block,
)
from einschalt.stages import gridded_transformation as gridded
from einschalt.stages import stage3_model_transformation as stage3
from einschalt.stages import triangulated_transformation as triangulated
from einschalt.stages.gridded_transformation import distribute_in_grid, with_grids
from einschalt.stages.transformation_kinds import TRANSFORMATION_KINDS
from einschalt.stages.triangulated_transformation import (
    distribute_in_triangles,
    with_triangles,
)

if TYPE_CHECKING:
    from einschalt.pipeline.result import DensificationResult

IDENTICAL, TRIANGLES, ASSESSMENT = "identical_points", "triangles", "assessment.json"
DISTRIBUTION = "distribution"
METHODS = (TRIANGLES, "collocation", "natural_neighbour")


class _Published:
    """What every fitted transformation can do with files."""

    def publish(
        self,
        name: str,
        folder: StrPath,
        *,
        crs: str | None = None,
        source_crs: str | None = None,
        **options: Any,
    ) -> Publication:
        """Write the transformation for PROJ, GDAL and QGIS.

        Parameters
        ----------
        name : str
            By which it is found: ``EINSCHALT:NAME``.
        folder : str or Path
            Made where it does not exist.
        crs : str, optional
            System of the ground coordinates, such as ``"EPSG:3067"``. Without it there
            is no PROJ database.
        source_crs : str, optional
            System of the model coordinates, where they are those of an old frame.
        **options
            As of :func:`einschalt.publish`.

        Returns
        -------
        Publication

        Raises
        ------
        EinschaltError
            PROJ does not give what :meth:`transform` gives, there and back; or
            something would be lost in the folder.
        """
        options |= {"crs": crs, "source_crs": source_crs}
        return publish_fit(self, name, as_path("folder", folder), **options)


@dataclass(frozen=True, eq=False, repr=False)
class ModelTransformation(_Published, stage3.ModelTransformation):
    """Transformations of all models of a flight, which can be published."""

    def distributed(
        self,
        triangles: pd.DataFrame | None = None,
        *,
        method: Literal["triangles", "collocation", "natural_neighbour"] = TRIANGLES,
        outliers: Literal["keep", "set_aside"] | None = None,
        cell: float | None = None,
    ) -> "TriangulatedTransformation | GriddedTransformation":
        """Distribute the residuals of identical points to those between.

        Parameters
        ----------
        triangles : DataFrame, optional
            Names of their corners, in three columns; Delaunay triangles where left out.
        method : {"triangles", "collocation", "natural_neighbour"}
            Linear in triangles of identical points, which go exactly where they were
            measured; or by a grid of shifts: those that neighbours share, without
            noise (collocation), or natural neighbours'.
        outliers : {"keep", "set_aside"}, optional
            Whether identical points that contradict their neighbours take part; where
            left out "keep" for triangles, and "set_aside" for grids.
        cell : float, optional
            Width of the cells of a grid [m]; chosen where left out.

        Returns
        -------
        TriangulatedTransformation or GriddedTransformation

        Raises
        ------
        EinschaltError
            The transformation is spatial, has too few points, or cannot be undone.
        """
        require_choice("method", method, METHODS)
        if method == TRIANGLES:
            _require_none("cell", cell, "collocation or natural_neighbour")
            found = distribute_in_triangles(
                self, triangles, outliers=outliers or "keep"
            )
            return with_publication(found, TriangulatedTransformation)
        _require_none("triangles", triangles, TRIANGLES)
        return with_publication(
            distribute_in_grid(
                self, method, outliers=outliers or "set_aside", cell=cell
            ),
            GriddedTransformation,
        )


def _require_none(name, value, method):
    if value is not None:
        raise SettingsError(
            f"{name} is given", expected=f"none, unless method is {method}"
        )


@dataclass(frozen=True, eq=False, repr=False)
class TriangulatedTransformation(_Published, triangulated.TriangulatedTransformation):
    """Transformations that are linear in triangles, which can be published."""


@dataclass(frozen=True, eq=False, repr=False)
class GriddedTransformation(_Published, gridded.GriddedTransformation):
    """Transformations with grids of shifts, which can be published."""


def with_publication(fit, kind=ModelTransformation):
    """Give a fit of the lower floors the interface that writes files."""
    return kind(**{field.name: getattr(fit, field.name) for field in fields(fit)})


def transform_models(  # noqa: D103
    model_points: pd.DataFrame,
    ground_points: pd.DataFrame,
    kind: Literal["affine", "helmert", "rigid", "helmert_3d"] = "affine",
    weights: pd.Series | NDArray[np.float64] | None = None,
) -> ModelTransformation:
    return with_publication(
        stage3.transform_models(model_points, ground_points, kind, weights)
    )


transform_models.__doc__ = stage3.transform_models.__doc__


def identical_points(fit):
    """Identical points of a fit in both frames, with all that a new fit needs."""
    kind = TRANSFORMATION_KINDS[fit.kind]
    table = fit.observed.rows.reset_index(drop=True)
    table[list(kind.source)] = fit.observed.source
    table[list(kind.target)] = fit.observed.target
    table["weight"] = fit.observed.weights
    return table if fit.has_coverages else table.drop(columns="coverage")


def publish_folder(folder, name, output, *, crs=None, source_crs=None, **options):
    """Publish what ``einschalt densify`` or ``transform`` has written into a folder."""
    folder = Path(folder)
    facts = provenance_in(folder)
    files = [path for path in sorted(folder.iterdir()) if path.is_file()]
    options |= {"files": files, "crs": crs, "source_crs": source_crs}
    if facts.get("command") == "transform":
        fit = _fit_in(folder)
        return publish_fit(fit, name, output, **options)
    block = facts.get("block") or {}
    if "output" in facts:
        raise FileError(
            f"its points are in {label_of(facts['output'].get('crs'))}, and its models "
            f"lead to {label_of(block.get('crs'))}",
            expected="results in the system of the block",
            remedy="Compute them again without output_crs",
            file=folder,
        )
    return publish_block(
        {table: _table(folder, table) for table in BLOCK_TABLES},
        name,
        output,
        own_crs=block.get("crs"),
        title=title_of_block(block.get("name") or ""),
        bent=_bent(folder),
        **options,
    )


def _fit_in(folder):
    """Make the transformation again from its identical points, as it was."""
    points, models = _table(folder, IDENTICAL), _table(folder, "models")
    kind = models["transformation"].iloc[0]
    target = list(TRANSFORMATION_KINDS[kind].target)
    ground = points[["point_id", *target]].drop_duplicates("point_id")
    fit = stage3.transform_models(points.drop(columns=target), ground, kind=kind)
    if (folder / f"{DISTRIBUTION}.parquet").exists():
        return with_grids(fit, _table(folder, DISTRIBUTION))
    if not (folder / f"{TRIANGLES}.parquet").exists():
        return fit
    return with_triangles(fit, _table(folder, TRIANGLES), _table(folder, "left_out"))


def provenance_in(folder):
    """What provenance.json of a folder with results says; a FileError without one."""
    try:
        content = json.loads((folder / PROVENANCE).read_bytes())
    except (OSError, ValueError):
        content = None
    if isinstance(content, dict) and content.get("program") == "einschalt":
        return content
    raise FileError(
        f"there is no {PROVENANCE} of einschalt",
        expected="a folder with results of einschalt densify or transform",
        remedy="Name the folder that was given as --output",
        file=folder,
    )


def _table(folder, name):
    path = folder / f"{name}.parquet"
    if path.exists():
        return pd.read_parquet(path)
    raise FileError(
        "is missing",
        expected="the results of einschalt densify or transform, of this version",
        remedy="Compute them again",
        file=path,
    )


def _bent(folder):
    """Flights whose models share a deformation that was modelled, or corrected."""
    path = folder / ASSESSMENT
    assessed = json.loads(path.read_bytes()) if path.exists() else {}
    flights = (assessed.get("deformation") or {}).get("flights", ())
    modelled = {flight["flight"] for flight in flights if flight["is_modelled"]}
    findings = assessed.get("findings") or ()
    corrected = (f["names"] for f in findings if f["code"] == "bent_models")
    return sorted(modelled.union(*corrected))


def publish(
    result: "stage3.ModelTransformation | DensificationResult | StrPath",
    name: str,
    folder: StrPath,
    *,
    crs: str | None = None,
    source_crs: str | None = None,
    installed_at: str | None = None,
    proj_db: StrPath | None = None,
    overwrite: bool = False,
) -> Publication:
    """Publish a result, so that PROJ, GDAL and QGIS find its transformations by name.

    Each as PROJ string and WKT, with accuracy and area; as triangles of ``tinshift``,
    or as a grid of shifts (GTG) where its residuals are distributed by one; all of them
    in an auxiliary PROJ database; and a page that says how to use them and
    how good they are. PROJ runs every form before it is published, there and back.

    Parameters
    ----------
    result : ModelTransformation, DensificationResult, str or Path
        Or the folder into which one was written.
    name : str
        By which PROJ finds it, as ``EINSCHALT:NAME``.
    folder : str or Path
        Made where it does not exist.
    crs : str, optional
        System of the ground coordinates; that of the block where it is one.
    source_crs : str, optional
        System of the model coordinates, where they are those of an old frame.
    installed_at : str, optional
        Folder in which the files will stand when they are used, where that is another
        one; empty where PROJ searches for them in its own folders.
    proj_db : str or Path, optional
        The file proj.db of the PROJ that is to use the database, where that is another
        version than the one of pyproj.
    overwrite : bool, optional
        Replace what einschalt did not write; never what the result was read from.

    Returns
    -------
    Publication
        operations, left_out, folder, database.

    Raises
    ------
    EinschaltError
        A form does not return, or something would be lost in the folder.
    """
    options = {"installed_at": installed_at, "overwrite": overwrite}
    if proj_db is not None:
        options["proj_db"] = as_path("proj_db", proj_db)
    folder = as_path("folder", folder)
    systems = {"crs": crs, "source_crs": source_crs}
    if hasattr(result, "publish"):
        return result.publish(name, folder, **systems, **options)
    return publish_folder(as_path("result", result), name, folder, **systems, **options)
