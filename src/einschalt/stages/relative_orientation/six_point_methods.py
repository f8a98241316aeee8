"""Stage 2 by the methods that know six points: Krames' formulas, Gruber's procedure.

Both are told which point is which by where it lies. Krames needs three points in each
of the planes x = 0 and x = base; Gruber's procedure needs three on either side.
"""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from einschalt.foundations import typesetting
from einschalt.foundations.language import Amount
from einschalt.theory.relative_orientation.bachmann import (
    pass_matrices,
    stationary_covariance,
)
from einschalt.theory.relative_orientation.gruber import standard_procedure
from einschalt.theory.relative_orientation.hallert import (
    ParallaxAdjustment,
    adjust_parallaxes,
)
from einschalt.theory.relative_orientation.krames import (
    contradiction,
    fundamental_points,
    plane_determinants,
    solve_krames,
)
from einschalt.theory.relative_orientation.parallax_equations import (
    N_ELEMENTS,
    design_matrix,
)
from einschalt.theory.relative_orientation.six_points import (
    FROM_1_TO_6,
    N_SIX,
    are_in_base_normal_planes,
    are_on_two_sides,
    number_six_points,
)

TILT_AT = "5"
"""Gruber's procedure turns the tilt by the parallax of this point."""
TAKE_LEAST_SQUARES = 'Use method="least_squares"'
NOT_SIX = "{points:point|points}, but {method} takes six"
NOT_IN_PLANES = "not three of its points lie in each of the planes x = 0 and x = base"
NOT_ON_SIDES = "not three of its points lie on the side of each projection centre"
DIVERGES = (
    "its points make Gruber's procedure diverge: a pass multiplies errors by {factor}"
)
SIX_POINT_METHODS = {
    "krames": ("Krames' construction", are_in_base_normal_planes, NOT_IN_PLANES),
    "gruber": ("Gruber's procedure", are_on_two_sides, NOT_ON_SIDES),
}
CONTRADICTION_COLUMNS = [
    *("w", "d_omega_0", "d_omega_b", "delta_omega"),
    *("Y_0", "Z_0", "Y_b", "Z_b", "M_0", "M_b", "N_0", "N_b"),
]


@dataclass(frozen=True, eq=False)
class SixPointModels:
    """The models with six points, these as points 1, 3, 5, 2, 4, 6."""

    models: np.ndarray  # (n_six,): their places among all models
    # (n_six, 6): rows of their points in the tables that are sorted by model
    rows: np.ndarray
    xyz: np.ndarray  # (n_six, 6, 3)
    base: np.ndarray  # (n_six,)

    @classmethod
    def of(cls, xyz, base, model_start):
        """Find the models with six points, and number these.

        ``xyz`` (n_points, 3) is sorted by model, as everywhere here.
        """
        models = np.flatnonzero(np.diff(model_start) == N_SIX)
        rows = model_start[models, np.newaxis] + np.arange(N_SIX)
        order = number_six_points(xyz[rows])
        rows = np.take_along_axis(rows, order, axis=1)
        return cls(models, rows, xyz[rows], base[models])

    def only(self, is_kept):
        """Keep some of these models; ``is_kept`` has the shape (n_six,)."""
        return type(self)(*(each[is_kept] for each in vars(self).values()))


def say_six_point_faults(method, xyz, base, model_start, faults):
    """Say which models do not have the six points of a method."""
    title, fit_in, reason = SIX_POINT_METHODS[method]
    n_points = np.diff(model_start)
    for count in np.unique(n_points[n_points != N_SIX]):
        not_six = NOT_SIX.format(points=Amount(count), method=title)
        remedy = TAKE_LEAST_SQUARES if count >= N_ELEMENTS else "Measure more points"
        faults.say(n_points == count, not_six, remedy)
    six = SixPointModels.of(xyz, base, model_start)
    is_off = _of_all(~fit_in(six.xyz, six.base), six.models, len(base))
    faults.say(is_off, reason, TAKE_LEAST_SQUARES)


def _of_all(is_it, models, n_models):
    found = np.zeros(n_models, dtype=bool)
    found[models] = is_it
    return found


def adjust_by_krames(xyz, y_parallax, base, model_start, *, case) -> ParallaxAdjustment:
    """Orient six-point models by Krames' formulas.

    Arguments as in Hallert's :func:`adjust_parallaxes`; models have six points in the
    two planes, or none at all.
    """
    six = SixPointModels.of(xyz, base, model_start)
    solution = solve_krames(six.xyz, y_parallax[six.rows], six.base, case)
    n_models = len(base)
    return ParallaxAdjustment(
        elements=_scattered(solution.elements, six.models, n_models),
        cofactor=_scattered(solution.cofactor, six.models, n_models),
        sigma_0=_scattered(solution.sigma_0, six.models, n_models),
        residuals=_scattered(solution.residuals, six.rows, len(xyz)),
        redundancy_numbers=_scattered(solution.redundancy_numbers, six.rows, len(xyz)),
        n_points=np.diff(model_start),
        condition=_scattered(solution.condition, six.models, n_models, fill=np.inf),
    )


def _scattered(values, places, n_places, fill=np.nan):
    scattered = np.full((n_places, *values.shape[places.ndim :]), fill)
    scattered[places] = values
    return scattered


def adjust_by_gruber(xyz, y_parallax, base, model_start, *, case, faults):
    """Orient six-point models as Gruber's procedure leaves them.

    The elements are those with which the procedure comes to rest on the measured
    parallaxes. An operator does not read the same parallaxes twice, therefore the
    cofactors are Bachmann's, of a procedure that reads afresh at every step. sigma_0,
    of one reading, comes from the contradiction of the six parallaxes, and is that of
    least squares; the residuals are those of the elements.

    Arguments as in Hallert's :func:`adjust_parallaxes`; models have six points on two
    sides, or none at all. ``faults`` takes the models for which the procedure diverges.
    """
    adjustment = adjust_parallaxes(xyz, y_parallax, base, model_start, case=case)
    six = SixPointModels.of(xyz, base, model_start)
    six = six.only(adjustment.is_determined[six.models])
    rows = six.rows[:, FROM_1_TO_6]
    design = _designs(six, case)
    procedure = standard_procedure(design, case, tilt_at=TILT_AT)
    one_pass = pass_matrices(procedure, design)
    _say_diverging(one_pass, six.models, faults)
    solution = one_pass.solution(N_SIX)
    elements = np.einsum("mij,mj->mi", solution, y_parallax[rows])
    hat = design @ solution
    misclosure = y_parallax[rows] - np.einsum("mij,mj->mi", hat, y_parallax[rows])
    redundancy = np.clip(1.0 - np.einsum("mii->mi", hat), 0.0, 1.0)
    is_good = _of_all(~one_pass.diverges, six.models, len(base))
    covariance = stationary_covariance(one_pass)
    return replace(
        adjustment,
        elements=_scattered(elements, six.models, len(base)),
        cofactor=_scattered(covariance, six.models, len(base)),
        sigma_0=np.where(is_good, adjustment.sigma_0, np.nan),
        residuals=_scattered(-misclosure, rows, len(xyz)),
        redundancy_numbers=_scattered(redundancy, rows, len(xyz)),
        condition=np.where(is_good, adjustment.condition, np.inf),
    )


def _designs(six, case):
    """Coefficients of the parallaxes in points 1 to 6, (n_six, 6, 5)."""
    xyz = six.xyz[:, FROM_1_TO_6].reshape(-1, 3)
    design = design_matrix(xyz, np.repeat(six.base, N_SIX), case)
    return design.reshape(-1, N_SIX, N_ELEMENTS)


def _say_diverging(one_pass, models, faults):
    reasons = np.full(len(faults.reasons), "", dtype=object)
    bad = np.flatnonzero(one_pass.diverges)
    factors = [typesetting.number(one_pass.spectral_radius[place], 3) for place in bad]
    reasons[models[bad]] = [DIVERGES.format(factor=factor) for factor in factors]
    faults.say(reasons != "", reasons, TAKE_LEAST_SQUARES)


def contradiction_table(xyz, y_parallax, base, model_start, index) -> pd.DataFrame:
    """What each base-normal plane says by itself, and how far the two disagree.

    Arguments as in Hallert's :func:`adjust_parallaxes`. NaN for models that do not have
    three points in each of the two planes.
    """
    six = SixPointModels.of(xyz, base, model_start)
    six = six.only(are_in_base_normal_planes(six.xyz, six.base))
    parallax = y_parallax[six.rows]
    planes = plane_determinants(six.xyz)
    own = fundamental_points(planes, parallax)
    columns = [
        *(contradiction(planes, parallax), *own.d_omega.T, own.delta_omega),
        *(own.Y[:, 0], own.Z[:, 0], own.Y[:, 1], own.Z[:, 1], *own.M.T, *planes.N.T),
    ]
    values = _scattered(np.column_stack(columns), six.models, len(base))
    return pd.DataFrame(values, index, CONTRADICTION_COLUMNS)
