"""Kinds of blunders: what goes wrong between field book and computer.

Each takes a clean simulated block and a generator of random numbers, which draws size
and place, and gives the block as it would come in.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from tests.given_approximations import onto_given_approximations

PLAN, HEIGHT = ("easting", "northing"), ("height",)
FEET = 0.3048
# what a kind needs of a block to be possible
ANY, SPATIAL, IMAGES, MACHINE, PLANE = "any", "spatial", "images", "machine", "plane"


@dataclass(frozen=True)
class Kind:
    """A kind of blunder."""

    name: str
    spoil: Callable  # of a block and random numbers
    needs: str = ANY
    # whether measurements can show it at all
    can_show: bool = True


def size(rng, low=0.1, high=1000.0):
    """A size of any order of magnitude between two."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


# control points


def _with_control(block, **columns):
    return replace(block, control_points=block.control_points.assign(**columns))


def _places(block, role="control"):
    return np.flatnonzero((block.control_points["role"] == role).to_numpy())


def _moved(block, rows, offsets, axes):
    """Move rows of given points by offsets, (n_rows, n_axes)."""
    values = block.control_points[list(axes)].to_numpy(dtype=float).copy()
    values[rows] += offsets
    return _with_control(block, **dict(zip(axes, values.T, strict=True)))


def _direction(rng, axes):
    found = rng.standard_normal(len(axes))
    return found / np.linalg.norm(found)


def points_moved(axes, n_points, role="control"):
    """Some points wrong, each in its own direction."""

    def spoil(block, rng):
        places = _places(block, role)
        n = min(int(rng.integers(n_points[0], n_points[1] + 1)), len(places))
        rows = rng.choice(places, n, replace=False)
        moves = [size(rng) * _direction(rng, axes) for _ in rows]
        return _moved(block, rows, np.array(moves), axes)

    return spoil


def one_axis_wrong(block, rng):
    """Two digits of a coordinate exchanged, or one misread."""
    row, axis = rng.choice(_places(block)), PLAN[rng.integers(2)]
    digit = 10.0 ** rng.integers(-1, 4)
    return _moved(block, [row], [[digit * rng.integers(1, 10)]], (axis,))


def group_moved(axes, shape):
    """All control points beyond a line, or within a circle, set off together."""

    def spoil(block, rng):
        place = block.control_points[list(PLAN)].to_numpy(dtype=float)
        if shape == "line":
            angle = rng.uniform(0.0, np.pi)
            along = place @ [np.cos(angle), np.sin(angle)]
            is_in = along > np.quantile(along, rng.uniform(0.3, 0.7))
        else:
            near = np.linalg.norm(place - place[rng.integers(len(place))], axis=1)
            is_in = near <= np.quantile(near, rng.uniform(0.15, 0.5))
        return _moved(block, is_in, size(rng) * _direction(rng, axes), axes)

    return spoil


def bent(axes):
    """The network strained by a quadratic form."""

    def spoil(block, rng):
        place = block.control_points[list(PLAN)].to_numpy(dtype=float)
        place = (place - place.mean(axis=0)) / place.std(axis=0)
        angle = rng.uniform(0.0, np.pi)
        form = (place @ [np.cos(angle), np.sin(angle)]) ** 2 - 1.0
        moves = size(rng) * form[:, None] * _direction(rng, axes)
        return _moved(block, np.arange(len(place)), moves, axes)

    return spoil


def all_worse(axes):
    """Control of another quality than stated."""

    def spoil(block, rng):
        shape = (len(block.control_points), len(axes))
        errors = size(rng) * rng.standard_normal(shape)
        return _moved(block, np.arange(shape[0]), errors, axes)

    return spoil


def all_moved(axes):
    """Everything set off alike."""

    def spoil(block, rng):
        n = len(block.control_points)
        return _moved(block, np.arange(n), size(rng) * _direction(rng, axes), axes)

    return spoil


def turned(block, rng):
    """Everything turned alike."""
    place = block.control_points[list(PLAN)].to_numpy(dtype=float)
    offset = place - place.mean(axis=0)
    angle = size(rng, 1e-4, 0.1)
    across = np.column_stack([-offset[:, 1], offset[:, 0]])
    return _moved(block, np.arange(len(place)), np.sin(angle) * across, PLAN)


def scaled(block, rng):
    """Everything out of scale alike, by less than film can tell."""
    place = block.control_points[list(PLAN)].to_numpy(dtype=float)
    offset = place - place.mean(axis=0)
    moves = size(rng, 1e-4, 0.02) * offset
    return _moved(block, np.arange(len(place)), moves, PLAN)


def tilted(block, rng):
    """All heights tilted alike."""
    place = block.control_points[list(PLAN)].to_numpy(dtype=float)
    offset = place - place.mean(axis=0)
    moves = size(rng, 1e-4, 0.05) * offset @ _direction(rng, PLAN)
    return _moved(block, np.arange(len(place)), moves[:, None], HEIGHT)


def control_names_exchanged(block, rng):
    """Two control points under each other's name."""
    names = block.control_points["point_id"].to_numpy(copy=True)
    pair = rng.choice(_places(block), 2, replace=False)
    names[pair] = names[pair[::-1]]
    return _with_control(block, point_id=names)


def control_names_shifted(block, rng):
    """Names of control set off by some rows, or of a part of the list."""
    names = block.control_points["point_id"].to_numpy(copy=True)
    n = len(names)
    first = int(rng.integers(0, n - 4)) if rng.random() < 0.5 else 0
    last = n if first == 0 else int(rng.integers(first + 3, n + 1))
    names[first:last] = np.roll(names[first:last], int(rng.integers(1, 4)))
    return _with_control(block, point_id=names)


def without_system(block, change):
    """Given points changed in a block that names no system."""
    return replace(block, control_points=change(block.control_points), crs=None)


def in_unit(factor):
    """Control in another unit, taken for metres."""

    def spoil(block, rng):
        axes = [axis for axis in (*PLAN, *HEIGHT) if axis in block.control_points]
        return without_system(
            block, lambda c: c.assign(**{a: factor * c[a] for a in axes})
        )

    return spoil


def axes_exchanged(block, rng):
    """Easting and northing under each other's name."""
    east, north = PLAN
    return without_system(
        block, lambda c: c.assign(easting=c[north].to_numpy(), northing=c[east])
    )


def mirrored(block, rng):
    """An axis with the wrong sign."""
    axis = PLAN[rng.integers(2)]
    return without_system(block, lambda c: c.assign(**{axis: -c[axis]}))


def axis_scaled(block, rng):
    """One axis in another unit, or with a thousands point, or stretched."""
    axis = PLAN[rng.integers(2)]
    factor = rng.choice([1e-3, FEET, 1e3, 1.0 + size(rng, 0.01, 0.3)])
    return without_system(block, lambda c: c.assign(**{axis: factor * c[axis]}))


def another_zone(block, rng):
    """Control in the neighbouring strip, where no system tells."""
    moved = block.control_points["easting"] + rng.choice([-1.0, 1.0]) * 223_000.0
    control = block.control_points.assign(easting=moved)
    return replace(block, control_points=control, crs=None)


def heights_in_feet(block, rng):
    """Control heights in feet, taken for metres."""
    return _with_control(block, height=block.control_points["height"] / FEET)


def control_errors_misstated(block, rng):
    """Standard errors of control 3 or 10 times too small, or too large."""
    factor = rng.choice([0.1, 1.0 / 3.0, 3.0, 10.0])
    stated = block.control_points["standard_error_m"] * factor
    return _with_control(block, standard_error_m=stated)


# measurements


def _flights(block, rng, n=1):
    names = list(block.flights)
    return list(rng.choice(names, min(n, len(names)), replace=False))


def _measured(flight):
    """Table of a flight's measurements, and the columns that name their models."""
    if flight.has_images:
        return "image_points", flight.image_points, ["image_id"]
    return "model_points", flight.model_points, ["coverage", "model_id"]


def _with_measured(block, name, change):
    """Change the measurements of a flight: ``change`` of the table and of models."""
    flight = block.flights[name]
    field, table, keys = _measured(flight)
    table = table.reset_index(drop=True)
    models = [np.asarray(rows) for rows in table.groupby(keys).indices.values()]
    changed = replace(flight, **{field: change(table, models)})
    return replace(block, **{name: changed})


def _any_flight(change):
    """A blunder in the measurements of one flight, whichever."""

    def spoil(block, rng):
        (name,) = _flights(block, rng)
        return _with_measured(block, name, lambda t, m: change(t, m, rng))

    return spoil


def _renamed(table, rows, names):
    ids = table["point_id"].to_numpy(copy=True)
    ids[rows] = names
    return table.assign(point_id=ids)


@_any_flight
def names_exchanged(table, models, rng):
    """Pairs of points of a model under each other's name."""
    ids = table["point_id"].to_numpy(copy=True)
    for _ in range(int(rng.integers(1, 6))):
        pair = rng.choice(models[rng.integers(len(models))], 2, replace=False)
        ids[pair] = ids[pair[::-1]]
    return table.assign(point_id=ids)


@_any_flight
def names_shifted(table, models, rng):
    """All names of a model set off by some rows."""
    rows = models[rng.integers(len(models))]
    shift = int(rng.integers(1, 4))
    return _renamed(table, rows, np.roll(table["point_id"].to_numpy()[rows], shift))


@_any_flight
def names_shuffled(table, models, rng):
    """Some points of a model under names of each other."""
    rows = models[rng.integers(len(models))]
    rows = rng.choice(rows, min(len(rows), int(rng.integers(3, 9))), replace=False)
    return _renamed(table, rows, np.roll(table["point_id"].to_numpy()[rows], 1))


@_any_flight
def many_names_exchanged(table, models, rng):
    """One in twenty names of a flight exchanged within its model."""
    ids = table["point_id"].to_numpy(copy=True)
    for rows in models:
        for _ in range(rng.binomial(len(rows), 0.025)):
            pair = rng.choice(rows, 2, replace=False)
            ids[pair] = ids[pair[::-1]]
    return table.assign(point_id=ids)


@_any_flight
def another_point_set(table, models, rng):
    """A point set on a wrong place in one model."""
    row = int(rng.integers(len(table)))
    xy = table[["x", "y"]].to_numpy(copy=True)
    xy[row] += size(rng, 0.02, 30.0) * _direction(rng, PLAN)
    return table.assign(x=xy[:, 0], y=xy[:, 1])


@_any_flight
def gross_errors(table, models, rng):
    """Some measurements wrong."""
    share, largest = rng.uniform(0.005, 0.05), size(rng, 0.02, 30.0)
    is_wrong = rng.random(len(table)) < share
    errors = largest * rng.standard_normal((len(table), 2)) * is_wrong[:, None]
    return table.assign(x=table["x"] + errors[:, 0], y=table["y"] + errors[:, 1])


@_any_flight
def model_wrong_in_itself(table, models, rng):
    """A model twisted: y grows with x y."""
    rows = models[rng.integers(len(models))]
    x, y = table[["x", "y"]].to_numpy(dtype=float)[rows].T
    x, y = x - x.mean(), y - y.mean()
    twist = size(rng, 0.02, 5.0) * x * y / max(np.abs(x * y).max(), 1e-9)
    ys = table["y"].to_numpy(copy=True)
    ys[rows] += twist
    return table.assign(y=ys)


@_any_flight
def model_heights_wrong(table, models, rng):
    """A model whose heights are twisted: z grows with x y."""
    rows = models[rng.integers(len(models))]
    x, y = table[["x", "y"]].to_numpy(dtype=float)[rows].T
    x, y = x - x.mean(), y - y.mean()
    zs = table["z"].to_numpy(copy=True)
    zs[rows] += size(rng, 0.05, 5.0) * x * y / max(np.abs(x * y).max(), 1e-9)
    return table.assign(z=zs)


@_any_flight
def model_stretched(table, models, rng):
    """A model on paper that shrank one way."""
    rows = models[rng.integers(len(models))]
    xs = table["x"].to_numpy(copy=True)
    xs[rows] *= 1.0 + size(rng, 5e-4, 0.1)
    return table.assign(x=xs)


def film_shrinkage(block, rng):
    """Film of a flight, or of both, that shrank one way."""
    stretch = 1.0 + size(rng, 2e-4, 0.01)
    axis = "xy"[rng.integers(2)]
    for name in _flights(block, rng, int(rng.integers(1, 3))):
        block = _with_measured(
            block, name, lambda t, _: t.assign(**{axis: stretch * t[axis]})
        )
    return block


def one_place_everywhere(block, rng):
    """One point of a flight set on the same wrong place in all of its models."""
    (name,) = _flights(block, rng)
    truth = block.truth["point_id"].to_numpy()
    wrong = rng.choice(truth)
    move = size(rng, 0.02, 5.0) * _direction(rng, PLAN)

    def change(table, models):
        is_it = (table["point_id"] == wrong).to_numpy()[:, None]
        xy = table[["x", "y"]].to_numpy(copy=True) + is_it * move
        return table.assign(x=xy[:, 0], y=xy[:, 1])

    return _with_measured(block, name, change)


@_any_flight
def model_measured_twice(table, models, rng):
    """The measurements of a model once more, under another name of a model."""
    rows = models[rng.integers(len(models))]
    again = table.iloc[rows].assign(model_id="again")
    return pd.concat([table, again], ignore_index=True)


def coverage_copied(block, rng):
    """A coverage that is a copy of the other, in one flight or in both."""
    for name in _flights(block, rng, int(rng.integers(1, 3))):
        flight = block.flights[name]
        points = flight.model_points
        kept = points[points["coverage"] == "12"[rng.integers(2)]]
        both = pd.concat([kept.assign(coverage=c) for c in "12"])
        block = replace(block, **{name: replace(flight, model_points=both)})
    return block


def m_g_misstated(block, rng):
    """m_g of a flight, or of both, 3 or 10 times too small or too large."""
    factor = rng.choice([0.1, 1.0 / 3.0, 3.0, 10.0])
    for name in _flights(block, rng, int(rng.integers(1, 3))):
        flight = block.flights[name]
        block = replace(block, **{name: replace(flight, m_g_um=factor * flight.m_g_um)})
    return block


def scale_misstated(block, rng):
    """The scale number of another flight, or with a wrong decimal."""
    (name,) = _flights(block, rng)
    flight = block.flights[name]
    number = flight.scale_number * rng.choice([0.1, 0.5, 8.0 / 15.0, 15.0 / 8.0, 10.0])
    return replace(block, **{name: replace(flight, scale_number=number)})


def z_out_of_scale(block, rng):
    """Heights of one flight, or of both, out of scale: wrong base or distance."""
    factor = 1.0 + rng.choice([-1.0, 1.0]) * size(rng, 0.003, 0.3)
    for name in _flights(block, rng, int(rng.integers(1, 3))):
        block = _with_measured(block, name, lambda t, _: t.assign(z=factor * t["z"]))
    return block


def principal_distance_misstated(block, rng):
    """Another camera's principal distance."""
    factor = 1.0 + rng.choice([-1.0, 1.0]) * size(rng, 0.003, 0.3)
    for name in _flights(block, rng, int(rng.integers(1, 3))):
        flight = block.flights[name]
        distance = factor * flight.principal_distance_mm
        wrong = replace(flight, principal_distance_mm=distance)
        block = replace(block, **{name: wrong})
    return block


def images_exchanged(block, rng):
    """The image points of two photographs under each other's name."""
    (name,) = _flights(block, rng)

    def change(table, models):
        a, b = rng.choice(len(models), 2, replace=False)
        ids = table["image_id"].to_numpy(copy=True)
        first, second = ids[models[a][0]], ids[models[b][0]]
        ids[models[a]], ids[models[b]] = second, first
        return table.assign(image_id=ids)

    return _with_measured(block, name, change)


@_any_flight
def models_exchanged(table, models, rng):
    """A model's points of another place: its names are those of another model."""
    a, b = rng.choice(len(models), 2, replace=False)
    n = min(len(models[a]), len(models[b]))
    ids = table["point_id"].to_numpy(copy=True)
    first, second = ids[models[a][:n]], ids[models[b][:n]]
    ids[models[a][:n]], ids[models[b][:n]] = second, first
    table = table.assign(point_id=ids)
    keys = ["point_id", *(k for k in ("coverage", "model_id") if k in table)]
    return table if "image_id" in table else table.drop_duplicates(keys)


def approximations_wrong(block, rng):
    """Given approximate coordinates, of which some, a part or all are wrong."""
    given = onto_given_approximations(block, own_error=0.05, seed=block.seed)
    table = given.approximate_points
    place = table[list(PLAN)].to_numpy(dtype=float)
    which = rng.integers(3)
    is_wrong = np.ones(len(place), dtype=bool)
    if which == 0:
        is_wrong = np.isin(np.arange(len(place)), rng.choice(len(place), 3))
    elif which == 1:
        angle = rng.uniform(0.0, np.pi)
        along = place @ [np.cos(angle), np.sin(angle)]
        is_wrong = along > np.quantile(along, rng.uniform(0.3, 0.7))
    move = size(rng) * _direction(rng, PLAN)
    if which == 2:
        move = size(rng) * rng.standard_normal(place.shape)
    place = place + move * is_wrong[:, None]
    return replace(
        given,
        approximate_points=table.assign(easting=place[:, 0], northing=place[:, 1]),
    )


KINDS = (
    Kind("one control point", points_moved(PLAN, (1, 1))),
    Kind("one coordinate of control", one_axis_wrong),
    Kind("several control points", points_moved(PLAN, (2, 4))),
    Kind("control on one side of a line", group_moved(PLAN, "line")),
    Kind("control within a circle", group_moved(PLAN, "circle")),
    Kind("bent network", bent(PLAN)),
    Kind("control worse than stated", all_worse(PLAN)),
    Kind("two control names exchanged", control_names_exchanged),
    Kind("control names shifted", control_names_shifted),
    Kind("control in feet", in_unit(1.0 / FEET)),
    Kind("control in a longer unit", in_unit(FEET), IMAGES),
    Kind("axes exchanged", axes_exchanged),
    Kind("axis mirrored", mirrored),
    Kind("axis out of scale", axis_scaled),
    Kind("standard errors of control", control_errors_misstated),
    Kind("check points", points_moved(PLAN, (1, 6), role="check")),
    Kind("one control height", points_moved(HEIGHT, (1, 1)), SPATIAL),
    Kind("several control heights", points_moved(HEIGHT, (2, 4)), SPATIAL),
    Kind("heights beyond a line", group_moved(HEIGHT, "line"), SPATIAL),
    Kind("heights within a circle", group_moved(HEIGHT, "circle"), SPATIAL),
    Kind("bent heights", bent(HEIGHT), SPATIAL),
    Kind("heights worse than stated", all_worse(HEIGHT), SPATIAL),
    Kind("heights in feet", heights_in_feet, SPATIAL),
    Kind("check heights", points_moved(HEIGHT, (1, 6), role="check"), SPATIAL),
    Kind("names exchanged in models", names_exchanged),
    Kind("names shifted in a model", names_shifted),
    Kind("names shuffled in a model", names_shuffled),
    Kind("one in twenty names", many_names_exchanged),
    Kind("names of two models", models_exchanged),
    Kind("a point set wrongly", another_point_set),
    Kind("a point wrong in a whole flight", one_place_everywhere),
    Kind("gross errors", gross_errors),
    Kind("a twisted model", model_wrong_in_itself, MACHINE),
    Kind("a stretched model", model_stretched, MACHINE),
    Kind("a model twisted in height", model_heights_wrong, "machine, spatial"),
    Kind("film shrinkage", film_shrinkage),
    Kind("a model measured twice", model_measured_twice, MACHINE),
    Kind("a coverage copied", coverage_copied, MACHINE),
    Kind("m_g", m_g_misstated),
    Kind("scale number", scale_misstated),
    Kind("z out of scale", z_out_of_scale, "machine, spatial"),
    Kind("principal distance", principal_distance_misstated, IMAGES),
    Kind("two photographs exchanged", images_exchanged, IMAGES),
    Kind("approximate coordinates", approximations_wrong, PLANE),
    Kind("control in a longer unit, machine", in_unit(FEET), MACHINE, can_show=False),
    Kind("another zone", another_zone, can_show=False),
    Kind("everything shifted", all_moved(PLAN), can_show=False),
    Kind("everything turned", turned, can_show=False),
    Kind("everything out of scale", scaled, can_show=False),
    Kind("all heights shifted", all_moved(HEIGHT), SPATIAL, can_show=False),
    Kind("all heights tilted", tilted, SPATIAL, can_show=False),
)


def kinds_for(block):
    """The kinds that a block can have."""
    flight = block.low_flight
    has = {ANY, IMAGES if flight.has_images else MACHINE}
    has.add(SPATIAL if "height" in block.control_points else PLANE)
    return [kind for kind in KINDS if set(kind.needs.split(", ")) <= has]
