"""Stage 2, from image coordinates: every stereo pair oriented for itself."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pandas as pd

from einschalt.foundations import typesetting
from einschalt.foundations.batches import segments
from einschalt.foundations.errors import SettingsError, TableError, raise_problems
from einschalt.foundations.names import CodedPairs, encode_pairs
from einschalt.foundations.tables import IMAGE_PAIRS, check_table, with_coverage
from einschalt.foundations.units import (
    METRES_PER_MM,
    METRES_PER_UM,
    RADIANS_PER_GON,
)
from einschalt.stages.dangerous_surface import geometry_of_images, surface_table
from einschalt.stages.results import Result, failures_table, row_of_model
from einschalt.theory.relative_orientation import coplanarity
from einschalt.theory.relative_orientation.coplanarity import (
    BEHIND,
    MODES,
    NOT_CONVERGED,
    ORIENTED,
    TOO_FEW,
    UNDETERMINED,
    orient_pairs,
)
from einschalt.theory.relative_orientation.dangerous_surfaces import examine_surfaces
from einschalt.theory.relative_orientation.model_formation import form_model
from einschalt.theory.relative_orientation.orientation_elements import (
    CASES,
    OrientationElements,
    orientation_elements,
)

STAGE = "stage2_relative_orientation"
KEYS = ["model_id", "point_id"]
COORDINATES = ["x_left", "y_left", "x_right", "y_right"]
# the rule of model coordinates that belongs to the estimator
RULES = {"rigorous": "adjusted_rays", "determinants": "mean_y"}
# tangent of the widest and the narrowest field angle that is believed
WIDEST_FIELD, NARROWEST_FIELD = 2.5, 0.01
SMALLEST_DISTANCE_MM, LARGEST_DISTANCE_MM = 1.0, 5000.0
# sigma_0 of a model against that of all models that is worth a word
LARGE_SIGMA = 3.0
AMBIGUOUS = (
    "another orientation fits about as well; the one nearer to the normal case was "
    "taken. Measure more points, at different heights."
)
SOME_BEHIND = "a point lies behind a camera. Look for gross errors in x."
POOLED = "sigma_0 (an image coordinate, all models together)"
NEAR_SURFACE = "weak or critical, near a dangerous surface: see dangerous_surface."
LARGE = "sigma_0 is more than three times the median. Look for gross errors."
MOST_LISTED = 12
REMEDIES = {
    TOO_FEW: "Measure at least six points in the overlap, or take the model out",
    UNDETERMINED: "Measure points that are spread over the whole overlap",
    NOT_CONVERGED: "Look for exchanged points and gross errors, or measure more points",
    BEHIND: "Check that left and right image and the axes are not confused",
}


@dataclass(frozen=True, eq=False, repr=False)
class ImageOrientation(Result):
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
        residual_x_right, residual_y_right [mm] (adjusted less measured),
        redundancy_number (of the condition of the point).
    model_points : DataFrame
        [coverage,] model_id, point_id, x, y, z in the unit of the base: intersections
        of the adjusted rays ("rigorous"), or with the mean of both y ("determinants").
    failures : DataFrame
        coverage, model_id, stage, reason, remedy.
    """

    case: str
    estimator: str
    models: pd.DataFrame
    parameters: pd.DataFrame
    elements: OrientationElements
    residuals: pd.DataFrame
    model_points: pd.DataFrame
    failures: pd.DataFrame

    @property
    def sigma_0(self):
        """Standard error of an image coordinate [mm], Series by model_id."""
        return self._by_model("sigma_0")

    @property
    def converged(self):
        """Whether the adjustment converged, Series of bool by model_id."""
        return self._by_model("is_converged").rename("converged")

    @property
    def n_points(self):
        """Number of points, Series by model_id."""
        return self._by_model("n_points")

    @property
    def redundancy(self):
        """Points less five, Series by model_id."""
        return self._by_model("redundancy")

    @cached_property
    def dangerous_surface(self):
        """Whether the points of each model lie near a dangerous surface, and why.

        Index model_id; verdict (safe, weak or critical), inflation, and the other
        columns of :func:`einschalt.stages.dangerous_surface.surface_table`. Models that
        could not be oriented are critical, with the reason of their failure.
        """
        reason = self.models["reason"].to_numpy()
        count = np.where(reason == "", self.models["n_points"], 0)
        xyz = self.model_points[["x", "y", "z"]].to_numpy()
        start = np.append(0, np.cumsum(count))
        geometry = geometry_of_images(self.elements.cameras, xyz, start)
        examination = examine_surfaces(
            geometry.xyz, geometry.base, geometry.model_start, grows_with_depth=True
        )
        surfaces = surface_table(examination, self.models["model_id"])
        surfaces.loc[reason != "", "reason"] = reason[reason != ""]
        return surfaces

    @property
    def orientations(self):
        """One row per model: ``models`` beside ``parameters``."""
        parameters = self.parameters.reset_index(drop=True)
        return pd.concat([self.models, parameters], axis=1)

    def _by_model(self, column):
        return self.models.set_index("model_id")[column]

    def cofactor(self, model_id, coverage=None):
        """Cofactor matrix of the five estimated elements of a model.

        Parameters
        ----------
        model_id : str
        coverage : str, optional
            Needed where two coverages have a model of that name.

        Returns
        -------
        DataFrame
            Named on both sides; lengths in the unit of the base, angles in radians, for
            an image coordinate with the variance 1 mm².

        Raises
        ------
        TableError
            There is no such model, or there is one in each of several coverages.
        """
        row = row_of_model(self.models, model_id, coverage)
        names = list(self.elements.estimated)
        return pd.DataFrame(self.elements.cofactor[row], index=names, columns=names)

    def covariance(self, model_id, coverage=None):
        """Covariance matrix of the five estimated elements of a model.

        Parameters
        ----------
        model_id : str
        coverage : str, optional
            Needed where two coverages have a model of that name.

        Returns
        -------
        DataFrame
            by, bz, omega, phi, kappa (independent case: phi_1, kappa_1, omega_2, phi_2,
            kappa_2) on both sides; NaN with five points, which leave no redundancy.

        Raises
        ------
        TableError
            There is no such model, or there is one in each of several coverages.
        """
        row = row_of_model(self.models, model_id, coverage)
        return self.cofactor(model_id, coverage) * self.models["sigma_0"].iloc[row] ** 2

    def summary(self):
        """Say how many models were oriented, how well, and what is doubtful."""
        return _summary(self)


def orient_from_images(
    image_pairs,
    principal_distance,
    *,
    base_length=None,
    case="dependent_right",
    estimator="rigorous",
):
    """Orient every stereo pair from its image coordinates; no start value is needed.

    Parameters
    ----------
    image_pairs : DataFrame
        [coverage,] model_id, point_id, x_left, y_left, x_right, y_right [mm], origin
        in the principal point, y up.
    principal_distance : float or pair of floats
        [mm]; a pair where the left and the right camera differ.
    base_length : float or Series by model_id, optional
        Of bx where the base lies within 45 degrees of x, otherwise of the base vector;
        it gives the model its unit. The default is 1.
    case : {"dependent_right", "dependent_left", "independent"}
        Which photograph is moved: the right one, the left one, or both.
    estimator : {"rigorous", "determinants"}
        Gauss-Helmert with equal weights of the four image coordinates, or the least sum
        of squares of the unweighted determinants, as in lecture notes.

    Returns
    -------
    ImageOrientation
        Models with fewer than five points, or points that determine nothing, are rows
        of ``failures``.

    Raises
    ------
    TableError
        A column is missing, or a value is not what it should be.
    SettingsError
        An argument is unknown or has the wrong unit.

    Examples
    --------
    >>> import pandas as pd
    >>> pairs = pd.DataFrame(
    ...     {"model_id": "7/8", "point_id": list("abcdef"),
    ...      "x_left": [0.0, 92.0, 0.0, 92.0, 0.0, 92.0],
    ...      "y_left": [0.0, 0.0, 95.0, 95.0, -95.0, -95.0],
    ...      "x_right": [-92.0, 0.0, -92.0, 0.0, -92.0, 0.0],
    ...      "y_right": [0.0, 0.0, 95.0, 95.0, -95.0, -95.0]})
    >>> oriented = orient_from_images(pairs, 152.0, base_length=92.0)
    >>> (oriented.parameters.loc["7/8"].round(9) + 0.0).tolist()
    [92.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    """
    _check_arguments(principal_distance, case, estimator)
    checked = check_table(image_pairs, IMAGE_PAIRS)
    raise_problems(checked.problems)
    _check_unit(checked.frame, np.max(principal_distance))
    measured = _Measured.of(checked.frame, "coverage" in image_pairs.columns)
    pairs = orient_pairs(measured.image, measured.start, principal_distance, estimator)
    models = _models_table(measured.names, pairs, case)
    length = _base_lengths(base_length, models)
    elements = orientation_elements(pairs, length, case)
    model = form_model(
        measured.image,
        measured.start,
        principal_distance,
        elements.cameras,
        RULES[estimator],
        pairs.residuals,
    )
    index = pd.Index(models["model_id"], name="model_id")
    is_kept = np.repeat(pairs.status == ORIENTED, pairs.n_points)
    return ImageOrientation(
        case=case,
        estimator=estimator,
        models=models,
        parameters=pd.DataFrame(elements.values, index, list(elements.names)),
        elements=elements,
        residuals=_residuals_table(measured.keys, pairs)[is_kept].reset_index(
            drop=True
        ),
        model_points=_points_table(measured.keys, model.xyz)[is_kept].reset_index(
            drop=True
        ),
        failures=_failures(models, pairs.status),
    )


@dataclass(frozen=True, eq=False)
class _Measured:
    """Image coordinates and names of the rows, sorted by model."""

    image: np.ndarray
    keys: pd.DataFrame
    start: np.ndarray
    names: CodedPairs

    @classmethod
    def of(cls, frame, has_coverages):
        frame = with_coverage(frame)
        names = encode_pairs(frame["coverage"], frame["model_id"])
        sort = segments(names.codes, len(names))
        keys = ["coverage", *KEYS] if has_coverages else KEYS
        return cls(
            image=frame[COORDINATES].to_numpy(dtype=float)[sort.order],
            keys=frame[keys].iloc[sort.order].reset_index(drop=True),
            start=sort.start,
            names=names,
        )


def _check_arguments(principal_distance, case, estimator):
    for name, value, allowed in (
        ("case", case, CASES),
        ("estimator", estimator, MODES),
    ):
        if value not in allowed:
            raise SettingsError(
                f"{name} = {value!r} is unknown", expected=" or ".join(allowed)
            )
    distance = np.atleast_1d(np.asarray(principal_distance, dtype=float))
    is_good = (distance >= SMALLEST_DISTANCE_MM) & (distance <= LARGEST_DISTANCE_MM)
    if distance.shape not in ((1,), (2,)) or not is_good.all():
        is_small = distance.size and 0.0 < distance.min() < SMALLEST_DISTANCE_MM
        raise SettingsError(
            f"principal_distance = {principal_distance!r}",
            expected=f"{SMALLEST_DISTANCE_MM:g} to {LARGEST_DISTANCE_MM:g} "
            "(millimetres), one number or one for each side",
            remedy="Did you give metres?" if is_small else "",
        )


def _check_unit(frame, distance):
    values = frame[COORDINATES].to_numpy(dtype=float)
    sizes = np.abs(values).max(axis=1)
    found = f"image coordinates up to {sizes.max():.4g} with a principal distance of "
    found += f"{distance:g}"
    expected = "millimetres, from the principal point"
    if np.median(sizes) > WIDEST_FIELD * distance:
        remedy = "Did you give pixels? Convert them with pixel size and principal point"
    elif values.min() >= 0.0 and sizes.max() > distance:
        found += ", none of them negative"
        remedy = "Is the origin in a corner? Subtract the principal point"
    elif 0.0 < sizes.max() < NARROWEST_FIELD * distance:
        remedy = "Did you give metres? Multiply them by 1000"
    else:
        return
    raise TableError(found, expected=expected, remedy=remedy, file="image_pairs")


def _base_lengths(base_length, models):
    if base_length is None:
        return np.ones(len(models))
    if isinstance(base_length, pd.Series):
        keys = models["model_id"]
        if isinstance(base_length.index, pd.MultiIndex):
            keys = pd.MultiIndex.from_frame(models[["coverage", "model_id"]])
        length = base_length.reindex(keys).to_numpy(dtype=float)
    else:
        length = np.full(len(models), base_length, dtype=float)
    is_bad = ~(np.isfinite(length) & (length > 0.0))
    if is_bad.any():
        first = int(np.argmax(is_bad))
        raise SettingsError(
            f"base_length = {length[first]}",
            expected="a positive length for every model",
            model=models["model_id"].iloc[first],
        )
    return length


def _models_table(names, pairs, case):
    return pd.DataFrame(
        {
            "coverage": names.first,
            "model_id": names.second,
            "case": case,
            "n_points": pairs.n_points,
            "redundancy": pairs.redundancy,
            "sigma_0": pairs.sigma_0,
            "is_converged": pairs.is_converged,
            "is_ambiguous": pairs.is_ambiguous,
            "n_in_front": pairs.n_in_front,
            "reason": _reasons(pairs),
        }
    )


def _reasons(pairs):
    reasons = np.full(len(pairs.status), "", dtype=object)
    for place in np.flatnonzero(pairs.status == TOO_FEW):
        points = typesetting.count(int(pairs.n_points[place]), "point")
        reasons[place] = (
            f"{points}, but relative orientation needs {coplanarity.N_PARAMETERS}"
        )
    reasons[pairs.status == UNDETERMINED] = (
        "its points lie in a line, in one place or near a dangerous surface"
    )
    for place in np.flatnonzero(pairs.status == NOT_CONVERGED):
        sigma = typesetting.length(pairs.sigma_0[place] * METRES_PER_MM)
        reasons[place] = f"the adjustment did not converge, sigma_0 {sigma}"
    for place in np.flatnonzero(pairs.status == BEHIND):
        n, front = pairs.n_points[place], pairs.n_in_front[place]
        reasons[place] = f"{n - front} of {n} points lie behind a camera"
    return reasons


def _failures(models, status):
    is_failed = (models["reason"] != "").to_numpy()
    return failures_table(
        (row.coverage, row.model_id, STAGE, row.reason, REMEDIES[code])
        for row, code in zip(
            models[is_failed].itertuples(), status[is_failed], strict=True
        )
    )


def _residuals_table(keys, pairs):
    table = keys.copy()
    table[[f"residual_{name}" for name in COORDINATES]] = pairs.residuals
    table["redundancy_number"] = pairs.redundancy_numbers
    return table


def _points_table(keys, xyz):
    table = keys.copy()
    table[["x", "y", "z"]] = xyz
    return table


def _summary(result):
    models = result.models
    is_good = (models["reason"] == "").to_numpy()
    good = models[is_good]
    n_models = typesetting.count(len(models), "model")
    n_points = typesetting.count(int(good["n_points"].sum()), "point")
    way = f"{result.case}, {result.estimator}"
    lines = [
        f"Relative orientation of {len(good)} of {n_models} from image coordinates",
        f"{n_points}, {way}",
    ]
    problems = _problems(result, good)
    if problems:
        lines += ["", "Problems and suggestions"]
        lines += [
            typesetting.wrapped(text, first="- ", indent="  ") for text in problems
        ]
    if good["redundancy"].sum() > 0:
        lines += ["", *_precision(good)]
    if 0 < len(good) <= MOST_LISTED:
        lines += ["", _listed(result, good)]
    return "\n".join(lines)


def _problems(result, good):
    problems = [
        f"model {row.model_id}: {row.reason}. {row.remedy}."
        for row in result.failures.head(5).itertuples()
    ]
    rest = len(result.failures) - len(problems)
    problems += [f"and {typesetting.count(rest, 'model')} more failed."] if rest else []
    for is_it, text in (
        (good["is_ambiguous"], AMBIGUOUS),
        (good["n_in_front"] < good["n_points"], SOME_BEHIND),
        (good["sigma_0"] > LARGE_SIGMA * good["sigma_0"].median(), LARGE),
        (_is_near_surface(result, good), NEAR_SURFACE),
    ):
        if is_it.any():
            names = typesetting.names(good.loc[is_it, "model_id"])
            problems.append(f"model {names}: {text}")
    return problems


def _is_near_surface(result, good):
    verdicts = result.dangerous_surface["verdict"].to_numpy()
    return pd.Series(verdicts[good.index] != "safe", index=good.index)


def _precision(good):
    usable = good[good["redundancy"] > 0]
    weights = usable["redundancy"]
    pooled = np.sqrt((usable["sigma_0"] ** 2 * weights).sum() / weights.sum())
    length = typesetting.length(pooled * METRES_PER_MM)
    lines = [f"{POOLED}  {length}, redundancy {weights.sum()}"]
    if len(usable) > 1:
        steps = usable["sigma_0"].quantile([0.0, 0.5, 1.0]) * METRES_PER_MM
        low, mid, high = map(typesetting.length, steps)
        lines.append(f"sigma_0 of single models  {low} to {high}, median {mid}")
    return lines


def _listed(result, good):
    angles = result.parameters.columns[-3:]
    values = result.parameters[angles].to_numpy()[good.index] / RADIANS_PER_GON
    sigma_um = good["sigma_0"] * METRES_PER_MM / METRES_PER_UM
    rows = [
        [typesetting.shortened(name, 20), str(count), typesetting.fixed(size, 1)]
        + [typesetting.fixed(angle, 4) for angle in row]
        for name, count, size, row in zip(
            good["model_id"], good["n_points"], sigma_um, values, strict=True
        )
    ]
    header = ["model", "points", "sigma_0/µm", *(f"{name}/gon" for name in angles)]
    return typesetting.table(rows, header=header)
