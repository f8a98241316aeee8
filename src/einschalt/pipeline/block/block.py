"""A block: the checked tables of one survey, with the facts of its flights.

Construction checks everything and raises at once what stops the computation
(:func:`check_block` lists it without raising). A model that cannot be used does not
stop a block: it is found here as well (``model_problems``), and becomes a row of
``failures`` when the block is computed.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from einschalt.foundations import projections
from einschalt.foundations.arguments import require_kind, require_text
from einschalt.foundations.display_names import printable
from einschalt.foundations.errors import EinschaltError, raise_problems
from einschalt.foundations.frame_columns import columns_of, values_of
from einschalt.foundations.known_fields import with_known_fields
from einschalt.foundations.names import encode_pairs
from einschalt.foundations.number_parsing import plain_integer
from einschalt.foundations.tables import with_coverage
from einschalt.foundations.typesetting import scale
from einschalt.foundations.units import METRES_PER_UM, METRES_PER_UNIT
from einschalt.pipeline.block.check import check_block
from einschalt.pipeline.block.facts import FLIGHTS
from einschalt.pipeline.block.stereo_models import points_in_both_photographs
from einschalt.pipeline.settings import Settings
from einschalt.stages.identical_points import ROW_NAMES
from einschalt.stages.relative_orientation.shown_errors import errors_as_shown
from einschalt.stages.stage2_relative_orientation import image_pairs
from einschalt.theory.adjustment.least_squares import SQRT2
from einschalt.theory.interior_orientation import Camera
from einschalt.theory.measuring_error import m_g_of_mean


@with_known_fields
@dataclass(frozen=True, eq=False, repr=False)
class Flight:
    """One flight: its measurements and their properties.

    Exactly one of ``model_points`` (machine coordinates) and ``image_points`` (image
    coordinates, with ``models`` and ``camera`` or ``principal_distance_mm``) is given.

    Attributes
    ----------
    model_points : DataFrame, optional
        coverage, model_id, point_id, x, y [, z] [, n_settings] [, settings_spread], in
        ``model_unit``. x and y are means of ``n_settings`` settings, of one where the
        column is missing, which scatter about them by ``settings_spread`` (total). Or
        one row for each ``setting`` of a point: a block has their means.
    scale_number : float
        Denominator of the image scale.
    m_g_um : float
        TOTAL error of one setting of a point in the image plane [µm].
    transformation : {"affine", "helmert", "rigid", "helmert_3d"}
    model_unit : {"mm", "cm", "m", "um"}
        Unit of x, y, z in ``model_points`` and of ``y_parallaxes``.
    y_parallaxes : DataFrame, optional
        model_id, point_id, x, y, z, y_parallax, in ``model_unit``.
    base : DataFrame or float, optional
        With ``y_parallaxes``: coverage, model_id, base; or one base for all models.
    image_points : DataFrame, optional
        image_id, point_id, x, y [mm], principal-point system, y up; with ``camera`` as
        that says.
    models : DataFrame, optional
        With ``image_points``: coverage, model_id, left_image, right_image.
    principal_distance_mm : float, optional
        [mm]; with ``camera`` it is that of the camera.
    camera : Camera, optional
        Makes image coordinates of what ``image_points`` has: pixels (column, row), or
        millimetres from another origin, with distortion.
    orientation_case : {"independent", "dependent_left", "dependent_right"}, optional
        Which bundles the relative orientation moves: with y-parallaxes both where
        nothing is said, with image coordinates the right one. It fixes the sign of
        the y-parallaxes as well, see :func:`orient_from_parallaxes`.
    orientation_method : {"least_squares", "krames", "gruber"}, optional
        How the elements are found from y-parallaxes: by least squares where nothing
        is said.
    """

    model_points: pd.DataFrame | None = None
    scale_number: float = field(kw_only=True)
    m_g_um: float = field(kw_only=True)
    transformation: str = field(default="affine", kw_only=True)
    model_unit: str = field(default="mm", kw_only=True)
    y_parallaxes: pd.DataFrame | None = field(default=None, kw_only=True)
    base: pd.DataFrame | float | None = field(default=None, kw_only=True)
    image_points: pd.DataFrame | None = field(default=None, kw_only=True)
    models: pd.DataFrame | None = field(default=None, kw_only=True)
    principal_distance_mm: float | None = field(default=None, kw_only=True)
    camera: Camera | None = field(default=None, kw_only=True)
    orientation_case: str | None = field(default=None, kw_only=True)
    orientation_method: str | None = field(default=None, kw_only=True)

    def __post_init__(self):
        """Take the principal distance from the camera."""
        remedy = (
            "Make it with Camera.from_opencv, from_metashape, from_mm or from_micmac"
        )
        kinds = Camera | None
        require_kind("camera", self.camera, kinds, expected="a Camera", remedy=remedy)
        if self.camera is not None and self.principal_distance_mm is None:
            distance = self.camera.principal_distance_mm
            object.__setattr__(self, "principal_distance_mm", distance)

    def __repr__(self) -> str:
        """Say in a line what it is; a flight that was not checked may be anything."""
        table = self.image_points if self.has_images else self.model_points
        what = "image points" if self.has_images else "model points"
        rows = f"{len(table)} {what}" if isinstance(table, pd.DataFrame) else what
        number = self.scale_number
        said = scale(number) if isinstance(number, float | int) else str(number)
        facts = f"{said}, {self.transformation}, m_g {self.m_g_um} µm"
        return f"<{type(self).__name__} {facts}, {rows}>"

    @property
    def has_images(self) -> bool:
        """Whether the flight comes from image coordinates."""
        return self.image_points is not None

    @property
    def is_oriented_numerically(self) -> bool:
        """Whether this flight needs stage 2."""
        return self.has_images or self.y_parallaxes is not None

    @property
    def points_to_fit(self) -> pd.DataFrame:
        """The measured model points as their transformation takes them."""
        return self.to_fit(self.model_points)

    def to_fit(self, model_points: pd.DataFrame) -> pd.DataFrame:
        """Model points of this flight, in metres if the scale is held, else as is."""
        if self.transformation != "rigid":
            return model_points
        factor = METRES_PER_UNIT[self.model_unit]
        return model_points.assign(
            x=model_points["x"] * factor, y=model_points["y"] * factor
        )

    def image_coordinates(self) -> pd.DataFrame:
        """Image coordinates of ``image_points``, without distortion.

        Returns
        -------
        DataFrame
            image_id, point_id, x, y [mm], origin in the principal point, y up; NaN
            where the camera's distortion has no inverse.
        """
        if self.camera is None:
            return self.image_points
        measured = values_of(self.image_points, ["x", "y"])
        xy = self.camera.xy_from_measured(measured)
        return self.image_points.assign(x=xy[:, 0], y=xy[:, 1])

    @property
    def tails(self) -> tuple[float, float]:
        """Share of much worse points, and how many times: here none."""
        return 0.0, 1.0

    @property
    def m_g_counted_um(self) -> float:
        """Error of a setting that is counted with, TOTAL [µm]: here the stated one."""
        return self.m_g_um

    def m_g_um_of(self, model_points: pd.DataFrame) -> NDArray[np.float64]:
        """TOTAL error of each measured point [µm], shape (n_rows,).

        m_g / √k for the mean of k settings, where there is a column ``n_settings``.
        """
        n_settings = np.ones(len(model_points))
        if "n_settings" in model_points:
            n_settings = model_points["n_settings"].to_numpy(dtype=float)
        return m_g_of_mean(self.m_g_counted_um, n_settings)

    def ground_error_of(self, measured: pd.DataFrame) -> NDArray[np.float64]:
        """Error of each measured coordinate on the ground, shape (n_rows,) [m].

        Of model or image points of this flight, per coordinate; m_g is total.
        """
        m_g_um = self.m_g_um_of(measured)
        return m_g_um * METRES_PER_UM * self.scale_number / SQRT2

    @property
    def n_models(self) -> int:
        """Models as they were measured."""
        measured = self._measured_models
        return len(encode_pairs(measured["coverage"], measured["model_id"]))

    @property
    def n_coverages(self) -> int:
        """Coverages as they were measured."""
        return int(self._measured_models["coverage"].nunique())

    @property
    def _measured_models(self):
        return self.models if self.has_images else self.model_points

    def model_table(self) -> pd.DataFrame:
        """Which point lies in which model: coverage, model_id, point_id."""
        if not self.has_images:
            return columns_of(self.model_points, ROW_NAMES)
        return points_in_both_photographs(self.models, self.image_points)


FIELD_KINDS = {
    "crs": (projections.NAMES | None, "an EPSG code such as 'EPSG:31255'"),
    "settings": (Settings, "Settings, such as Settings(coverage_mean=…)"),
    "sources": (Mapping, "a dict of file names"),
    "checksums": (Mapping, "a dict of checksums"),
    "notes": (tuple, "a tuple of texts"),
    "may_be_unmeasured": (bool, "True or False"),
    "shared_errors_m": (Mapping, "a dict of metres by table"),
    "axes_told": (Mapping, "a dict of True or False by table"),
    "group_errors_m": (Mapping, "a dict of metres by table"),
    "correlation_lengths_m": (Mapping, "a dict of metres by table"),
}


@dataclass(frozen=True, eq=False, repr=False)
class FlightAsShown(Flight):
    """A flight whose image points have larger errors than stated, as they show.

    A share of them is much worse than the others; ``over_given`` is the root mean
    square of all errors over the stated one, ``tails`` their share and how many times
    as large their errors are.
    """

    over_given: float = field(default=1.0, kw_only=True)
    tails: tuple[float, float] = field(default=(0.0, 1.0), kw_only=True)

    @property
    def m_g_counted_um(self) -> float:
        """Error of a setting that is counted with, TOTAL [µm]: the one that shows."""
        return self.m_g_um * self.over_given


@with_known_fields
@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class Block:
    """The checked tables of one survey.

    Attributes
    ----------
    control_points : DataFrame
        point_id, easting, northing [, height, standard_error_m, role, group].
    high_flight, low_flight : Flight
        ``high_flight`` is None where ``approximate_points`` are given.
    approximate_points : DataFrame, optional
        point_id, easting, northing [, height, group], wherever they come from.
    approximate_m_0_m : float, optional
        Their TOTAL standard error [m].
    crs : str, optional
        Of all ground coordinates, and of the results.
    name : str
    project, operator : str
        Of which project the block is, and who is responsible for its results: both
        stand at the head of the report, empty where nobody said.
    settings : Settings
    sources : dict of str to str
        File name of each table, said in messages.
    checksums : dict of str to str
        SHA-256 of each file that was read, by its name.
    files : tuple of Path
        Files that it was read from, the block's own first: no output replaces them.
    notes : tuple of str
        What was ignored, filled in or reprojected while reading.
    may_be_unmeasured : bool
        Whether control or approximate points that lie in no model are passed over, also
        where their names look misspelt.
    axes_told : dict of str to bool
        Whether the system in which control_points, or approximate_points, were given
        tells easting from northing where they lie; where left out, whether ``crs``
        does.
    shared_errors_m : dict of str to float
        TOTAL error that all control_points, or all approximate_points, have in common
        [m]: that of the operation by which they came into ``crs``.
    group_errors_m : dict of str to float
        TOTAL standard error of the shift that control_points, or approximate_points, of
        one ``group`` share [m], beside their own errors; estimated where it is left
        out. It is propagated; fits and adjustments weigh points as if independent.
    correlation_lengths_m : dict of str to float
        Distance L over which errors of control_points, or approximate_points, are
        alike [m]: their correlation is exp(−d/L); 0 where they are independent. As for
        groups, propagated, not weighed.

    Raises
    ------
    EinschaltError
        What stops the computation; several faults come together in a BlockError.
    """

    low_flight: Flight
    control_points: pd.DataFrame | None = None
    high_flight: Flight | None = None
    approximate_points: pd.DataFrame | None = None
    approximate_m_0_m: float | None = None
    crs: str | None = None
    name: str = "block"
    project: str = ""
    operator: str = ""
    settings: Settings = field(default_factory=Settings)
    sources: dict[str, str] = field(default_factory=dict)
    checksums: dict[str, str] = field(default_factory=dict)
    files: tuple[Path, ...] = ()
    notes: tuple[str, ...] = ()
    may_be_unmeasured: bool = False
    axes_told: dict[str, bool] = field(default_factory=dict)
    shared_errors_m: dict[str, float] = field(default_factory=dict)
    group_errors_m: dict[str, float] = field(default_factory=dict)
    correlation_lengths_m: dict[str, float] = field(default_factory=dict)

    def __post_init__(self):
        """Check all tables, and keep them as checked."""
        object.__setattr__(self, "crs", plain_integer(self.crs))
        self._require_kinds()
        found = check_block(self)
        raise_problems(found.problems)
        for name, value in found.tables.items():
            object.__setattr__(self, name, value)
        if self.crs is not None:
            object.__setattr__(self, "crs", projections.crs_name(self.crs))
        # a block made from a block has been told before
        notes = tuple(dict.fromkeys((*self.notes, *found.notes)))
        object.__setattr__(self, "notes", notes)
        object.__setattr__(self, "_model_problems", found.model_problems)

    def __repr__(self) -> str:
        """Say in a line what was measured."""
        tables = (self.control_points, self.approximate_points)
        known = [
            f"{len(table)} {kind} points"
            for kind, table in zip(("known", "approximate"), tables, strict=True)
            if table is not None
        ]
        flights = [
            f"{flight.n_models} models of the {name.replace('_', ' ')}"
            for name, flight in self.flights.items()
        ]
        said = ", ".join([*known, *flights, self.crs or "no reference system"])
        return f"<{type(self).__name__} {printable(self.name)!r}: {said}>"

    def _require_kinds(self):
        """See that every field is of its kind, the tables excepted."""
        table = "Write Flight(model_points=…, scale_number=…, m_g_um=…)"
        for name in FLIGHTS:
            flight = getattr(self, name)
            require_kind(name, flight, Flight | None, expected="a Flight", remedy=table)
        require_text("name", self.name, expected="the name of the block, as text")
        for name in ("project", "operator"):
            require_text(name, getattr(self, name), expected="a name, as text")
        for name, (kind, expected) in FIELD_KINDS.items():
            require_kind(name, getattr(self, name), kind, expected=expected)

    @property
    def model_problems(self) -> tuple[EinschaltError, ...]:
        """Models that cannot be used, as errors that were not raised."""
        return self._model_problems

    @property
    def flights(self) -> dict[str, Flight]:
        """The flights that the block has, by name."""
        named = {name: getattr(self, name) for name in FLIGHTS}
        return {name: flight for name, flight in named.items() if flight is not None}

    def source(self, table: str) -> str:
        """File name of a table, or its own name where it has no file."""
        return self.sources.get(table, table)


def plain_fields(block):
    """Fields of a block or flight as a dict, without copying the tables."""
    return {f.name: getattr(block, f.name) for f in fields(block)}


def with_errors_as_shown(block, outliers):
    """Count with the errors that image points show where they are larger than stated.

    As they are where ``outliers`` are kept, taken out or given less weight.
    """
    shown = {}
    for name, flight in block.flights.items():
        if not flight.has_images:
            continue
        pairs = image_pairs(flight.image_coordinates(), with_coverage(flight.models))
        given = flight.principal_distance_mm, flight.m_g_um, outliers
        over_given, tails = errors_as_shown(pairs, *given) or (1.0, (0.0, 1.0))
        if over_given > 1.0 or tails[0] > 0.0 or isinstance(flight, FlightAsShown):
            stated = {f.name: getattr(flight, f.name) for f in fields(Flight)}
            shown[name] = FlightAsShown(**stated, over_given=over_given, tails=tails)
    return replace(block, **shown) if shown else block
