"""Control is chosen so that every model has it, and neighbours share it."""

import numpy as np
import pytest

from einschalt.theory.planning.control_choice import serving_points

PLACES = 0.75 * np.array([[0, 0], [-1, -1], [1, -1], [1, 1], [-1, 1.0]])
HALF = np.array([300.0, 500.0])
NEAR = 0.35


def _block(n_models=12, n_points=600, seed=1):
    rng = np.random.default_rng(seed)
    centre = np.column_stack([np.arange(n_models) * 240.0, np.zeros(n_models)])
    position = rng.uniform([-300, -500], [centre[-1, 0] + 300, 500], (n_points, 2))
    away = (position[None] - centre[:, None]) / HALF
    model, point = np.nonzero((abs(away) <= 1.0).all(axis=2))
    start = np.searchsorted(model, np.arange(n_models + 1))
    return point, start, position, centre


def _slowly(point, start, position, centre, near):
    """The same choice as a table of distances for each model."""
    is_chosen = np.zeros(len(position), dtype=bool)
    for model in range(len(centre)):
        held = point[start[model] : start[model + 1]]
        away = (position[held] - centre[model]) / HALF
        distance = abs(away[:, None] - PLACES).max(axis=2)
        for place in range(len(PLACES)):
            reach = distance[:, place]
            allowed = max(near, reach.min() + near)
            old = np.flatnonzero(is_chosen[held] & (reach <= allowed))
            one = old[reach[old].argmin()] if len(old) else reach.argmin()
            distance[one] = np.inf
            is_chosen[held[one]] = True
    return is_chosen


@pytest.mark.slow
@pytest.mark.parametrize("near", [0.0, NEAR, 0.7])
def test_the_choice_is_that_of_a_table_of_distances(near):
    point, start, position, centre = _block()
    chosen = np.zeros(len(position), dtype=bool)
    serving_points(point, start, position, centre, HALF, PLACES, chosen, near)
    assert (chosen == _slowly(point, start, position, centre, near)).all()


def test_every_model_has_its_places_and_neighbours_share_them():
    point, start, position, centre = _block()
    chosen = np.zeros(len(position), dtype=bool)
    serving_points(point, start, position, centre, HALF, PLACES, chosen, NEAR)
    for model in range(len(centre)):
        held = point[start[model] : start[model + 1]]
        away = (position[held[chosen[held]]] - centre[model]) / HALF
        reach = abs(away[:, None] - PLACES).max(axis=2).min(axis=0)
        # in 600 points over twelve models there is one near every place
        assert (reach <= 2 * NEAR).all()
    # alone each would have five of its own
    assert chosen.sum() < 0.75 * len(PLACES) * len(centre)


def test_models_of_fewer_points_than_places_want_none():
    position = np.zeros((4, 2))
    chosen = np.zeros(4, dtype=bool)
    given = np.arange(4), np.array([0, 4]), position, np.zeros((1, 2))
    serving_points(*given, HALF, PLACES, chosen, NEAR)
    assert not chosen.any()


def test_points_that_are_chosen_before_serve():
    point, start, position, centre = _block(n_models=1)
    first = np.zeros(len(position), dtype=bool)
    serving_points(point, start, position, centre, HALF, PLACES, first, NEAR)
    again = first.copy()
    serving_points(point, start, position, centre, HALF, PLACES, again, NEAR)
    assert first.sum() == len(PLACES)
    assert (again == first).all()
