"""Approximate relative orientations from nothing but the image coordinates.

Near-vertical photographs of near-level ground are similar figures: a plane similarity
gives kappa by its rotation and the base by its shift (**normal case**). Points in a
plane have two orientations that fit them equally well, since the roles of base and
plane normal can be exchanged: the **twin** follows in closed form, and can be excluded
where it puts points behind the cameras. For a given rotation the best base is the
smallest eigenvector of a 3 x 3 matrix, so three dimensions are left to a **search**,
which a coarse lattice covers. Poses and image coordinates are those of
``coplanarity_condition``.

Source: the twin is derived from the factorisation of ``I - e p.T`` into a rotation and
such a matrix (Longuet-Higgins 1986, The Reconstruction of a Plane Surface from Two
Perspective Projections, Proc. R. Soc. B 227); eliminating the base, Kneip and Lynen
2013 (Direct Optimization of Frame-to-Frame Rotation, ICCV).
"""

import math

import numpy as np

from einschalt.foundations.kernels import compiled, place_of_least
from einschalt.foundations.rotations import rotation_by_vector
from einschalt.theory.relative_orientation.coplanarity_condition import (
    COMPILED,
    FAST,
    FIRST_ORDER,
    SQUARES,
    coplanarity,
    form_normals,
    frame_of,
    product,
    right_ray,
)

IDENTITY = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
# part of the length of a ray by which a point must lie off the plane between the twins
TWIN_MARGIN = 0.02
# rotations that the search tries: relative tilts on rings, with all kappas on each
LATTICE_STEP = math.radians(20.0)
N_TILT_RINGS = 3
N_SEARCHED_POINTS = 48
# trace of the rotation between two places that count as neighbours
NEIGHBOUR_TRACE = 1.0 + 2.0 * math.cos(1.3 * LATTICE_STEP)


def rotation_lattice(step, n_rings):
    """Rotations about as far from each other as the step [rad], R row by row (n, 9).

    Rings of relative tilts have 6, 12, 18, ... places around no tilt.
    """
    tilts = [np.zeros(3)]
    for ring in range(1, n_rings + 1):
        azimuth = 2.0 * np.pi * np.arange(6 * ring) / (6 * ring)
        tilts += list(
            ring * step * np.stack([np.cos(azimuth), np.sin(azimuth), 0 * azimuth], 1)
        )
    kappas = np.arange(0.0, 2.0 * np.pi - 1e-9, step)
    spin = rotation_by_vector(np.multiply.outer(kappas, [0.0, 0.0, 1.0]))
    tip = rotation_by_vector(np.array(tilts))
    return (tip[:, None] @ spin).reshape(-1, 9)


LATTICE = rotation_lattice(LATTICE_STEP, N_TILT_RINGS)


@compiled(**COMPILED)
def normal_case_start(image, zr):
    """Pose by a plane similarity of the two images, (4, n).

    With the base in the direction in which the shift says it, and no tilts.
    """
    n = image.shape[1]
    mean_xl = mean_yl = mean_xr = mean_yr = 0.0
    for i in range(n):
        mean_xl, mean_yl = mean_xl + image[0, i], mean_yl + image[1, i]
        mean_xr, mean_yr = mean_xr + image[2, i], mean_yr + image[3, i]
    mean_xl, mean_yl = mean_xl / n, mean_yl / n
    mean_xr, mean_yr = mean_xr / n, mean_yr / n
    same = turned = spread = 0.0
    for i in range(n):
        xl, yl = image[0, i] - mean_xl, image[1, i] - mean_yl
        xr, yr = image[2, i] - mean_xr, image[3, i] - mean_yr
        same += xl * xr + yl * yr
        turned += yl * xr - xl * yr
        spread += xr * xr + yr * yr
    length = math.hypot(same, turned)
    if not length > 0.0:
        return (1.0, 0.0, 0.0), IDENTITY
    cos_k, sin_k, scale = same / length, turned / length, length / spread
    base = (
        mean_xl - scale * (cos_k * mean_xr - sin_k * mean_yr),
        mean_yl - scale * (sin_k * mean_xr + cos_k * mean_yr),
        -1.0 - scale * zr,
    )
    return unit(base), (cos_k, -sin_k, 0.0, sin_k, cos_k, 0.0, 0.0, 0.0, 1.0)


@compiled(**COMPILED)
def unit(vector):
    """Unit vector; (1, 0, 0) where the vector is zero."""
    x, y, z = vector
    length = math.sqrt(x * x + y * y + z * z)
    if not length > 0.0:
        return 1.0, 0.0, 0.0
    return x / length, y / length, z / length


@compiled(fastmath=FAST, **COMPILED)
def depths(point, zr, pose):
    """Distances of a point along its two rays, in bases, times the square of u x v.

    Left, right, and the square of u x v.
    """
    base, rotation = pose
    _, (a0, a1, a2), _, _ = coplanarity(point, zr, base, rotation)
    b0, b1, b2 = base
    xl, yl, xr, yr = point
    m0, m1, m2 = -b1 - b2 * yl, b2 * xl + b0, b0 * yl - b1 * xl
    v0, v1, v2 = right_ray(xr, yr, zr, rotation)
    left = (
        (b1 * v2 - b2 * v1) * a0 + (b2 * v0 - b0 * v2) * a1 + (b0 * v1 - b1 * v0) * a2
    )
    right = m0 * a0 + m1 * a1 + m2 * a2
    return left, right, a0 * a0 + a1 * a1 + a2 * a2


@compiled(**COMPILED)
def facing(image, zr, pose):
    """Pose with the base towards the side of more points in front, and their number.

    A base and its opposite fit the condition equally well.
    """
    n_front = n_behind = 0
    for i in range(image.shape[1]):
        point = image[0, i], image[1, i], image[2, i], image[3, i]
        left, right, _ = depths(point, zr, pose)
        if left > 0.0 and right > 0.0:
            n_front += 1
        elif left < 0.0 and right < 0.0:
            n_behind += 1
    if n_behind <= n_front:
        return pose, n_front
    (x, y, z), rotation = pose
    return ((-x, -y, -z), rotation), n_behind


@compiled(**COMPILED)
def inverse_depth_plane(image, zr, pose):
    """Plane p . X = 1 through the model points, with the base as unit of length.

    Least squares of the inverse depths, which are linear in p and stay finite.
    """
    a = b = c = d = e = 0.0
    f, g, h = 0.0, 0.0, 0.0
    for i in range(image.shape[1]):
        x, y = image[0, i], image[1, i]
        left, _, square = depths((x, y, image[2, i], image[3, i]), zr, pose)
        inverse = square / left
        a, b, c = a + x * x, b + x * y, c + y * y
        d, e = d - x, e - y
        f, g, h = f + x * inverse, g + y * inverse, h - inverse
    n = float(image.shape[1])
    # a little of the identity: points in a line leave the plane undetermined
    a, c, n = a * (1.0 + 1e-9), c * (1.0 + 1e-9), n * (1.0 + 1e-9)
    co_0, co_1, co_2 = c * n - e * e, d * e - b * n, b * e - c * d
    det = a * co_0 + b * co_1 + d * co_2
    co_3, co_4, co_5 = a * n - d * d, b * d - a * e, a * c - b * b
    return (
        (co_0 * f + co_1 * g + co_2 * h) / det,
        (co_1 * f + co_3 * g + co_4 * h) / det,
        (co_2 * f + co_4 * g + co_5 * h) / det,
    )


@compiled(**COMPILED)
def planar_twin(image, zr, pose):
    """Whether points in a plane allow a second orientation, and that orientation.

    With the plane p . X = 1 the rays are v ~ (I - e p.T) u. With s = p/2 - e the same
    matrix is a rotation times I + t s.T, t = p - (p.p)/(2 s.s) s: a camera whose base
    is along t and a plane with the normal s. Points of both signs of s . u exclude it.
    """
    (x, y, z), rotation = pose
    p0, p1, p2 = inverse_depth_plane(image, zr, pose)
    s0, s1, s2 = 0.5 * p0 - x, 0.5 * p1 - y, 0.5 * p2 - z
    square_s = s0 * s0 + s1 * s1 + s2 * s2
    limit = TWIN_MARGIN * math.sqrt(square_s)
    n_above = n_below = 0
    for i in range(image.shape[1]):
        side = s0 * image[0, i] + s1 * image[1, i] - s2
        n_above += side > limit
        n_below += side < -limit
    half = 0.5 * (p0 * p0 + p1 * p1 + p2 * p2) / square_s
    t0, t1, t2 = p0 - half * s0, p1 - half * s1, p2 - half * s2
    f = -1.0 / (1.0 + t0 * s0 + t1 * s1 + t2 * s2)
    flat = rank_one_more(-1.0, (x, y, z), (p0, p1, p2))
    turn = product(flat, rank_one_more(f, (t0, t1, t2), (s0, s1, s2)))
    twin = unit((t0, t1, t2)), product(transposed(turn), rotation)
    return n_above == 0 or n_below == 0, twin


@compiled(**COMPILED)
def rank_one_more(factor, a, b):
    """Matrix I + factor a b.T, row by row."""
    x, y, z = a
    p, q, r = b
    top = 1.0 + factor * x * p, factor * x * q, factor * x * r
    middle = factor * y * p, 1.0 + factor * y * q, factor * y * r
    bottom = factor * z * p, factor * z * q, 1.0 + factor * z * r
    return top + middle + bottom


@compiled(**COMPILED)
def transposed(m):
    """Transpose of a matrix, row by row."""
    return m[0], m[3], m[6], m[1], m[4], m[7], m[2], m[5], m[8]


@compiled(fastmath=FAST, **COMPILED)
def with_best_base(image, zr, pose):
    """Pose with the base that fits best to its rotation.

    The base should be at right angles to every u x v: it is the eigenvector with the
    smallest eigenvalue of their weighted sum of squares and products. The weights are
    those of the conditions at the pose.
    """
    base, rotation = pose
    a = b = c = d = e = f = 0.0
    for i in range(image.shape[1]):
        point = image[0, i], image[1, i], image[2, i], image[3, i]
        _, (x, y, z), _, by_image = coplanarity(point, zr, base, rotation)
        d0, d1, d2, d3 = by_image
        weight = 1.0 / (d0 * d0 + d1 * d1 + d2 * d2 + d3 * d3)
        a, b, c = a + weight * x * x, b + weight * y * x, c + weight * y * y
        d, e, f = d + weight * z * x, e + weight * z * y, f + weight * z * z
    return smallest_eigenvector(a, b, c, d, e, f), rotation


@compiled(fastmath=FAST, **COMPILED)
def base_of_rotation(image, zr, rotation):
    """Base that fits best to a rotation, every u x v being scaled to length 1."""
    a = b = c = d = e = f = 0.0
    for i in range(image.shape[1]):
        point = image[0, i], image[1, i], image[2, i], image[3, i]
        _, (x, y, z), _, _ = coplanarity(point, zr, (1.0, 0.0, 0.0), rotation)
        weight = 1.0 / (x * x + y * y + z * z + 1e-12)
        a, b, c = a + weight * x * x, b + weight * y * x, c + weight * y * y
        d, e, f = d + weight * z * x, e + weight * z * y, f + weight * z * z
    return smallest_eigenvector(a, b, c, d, e, f)


@compiled(**COMPILED)
def smallest_eigenvector(a, b, c, d, e, f):
    """Eigenvector of ((a, b, d), (b, c, e), (d, e, f)) of its smallest eigenvalue."""
    mean = (a + c + f) / 3.0
    p, q, r = a - mean, c - mean, f - mean
    size = math.sqrt((p * p + q * q + r * r + 2.0 * (b * b + d * d + e * e)) / 6.0)
    if not size > 0.0:
        return 1.0, 0.0, 0.0
    det = p * (q * r - e * e) - b * (b * r - e * d) + d * (b * e - q * d)
    half = max(-1.0, min(1.0, 0.5 * det / size**3))
    shift = 2.0 * size * math.cos((math.acos(half) + 2.0 * math.pi) / 3.0)
    p, q, r = p - shift, q - shift, r - shift
    # columns of the adjoint: the longest keeps most digits
    x0, x1, x2 = q * r - e * e, d * e - b * r, b * e - d * q
    y1, y2, z2 = p * r - d * d, b * d - p * e, p * q - b * b
    if x0 >= y1 and x0 >= z2:
        return unit((x0, x1, x2))
    if y1 >= z2:
        return unit((x1, y1, y2))
    return unit((x2, y2, z2))


@compiled(**COMPILED)
def survey_lattice(image, zr):
    """Sum of squares of every rotation of the lattice with its best base, and these."""
    # only the shape of the sum of squares is wanted, which some of the points give
    step = 1 + image.shape[1] // N_SEARCHED_POINTS
    sample = np.empty((4, (image.shape[1] + step - 1) // step))
    for i in range(4):
        for k in range(sample.shape[1]):
            sample[i, k] = image[i, k * step]
    idle = np.empty(sample.shape)
    idle[:] = 0.0
    squares = np.empty(len(LATTICE))
    bases = np.empty((len(LATTICE), 3))
    for place in range(len(LATTICE)):
        rotation = lattice_rotation(place)
        base = base_of_rotation(sample, zr, rotation)
        frame = frame_of((base, rotation), False)
        squares[place] = form_normals(sample, idle, zr, frame, FIRST_ORDER)[SQUARES]
        bases[place, 0], bases[place, 1], bases[place, 2] = base
    return squares, bases


@compiled(**COMPILED)
def next_start(squares, bases):
    """Pose with the smallest sum of squares of the lattice.

    Its place and the neighbours are infinite in ``squares`` afterwards.
    """
    best = place_of_least(squares)
    for place in range(len(LATTICE)):
        trace = 0.0
        for i in range(9):
            trace += LATTICE[place, i] * LATTICE[best, i]
        if trace > NEIGHBOUR_TRACE:
            squares[place] = np.inf
    return (bases[best, 0], bases[best, 1], bases[best, 2]), lattice_rotation(best)


@compiled(**COMPILED)
def lattice_rotation(place):
    """Rotation of a place of the lattice as a tuple of 9 floats."""
    r = LATTICE[place]
    return r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8]
