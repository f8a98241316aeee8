"""Solvers and seeded models for the tests of all kinds of transformation."""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pytest

from einschalt.foundations.rotations import rotation_from_angles
from einschalt.theory.transformation import affine, helmert, helmert_3d, rigid


@dataclass(frozen=True)
class Solver:
    """One kind of transformation, and what the tests must know of it."""

    kind: str
    fit: Callable
    cofactors: Callable
    least: int
    n_parameters: int
    size: int
    formula: Callable

    def __repr__(self):
        return self.kind


@dataclass(frozen=True)
class Models:
    """Observations of several models, sorted by model."""

    source: np.ndarray
    target: np.ndarray
    weights: np.ndarray
    start: np.ndarray

    def __iter__(self):
        return iter((self.source, self.target, self.weights, self.start))

    def rows(self, model):
        return slice(self.start[model], self.start[model + 1])

    def single(self, model):
        """The same observations of one model alone."""
        rows = self.rows(model)
        count = np.array([0, self.start[model + 1] - self.start[model]])
        return Models(self.source[rows], self.target[rows], self.weights[rows], count)


def affine_formula(p, xy):
    a0, a1, a2, b0, b1, b2 = p
    x, y = xy.T
    return np.column_stack([a0 + a1 * x + a2 * y, b0 + b1 * x + b2 * y])


def helmert_formula(p, xy):
    a, b, te, tn = p
    x, y = xy.T
    return np.column_stack([a * x - b * y + te, b * x + a * y + tn])


def rigid_formula(p, xy):
    return helmert_formula([np.cos(p[0]), np.sin(p[0]), p[1], p[2]], xy)


def helmert_3d_formula(p, xyz):
    # right-handed R_x R_y R_z is the transpose of the matrix of the camera
    return p[:3] + p[3] * xyz @ rotation_from_angles(*p[4:])


SOLVERS = (
    Solver(
        "affine", affine.fit_affine, affine.affine_cofactors, 3, 6, 2, affine_formula
    ),
    Solver(
        "helmert",
        helmert.fit_helmert,
        helmert.helmert_cofactors,
        2,
        4,
        2,
        helmert_formula,
    ),
    Solver("rigid", rigid.fit_rigid, rigid.rigid_cofactors, 2, 3, 2, rigid_formula),
    Solver(
        "helmert_3d",
        helmert_3d.fit_helmert_3d,
        helmert_3d.helmert_3d_cofactors,
        3,
        7,
        3,
        helmert_3d_formula,
    ),
)


@pytest.fixture(params=SOLVERS, ids=repr, scope="session")
def solver(request):
    """Every kind in turn."""
    return request.param


@pytest.fixture(params=SOLVERS[:3], ids=repr, scope="session")
def plane_solver(request):
    """The three kinds of a plane in turn."""
    return request.param


@pytest.fixture(scope="session")
def solver_named():
    """A kind by its name."""
    return {solver.kind: solver for solver in SOLVERS}.__getitem__


def similarity(rng, size):
    """A rotation by any angle, near the identity in ω and φ in space."""
    omega, phi = rng.normal(0.0, 0.1, 2) if size == 3 else (0.0, 0.0)
    return rotation_from_angles(omega, phi, rng.uniform(-np.pi, np.pi)).T[:size, :size]


@pytest.fixture(scope="session")
def make_models():
    """Maker of seeded models: 1:8000, 0.9 km, coordinates of 5·10⁶ m."""

    def make(solver, counts, *, seed=0, noise=0.05):
        rng = np.random.default_rng(seed)
        start = np.concatenate([[0], np.cumsum(counts)])
        n_points, size = int(start[-1]), solver.size
        source = rng.uniform(-450.0, 450.0, (n_points, size))
        source[:, 2:] *= 0.1
        scale = 1.0 if solver.kind == "rigid" else 2.5
        origin = np.array([4.5e6, 5.3e6, 500.0])[:size]
        target = np.empty_like(source)
        for first, last in pairwise(start.tolist()):
            shift = origin + rng.uniform(-1e4, 1e4, size)
            turned = source[first:last] @ (scale * similarity(rng, size)).T
            target[first:last] = turned + shift
        target += rng.normal(0.0, noise, target.shape) if noise else 0.0
        return Models(source, target, rng.uniform(0.5, 2.0, n_points), start)

    return make


@pytest.fixture(scope="session")
def filled_rectangle():
    """230 × 160 mm, filled evenly and densely, with its special points."""
    x, y = np.meshgrid(np.linspace(-115, 115, 301), np.linspace(-80, 80, 301))
    points = np.column_stack([x.ravel(), y.ravel()])
    special = np.array([[0.0, 0.0], [115.0, 0.0], [0.0, 80.0], [115.0, 80.0]])
    return points, special
