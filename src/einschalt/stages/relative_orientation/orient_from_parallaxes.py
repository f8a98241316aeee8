"""Stage 2 from y-parallaxes: the elements of every model, by one of three methods."""

from dataclasses import dataclass, replace
from functools import cached_property
from numbers import Real
from typing import Literal

import numpy as np
import pandas as pd

from einschalt.foundations import tables
from einschalt.foundations.arguments import described, require_choice
from einschalt.foundations.batches import segment_min_max, segments
from einschalt.foundations.errors import SettingsError, raise_problems
from einschalt.foundations.frame_columns import values_of
from einschalt.foundations.kept_texts import kept
from einschalt.foundations.names import CodedPairs, encode_pairs
from einschalt.foundations.number_parsing import LARGEST_NUMBER
from einschalt.stages.relative_orientation.dangerous_surface import ModelGeometry
from einschalt.stages.relative_orientation.parallax_orientation import (
    ABOVE,
    COUNT_Z_UP,
    NAME_COVERAGE,
    ModelFaults,
    ParallaxOrientation,
    models_frame,
    places_of_models,
)
from einschalt.stages.relative_orientation.six_point_methods import (
    adjust_by_gruber,
    adjust_by_krames,
    contradiction_table,
    say_six_point_faults,
)
from einschalt.theory.relative_orientation.hallert import adjust_parallaxes
from einschalt.theory.relative_orientation.model_correction import parallaxes_to_clear
from einschalt.theory.relative_orientation.parallax_equations import (
    CASES,
    ELEMENTS,
    N_ELEMENTS,
)

METHODS = ("least_squares", "krames", "gruber")
MODEL_COLUMNS = [
    *("coverage", "model_id", "case", "n_points", "redundancy", "sigma_0", "base"),
    *("is_usable", "reason"),
]
SINGULAR = (
    "its points lie on a line or a dangerous surface, and do not determine the elements"
)
# bases that no flight has, in depths
SHORTEST_BASE, LONGEST_BASE = 1e-3, 1e2
TOO_SHORT = "its base is less than a thousandth of its depth"
TOO_LONG = "its base is more than a hundred times its depth"
SAME_UNIT = "Give the base and the coordinates in one unit"
# of a point below the centres, in depths of the deepest
LEAST_DEPTH = 1e-9
# a length that no model has in any unit
LARGEST_LENGTH = 1e12
NO_LENGTH = "a coordinate or y-parallax is larger than 1e12"
CHECK_POINTS = "Look for slips in its coordinates and y-parallaxes"
MEASURE_ELSEWHERE = (
    "Measure points elsewhere: six in the usual pattern, or higher and lower ones"
)


def orient_from_parallaxes(
    y_parallaxes: pd.DataFrame,
    base: pd.DataFrame | pd.Series | float,
    *,
    case: Literal["independent", "dependent_left", "dependent_right"] = "independent",
    method: Literal["least_squares", "krames", "gruber"] = "least_squares",
) -> ParallaxOrientation:
    """Orient every model by its y-parallaxes.

    The system of a model has its origin in the left projection centre, x along the
    base to the right centre, y across, z up, so that points have z < 0. All lengths
    have any one unit; angles are in radians, right-handed about +x, +y, +z. The
    parameters are *corrections*: what the bundles have yet to be turned and shifted
    for the parallaxes to vanish.

    Parameters
    ----------
    y_parallaxes : DataFrame
        [coverage,] model_id, point_id, x, y, z, y_parallax. **The parallax is y of the
        moved bundle less y of the fixed one**: y_left - y_right for ``independent``
        and ``dependent_left``, but y_right - y_left for ``dependent_right``. Nothing
        is turned here; parallaxes of the other sign give elements of the other sign.
    base : float, Series or DataFrame
        One base for all models; or by model_id; or with the columns [coverage,]
        model_id, base.
    case : {"independent", "dependent_left", "dependent_right"}
        Which bundles move: both turn, or one turns and shifts.
    method : {"least_squares", "krames", "gruber"}
        Hallert's numerical method, from five parallaxes or more with equal weights; or
        Krames' formulas, from three points in each of the planes x = 0 and x = base,
        with the same result; or Gruber's optical-mechanical procedure on six points in
        the usual layout, its tilt over-corrected in point 5. The procedure ends without
        parallaxes in points 1 to 5; its cofactors are Bachmann's for repeated passes
        with fresh readings, and worse than those of least squares.

    Returns
    -------
    ParallaxOrientation
        A model without base, with points that are too few, do not determine the
        elements or do not suit the method, is a row of ``failures``.

    Raises
    ------
    SettingsError
        ``case``, ``method`` or a numeric ``base`` is not allowed.
    TableError
        A column is missing or a value is not what it should be.

    Notes
    -----
    Source: J. Krames 1951; B. Hallert's numerical method; W. K. Bachmann 1947
    (docs/theory/relative_orientation.md).

    Examples
    --------
    Six points of a flat model of which the right bundle must be turned by kappa, so
    that its y-parallaxes grow with the distance from the right centre:

    >>> import pandas as pd
    >>> parallaxes = pd.DataFrame({
    ...     "model_id": "1/2", "point_id": list("123456"), "z": -152.0,
    ...     "x": [0.0, 92.0] * 3, "y": [0.0, 0.0, 95.0, 95.0, -95.0, -95.0],
    ...     "y_parallax": [0.092, 0.0, 0.092, 0.0, 0.092, 0.0]})
    >>> oriented = orient_from_parallaxes(parallaxes, 92.0, case="dependent_right")
    >>> oriented.parameters.loc["1/2"].round(9).abs().tolist()
    [0.0, 0.0, 0.001, 0.0, 0.0]
    """
    require_choice("case", case, CASES)
    require_choice("method", method, METHODS)
    checked = tables.check_table(y_parallaxes, tables.Y_PARALLAXES)
    raise_problems(checked.problems)
    measured = _Measured.of(checked.frame)
    faults = ModelFaults.none(len(measured.models))
    bases = _bases(base, measured, faults)
    _check_points(measured, bases, method, faults)
    sound = measured.only(faults.is_sound)
    adjustment = _adjusted(method, case, sound, bases, faults)
    faults.say(~adjustment.is_determined, SINGULAR, MEASURE_ELSEWHERE)
    models = _models_table(measured, adjustment, faults).assign(base=bases, case=case)
    index = pd.Index(models["model_id"], name="model_id")
    neglected = _linearisation_error(sound, adjustment, bases, case)
    return ParallaxOrientation(
        case=case,
        method=method,
        models=models[MODEL_COLUMNS],
        parameters=pd.DataFrame(adjustment.elements, index, list(ELEMENTS[case])),
        residuals=_residuals_table(sound, adjustment),
        linearisation_error=pd.Series(neglected, index, name="linearisation_error"),
        contradiction=contradiction_table(
            sound.xyz, sound.y_parallax, bases, sound.start, index
        ),
        failures=faults.table(measured.models.names),
        adjustment=adjustment,
        geometry=ModelGeometry(measured.xyz, bases, measured.start),
        has_coverages=measured.has_coverages,
    )


@dataclass(frozen=True, eq=False)
class _Measured:
    """The parallaxes sorted by model; ``order`` are their rows in ``frame``."""

    frame: pd.DataFrame
    models: CodedPairs
    order: np.ndarray
    start: np.ndarray
    has_coverages: bool

    @classmethod
    def of(cls, frame):
        has_coverages = "coverage" in frame.columns
        frame = tables.with_coverage(frame)
        models = encode_pairs(frame["coverage"], frame["model_id"])
        sort = segments(models.codes, len(models))
        return cls(frame, models, sort.order, sort.start, has_coverages)

    def only(self, is_kept):
        """Keep the rows of some models; the others have none, but keep their place."""
        count = np.where(is_kept, self.count, 0)
        order = self.order[np.repeat(is_kept, self.count)]
        return replace(self, order=order, start=np.append(0, np.cumsum(count)))

    @property
    def count(self):
        return np.diff(self.start)

    @cached_property
    def xyz(self):
        return values_of(self.frame, ["x", "y", "z"])[self.order]

    @property
    def y_parallax(self):
        return self.frame["y_parallax"].to_numpy()[self.order]


def _bases(base, measured, faults):
    """Find the base of each model; NaN, and a fault, where there is none."""
    if isinstance(base, pd.Series):
        base = base.rename("base").rename_axis("model_id").reset_index()
    if not isinstance(base, pd.DataFrame):
        return np.full(len(measured.models), _number(base))
    # a model whose base is left empty fails alone
    is_given = base.get("base", pd.Series(index=base.index)).notna()
    known = base[is_given] if is_given.any() else base
    checked = tables.check_table(known, tables.MODEL_BASES, source="base")
    raise_problems(checked.problems)
    wanted = models_frame(measured.models.names)
    if not (measured.has_coverages and "coverage" in checked.frame.columns):
        wanted = wanted.drop(columns="coverage")
    place, is_ambiguous = places_of_models(wanted, checked.frame)
    faults.say(is_ambiguous, "several coverages have its base", NAME_COVERAGE)
    faults.say(place < 0, "its base is missing", "Give its base")
    values = checked.frame["base"].to_numpy()[place]
    return np.where(faults.is_sound, values, np.nan)


def _number(base):
    is_number = isinstance(base, Real) and not isinstance(base, (bool, np.bool_))
    if is_number and 0.0 < base <= LARGEST_NUMBER:
        return float(base)
    raise SettingsError(
        f"base = {described(base)}",
        expected="a positive length, a Series by model_id or a table with the columns "
        "model_id and base",
    )


def _check_points(measured, bases, method, faults):
    deepest, highest = segment_min_max(measured.xyz[:, 2], measured.start)
    faults.say(highest >= LEAST_DEPTH * np.minimum(deepest, 0.0), ABOVE, COUNT_Z_UP)
    _check_lengths(measured, bases, faults)
    is_short = measured.count < N_ELEMENTS
    for count in np.unique(measured.count[is_short]):
        reason = kept("{n:point|points}, but five are needed", n=count)
        faults.say(measured.count == count, reason, "Measure more points in it")
    if method != "least_squares":
        say_six_point_faults(method, measured.xyz, bases, measured.start, faults)


def _check_lengths(measured, bases, faults):
    """Say which models hold lengths that cannot be meant."""
    xyz, parallax = np.abs(measured.xyz), np.abs(measured.y_parallax)
    largest = segment_min_max(np.maximum(xyz.max(axis=1), parallax), measured.start)[1]
    faults.say(largest > LARGEST_LENGTH, NO_LENGTH, CHECK_POINTS)
    depth = segment_min_max(xyz[:, 2], measured.start)[1]
    faults.say(bases < SHORTEST_BASE * depth, TOO_SHORT, SAME_UNIT)
    faults.say(bases > LONGEST_BASE * depth, TOO_LONG, SAME_UNIT)


def _adjusted(method, case, sound, bases, faults):
    measured = (sound.xyz, sound.y_parallax, bases, sound.start)
    if method == "krames":
        return adjust_by_krames(*measured, case=case)
    if method == "gruber":
        return adjust_by_gruber(*measured, case=case, faults=faults)
    return adjust_parallaxes(*measured, case=case)


def _models_table(measured, adjustment, faults):
    return models_frame(measured.models.names).assign(
        n_points=measured.count,
        redundancy=adjustment.redundancy,
        sigma_0=adjustment.sigma_0,
        is_usable=faults.is_sound,
        reason=faults.reasons,
    )


def _residuals_table(sound, adjustment):
    """Rows in the order in which they were given."""
    keys = ["model_id", "point_id"]
    keys = ["coverage", *keys] if sound.has_coverages else keys
    is_used = np.isfinite(adjustment.residuals)
    rows = sound.order[is_used]
    table = sound.frame[keys].iloc[rows]
    table = table.assign(
        residual=adjustment.residuals[is_used],
        redundancy_number=adjustment.redundancy_numbers[is_used],
    )
    return table.iloc[np.argsort(rows)].reset_index(drop=True)


def _linearisation_error(sound, adjustment, bases, case):
    """Largest parallax of each model that the linear equations neglect."""
    elements = np.repeat(adjustment.elements, sound.count, axis=0)
    exact = parallaxes_to_clear(
        sound.xyz, np.repeat(bases, sound.count), elements, case
    )
    linear = sound.y_parallax + adjustment.residuals
    return segment_min_max(np.abs(exact - linear), sound.start)[1]
