"""Gruber's optical-mechanical procedure: turn one element after another.

An operator reads the y-parallax in one point (or the mean of several) and turns one
element until it vanishes, then goes to the next. One :class:`Step` is one such turn; a
:class:`Procedure` is their sequence, a *pass*, that is repeated. Swings and tips have
points 1 to 4 to themselves; the tilt is turned by the parallax of a wing point, and by
more than what clears it there, since the following turns bring a part of it back: it is
over-corrected n times. Every step reads afresh, with a fresh error; what follows from
that is Bachmann's theory, in :mod:`~.relative_orientation.bachmann`.

Points are numbered from 1, as an operator does: point k is row k - 1 of the design
matrix; :mod:`~.relative_orientation.six_points` has the usual layout. Conventions,
cases and signs are those of :mod:`~.relative_orientation.parallax_equations`.

Source: O. von Gruber 1924, as W. K. Bachmann 1947 refers to it. The order of the turns
(swing, swing, tip, tip, and the tilt over-corrected) is that of the text-books.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from einschalt.foundations.arguments import require_choice
from einschalt.foundations.errors import SettingsError
from einschalt.theory.relative_orientation.parallax_equations import (
    CASES,
    DEPENDENT_LEFT,
    DEPENDENT_RIGHT,
    ELEMENTS,
    INDEPENDENT,
    N_ELEMENTS,
)

TILT_POINTS = {"5": {5: 1.0}, "6": {6: 1.0}, "mean": {5: 0.5, 6: 0.5}}
"""Where the tilt is read: in one wing, or in both."""
_ELIMINATION = {
    INDEPENDENT: (("d_kappa_2", 1), ("d_kappa_1", 2), ("d_phi_2", 3), ("d_phi_1", 4)),
    DEPENDENT_RIGHT: (("d_by", 2), ("d_kappa", 1), ("d_bz", 4), ("d_phi", 3)),
    DEPENDENT_LEFT: (("d_by", 1), ("d_kappa", 2), ("d_bz", 3), ("d_phi", 4)),
}


@dataclass(frozen=True, eq=False)
class Step:
    """One turn: read a parallax, and turn one element by what clears it, n times.

    Raises
    ------
    SettingsError
        Nothing is observed.
    """

    element: str  # one of ``ELEMENTS[case]``
    # point number, from 1, and its weight in what is read; the mean of points 5 and 6
    # is ``{5: 0.5, 6: 0.5}``
    observed: Mapping[int, float]
    # number or (...): n, total: 1 clears the parallax, 1.78 drives it to -0.78 times
    # itself. One number, or one for each model.
    over_correction: float | np.ndarray = 1.0

    def __post_init__(self):
        if not any(self.observed.values()):
            raise SettingsError(
                f"the step that turns {self.element} observes no point",
                expected="a point number and its weight, such as {5: 1.0}",
            )


@dataclass(frozen=True, eq=False)
class Procedure:
    """A pass of steps, which is repeated, and what is done once before it.

    Raises
    ------
    SettingsError
        The case is unknown, a step turns an element that the case does not have, or
        there are no steps.
    """

    case: str  # {"independent", "dependent_left", "dependent_right"}
    # one pass, in the order of working. The orientation is read at its end.
    steps: tuple[Step, ...]
    start: tuple[Step, ...] = ()  # done once, before the first pass

    def __post_init__(self):
        require_choice("case", self.case, CASES)
        if not self.steps:
            raise SettingsError("a procedure without steps", expected="at least one")
        for name in ("steps", "start"):
            object.__setattr__(self, name, tuple(getattr(self, name)))
        for step in (*self.start, *self.steps):
            if step.element not in ELEMENTS[self.case]:
                raise SettingsError(
                    f"{self.case} has no element {step.element!r}",
                    expected=" or ".join(ELEMENTS[self.case]),
                )

    def column(self, step):
        """Column of the design matrix that a step turns, int."""
        return ELEMENTS[self.case].index(step.element)


def elimination(case):
    """Steps that clear points 1 to 4 by swings and tips, or by the shifts.

    Each clears its own point; in flat terrain none disturbs those before it.
    """
    return tuple(Step(element, {point: 1.0}) for element, point in _ELIMINATION[case])


def standard_procedure(design, case, *, tilt_at="5", rel=1.0) -> Procedure:
    """Gruber's procedure for six points, with the over-correction of their model.

    Points 1 to 4 are cleared once. A pass turns the tilt, over-corrected, and clears
    points 1 to 4 again.

    Parameters
    ----------
    design : ndarray, shape (..., 6, 5)
        Coefficients of the parallaxes in points 1 to 6.
    case : {"independent", "dependent_left", "dependent_right"}
    tilt_at : {"5", "6", "mean"}
        Where the tilt is read: in one wing, or as the mean of both.
    rel : float or ndarray, shape (...)
        Multiplier of the exact over-correction: 1 clears a model that is free of
        errors in one pass, below 1 is cautious, above 1 exaggerates.

    Raises
    ------
    SettingsError
        ``tilt_at`` is unknown.

    Examples
    --------
    >>> from einschalt.theory.relative_orientation.hallert import flat_six_points
    >>> from einschalt.theory.relative_orientation.parallax_equations import (
    ...     design_matrix)
    >>> from einschalt.theory.relative_orientation.six_points import FROM_1_TO_6
    >>> xyz = flat_six_points(95.0, 92.0, 152.0)[FROM_1_TO_6]
    >>> design = design_matrix(xyz, 92.0, "independent")
    >>> procedure = standard_procedure(design, "independent")
    >>> [step.element for step in procedure.steps]
    ['d_omega', 'd_kappa_2', 'd_kappa_1', 'd_phi_2', 'd_phi_1']
    >>> round(float(procedure.steps[0].over_correction), 12)
    1.78
    """
    n = rel * over_correction(design, case, tilt_at=tilt_at)
    tilt = Step("d_omega", TILT_POINTS[tilt_at], n)
    clear = elimination(case)
    return Procedure(case, (tilt, *clear), start=clear)


def over_correction(design, case, *, tilt_at="5"):
    """Over-correction n with which one pass clears a model that is free of errors.

    While points 1 to 4 are clear, what the orientation still lacks is one number times
    the one vector that leaves no parallax there. n, of shape (...), compares its tilt
    with the turn that its parallax in the wings seems to ask for; ``design`` and
    ``tilt_at`` are those of :func:`standard_procedure`. Kasper's extra over-correction,
    by which the parallax is driven to -k times itself, is k = n - 1.

    (1 + h²/a²)/2 in flat terrain: below 1 where the height is less than the distance of
    the wings (super-wide angles). It grows without bounds, and then changes its sign,
    as the points approach a circle with the projection centre. NaN where points 1 to 4
    do not determine the other elements.

    Raises
    ------
    SettingsError
        ``tilt_at`` is unknown.
    """
    require_choice("tilt_at", tilt_at, TILT_POINTS)
    design = np.asarray(design, dtype=float)
    cleared = [point - 1 for _, point in _ELIMINATION[case]]
    others = _solve(design[..., cleared, 1:], -design[..., cleared, 0])
    wing = reading(design, TILT_POINTS[tilt_at])
    seen = wing[..., 0] + np.sum(wing[..., 1:] * others, axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        return wing[..., 0] / seen


def _solve(matrix, right):
    """Solve all systems; NaN where one is singular, which stops numpy's own."""
    # rows of one length: their determinant is then a volume without unit
    length = np.sqrt(np.sum(matrix**2, axis=-1, keepdims=True))
    with np.errstate(divide="ignore", invalid="ignore"):
        matrix, right = matrix / length, right / length[..., 0]
        volume = np.abs(np.linalg.det(matrix))
    is_regular = volume > 1e-14
    matrix = np.where(is_regular[..., None, None], matrix, np.eye(matrix.shape[-1]))
    right = np.where(is_regular[..., None], right, np.nan)
    return np.linalg.solve(matrix, right[..., None])[..., 0]


def reading(values, observed):
    """Combine the points that a step observes, (..., n_columns).

    ``values`` (..., n_points, n_columns) are rows of the design matrix, or parallaxes;
    ``observed`` maps a point number, from 1, to its weight.

    Raises
    ------
    SettingsError
        A point number is not among those of the rows.
    """
    n_points = values.shape[-2]
    for point in observed:
        if not 1 <= point <= n_points:
            raise SettingsError(
                f"a step observes point {point!r}", expected=f"1 to {n_points}"
            )
    return sum(weight * values[..., k - 1, :] for k, weight in observed.items())


@dataclass(frozen=True, eq=False)
class ProcedureRecord:
    """What a procedure has turned, pass by pass."""

    # (n_passes + 1, ..., 5): sum of all turns so far [rad, unit of the model], after
    # the start (entry 0) and after each pass. At the end of a good orientation they are
    # the elements.
    elements: np.ndarray
    # (n_passes + 1, ..., n_points): what the model then shows, if read without error
    residual_parallaxes: np.ndarray


def run_procedure(
    procedure, design, parallax, n_passes, *, sigma=0.0, rng=None
) -> ProcedureRecord:
    """Carry out a procedure on measured, or on simulated, parallaxes.

    Without ``sigma`` it is what the procedure makes of these parallaxes, read again and
    again through the model without any new error: ``p - A·elements``. With ``sigma``
    every reading of every point has an error of its own, as on the instrument; the
    parallaxes given are then those of the model without errors.

    Parameters
    ----------
    procedure : Procedure
    design : ndarray, shape (..., n_points, 5)
        Coefficients of the parallaxes, for one model or many.
    parallax : ndarray, shape (..., n_points)
        Before the start; the leading axes, with those of the design, are models or
        runs of a simulation.
    n_passes : int
    sigma : float, optional
        Standard error of one reading of one point, in the unit of the parallaxes.
    rng : numpy.random.Generator, optional
        Needed with ``sigma``.

    Raises
    ------
    SettingsError
        ``sigma`` without ``rng``, or a step observes a point that does not exist.
    """
    if sigma and rng is None:
        raise SettingsError(
            "sigma without rng", expected="rng=np.random.default_rng(seed)"
        )
    design, parallax = np.asarray(design, float), np.asarray(parallax, float)
    shape = np.broadcast_shapes(design.shape[:-2], parallax.shape[:-1])
    elements = np.zeros((n_passes + 1, *shape, N_ELEMENTS))
    seen = np.empty((n_passes + 1, *shape, design.shape[-2]))
    turned = np.zeros((*shape, N_ELEMENTS))
    residual = np.zeros(seen.shape[1:]) + parallax
    for number in range(n_passes + 1):
        for step in procedure.steps if number else procedure.start:
            error = _error_of_reading(step, sigma, rng, shape)
            column = procedure.column(step)
            turn = _turn(step, design, residual, column, error)
            turned[..., column] += turn
            residual -= design[..., column] * turn[..., None]
        elements[number], seen[number] = turned, residual
    return ProcedureRecord(elements, seen)


def _error_of_reading(step, sigma, rng, shape):
    if not sigma:
        return 0.0
    weights = np.array(list(step.observed.values()))
    return sigma * np.sqrt(np.sum(weights**2)) * rng.standard_normal(shape)


def _turn(step, design, residual, column, error):
    observed = reading(residual[..., None], step.observed)[..., 0] + error
    sensitivity = reading(design, step.observed)[..., column]
    with np.errstate(divide="ignore", invalid="ignore"):
        return step.over_correction * observed / sensitivity
