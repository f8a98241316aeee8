"""Nothing is published that does not return: each form is run by PROJ, there and back.

At all identical points, and at others within the triangles, PROJ must give what the
result gives, to a tenth of a millimetre, and must lead back as well.
"""

import os
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pyproj

from einschalt.foundations.coordinate_operations import PROJ
from einschalt.foundations.errors import GeometryError, name_some
from einschalt.foundations.published_systems import run_pipeline
from einschalt.interfaces.publication.proj_database import AUTHORITY

AT_MOST = 1e-4  # metres
N_POINTS = 10_000
MOST_SEARCHED = 5
SEED = 0  # a publication is the same in every run


def points_of_operation(operation):
    """Identical points of an operation, and others among them, (n, 2 or 3).

    As many of these at most as it has identical points, but 100 at least.
    """
    if not operation.is_plane:
        return operation.source
    rng = np.random.default_rng(SEED)
    n_points = min(N_POINTS, max(100, len(operation.source)))
    net = operation.net
    if net is None:
        known = operation.source
        chosen = rng.integers(0, len(known), (n_points, 3))
        shares = rng.dirichlet(np.ones(3), n_points)[..., None]
        asked = np.concatenate([known, (shares * known[chosen]).sum(axis=1)])
        # what was set aside for its place lies beyond
        return asked[np.isfinite(operation.apply(asked)).all(axis=1)]
    chosen = rng.integers(0, len(net.corners), n_points)
    shares = rng.dirichlet(np.ones(3), n_points)
    within = np.einsum("nk,nkj->nj", shares, net.source[net.corners[chosen]])
    known = net.source[net.used] if operation.is_distributed else operation.source
    return np.concatenate([known, within])


def require_return(operation, form, there, back):
    """Refuse a form of an operation in which PROJ gives another result.

    ``there`` and ``back`` take points (n, 2 or 3) from one frame to the other.
    """
    points = points_of_operation(operation)
    expected = operation.apply(points)
    found = there(points)
    misses = np.linalg.norm(found - expected, axis=1)
    returns = np.linalg.norm(back(expected) - points, axis=1) * operation.unit_m
    worst = np.maximum(misses, returns)
    is_wrong = ~(worst <= AT_MOST)
    if not is_wrong.any():
        return
    known = is_wrong & np.isfinite(worst)
    largest = f"by up to {worst[known].max():.2g} m" if known.any() else "without end"
    at = [f"({x:.1f}, {y:.1f})" for x, y in points[is_wrong, :2]]
    raise GeometryError(
        f"{operation.title}: as {form} it does not give the same, or does not return: "
        f"{int(is_wrong.sum())} of {len(points)} points miss {largest}, near "
        f"{name_some(at, 3)}",
        expected=f"{AT_MOST * 1e3:g} mm, there and back; nothing is published",
        remedy="See whether identical points there are right, or take them out",
    )


def require_text_returns(operation, form, text):
    """Check a PROJ string or WKT."""
    require_return(
        operation,
        form,
        lambda points: run_pipeline(text, points),
        lambda points: run_pipeline(text, points, inverse=True),
    )


def require_database_returns(operations, target, path):
    """Check that an auxiliary database leads operations to the target's code.

    Five of them, since PROJ searches for long: the database holds the strings of all,
    which PROJ has run. In a thread of its own: each opens PROJ's database for itself,
    and this one must be beside it.
    """
    step = -(-len(operations) // MOST_SEARCHED)

    def check():
        for one in operations[::step]:
            _require_chosen(one, target)

    with PROJ, ThreadPoolExecutor(1) as alone:
        before = os.environ.get("PROJ_AUX_DB")
        os.environ["PROJ_AUX_DB"] = str(path)
        try:
            alone.submit(check).result()
        finally:
            if before is None:
                del os.environ["PROJ_AUX_DB"]
            else:
                os.environ["PROJ_AUX_DB"] = before


def _require_chosen(operation, target):
    pyproj.network.set_network_enabled(active=False)
    way = pyproj.Transformer.from_crs(
        f"{AUTHORITY}:{operation.code}",
        target,
        always_xy=True,
        only_best=True,
        allow_ballpark=False,
    )
    require_return(
        operation,
        "PROJ database",
        lambda points: np.column_stack(way.transform(*points.T)),
        lambda points: np.column_stack(way.transform(*points.T, direction="INVERSE")),
    )
