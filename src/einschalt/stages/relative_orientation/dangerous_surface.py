"""Dangerous surfaces as tables: of measured models, and before the flight."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from einschalt.foundations import tables, typesetting
from einschalt.foundations.display_names import all_shortened
from einschalt.foundations.errors import SettingsError, raise_problems
from einschalt.foundations.frame_columns import values_of
from einschalt.foundations.kept_texts import place_text, retold
from einschalt.foundations.language import figure, mark, mark_each, translated
from einschalt.foundations.units import RADIANS_PER_GON
from einschalt.stages.results import Result
from einschalt.theory.relative_orientation.base_normal_planes import base_system
from einschalt.theory.relative_orientation.dangerous_surfaces import examine_surfaces
from einschalt.theory.relative_orientation.surface_verdicts import WEAK_INFLATION
from einschalt.theory.relative_orientation.valley_flights import (
    POINTS,
    critical_depth,
    standard_points,
    valley_depths,
)

MOST_PRINTED = 20
WIDEST_NAME = 16
EDGE = 0.015
"""Part of the image that standard points keep away from, at each side [m]."""
MEASURE_ELSEWHERE = mark("Measure points that lie higher or lower, or farther apart")
VERDICTS = mark_each({"critical": "critical", "weak": "weak", "safe": "safe"})
METRES = "metres"
REACHED = "the terrain reaches the flying height in a standard point"
HEIGHTS = [f"h{point}" for point in POINTS]
TERRAIN_HEIGHTS = tables.Schema(
    "terrain",
    (tables.MODEL_ID, *(tables.Column(name, unit="metres") for name in HEIGHTS)),
    key=("model_id",),
)


@dataclass(frozen=True, eq=False)
class ModelGeometry:
    """Where the measured points of all models lie."""

    # (n_points, 3): sorted by model, origin in the left projection centre, x along the
    # base, z up
    xyz: np.ndarray
    base: np.ndarray  # (n_models,): NaN where a model has none
    # (n_models + 1,): model k owns rows model_start[k]:model_start[k + 1]
    model_start: np.ndarray


def geometry_of_images(cameras, xyz, model_start) -> ModelGeometry:
    """Bring points of models that were formed from images into their base systems.

    Without points behind the cameras, which are gross errors; in the unit of the base.
    ``xyz`` (n_points, 3) is in the systems of the models, sorted by model.
    """
    model = np.repeat(np.arange(len(cameras.left_centre)), np.diff(model_start))
    turned, _ = turned_to_base(cameras, xyz, model)
    is_below = turned[:, 2] < 0.0
    count = np.bincount(model[is_below], minlength=len(cameras.left_centre))
    base = np.linalg.norm(cameras.right_centre - cameras.left_centre, axis=1)
    return ModelGeometry(turned[is_below], base, np.append(0, np.cumsum(count)))


def turned_to_base(cameras, xyz, model):
    """Turn points of models into the systems of their bases.

    Gives xyz (n_points, 3) with the origin in the left projection centre, x along the
    base, z upwards, and the axes (n_models, 3, 3): rows x, y, z of the base systems.
    """
    base = cameras.right_centre - cameras.left_centre
    upwards = cameras.left_rotation[:, 2] + cameras.right_rotation[:, 2]
    axes = base_system(base, upwards)
    reduced = xyz - cameras.left_centre[model]
    return np.einsum("nij,nj->ni", axes[model], reduced), axes


def surface_problems(surfaces, is_oriented) -> list[str]:
    """Say which oriented models are near a dangerous surface.

    One sentence or two per model that is not safe; models that are not oriented are
    said elsewhere. ``surfaces`` is a :func:`surface_table`.
    """
    flagged = surfaces[is_oriented & (surfaces["verdict"] != "safe").to_numpy()]
    return [
        f"{_said(row)}. {translated(MEASURE_ELSEWHERE)}."
        for row in flagged.itertuples()
    ]


def _said(row):
    """Model, verdict and reason."""
    verdict = translated(VERDICTS[row.verdict])
    return f"{place_text('model', row.Index)}, {verdict}: {retold(row.reason)}"


def surface_table(examination, model_ids) -> pd.DataFrame:
    """Verdicts on all models as a table, index model_id.

    verdict: safe; weak where omega is at least twice as uncertain as on flat terrain;
    critical from ten times on, or where the points determine nothing. inflation:
    standard error of omega over that on flat terrain; sigma_omega: that for a parallax
    error of 1 [rad / unit of length]. over_correction_k, over_correction_n, gap:
    Kasper's k and n = k + 1 (signed), and the gap from the circle, in the base-normal
    plane that determines omega better; NaN where the points are not under the
    projection centres. n_0, n_b: determinants N of the left and the right plane
    [length⁴]. singular_value_ratio: smallest singular value of the unit-free equations
    over that on flat terrain. reason: empty where safe.
    """
    planes, better = examination.planes, examination.better_plane
    model = np.arange(len(better))
    return pd.DataFrame(
        {
            "verdict": examination.verdict.names,
            "inflation": examination.inflation,
            "sigma_omega": examination.sigma_omega,
            "over_correction_k": planes.over_correction_k[model, better],
            "over_correction_n": planes.over_correction_n[model, better],
            "gap": planes.gap[model, better],
            "n_0": planes.determinant[:, 0],
            "n_b": planes.determinant[:, 1],
            "singular_value_ratio": examination.singular_value_ratio,
            "reason": examination.verdict.reasons,
        },
        index=pd.Index(model_ids, name="model_id", dtype=object),
    )


def count_verdicts(surfaces) -> str:
    """Say how many models are critical, weak or safe."""
    return translated(
        "{n:model|models}: {verdicts}",
        n=len(surfaces),
        verdicts=amounts_of_verdicts(surfaces),
    )


def amounts_of_verdicts(surfaces) -> str:
    """List how many models are critical, weak or safe."""
    amounts = surfaces["verdict"].value_counts()
    return ", ".join(
        f"{figure(amounts[verdict], 'd')} {translated(text)}"
        for verdict, text in VERDICTS.items()
        if verdict in amounts
    )


@dataclass(frozen=True, kw_only=True)
class FlightPlan:
    """How the models will be flown; lengths in metres.

    Exactly one of ``scale_number``, ``flying_height`` and ``altitude`` is given.
    """

    principal_distance: float  # 0.152 for a wide-angle camera
    scale_number: float | None = None  # of the terrain in points 1 and 2 of each model
    # above the terrain in points 1 and 2 of each model
    flying_height: float | None = None
    altitude: float | None = None  # of the whole flight, in the system of the heights
    image_format: float = 0.23  # side of the image
    forward_overlap: float = 0.60  # 0 to 1
    # distance of points 3 to 6 from the base in the image; half of the image format
    # less 15 mm where it is left out
    wing: float | None = None
    parallax_error: float = 5e-6  # standard error of a y-parallax in the image

    def __post_init__(self):
        """Check the values."""
        _check_heights_given(self)
        _check_range("principal_distance", self.principal_distance, 1e-3, 5.0, METRES)
        _check_range("image_format", self.image_format, 1e-3, 1.0, METRES)
        _check_range("parallax_error", self.parallax_error, 0.0, 1e-3, METRES)
        _check_range("forward_overlap", self.forward_overlap, 0.0, 1.0, "a part")
        if self.wing is not None:
            half = self.image_format / 2.0
            _check_range("wing", self.wing, 0.0, half, "within the image, metres")

    @property
    def wing_in_image(self):
        """Distance of the wings from the base in the image [m]."""
        if self.wing is not None:
            return self.wing
        return max(self.image_format / 2.0 - EDGE, self.image_format / 4.0)

    @property
    def base_in_image(self):
        """Base as it appears in the image [m]."""
        return (1.0 - self.forward_overlap) * self.image_format

    @property
    def critical_depth(self):
        """Depth of a dangerous valley, in flying heights above its middle."""
        return critical_depth(self.wing_in_image, self.principal_distance)

    def altitudes(self, middle):
        """Altitude over each model.

        ``middle`` (n_models,) is the mean height of points 1 and 2 [m].
        """
        if self.altitude is not None:
            return np.full(len(middle), float(self.altitude))
        if self.flying_height is not None:
            return middle + self.flying_height
        return middle + self.scale_number * self.principal_distance


def _check_heights_given(plan):
    names = ("scale_number", "flying_height", "altitude")
    given = [name for name in names if getattr(plan, name) is not None]
    if len(given) != 1:
        raise SettingsError(
            f"{' and '.join(given)} are given"
            if given
            else "no flying height is given",
            expected="one of scale_number, flying_height and altitude",
        )
    if given != ["altitude"]:
        _check_range(given[0], getattr(plan, given[0]), 0.0, np.inf, "a number")


def _check_range(name, value, low, high, what):
    if low < value < high:
        return
    raise SettingsError(
        f"{name} = {value:.6g}",
        expected=f"{what} above 0"
        if high == np.inf
        else f"{what} between {low:g} and {high:g}",
        remedy="Did you mistake metres for millimetres?" if what == METRES else "",
    )


@dataclass(frozen=True, eq=False, repr=False)
class SurfaceForecast(Result):
    """Which models of a planned flight come near a dangerous surface."""

    plan: FlightPlan
    # index model_id; verdict, inflation, standard_error_omega [rad], over_correction_k,
    # over_correction_n, gap, flying_height, valley_depth, critical_depth,
    # safe_flying_height [m], n_0, n_b, singular_value_ratio, reason. ``valley_depth``
    # is the mean of both base-normal planes, negative on ridges; ``safe_flying_height``
    # is that above the middle of a symmetrical valley from which the model is safe, NaN
    # where there is no valley
    models: pd.DataFrame

    def summary(self):
        """Say which models are in danger and what helps, then the numbers."""
        plan = self.plan
        wing = typesetting.number(plan.wing_in_image * 1e3, 3)
        distance = typesetting.number(plan.principal_distance * 1e3, 3)
        depth = typesetting.number(plan.critical_depth * 100.0)
        lines = [
            translated(
                "Dangerous surfaces before the flight, {verdicts}",
                verdicts=count_verdicts(self.models),
            ),
            translated(
                "principal distance {distance} mm, points 3 to 6 {wing} mm from the "
                "base",
                distance=distance,
                wing=wing,
            ),
            translated(
                "a valley is dangerous when its depth is {depth} of the height above "
                "it",
                depth=f"{depth} %",
            ),
        ]
        flagged = self.models[self.models["verdict"] != "safe"]
        if len(flagged):
            said = [_warning(row) for row in flagged.head(MOST_PRINTED).itertuples()]
            lines += ["", translated("Problems and suggestions"), *said]
            lines += _rest(len(flagged))
        return "\n".join([*lines, "", _table_of_models(self.models)])


def forecast_dangerous_surfaces(heights, plan) -> SurfaceForecast:
    """Judge the models of a planned flight by the terrain in their standard points.

    Points 1 and 2 lie below the left and the right projection centre, 3 and 5 beside
    point 1, 4 and 6 beside point 2, at the distance ``plan.wing_in_image`` in the
    image.

    ``heights`` has model_id and h1 to h6, the terrain in these points [m]. Points 1 and
    2 lie below the left and the right projection centre, 3 and 5 beside point 1, 4 and
    6 beside point 2, at the distance ``plan.wing_in_image`` in the image.

    Notes
    -----
    Source: P. Waldhäusl 1971 (docs/theory/relative_orientation/valley_flights.md).

    Examples
    --------
    A valley 300 m deep, flown 1000 m above its floor with a wide-angle camera:

    >>> valley = pd.DataFrame([["7/8", 600, 600, 900, 900, 900, 900]],
    ...                       columns=["model_id", *HEIGHTS])
    >>> plan = FlightPlan(principal_distance=0.152, flying_height=1000)
    >>> forecast_dangerous_surfaces(valley, plan).models.loc["7/8", "verdict"]
    'critical'
    """
    checked = tables.check_table(heights, TERRAIN_HEIGHTS)
    raise_problems(checked.problems)
    terrain = values_of(checked.frame, HEIGHTS)
    middle = terrain[:, :2].mean(axis=1)
    altitude = plan.altitudes(middle)
    camera = (plan.principal_distance, plan.wing_in_image, plan.base_in_image)
    xyz, base = standard_points(terrain, altitude, *camera)
    start = len(POINTS) * np.arange(len(xyz) + 1)
    examination = examine_surfaces(xyz.reshape(-1, 3), base, start)
    models = surface_table(examination, checked.frame["model_id"])
    models.loc[examination.verdict.figure.is_behind, "reason"] = REACHED
    flying_height = altitude - middle
    parallax_error = plan.parallax_error * flying_height / plan.principal_distance
    valley = valley_depths(terrain).mean(axis=1)
    least = WEAK_INFLATION / (WEAK_INFLATION - 1.0) * valley / plan.critical_depth
    models["standard_error_omega"] = models["sigma_omega"] * parallax_error
    models["flying_height"] = flying_height
    models["valley_depth"] = valley
    models["critical_depth"] = plan.critical_depth * flying_height
    models["safe_flying_height"] = np.where(valley > 0.0, least, np.nan)
    return SurfaceForecast(plan, models[FORECAST_COLUMNS])


FORECAST_COLUMNS = [
    *("verdict", "inflation", "standard_error_omega"),
    *("over_correction_k", "over_correction_n", "gap"),
    *("flying_height", "valley_depth", "critical_depth", "safe_flying_height"),
    *("n_0", "n_b", "singular_value_ratio", "reason"),
]


def _warning(row):
    text = f"{_said(row)}."
    if np.isfinite(row.inflation) and row.safe_flying_height > row.flying_height:
        height = typesetting.at_least(row.safe_flying_height)
        message = mark("Fly {height} m above the valley, or with a wider-angle camera.")
        text += f" {translated(message, height=height)}"
    elif row.over_correction_n < 0.0:
        message = mark(
            "Beyond the dangerous circle: over-corrections go the other way."
        )
        text += f" {translated(message)}"
    return typesetting.wrapped(text, first="  ", indent="    ")


def _table_of_models(models):
    milligon = RADIANS_PER_GON / 1e3
    shown = models.head(MOST_PRINTED)
    names = all_shortened(shown.index, WIDEST_NAME)
    rows = [
        [
            name,
            translated(VERDICTS[row.verdict]),
            typesetting.fixed(row.inflation, 2),
            typesetting.number(row.standard_error_omega / milligon),
            typesetting.fixed(row.over_correction_k, 2),
            typesetting.fixed(row.flying_height, 0),
            typesetting.fixed(row.valley_depth, 0),
            typesetting.fixed(row.critical_depth, 0),
        ]
        for row, name in zip(shown.itertuples(), names, strict=True)
    ]
    header = [translated("model"), translated("verdict"), translated("inflation")]
    header += ["omega", "k", translated("height"), translated("valley")]
    header += [translated("critical")]
    text = typesetting.table(rows, header=header, align="llrrrrrr")
    units = mark("Standard error of omega [mgon]; flying height, depth of valley [m]")
    return "\n".join([translated(units), text, *_rest(len(models))])


def _rest(n_rows):
    n_more = n_rows - MOST_PRINTED
    return [translated("  and {n} more", n=n_more)] if n_more > 0 else []
