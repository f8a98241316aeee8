"""The angle at which two photographs see the same ground, without an orientation.

Two photographs of a plane are projections of each other: x'' ~ H x' (a homography).
With the rotation R between the photographs, the translation t and the normal n of the
plane at the distance d, H = R + t n^T / d, whatever the tilts. So H, fitted to the
points that both show, tells base over distance before any relative orientation; relief
around the plane changes little of it, but for narrow overlaps.

The equations of the fit are bilinear in what the two photographs hold: their sums over
common points are sums of products, which can be formed for many pairs at once.

Sources: O. Faugeras, F. Lustman 1988 (Motion and structure from motion in a piecewise
planar environment); Y. Ma, S. Soatto, J. Košecká, S. Sastry 2004, section 5.3.
"""

import numpy as np

# monomials of the image coordinates of either photograph, of which sums are formed
OF_LEFT = 6  # 1, x, y, x², xy, y²
OF_RIGHT = 4  # 1, x, y, x² + y²
PLACES = np.array([[3, 4, 1], [4, 5, 2], [1, 2, 0]])  # of x xᵀ among those of the left
# of the largest eigenvalue: points on a line leave more than one homography
UNDETERMINED = 1e-13


def monomials_of_left(x, y):
    """Give 1, x, y, x², xy, y² of image coordinates, shape (6, n)."""
    return np.stack([np.ones_like(x), x, y, x * x, x * y, y * y])


def monomials_of_right(x, y):
    """Give 1, x, y, x² + y² of image coordinates, shape (4, n)."""
    return np.stack([np.ones_like(x), x, y, x * x + y * y])


def fit_homographies(sums):
    """Fit the projection of the left photograph onto the right one, for many pairs.

    Parameters
    ----------
    sums : ndarray, shape (n_pairs, 6, 4)
        Products of the monomials of the left and of the right image coordinates, in
        units of the principal distance, summed over the common points.

    Returns
    -------
    homographies : ndarray, shape (n_pairs, 3, 3)
        With the mean singular value 1, as R + t nᵀ/d has, and points before both
        cameras; NaN where the points determine none, as on a line.
    squares : ndarray, shape (n_pairs,)
        Sum of squares of what they miss the points in the right photograph by, about.
    """
    one, u, v, both = (sums[:, PLACES, k] for k in range(OF_RIGHT))
    normal = np.zeros((len(sums), 9, 9))
    normal[:, :3, :3] = normal[:, 3:6, 3:6] = one
    normal[:, :3, 6:] = normal[:, 6:, :3] = -u
    normal[:, 3:6, 6:] = normal[:, 6:, 3:6] = -v
    normal[:, 6:, 6:] = both
    values, vectors = np.linalg.eigh(normal)
    matrices = vectors[:, :, 0].reshape(-1, 3, 3)
    size = np.linalg.svd(matrices, compute_uv=False)[:, 1]
    left = np.stack([sums[:, 1, 0], sums[:, 2, 0], sums[:, 0, 0]], axis=1)
    right = sums[:, 0, [1, 2, 0]]
    ahead = np.einsum("ni,nij,nj->n", right, matrices, left)
    is_determined = values[:, 1] > UNDETERMINED * values[:, -1]
    with np.errstate(divide="ignore", invalid="ignore"):
        factor = np.where(is_determined, np.sign(ahead) / size, np.nan)
        squares = np.maximum(values[:, 0], 0.0) * factor**2
    return matrices * factor[:, None, None], squares


def base_ratios(homographies, ray):
    """Give base over distance of what both photographs see, as their rays meet there.

    Twice the tangent of half the angle at which the rays from both cameras meet: in
    vertical photographs with the same height, base over height.

    Parameters
    ----------
    homographies : ndarray, shape (n_pairs, 3, 3)
        As of :func:`fit_homographies`.
    ray : ndarray, shape (n_pairs, 2)
        Image coordinates in the left photograph, in units of the principal distance:
        the middle of the common points.

    Returns
    -------
    ndarray, shape (n_pairs,)
        NaN where the homography is.

    Notes
    -----
    Of the two planes that a homography may belong to, the one that faces the camera:
    the other one lies along the base, almost.
    """
    ratio = np.full(len(homographies), np.nan)
    is_known = np.isfinite(homographies).all(axis=(1, 2))
    h = homographies[is_known]
    m = np.column_stack([ray[is_known], np.ones(len(h))])
    m /= np.linalg.norm(m, axis=1)[:, None]
    squares, axes = np.linalg.eigh(np.swapaxes(h, 1, 2) @ h)
    along, across = (axes[:, :, k] for k in (2, 0))
    a = np.sqrt(np.maximum(1.0 - squares[:, 0], 0.0))[:, None]
    b = np.sqrt(np.maximum(squares[:, 2] - 1.0, 0.0))[:, None]
    length = np.hypot(a, b)
    length[length == 0.0] = np.inf  # the same photograph twice: no base
    found = [
        _seen(h, axes[:, :, 1], (a * along + side * b * across) / length, m)
        for side in (1.0, -1.0)
    ]
    (first, facing), (second, facing_too) = found
    ratio[is_known] = np.where(facing >= facing_too, first, second)
    return ratio


def _seen(h, middle, in_plane, m):
    """Ratio for one of the planes, and the cosine between its normal and the ray."""
    normal = np.cross(middle, in_plane)
    own = np.stack([middle, in_plane, normal], axis=2)
    moved = h @ own[:, :, :2]
    third = np.cross(moved[:, :, 0], moved[:, :, 1])
    rotation = np.concatenate([moved, third[:, :, None]], axis=2)
    rotation = rotation @ np.swapaxes(own, 1, 2)
    base = np.einsum("nij,nj->ni", h - rotation, normal)
    centre = -np.einsum("nji,nj->ni", rotation, base)
    facing = np.sum(normal * m, axis=1)
    # the plane is at the distance 1: the point is m / facing, and facing times that and
    # the base have the same directions
    from_right = m - facing[:, None] * centre
    across = np.linalg.norm(np.cross(m, from_right), axis=1)
    angle = np.arctan2(across, np.sum(m * from_right, axis=1))
    return 2.0 * np.tan(angle / 2.0), np.abs(facing)
