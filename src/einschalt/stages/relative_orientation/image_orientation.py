"""What the orientation of models by image coordinates gives."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from einschalt.foundations import typesetting
from einschalt.foundations.batches import segment_sum
from einschalt.foundations.display_names import all_shortened
from einschalt.foundations.frame_columns import values_of
from einschalt.foundations.kept_texts import place_text, retold
from einschalt.foundations.language import mark, translated
from einschalt.foundations.units import METRES_PER_MM, METRES_PER_UM, RADIANS_PER_GON
from einschalt.stages.relative_orientation.dangerous_surface import (
    geometry_of_images,
    surface_table,
)
from einschalt.stages.results import Estimates, OrientationResult, row_of_model
from einschalt.theory.adjustment.least_squares import pool_standard_errors
from einschalt.theory.relative_orientation.condition_tests import StereoPairs
from einschalt.theory.relative_orientation.coplanarity import ORIENTED
from einschalt.theory.relative_orientation.coplanarity_condition import COS_45
from einschalt.theory.relative_orientation.dangerous_surfaces import examine_surfaces
from einschalt.theory.relative_orientation.deformation_error import deformation_variance
from einschalt.theory.relative_orientation.model_precision import (
    N_CHANGES,
    OrientedPairs,
    model_precision,
)
from einschalt.theory.relative_orientation.orientation_elements import (
    OrientationElements,
)
from einschalt.theory.relative_orientation.orientation_influence import (
    orientation_influence,
)

# sigma_0 of a model against that of all models that is worth a word
LARGE_SIGMA = 3.0
# no comparator and no matching is worse: such rays do not belong to each other
HOPELESS_SIGMA = 0.1  # mm
AMBIGUOUS = mark(
    "another orientation fits about as well; the one nearer to the normal case was "
    "taken. Measure more points, at different heights."
)
SOME_BEHIND = mark("a point lies behind a camera. Look for gross errors in x.")
AGAINST_X = mark(
    "the base points against x. Where it was not flown that way, left and right image "
    "are exchanged, or the images are mirrored."
)
EXCHANGED = mark(
    "the base points against x: left and right image are exchanged, or the images "
    "mirrored, unless it was flown that way"
)
DO_NOT_MEET = mark(
    "sigma_0 is above 0.1 mm, and no measuring is so poor: its points have gross "
    "errors or wrong names, or principal distance or unit are wrong."
)
POOLED = mark(
    "sigma_0 (an image coordinate, all models together)  {length}, redundancy "
    "{redundancy}"
)
NEAR_SURFACE = mark(
    "weak or critical, near a dangerous surface: see dangerous_surface."
)
LARGE = mark("sigma_0 is more than three times the median. Look for gross errors.")
CONTRADICT = mark("Points that contradict their models, worst first (model, point):")
MEASURE_AGAIN = mark("Measure them again, or take them out with outliers = 'snoop'.")
TAKEN_OUT = mark("They were taken out: measure them again.")
LESS_WEIGHT = mark("They have less weight: measure them again.")
# weights that fell so far that the point hardly counts
SMALL_WEIGHT = 0.5
MOST_LISTED = 12
WIDEST_NAME = 20


@dataclass(frozen=True, eq=False)
class ImageInfluence:
    """Derivatives of the points of oriented models by all image coordinates.

    A point moves with its own four image coordinates e_i, and with the orientation of
    its model, by ``by_image[i] @ e_i + gain[i] @ sum over j of by_point[j] @ e_j``, the
    sum over all points of the model.
    """

    model: np.ndarray  # (n_points,): place of each point's model among all pairs
    # (n_points, 3, 4): by x', y', x", y" of the point, the orientation held [unit of
    # the base / mm]
    by_image: np.ndarray
    gain: np.ndarray  # (n_points, 3, 6): by base direction and turn of the right camera
    # (n_points, 6, 4): of base direction and turn by the image coordinates [1/mm]
    by_point: np.ndarray
    # (n_pairs, 2, 3, 6): of left and right projection centre by base direction and turn
    centres: np.ndarray


@dataclass(frozen=True, eq=False, repr=False)
class ImageOrientation(OrientationResult):
    """Relative orientations of all models of a flight.

    Attributes
    ----------
    case : str
        Which photograph is moved; see ``orientation_elements``.
    estimator : str
    models : DataFrame
        coverage, model_id, case, n_points, redundancy, sigma_0 [mm], is_converged,
        is_ambiguous (another orientation fits as well), n_in_front, reason (empty
        where the model is oriented).
    parameters : DataFrame
        Index model_id; bx, by, bz in the unit of the base, omega, phi, kappa [rad]; in
        the independent case base, phi_1, kappa_1, omega_2, phi_2, kappa_2. NaN where
        the points determine nothing.
    elements : OrientationElements
        The same as arrays, with cofactors and cameras.
    residuals : DataFrame
        [coverage,] model_id, point_id, residual_x_left, residual_y_left,
        residual_x_right, residual_y_right [mm] (adjusted minus measured),
        redundancy_number (of the condition of the point), weight (1, less after a
        robust norm, NaN where the point was taken out), w (length of the four residuals
        over its standard error), p_value, is_suspect. Of a point that was taken out
        the residuals are what the model misses it by, its redundancy number is 1, and
        it is a suspect.
    model_points : DataFrame
        [coverage,] model_id, point_id, x, y, z in the unit of the base: intersections
        of the adjusted rays ("rigorous"), or with the mean of both y ("determinants");
        without points that were taken out.
    failures : DataFrame
        coverage, model_id, stage, reason, remedy.
    pairs : OrientedPairs
        What ``model_precision`` is computed from.
    points : StereoPairs
        Image coordinates of all points that took part.
    factors : ndarray, shape (n_points,)
        Of the weights of ``points``; less than 1 after a robust norm.
    """

    case: str
    estimator: str
    models: pd.DataFrame
    parameters: pd.DataFrame
    elements: OrientationElements
    residuals: pd.DataFrame
    model_points: pd.DataFrame
    failures: pd.DataFrame
    pairs: OrientedPairs
    points: StereoPairs
    factors: np.ndarray

    @property
    def is_oriented(self) -> NDArray[np.bool_]:
        """Whether each model was oriented, ndarray of bool in the order of models."""
        return self.pairs.orientation.status == ORIENTED

    @property
    def sigma_0(self) -> pd.Series:
        """Standard error of an image coordinate [mm], Series by model_id."""
        return self._by_model("sigma_0")

    @property
    def converged(self) -> pd.Series:
        """Whether the adjustment converged, Series of bool by model_id."""
        return self._by_model("is_converged").rename("converged")

    @cached_property
    def dangerous_surface(self) -> pd.DataFrame:
        """Whether the points of each model lie near a dangerous surface, and why.

        Index model_id; verdict (safe, weak or critical), inflation, and the other
        columns of ``dangerous_surface.surface_table``. Models that could not be
        oriented are critical, with the reason of their failure.
        """
        is_failed = ~self.is_oriented
        geometry = geometry_of_images(self.elements.cameras, *self._points_of_models())
        examination = examine_surfaces(
            geometry.xyz, geometry.base, geometry.model_start, grows_with_depth=True
        )
        surfaces = surface_table(examination, self.models["model_id"])
        reason = self.models["reason"].to_numpy()
        surfaces.loc[is_failed, "reason"] = reason[is_failed]
        # nothing is wrong with their surfaces, but nobody should overlook it
        for is_it, text in (
            (self.is_oriented & self._is_hopeless, DO_NOT_MEET),
            (self.is_against_x, EXCHANGED),
        ):
            surfaces.loc[is_it & (surfaces["reason"] == "").to_numpy(), "reason"] = text
        return surfaces

    @property
    def _is_hopeless(self):
        return (self.models["sigma_0"] > HOPELESS_SIGMA).to_numpy()

    @property
    def is_against_x(self) -> NDArray[np.bool_]:
        """Models whose base points against x of the left image, ndarray of bool.

        Left and right image are exchanged, or the images mirrored, where they were not
        flown that way.
        """
        return self.is_oriented & (self.pairs.orientation.base[:, 0] < -COS_45)

    @property
    def estimates(self) -> Estimates:
        """Five elements of each orientation, lengths in the unit of the base."""
        return Estimates(
            names=self.elements.estimated,
            cofactors=self.elements.cofactor,
            unit_error=self.models["sigma_0"].to_numpy(),
            is_usable=np.ones(len(self.models), dtype=bool),
        )

    @property
    def orientations(self) -> pd.DataFrame:
        """One row per model: ``models`` beside ``parameters``."""
        parameters = self.parameters.reset_index(drop=True)
        return pd.concat([self.models, parameters], axis=1)

    @cached_property
    def model_precision(self) -> pd.DataFrame:
        """Standard errors of the model points, row for row as ``model_points``.

        [coverage,] model_id, point_id, sigma_x, sigma_y, sigma_z (of intersection and
        orientation together), sigma_z_image (of the intersection alone), in the unit of
        the base; base_to_height, the base over the distance of the point from it. NaN
        where a model has no redundancy.
        """
        xyz, start = self._points_of_models()
        model = np.repeat(np.arange(len(start) - 1), np.diff(start))
        sigma_0 = self.models["sigma_0"].to_numpy()[model]
        of_axes = np.sqrt(np.diagonal(self._precision.cofactor, axis1=1, axis2=2))
        of_rays = np.sqrt(np.maximum(self._precision.image_part[:, 2, 2], 0.0))
        cameras = self.elements.cameras
        base = (cameras.right_centre - cameras.left_centre)[model]
        across = np.cross(base, xyz - cameras.left_centre[model])
        table = self.model_points.drop(columns=["x", "y", "z"])
        table[["sigma_x", "sigma_y", "sigma_z"]] = of_axes * sigma_0[:, None]
        table["sigma_z_image"] = of_rays * sigma_0
        squares = [np.sum(vector**2, axis=1) for vector in (base, across)]
        # |base| over |base x place| / |base|
        table["base_to_height"] = squares[0] / np.sqrt(squares[1])
        return table

    @cached_property
    def measuring_error(self) -> pd.DataFrame:
        """What image coordinates and orientation make of m_g: DataFrame by model_id.

        m_g_intersection_um, m_g_orientation_um: total errors in plan at the mean image
        scale of the model, of the intersection of rays, and of what an affine
        transformation leaves of the orientation's error. NaN without redundancy.
        """
        xyz, start = self._points_of_models()
        # NaN where there is no model
        count = np.where(np.diff(start), np.diff(start), np.nan)
        sigma_0 = self.models["sigma_0"].to_numpy()
        # image scale: principal distance over the mean depth of the points
        depth = np.abs(segment_sum(xyz[:, 2], start) / count)
        scale = self.pairs.distance[:, 0] / depth
        own = np.trace(self._precision.image_part[:, :2, :2], axis1=1, axis2=2)
        cofactor = self.pairs.orientation.cofactor
        gain = self._precision.gain[:, :2]
        bent = deformation_variance(gain, cofactor, xyz[:, :2], start)
        to_um = sigma_0 * scale * METRES_PER_MM / METRES_PER_UM
        return pd.DataFrame(
            {
                "m_g_intersection_um": np.sqrt(segment_sum(own, start) / count) * to_um,
                "m_g_orientation_um": np.sqrt(bent) * to_um,
            },
            index=pd.Index(self.models["model_id"], name="model_id"),
        )

    def model_covariance(
        self, model_id: str, coverage: str | None = None
    ) -> pd.DataFrame:
        """Covariance matrix of all points of a model.

        Parameters
        ----------
        model_id : str
        coverage : str, optional
            Needed where two coverages have a model of that name.

        Returns
        -------
        DataFrame
            Named by point_id and axis on both sides, in the unit of the base squared:
            the points share the errors of the orientation.

        Raises
        ------
        TableError
            There is no such model, or there is one in each of several coverages.
        """
        place = row_of_model(self.models, model_id, coverage)
        _, start = self._points_of_models()
        rows = slice(start[place], start[place + 1])
        gain = self._precision.gain[rows].reshape(-1, N_CHANGES)
        covariance = gain @ self.pairs.orientation.cofactor[place] @ gain.T
        for first, part in enumerate(self._precision.image_part[rows]):
            block = slice(3 * first, 3 * first + 3)
            covariance[block, block] += part
        names = [self.model_points["point_id"].iloc[rows], list("xyz")]
        index = pd.MultiIndex.from_product(names, names=["point_id", "axis"])
        sigma_0 = self.models["sigma_0"].iloc[place]
        return pd.DataFrame(covariance * sigma_0**2, index=index, columns=index)

    @cached_property
    def image_influence(self) -> ImageInfluence:
        """How image coordinates move the model points, row for row: ImageInfluence.

        Of the rigorous estimator.
        """
        rows = self.is_oriented[self.points.model]
        used, orientation = self.points.chosen(rows), self.pairs.orientation
        adjusted = replace(used, image=used.image + orientation.residuals[rows])
        return ImageInfluence(
            used.model,
            self._precision.by_image,
            self._precision.gain,
            orientation_influence(orientation, adjusted, self.factors[rows]),
            np.moveaxis(self.pairs.camera_changes()[0], 1, -1),
        )

    @cached_property
    def _precision(self):
        return model_precision(self.pairs, *self._points_of_models())

    def _points_of_models(self):
        """Places of the model points, and the first row of every model."""
        count = np.where(self.is_oriented, self.models["n_points"], 0)
        xyz = values_of(self.model_points, ["x", "y", "z"])
        return xyz, np.append(0, np.cumsum(count))

    def summary(self) -> str:
        """Say how many models were oriented, how well, and what is doubtful."""
        return _summary(self)


def _summary(result):
    models = result.models
    good = models[result.is_oriented]
    done = mark(
        "Relative orientation of {n} of {n_all:model|models} from image coordinates"
    )
    n_points = translated("{n:point|points}", n=int(good["n_points"].sum()))
    lines = [
        translated(done, n=len(good), n_all=len(models)),
        f"{n_points}, {result.case}, {result.estimator}",
    ]
    problems = _problems(result, good)
    if problems:
        said = (typesetting.wrapped(text, first="- ", indent="  ") for text in problems)
        lines += ["", translated("Problems and suggestions"), *said]
    if good["redundancy"].sum() > 0:
        lines += ["", *_precision(good)]
    if 0 < len(good) <= MOST_LISTED:
        lines += ["", _listed(result, good)]
    return "\n".join(lines)


def _problems(result, good):
    problems = [
        f"{place_text('model', row.model_id)}: {retold(row.reason)}. "
        f"{retold(row.remedy)}."
        for row in result.failures.head(5).itertuples()
    ]
    rest = len(result.failures) - len(problems)
    if rest:
        problems.append(translated("and {n:model|models} more failed.", n=rest))
    for is_it, text in (
        (good["is_ambiguous"], AMBIGUOUS),
        (good["n_in_front"] < good["n_points"], SOME_BEHIND),
        (result.is_against_x[good.index], AGAINST_X),
        (good["sigma_0"] > HOPELESS_SIGMA, DO_NOT_MEET),
        (good["sigma_0"] > LARGE_SIGMA * good["sigma_0"].median(), LARGE),
        (_is_near_surface(result, good), NEAR_SURFACE),
    ):
        if is_it.any():
            names = typesetting.names(good.loc[is_it, "model_id"])
            problems.append(f"{place_text('model', names)}: {translated(text)}")
    return [*problems, *_suspects(result)]


def _suspects(result):
    residuals = result.residuals
    rows = residuals[residuals["is_suspect"]].sort_values("w", ascending=False)
    if rows.empty:
        return []
    named = [f"{row.model_id} {row.point_id}" for row in rows.itertuples()]
    remedy = MEASURE_AGAIN
    if rows["weight"].isna().any():
        remedy = TAKEN_OUT
    elif (rows["weight"] < SMALL_WEIGHT).all():
        remedy = LESS_WEIGHT
    names = typesetting.names(named)
    return [f"{translated(CONTRADICT)} {names}. {translated(remedy)}"]


def _is_near_surface(result, good):
    verdicts = result.dangerous_surface["verdict"].to_numpy()
    return pd.Series(verdicts[good.index] != "safe", index=good.index)


def _precision(good):
    usable = good[good["redundancy"] > 0]
    pooled = pool_standard_errors(usable["sigma_0"], usable["redundancy"])
    length = typesetting.length(pooled * METRES_PER_MM)
    redundancy = int(usable["redundancy"].sum())
    lines = [translated(POOLED, length=length, redundancy=redundancy)]
    if len(usable) > 1:
        steps = usable["sigma_0"].quantile([0.0, 0.5, 1.0]) * METRES_PER_MM
        low, mid, high = map(typesetting.length, steps)
        message = mark("sigma_0 of single models  {low} to {high}, median {mid}")
        lines.append(translated(message, low=low, high=high, mid=mid))
    return lines


def _listed(result, good):
    angles = result.parameters.columns[-3:]
    values = result.parameters[angles].to_numpy()[good.index] / RADIANS_PER_GON
    sigma_um = good["sigma_0"] * METRES_PER_MM / METRES_PER_UM
    names = all_shortened(good["model_id"], WIDEST_NAME)
    rows = [
        [name, str(count), typesetting.fixed(size, 1)]
        + [typesetting.fixed(angle, 4) for angle in row]
        for name, count, size, row in zip(
            names, good["n_points"], sigma_um, values, strict=True
        )
    ]
    header = [
        translated("model"),
        translated("points"),
        "sigma_0/µm",
        *(f"{name}/gon" for name in angles),
    ]
    return typesetting.table(rows, header=header)
