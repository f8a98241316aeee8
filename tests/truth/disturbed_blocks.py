"""Simulated blocks with the errors of real ones, which no preset has.

Models and photographs that are deformed each in its own way, measurements with heavy
tails, control and approximate coordinates that share errors with their neighbours.
"""

from dataclasses import dataclass, replace

import numpy as np

from einschalt.foundations.units import METRES_PER_MM, METRES_PER_UM
from einschalt.pipeline.block.block import Block

PLANE = ["easting", "northing"]
GROUND = [*PLANE, "height"]
QUADRATIC, CUBIC = 2, 3
EDGE = 0.75  # of the half width of a model
HALF_BASE = 0.4  # of a model in its half width: where its photographs were taken from
SQRT2 = np.sqrt(2.0)


@dataclass(frozen=True, eq=False, kw_only=True)
class DisturbedBlock(Block):
    """A block whose true coordinates are known."""

    truth: object


def bent(block, edge_m, seed, degree=CUBIC, *, is_shared=False):
    """The block with deformations of the low flight, total RMS at the edge [m].

    Of each model, or (``is_shared``) of each photograph, which the models to both sides
    of it have in common. Heights of spatial models are bent as well.
    """
    flight = block.low_flight
    moved = _bending(
        flight.model_points, np.random.default_rng(seed), degree, is_shared
    )
    moved *= edge_m / (flight.scale_number * METRES_PER_MM)
    return replace(block, low_flight=_displaced(flight, moved))


def _bending(table, rng, degree, is_shared):
    """Displacements in x, y, z with a total RMS of 1 in plan at the edge of models."""
    by_model = table.groupby(["coverage", "model_id"])
    xy = by_model[["x", "y"]]
    middle = (xy.transform("max") + xy.transform("min")) / 2.0
    half = ((xy.max() - xy.min()) / 2.0).max(axis=1).median()
    x, y = ((table[["x", "y"]] - middle) / half).to_numpy().T
    if is_shared:
        strip, number = table["model_id"].str.split("/", expand=True).to_numpy().T
        strip, number = table["coverage"] + "/" + strip, number.astype(int)
        names = [
            [f"{s}/{n + side}" for s, n in zip(strip, number, strict=True)]
            for side in (0, 1)
        ]
        parts = [(names[0], x + HALF_BASE), (names[1], x - HALF_BASE)]
    else:
        parts = [(by_model.ngroup().to_numpy(), x)]
    codes = np.unique(
        np.concatenate([names for names, _ in parts]), return_inverse=True
    )
    codes = codes[1].reshape(len(parts), -1)
    n_terms = _terms(x, y, degree).shape[1]
    size = rng.standard_normal((codes.max() + 1, n_terms, 3))
    moved = sum(
        np.einsum("nk,nkc->nc", _terms(along, y, degree), size[code])
        for code, (_, along) in zip(codes, parts, strict=True)
    )
    is_edge = np.maximum(np.abs(x), np.abs(y)) > EDGE
    return moved / np.sqrt((moved[is_edge, :2] ** 2).sum(axis=1).mean())


def _terms(x, y, degree):
    powers = [(n - k, k) for n in range(2, degree + 1) for k in range(n + 1)]
    return np.column_stack([x**i * y**j for i, j in powers])


def _displaced(flight, moved):
    table = flight.model_points
    axes = [name for name in "xyz" if name in table]
    added = {name: table[name] + moved[:, k] for k, name in enumerate(axes)}
    return replace(flight, model_points=table.assign(**added))


def with_heavy_tails(block, m_g_um, seed, degrees=3):
    """A block measured without errors with t-distributed ones, m_g of the whole [µm].

    ``m_g_um`` is that of each flight, TOTAL.
    """
    rng, flights = np.random.default_rng(seed), {}
    for name, total in m_g_um.items():
        flight = getattr(block, name)
        size = total * METRES_PER_UM / METRES_PER_MM / SQRT2
        size /= np.sqrt(degrees / (degrees - 2.0))
        drawn = rng.standard_t(degrees, (len(flight.model_points), 3))
        flights[name] = replace(_displaced(flight, size * drawn), m_g_um=total)
    return replace(block, **flights)


def with_correlated_control(block, error_m, length_m, seed, *, is_stated=True):
    """Control, measured without errors, with exponentially correlated ones.

    TOTAL ``error_m``, alike over ``length_m`` [m].
    """
    control = block.control_points
    xy = control[PLANE].to_numpy()
    apart = np.linalg.norm(xy[:, None] - xy[None], axis=2)
    root = np.linalg.cholesky(np.exp(-apart / length_m))
    drawn = np.random.default_rng(seed).standard_normal((len(control), 3))
    moved = _moved(control, error_m / SQRT2 * root @ drawn)
    lengths = {"control_points": length_m} if is_stated else {}
    return replace(
        block,
        control_points=moved.assign(standard_error_m=error_m),
        correlation_lengths_m=lengths,
    )


def with_grouped_control(block, shift_m, seed, *, n_parts=3, is_stated=True):
    """Parts of the network, n × n of them, each displaced by itself, TOTAL [m]."""
    control = block.control_points
    xy = control[PLANE].to_numpy()
    cell = (xy - xy.min(axis=0)) / np.ptp(xy, axis=0) * n_parts
    cell = np.minimum(cell.astype(int), n_parts - 1)
    names = np.array([f"part {a}{b}" for a, b in cell], dtype=object)
    moved = _moved(control, _shifts(names, shift_m, np.random.default_rng(seed)))
    given = {"control_points": shift_m} if is_stated else {}
    return replace(
        block, control_points=moved.assign(group=names), group_errors_m=given
    )


def onto_grouped_approximations(
    block, own_m, shift_m, cell_m, seed, *, is_stated=True
) -> DisturbedBlock:
    """The low flight of a block onto approximate coordinates, without any control.

    Strips or rectangles of the size ``cell_m`` (easting, northing) are displaced, each
    by itself, as points from one strip or photograph are; TOTAL errors [m].
    """
    rng, truth = np.random.default_rng(seed), block.truth
    from_corner = truth[PLANE].to_numpy() - truth[PLANE].min().to_numpy()
    cell = (from_corner / np.asarray(cell_m, dtype=float)).astype(int)
    names = np.array([f"{a}/{b}" for a, b in cell], dtype=object)
    own = rng.standard_normal((len(truth), 3)) * own_m / SQRT2
    moved = _moved(truth, _shifts(names, shift_m, rng) + own)
    return DisturbedBlock(
        low_flight=block.low_flight,
        approximate_points=moved.assign(group=names),
        approximate_m_0_m=own_m,
        crs=block.crs,
        group_errors_m={"approximate_points": shift_m} if is_stated else {},
        truth=truth,
    )


def _shifts(names, total_m, rng):
    _, code = np.unique(names, return_inverse=True)
    return (rng.standard_normal((code.max() + 1, 3)) * total_m / SQRT2)[code]


def _moved(table, errors):
    axes = [name for name in GROUND if name in table]
    added = {name: table[name] + errors[:, k] for k, name in enumerate(axes)}
    return table.assign(**added)
