"""Stage 2, from image coordinates: every stereo pair oriented for itself."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
import pandas as pd

from einschalt.foundations import typesetting
from einschalt.foundations.arguments import (
    as_numbers,
    described,
    finite_number,
    require_choice,
)
from einschalt.foundations.batches import segments
from einschalt.foundations.errors import SettingsError, TableError, raise_problems
from einschalt.foundations.frame_columns import values_of
from einschalt.foundations.kept_texts import kept
from einschalt.foundations.language import mark
from einschalt.foundations.names import CodedPairs, encode_pairs
from einschalt.foundations.number_parsing import LARGEST_NUMBER
from einschalt.foundations.tables import IMAGE_PAIRS, check_table, with_coverage
from einschalt.foundations.units import METRES_PER_MM
from einschalt.stages.relative_orientation.image_orientation import ImageOrientation
from einschalt.stages.relative_orientation.image_units import unit_fault
from einschalt.stages.results import OUTLIERS, failures_table
from einschalt.theory.adjustment.multiple_testing import is_rejected_by_holm
from einschalt.theory.adjustment.significance import GROSS_ERROR_SIGNIFICANCE
from einschalt.theory.relative_orientation import coplanarity
from einschalt.theory.relative_orientation.condition_tests import (
    StereoPairs,
    condition_tests,
    misclosures,
    prediction_tests,
)
from einschalt.theory.relative_orientation.coplanarity import (
    BEHIND,
    MODES,
    NOT_CONVERGED,
    ORIENTED,
    TOO_FEW,
    UNDETERMINED,
)
from einschalt.theory.relative_orientation.gross_errors import find_gross_errors
from einschalt.theory.relative_orientation.missing_base import have_no_base
from einschalt.theory.relative_orientation.model_formation import form_model
from einschalt.theory.relative_orientation.model_precision import OrientedPairs
from einschalt.theory.relative_orientation.orientation_elements import (
    CASES,
    orientation_elements,
)
from einschalt.theory.relative_orientation.robust_orientation import (
    NORMS,
    orient_robustly,
)

STAGE = "stage2_relative_orientation"
KEYS = ["model_id", "point_id"]
COORDINATES = ["x_left", "y_left", "x_right", "y_right"]
# the rule of model coordinates that belongs to the estimator
RULES = {"rigorous": "adjusted_rays", "determinants": "mean_y"}
SMALLEST_DISTANCE_MM, LARGEST_DISTANCE_MM = 1.0, 5000.0
FEW = mark("{n:point|points}, but relative orientation needs {least}")
NO_BASE = "both photographs see its points as from one place: its base is too short"
OTHER_PLACE = "Check that left and right are not one image; take a pair with a base"
REMEDIES = {
    TOO_FEW: "Measure at least six points in the overlap, or take the model out",
    UNDETERMINED: "Measure points that are spread over the whole overlap",
    NOT_CONVERGED: (
        'Look for exchanged points and gross errors (outliers = "snoop" names them), '
        "or measure more points"
    ),
    BEHIND: "Check that left and right image and the axes are not confused",
}


def orient_from_images(
    image_pairs: pd.DataFrame,
    principal_distance: float,
    *,
    base_length: pd.Series | float | None = None,
    case: Literal[
        "independent", "dependent_left", "dependent_right"
    ] = "dependent_right",
    estimator: Literal["rigorous", "determinants"] = "rigorous",
    outliers: Literal["keep", "snoop", "huber", "tukey"] = "keep",
) -> ImageOrientation:
    """Orient every stereo pair from its image coordinates, without starting values.

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
    outliers : {"keep", "snoop", "huber", "tukey"}
        Only name the points that contradict their model, or take them out: first those
        that most of the points contradict, then the worst one until none is left; or
        keep them all with weights that fall with the size of their misclosure (only
        with the rigorous estimator).

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
    _check_choices(case, estimator, outliers)
    distance = _distances(principal_distance)
    checked = check_table(image_pairs, IMAGE_PAIRS)
    raise_problems(checked.problems)
    _check_unit(checked.frame, distance.max())
    measured = _Measured.of(checked.frame, "coverage" in image_pairs.columns)
    points = measured.pairs(distance)
    is_wrong = _gross_errors(points, estimator, outliers)
    is_out = is_wrong & (outliers == "snoop")
    used = points.chosen(~is_out)
    pairs, factors = _orient(used, estimator, outliers)
    models = _models_table(measured.names, pairs, case, used)
    length = _base_lengths(base_length, models)
    elements = orientation_elements(pairs, length, case)
    xyz = _model_points(used, elements, RULES[estimator], pairs.residuals)
    index = pd.Index(models["model_id"], name="model_id")
    is_good = pairs.status == ORIENTED
    return ImageOrientation(
        case=case,
        estimator=estimator,
        models=models,
        parameters=pd.DataFrame(elements.values, index, list(elements.names)),
        elements=elements,
        residuals=measured.keys.assign(
            **_residuals(points, is_out, pairs, factors),
            **_tests(points, is_wrong, None if outliers in NORMS else pairs),
        )[is_good[points.model]].reset_index(drop=True),
        model_points=measured.keys[~is_out]
        .assign(**dict(zip("xyz", xyz.T, strict=True)))[is_good[used.model]]
        .reset_index(drop=True),
        failures=_failures(models, pairs.status),
        pairs=OrientedPairs(pairs, length, case, used.distance),
        points=used,
        factors=factors,
    )


def _gross_errors(points, estimator, outliers):
    if outliers == "keep":
        return np.zeros(len(points.image), dtype=bool)
    return find_gross_errors(points, estimator, GROSS_ERROR_SIGNIFICANCE)


def _orient(points, estimator, outliers):
    """Orientation of all pairs, and the factors of their points' weights."""
    if outliers not in NORMS:
        return points.orient(estimator), np.ones(len(points.image))
    robust = orient_robustly(points, outliers)
    return robust.orientation, robust.factors


def _model_points(points, elements, rule, residuals):
    """Places of all points in their models."""
    where = (points.image, points.start, points.distance)
    return form_model(*where, elements.cameras, rule, residuals).xyz


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
            image=values_of(frame, COORDINATES)[sort.order],
            keys=frame[keys].iloc[sort.order].reset_index(drop=True),
            start=sort.start,
            names=names,
        )

    def pairs(self, principal_distance):
        """Pairs of all models, with the principal distances of both photographs."""
        distance = np.empty((len(self.names), 2))
        distance[:] = principal_distance
        return StereoPairs(self.image, self.start, distance)


def _check_choices(case, estimator, outliers):
    require_choice("case", case, CASES)
    require_choice("estimator", estimator, MODES)
    require_choice("outliers", outliers, OUTLIERS)
    if outliers in NORMS and estimator != "rigorous":
        raise SettingsError(
            f"outliers = {outliers!r} with estimator = {estimator!r}",
            expected="weights, which the determinants do not have",
            remedy='Use estimator = "rigorous", or outliers = "snoop"',
        )


def _distances(principal_distance):
    name, unit = "principal_distance", "millimetres"
    distance = np.atleast_1d(as_numbers(name, principal_distance, expected=unit))
    is_good = (distance >= SMALLEST_DISTANCE_MM) & (distance <= LARGEST_DISTANCE_MM)
    if distance.shape not in ((1,), (2,)) or not is_good.all():
        is_small = distance.size and 0.0 < distance.min() < SMALLEST_DISTANCE_MM
        raise SettingsError(
            f"principal_distance = {described(principal_distance)}",
            expected=f"{SMALLEST_DISTANCE_MM:g} to {LARGEST_DISTANCE_MM:g} "
            "(millimetres), one number or one for each side",
            remedy="Did you give metres?" if is_small else "",
        )
    return distance


def _check_unit(frame, distance):
    fault = unit_fault(values_of(frame, COORDINATES), distance)
    if fault is not None:
        raise TableError(
            fault.found,
            expected=fault.expected,
            remedy=fault.remedy,
            file="image_pairs",
        )


def _base_lengths(base_length, models):
    if base_length is None:
        return np.ones(len(models))
    if isinstance(base_length, pd.Series):
        length = _lengths_by_model(base_length, models)
    else:
        length = finite_number("base_length", base_length, expected="millimetres")
        length = np.full(len(models), length)
    is_bad = ~((length > 0.0) & (length <= LARGEST_NUMBER))
    if is_bad.any():
        first = int(np.argmax(is_bad))
        raise SettingsError(
            f"base_length = {float(length[first])}",
            expected="a positive length for every model",
            model=models["model_id"].iloc[first],
        )
    return length


def _lengths_by_model(base_length, models):
    by_coverage = isinstance(base_length.index, pd.MultiIndex)
    if not base_length.index.is_unique:
        doubled = base_length.index[base_length.index.duplicated()]
        raise SettingsError(
            "base_length has the model twice",
            expected="one length for every model",
            remedy="" if by_coverage else "Index it by coverage and model_id",
            model=doubled[0],
        )
    base_length = pd.to_numeric(base_length, errors="coerce")
    if by_coverage:
        keys = pd.MultiIndex.from_frame(models[["coverage", "model_id"]])
        return base_length.reindex(keys).to_numpy(dtype=float)
    # names are text, also where they look like numbers
    named = base_length.set_axis(base_length.index.map(str))
    return named.reindex(models["model_id"]).to_numpy(dtype=float)


def _models_table(names, pairs, case, used):
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
            "reason": _reasons(pairs, used),
        }
    )


def _reasons(pairs, used):
    reasons = np.full(len(pairs.status), "", dtype=object)
    for place in np.flatnonzero(pairs.status == TOO_FEW):
        numbers = {"n": int(pairs.n_points[place]), "least": coplanarity.N_PARAMETERS}
        reasons[place] = kept(FEW, **numbers)
    reasons[pairs.status == UNDETERMINED] = (
        "its points lie in a line, in one place or near a dangerous surface"
    )
    for place in np.flatnonzero(pairs.status == NOT_CONVERGED):
        sigma = typesetting.length(pairs.sigma_0[place] * METRES_PER_MM)
        reasons[place] = f"the adjustment did not converge, sigma_0 {sigma}"
    for place in np.flatnonzero(pairs.status == BEHIND):
        n, front = pairs.n_points[place], pairs.n_in_front[place]
        reasons[place] = f"{n - front} of {n} points lie behind a camera"
    lost = np.flatnonzero(np.isin(pairs.status, (UNDETERMINED, NOT_CONVERGED)))
    _, some = used.of_models(lost)
    has_none = have_no_base(some.image, some.start, some.distance)
    reasons[lost[has_none]] = NO_BASE
    return reasons


def _failures(models, status):
    is_failed = status != ORIENTED
    return failures_table(
        (row.coverage, row.model_id, STAGE, row.reason, _remedy(row.reason, code))
        for row, code in zip(
            models[is_failed].itertuples(), status[is_failed], strict=True
        )
    )


def _remedy(reason, code):
    return OTHER_PLACE if reason == NO_BASE else REMEDIES[code]


def _residuals(points, is_out, pairs, factors):
    """Columns that say how far each point is off, and how much it counts."""
    residuals, numbers = np.empty((len(is_out), 4)), np.ones(len(is_out))
    residuals[~is_out] = pairs.residuals
    residuals[is_out] = misclosures(pairs, points.chosen(is_out)).corrections
    numbers[~is_out] = pairs.redundancy_numbers
    names = [f"residual_{name}" for name in COORDINATES]
    return {
        **dict(zip(names, residuals.T, strict=True)),
        "redundancy_number": numbers,
        "weight": _merged(is_out, factors, np.nan),
    }


def _tests(points, is_wrong, pairs):
    """Columns of the tests, in ``pairs`` without the wrong points.

    Without ``pairs`` in an adjustment of equal weights, also where nothing is wrong:
    the scale of a robust fit comes from most of its points; residuals over it are not
    Pope's τ.
    """
    used, others = points.chosen(~is_wrong), points.chosen(is_wrong)
    if pairs is None:
        pairs = used.orient("rigorous")
    tests = condition_tests(pairs, used)
    predicted = prediction_tests(pairs, others)
    is_suspect = is_wrong.copy()
    is_suspect[~is_wrong] = is_rejected_by_holm(
        tests.p_value, GROSS_ERROR_SIGNIFICANCE, used.start
    )
    return {
        "w": _merged(is_wrong, tests.w, predicted.w),
        "p_value": _merged(is_wrong, tests.p_value, predicted.p_value),
        "is_suspect": is_suspect,
    }


def _merged(is_out, of_used, of_others):
    values = np.empty(len(is_out))
    values[~is_out], values[is_out] = of_used, of_others
    return values
