"""The adjustment of everything against dense least squares of the same equations."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import sparse

from einschalt.theory.block_adjustment.control_information import (
    ControlValues,
    ModelValues,
    control_checks,
)

N_POINTS = 14
CONTROL = np.array([0, 3, 7, 11, 13])


def flight(seed, n_models, kind):
    """Overlapping models of nine neighbouring points each, with errors of 0.05."""
    rng = np.random.default_rng(seed)
    first = np.linspace(0, N_POINTS - 10, n_models).astype(int)  # the last is in none
    point = (first[:, None] + np.arange(9)).ravel()
    model = np.repeat(np.arange(n_models), 9)
    xy = rng.uniform(-1.0, 1.0, (len(point), 2))
    one = np.ones(len(point))
    design = {
        "affine": np.column_stack([one, xy]),
        "helmert": np.column_stack([one, xy @ np.array([1.0, 1j])]),
    }[kind]
    value = 1e3 * point + rng.normal(0.0, 0.05, (len(point), 2)) @ np.array([1.0, 1j])
    weight = rng.uniform(0.5, 2.0, len(point)) * 400.0
    nothing = np.zeros((len(point), 0))
    return ModelValues(design, model, point, value, weight, nothing, nothing)


def dense(flights, control):
    """Scores and information from one large system, models first, then points."""
    n_bent = flights[0].bent.shape[1]
    flights = [replace(f, design=np.hstack([f.design, f.bent])) for f in flights]
    n_each = [f.design.shape[1] * (1 + f.model.max()) for f in flights]
    n_parameters = sum(n_each)
    n_points = N_POINTS + sum(f.common.shape[1] for f in flights)
    first_common = n_parameters + N_POINTS
    rows, right, weight = [], [], []
    before = 0
    for f, n in zip(flights, n_each, strict=True):
        k = f.design.shape[1]
        for d, c, m, p, v, w in zip(
            *(f.design, f.common, f.model, f.point, f.value, f.weight), strict=True
        ):
            row = np.zeros(n_parameters + n_points, dtype=complex)
            row[before + m * k : before + (m + 1) * k] = d
            row[n_parameters + p] = -1.0
            row[first_common : first_common + len(c)] = c
            rows.append(row)
            right.append(-v)
            weight.append(w)
        # what bends a model is observed as 0, with variance 1
        for column in range(before, before + n):
            if (column - before) % k >= k - n_bent:
                rows.append(np.eye(n_parameters + n_points, dtype=complex)[column])
                right.append(0.0)
                weight.append(1.0)
        before += n
        first_common += f.common.shape[1]
    for p, v, w in zip(control.point, control.value, control.weight, strict=True):
        row = np.zeros(n_parameters + n_points, dtype=complex)
        row[n_parameters + p] = 1.0
        rows.append(row)
        right.append(v)
        weight.append(w)
    root = np.sqrt(np.array(weight))[:, None]
    a, b = root * np.array(rows), root[:, 0] * np.array(right)
    normal = a.conj().T @ a
    cofactors = np.linalg.pinv(normal, hermitian=True, rcond=1e-13)
    adjusted = cofactors @ (a.conj().T @ b)
    places = n_parameters + control.point
    scores = control.weight * (control.value - adjusted[places])
    q = cofactors[np.ix_(places, places)]
    information = np.diag(control.weight) - control.weight[:, None] * q * control.weight
    return scores, information.real


@pytest.mark.parametrize(
    "kinds", [("affine", "affine"), ("helmert", "affine"), ("helmert", "helmert")]
)
def test_scores_and_information_are_those_of_the_dense_system(kinds):
    flights = [flight(1, 4, kinds[0]), flight(2, 7, kinds[1])]
    rng = np.random.default_rng(3)
    value = 1e3 * CONTROL + rng.normal(0.0, 0.05, (5, 2)) @ np.array([1.0, 1j])
    control = ControlValues(CONTROL, value, rng.uniform(0.5, 2.0, 5) * 800.0)
    check(flights, control)


@pytest.mark.parametrize("kind", ["affine", "helmert"])
def test_the_same_without_writing_the_information_out(kind):
    flights = [flight(1, 4, kind), flight(2, 7, kind)]
    rng = np.random.default_rng(3)
    value = 1e3 * CONTROL + rng.normal(0.0, 0.05, (5, 2)) @ np.array([1.0, 1j])
    control = ControlValues(CONTROL, value, rng.uniform(0.5, 2.0, 5) * 800.0)
    checks = control_checks(flights, control)
    scores, information = checks.written_out()
    scale = np.abs(information).max()
    np.testing.assert_allclose(checks.scores, scores, atol=1e-9 * np.abs(scores).max())
    for columns in (np.eye(5), sparse.eye_array(5, format="csc")):
        np.testing.assert_allclose(
            checks.times(columns).real, information, atol=1e-9 * scale
        )
    drawn = checks.draw(20_000, seed=1)
    n_parts = 2 if np.iscomplexobj(drawn) else 1
    shown = np.real(drawn @ drawn.conj().T) / drawn.shape[1] / n_parts
    np.testing.assert_allclose(shown, information, atol=0.05 * scale)
    turned = checks.times(1j * np.eye(5))
    np.testing.assert_allclose(turned.imag, information, atol=1e-9 * scale)


def test_models_that_are_bent_tell_less_of_control():
    """Against the same columns with weighted zeros beside them."""
    flights = [flight(1, 4, "helmert"), flight(2, 7, "helmert")]
    rng = np.random.default_rng(5)
    bends = 0.2 * rng.standard_normal((len(flights[1].point), 2)) + 0j
    straight = np.zeros((len(flights[0].point), 2), dtype=complex)
    flights = [
        replace(part, bent=bent)
        for part, bent in zip(flights, (straight, bends), strict=True)
    ]
    value = 1e3 * CONTROL + rng.normal(0.0, 0.05, (5, 2)) @ np.array([1.0, 1j])
    control = ControlValues(CONTROL, value, np.full(5, 600.0))
    check(flights, control)


@pytest.mark.parametrize(
    "kinds", [("affine", "affine"), ("helmert", "affine"), ("helmert", "helmert")]
)
def test_terms_that_models_share_may_have_any_size(kinds):
    """Against the same columns as unknowns of each flight."""
    rng = np.random.default_rng(8)
    flights = [flight(1, 4, kinds[0]), flight(2, 7, kinds[1])]
    flights = [
        replace(part, common=rng.standard_normal((len(part.point), n)) * (0.3 + 0.1j))
        for part, n in zip(flights, (2, 1), strict=True)
    ]
    value = 1e3 * CONTROL + rng.normal(0.0, 0.05, (5, 2)) @ np.array([1.0, 1j])
    control = ControlValues(CONTROL, value, np.full(5, 600.0))
    check(flights, control, frees_terms=True)
    scores, information = _freed(control_checks(flights, control))
    # whatever the models are displaced by such terms, control is told the same
    moved = [
        replace(part, value=part.value + part.common @ (3.0 + np.arange(n) * 2j))
        for part, n in zip(flights, (2, 1), strict=True)
    ]
    checks = control_checks(moved, control)
    moved_scores, moved_information = _freed(checks)
    largest = np.abs(scores).max()
    np.testing.assert_allclose(moved_scores, scores, atol=1e-6 * largest)
    np.testing.assert_allclose(moved_information, information)
    # and less than without them
    more = control_checks(flights, control).written_out()[1] - information
    assert np.linalg.eigvalsh(more)[0] > -1e-6 * np.trace(information)
    assert np.trace(more) > 1e-3 * np.trace(information)


def _freed(checks):
    return checks.written_out(checks.common)


def check(flights, control, *, frees_terms=False):
    checks = control_checks(flights, control)
    scores, information = _freed(checks) if frees_terms else checks.written_out()
    expected_scores, expected = dense(flights, control)
    scale = np.abs(expected).max()
    np.testing.assert_allclose(information, expected, atol=1e-5 * scale)
    size = np.abs(expected_scores).max()
    np.testing.assert_allclose(scores, expected_scores, atol=1e-4 * size)
    # the last control point lies in no model: nothing checks it
    assert scores[-1] == 0.0
    np.testing.assert_allclose(information[-1], 0.0, atol=1e-9 * scale)


@pytest.mark.parametrize("kind", ["affine", "helmert"])
def test_what_moves_everything_alike_is_no_check(kind):
    """Also where models have many strong points for each control point."""
    strong = flight(5, 5, kind)
    strong = replace(strong, weight=1e3 * strong.weight)
    shifted = ControlValues(CONTROL[:4], 1e3 * CONTROL[:4] + 7.0, np.full(4, 400.0))
    scores, information = control_checks([strong], shifted).written_out()
    alike = np.ones(4)
    assert abs(alike @ information @ alike) < 1e-9 * np.trace(information)
    assert abs(alike @ scores) < 1e-6 * np.abs(scores).max()
    assert np.trace(information) > 1.0
