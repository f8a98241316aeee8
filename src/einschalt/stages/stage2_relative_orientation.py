"""Stage 2: relative orientation of a flight's models, where it is to be computed.

From y-parallaxes the machine coordinates are corrected; from image coordinates the
models are formed. A flight that comes as machine coordinates of oriented models passes
through unchanged.
"""

from dataclasses import dataclass, field, replace
from typing import Literal, Protocol

import numpy as np
import pandas as pd

from einschalt.foundations.arguments import described, require_choice
from einschalt.foundations.errors import GeometryError, SettingsError, name_some
from einschalt.foundations.key_columns import rows_among
from einschalt.foundations.tables import with_coverage
from einschalt.foundations.units import METRES_PER_MM, METRES_PER_UM, METRES_PER_UNIT
from einschalt.stages.relative_orientation.image_errors import ImageErrors, image_errors
from einschalt.stages.relative_orientation.parallax_errors import (
    OrientationErrors,
    parallax_errors,
)
from einschalt.stages.relative_orientation.parallax_orientation import (
    correct_model_points,
)
from einschalt.stages.results import (
    FAILURE_COLUMNS,
    OUTLIERS,
    Result,
    failures_table,
)

STAGE = "stage2_relative_orientation"
NOTHING_IN_COMMON = "its photographs have no point in common"
LOOK_AT_PHOTOGRAPHS = (
    "Compare the names of its photographs in both tables: they may be exchanged; or "
    "take the model out"
)
LENGTHS = ("x", "y", "z", "y_parallax", "base")
SURFACE_COLUMNS = ["verdict", "inflation", "reason"]
MEASURING_ERRORS = ["m_g_intersection_um", "m_g_orientation_um"]
KEYS = ["model_id", "point_id"]
CENTRE_COLUMNS = ["coverage", "model_id", "image_id", "x", "y", "z"]
FLIGHT_PARTS = ("image_points", "y_parallaxes", "points_to_fit")
ORIENTATION_COLUMNS = [
    *("coverage", "model_id", "case", "n_points", "redundancy", "sigma_0"),
    *("is_converged", "is_ambiguous", *SURFACE_COLUMNS, *MEASURING_ERRORS),
]


@dataclass(frozen=True, eq=False, repr=False)
class RelativeOrientation(Result):
    """A flight after its relative orientation.

    Attributes
    ----------
    model_points : DataFrame
        coverage, model_id, point_id, x, y [, z] in the unit of the flight, in metres
        where it is transformed rigidly; from images in mm at image scale.
    orientations : DataFrame
        coverage, model_id, case, n_points, redundancy, sigma_0 [mm], is_converged,
        is_ambiguous (another orientation fits its image coordinates about as well),
        verdict (safe, weak, critical), inflation (standard error of omega over that on
        flat terrain), reason (empty where safe), m_g_intersection_um (from images, NaN
        otherwise), m_g_orientation_um (what an affine transformation leaves of the
        orientation's error; total, of images at image scale, of parallaxes at that of
        the model), then the elements [rad, mm]; no rows where nothing was to be
        oriented.
    residuals : DataFrame
        coverage, model_id, point_id, and the columns of the orientation's residuals
        [mm]; no rows where nothing was to be oriented.
    failures : DataFrame
        coverage, model_id, stage, reason, remedy.
    centres : DataFrame
        coverage, model_id, image_id, x, y, z of the projection centres, as the model
        points; no rows where they are not known.
    errors : OrientationErrors, ImageErrors or None
        How errors of the orientations, or of the image points, move the model points,
        row for row; None where that is not known.
    """

    model_points: pd.DataFrame
    orientations: pd.DataFrame
    residuals: pd.DataFrame
    failures: pd.DataFrame
    centres: pd.DataFrame = field(
        default_factory=lambda: pd.DataFrame(columns=CENTRE_COLUMNS)
    )
    errors: OrientationErrors | ImageErrors | None = None

    def without_models(self, models: pd.DataFrame) -> "RelativeOrientation":
        """The same without the points of some models (coverage, model_id)."""
        keys, points = ["coverage", "model_id"], self.model_points
        is_kept = ~rows_among(points, models, keys)
        return replace(
            self,
            model_points=points[is_kept].reset_index(drop=True),
            errors=None if self.errors is None else self.errors.of_rows(is_kept),
        )

    def summary(self) -> str:
        """Say how many models were oriented, and how well."""
        n_models = len(self.orientations)
        if n_models == 0:
            return "no relative orientation to compute"
        sigma = self.orientations["sigma_0"]
        return (
            f"{n_models} models oriented, {len(self.failures)} failed\n"
            f"sigma_0  {sigma.min() * 1e3:.1f} to {sigma.max() * 1e3:.1f} µm, "
            f"median {sigma.median() * 1e3:.1f} µm"
        )


class MeasuredFlight(Protocol):
    """What this stage takes of a flight: a Flight of a block, or what has its parts."""

    @property
    def model_points(self) -> pd.DataFrame | None:
        """Model points, where the flight has no images."""

    @property
    def image_points(self) -> pd.DataFrame | None:
        """Image points, where the flight has images."""

    @property
    def models(self) -> pd.DataFrame | None:
        """Which images make a model."""

    @property
    def y_parallaxes(self) -> pd.DataFrame | None:
        """The y-parallaxes of models that are to be oriented by them."""


def relative_orientation(
    flight: MeasuredFlight,
    *,
    outliers: Literal["keep", "snoop", "huber", "tukey"] = "keep",
) -> RelativeOrientation:
    """Orient the models of a flight and give their corrected points.

    Parameters
    ----------
    flight : Flight
        With ``model_points`` (and ``y_parallaxes``, ``base``), or ``image_points``,
        ``models`` and ``camera`` or ``principal_distance_mm``.
    outliers : {"keep", "snoop", "huber", "tukey"}
        What happens to image points that contradict their pair: they are only named,
        taken out, or given less weight. Six parallaxes cannot spare one: they are kept.

    Returns
    -------
    RelativeOrientation
        A model that cannot be oriented is a row of ``failures``, and its points are
        left out.

    Raises
    ------
    GeometryError
        Not one model could be oriented.
    TableError
        Model points that are to be corrected have no z.
    """
    _require_flight(flight)
    require_choice("outliers", outliers, OUTLIERS)
    flight = _with_coverages(flight)
    if flight.image_points is not None:
        return _from_images(flight, outliers)
    if flight.y_parallaxes is not None:
        return _from_parallaxes(flight)
    return RelativeOrientation(
        flight.points_to_fit,
        pd.DataFrame(columns=ORIENTATION_COLUMNS),
        pd.DataFrame(columns=["coverage", *KEYS]),
        pd.DataFrame(columns=FAILURE_COLUMNS),
    )


def _with_coverages(flight):
    """The flight with "1" as coverage of its models where they have none."""
    given = {name: getattr(flight, name) for name in ("model_points", "models")}
    missing = {
        name: with_coverage(table)
        for name, table in given.items()
        if table is not None and "coverage" not in table
    }
    return replace(flight, **missing) if missing else flight


def _require_flight(flight):
    # a Flight belongs to a higher floor, so it is known by what it has
    if all(hasattr(flight, name) for name in FLIGHT_PARTS):
        return
    raise SettingsError(
        f"flight = {described(flight)}",
        expected="a Flight",
        remedy="Write block.low_flight, or Flight(model_points, …)",
    )


def image_pairs(image_points, models) -> pd.DataFrame:
    """Put the image coordinates of each model's two photographs side by side.

    Of ``image_points`` (image_id, point_id, x, y [mm]) those that were measured in
    both: coverage, model_id, point_id, x_left, y_left, x_right, y_right [mm].
    """
    named = image_points[["image_id", "point_id", "x", "y"]]
    left, right = (
        named.rename(columns={"image_id": image, "x": f"x_{side}", "y": f"y_{side}"})
        for side, image in (("left", "left_image"), ("right", "right_image"))
    )
    both = models.merge(left, on="left_image")
    both = both.merge(right, on=["right_image", "point_id"])
    return both.drop(columns=["left_image", "right_image"])


def _require_points(points, failures):
    """Refuse to go on where not one model could be oriented."""
    if len(points):
        return
    raise GeometryError(
        f"no model could be oriented: {failures['reason'].iloc[0]}",
        expected="at least one oriented model",
        remedy=failures["remedy"].iloc[0],
        model=name_some(failures["model_id"]),
        stage=STAGE,
    )


def _without_pairs(models, pairs):
    """Failures of models whose photographs have no point in common.

    They have no rows among the pairs: what joins the photographs loses them.
    """
    keys = ["coverage", "model_id"]
    lost = models.loc[~rows_among(models, pairs, keys), keys]
    return failures_table(
        (*row, STAGE, NOTHING_IN_COMMON, LOOK_AT_PHOTOGRAPHS)
        for row in lost.itertuples(index=False)
    )


def _from_images(flight, outliers):
    # imported where photographs are oriented: other blocks do not wait for it
    from einschalt.stages.relative_orientation.orient_from_images import (  # noqa: PLC0415
        orient_from_images,
    )

    pairs = image_pairs(flight.image_coordinates(), flight.models)
    lost = _without_pairs(flight.models, pairs)
    if len(lost):
        _require_points(pairs, lost)
    oriented = orient_from_images(
        pairs,
        flight.principal_distance_mm,
        **_given(case=flight.orientation_case),
        outliers=outliers,
    )
    _require_points(oriented.model_points, oriented.failures)
    enlargement = _to_image_scale(oriented.model_points, flight.principal_distance_mm)
    return RelativeOrientation(
        _scaled(oriented.model_points, enlargement),
        _orientations(oriented, oriented.converged, oriented.measuring_error),
        oriented.residuals,
        pd.concat([lost, oriented.failures.assign(stage=STAGE)], ignore_index=True),
        _centres(oriented, flight),
        image_errors(oriented, flight, enlargement.to_numpy()),
    )


def _centres(oriented, flight):
    """Projection centres in the models, whichever photograph is the reference."""
    names = ["coverage", "model_id"]
    depth = oriented.model_points.groupby(names, sort=False)["z"].mean().abs()
    scale = (flight.principal_distance_mm / depth).rename("scale").reset_index()
    cameras = oriented.elements.cameras
    sides = {"left_image": cameras.left_centre, "right_image": cameras.right_centre}
    tables = []
    for side, centre in sides.items():
        table = oriented.models[names].reset_index(drop=True)
        table[list("xyz")] = centre
        table = flight.models[[*names, side]].merge(table, on=names)
        table = table.merge(scale, on=names).rename(columns={side: "image_id"})
        table[list("xyz")] = table[list("xyz")].mul(table["scale"], axis=0)
        tables.append(table)
    return pd.concat(tables, ignore_index=True)[CENTRE_COLUMNS]


def _given(**options):
    """Leave the defaults of the orientation to itself."""
    return {name: value for name, value in options.items() if value is not None}


def _to_image_scale(points, principal_distance):
    # a base of 1 says nothing of the scale: bring each model to the mean image scale
    depth = points.groupby(["coverage", "model_id"])["z"].transform("mean").abs()
    return principal_distance / depth


def _from_parallaxes(flight):
    # imported when a flight has parallaxes: it has the methods of half a century
    from einschalt.stages.relative_orientation.orient_from_parallaxes import (  # noqa: PLC0415
        orient_from_parallaxes,
    )

    to_mm = METRES_PER_UNIT[flight.model_unit] / METRES_PER_MM
    options = _given(case=flight.orientation_case, method=flight.orientation_method)
    oriented = orient_from_parallaxes(
        _scaled(flight.y_parallaxes, to_mm), _scaled(flight.base, to_mm), **options
    )
    corrected = correct_model_points(oriented, _scaled(flight.model_points, to_mm))
    failures = pd.concat([oriented.failures, corrected.failures], ignore_index=True)
    _require_points(corrected.points, failures)
    um_per_mm = METRES_PER_MM / METRES_PER_UM
    measuring_error = pd.DataFrame(
        {
            "m_g_intersection_um": np.nan,
            "m_g_orientation_um": corrected.orientation_error * um_per_mm,
        }
    )
    return RelativeOrientation(
        flight.to_fit(_scaled(corrected.points, 1.0 / to_mm)),
        _orientations(oriented, oriented.models["is_usable"], measuring_error),
        oriented.residuals,
        failures.drop_duplicates(["coverage", "model_id"]).assign(stage=STAGE),
        errors=_errors_of_points(flight, oriented, corrected.points),
    )


def _errors_of_points(flight, oriented, corrected):
    """How errors of the parallaxes move the corrected points, in their final unit."""
    to_mm = METRES_PER_UNIT[flight.model_unit] / METRES_PER_MM
    machine = _scaled(flight.model_points, to_mm).loc[corrected.index]
    errors = parallax_errors(oriented, machine)
    if errors is None:
        return None
    unit = flight.to_fit(pd.DataFrame({"x": [1.0 / to_mm], "y": [1.0 / to_mm]}))
    return replace(errors, factors=errors.factors * unit["x"].iloc[0])


def _scaled(lengths, factor):
    """The same lengths in another unit, in a table or as one number."""
    if not isinstance(lengths, pd.DataFrame):
        return None if lengths is None else lengths * factor
    names = [name for name in LENGTHS if name in lengths]
    return lengths.assign(**{name: lengths[name] * factor for name in names})


def _orientations(oriented, is_converged, measuring_error):
    models = oriented.models
    names = ["coverage", "model_id", "case", "n_points", "redundancy", "sigma_0"]
    facts = models[names].assign(
        is_converged=is_converged.to_numpy(),
        is_ambiguous=models.get("is_ambiguous", is_converged & False).to_numpy(),
    )
    surfaces = oriented.dangerous_surface.reset_index(drop=True)
    facts[SURFACE_COLUMNS] = surfaces[SURFACE_COLUMNS]
    facts[MEASURING_ERRORS] = measuring_error[MEASURING_ERRORS].to_numpy()
    return pd.concat([facts, oriented.parameters.reset_index(drop=True)], axis=1)
