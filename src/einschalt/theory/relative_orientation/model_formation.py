"""Model coordinates of the points of oriented pairs.

The two rays of a point meet only when their observations are adjusted; otherwise a rule
says where the model point is:

adjusted_rays
    Intersection of the rays through the adjusted image coordinates (the point of the
    bundle adjustment). Needs the corrections.
midpoint
    Middle of the common perpendicular of the two rays.
mean_y
    x and z from the intersection in the x-z plane, y the mean of both rays (lecture
    notes in the West). The difference of the two is the y-parallax.
left_ray
    x and z the same, y on the left ray (Chinese texts).

The last two take x and z literally, in the model system; where the base is nearer to
the y axis than to the x axis, x and y exchange their roles.
"""

from typing import NamedTuple

import numpy as np

from einschalt.foundations.arguments import require_choice
from einschalt.foundations.batches import over_segments
from einschalt.foundations.errors import SettingsError
from einschalt.foundations.kernels import compiled

RULES = ("adjusted_rays", "midpoint", "mean_y", "left_ray")
ADJUSTED, MIDPOINT, MEAN_Y, LEFT_RAY = range(4)


class ModelCoordinates(NamedTuple):
    """Model points."""

    xyz: np.ndarray  # (n_points, 3): in the unit of the base
    # (n_points,): y of the right ray less y of the left ray at equal x and z
    # (x-parallax where x and y exchange their roles), from the measured image
    # coordinates
    y_parallax: np.ndarray


def form_model(image, model_start, principal_distance, cameras, rule, corrections=None):
    """Intersect the rays of all points; NaN where a pair is not oriented.

    ``image`` (n_points, 4) is x', y', x", y" [mm], sorted by pair;
    ``principal_distance`` [mm] a number, (2,) or (n_pairs, 2); ``cameras`` are
    StereoCameras, ``rule`` is one of RULES. ``corrections`` (n_points, 4) of the image
    coordinates [mm] are for "adjusted_rays".

    Raises
    ------
    SettingsError
        The rule is unknown, or "adjusted_rays" has no corrections.
    """
    require_choice("rule", rule, RULES)
    if rule == "adjusted_rays" and corrections is None:
        raise SettingsError(
            "rule = 'adjusted_rays' without corrections",
            expected="the residuals of the image coordinates",
            remedy="Pass corrections, or take the rule 'midpoint'",
        )
    image = np.ascontiguousarray(image, dtype=float)
    used = image + corrections if rule == "adjusted_rays" else image
    distance = np.empty((len(model_start) - 1, 2))
    distance[:] = principal_distance
    model = ModelCoordinates(np.empty((len(image), 3)), np.empty(len(image)))
    cameras = cameras.stacked()
    start = np.ascontiguousarray(model_start, dtype=np.int64)
    code = MIDPOINT if rule == "adjusted_rays" else RULES.index(rule)
    over_segments(_intersect, start, used, distance, cameras, code, model.xyz)
    over_segments(_measure, start, image, distance, cameras, model.y_parallax)
    return model


@compiled(error_model="numpy")
def _intersect(first, last, model_start, image, distance, cameras, code, xyz):
    stations, axes = cameras
    for k in range(first, last):
        left, right = stations[k, 0], stations[k, 1]
        base = (right[0] - left[0], right[1] - left[1], right[2] - left[2])
        for i in range(model_start[k], model_start[k + 1]):
            u = _ray(image[i, 0], image[i, 1], distance[k, 0], axes[k, 0])
            v = _ray(image[i, 2], image[i, 3], distance[k, 1], axes[k, 1])
            if code == MIDPOINT:
                x, y, z = _middle(u, v, base)
            else:
                x, y, z = _level_point(u, v, base, code == MEAN_Y)
            xyz[i, 0], xyz[i, 1], xyz[i, 2] = left[0] + x, left[1] + y, left[2] + z


@compiled(error_model="numpy")
def _measure(first, last, model_start, image, distance, cameras, y_parallax):
    stations, axes = cameras
    for k in range(first, last):
        left, right = stations[k, 0], stations[k, 1]
        base = (right[0] - left[0], right[1] - left[1], right[2] - left[2])
        across, _ = _roles(base)
        for i in range(model_start[k], model_start[k + 1]):
            u = _ray(image[i, 0], image[i, 1], distance[k, 0], axes[k, 0])
            v = _ray(image[i, 2], image[i, 3], distance[k, 1], axes[k, 1])
            along_u, along_v = _level_distances(u, v, base)
            y_parallax[i] = base[across] + along_v * v[across] - along_u * u[across]


@compiled(error_model="numpy")
def _ray(x, y, distance, rotation):
    """Direction of an image point in the model system."""
    return (
        rotation[0, 0] * x + rotation[1, 0] * y - rotation[2, 0] * distance,
        rotation[0, 1] * x + rotation[1, 1] * y - rotation[2, 1] * distance,
        rotation[0, 2] * x + rotation[1, 2] * y - rotation[2, 2] * distance,
    )


@compiled(error_model="numpy")
def _roles(base):
    """Axis across the base and axis along it: y and x, or x and y."""
    return (1, 0) if abs(base[0]) >= abs(base[1]) else (0, 1)


@compiled(error_model="numpy")
def _level_distances(u, v, base):
    """Where the rays meet in the plane of z and the axis along the base."""
    _, along = _roles(base)
    det = u[along] * v[2] - v[along] * u[2]
    left = (base[along] * v[2] - base[2] * v[along]) / det
    right = (base[along] * u[2] - base[2] * u[along]) / det
    return left, right


@compiled(error_model="numpy")
def _level_point(u, v, base, is_mean):
    """Point by the intersection in the plane of z and the axis along the base."""
    left, right = _level_distances(u, v, base)
    x, y, z = left * u[0], left * u[1], left * u[2]
    if not is_mean:
        return x, y, z
    if abs(base[0]) >= abs(base[1]):
        return x, 0.5 * (y + base[1] + right * v[1]), z
    return 0.5 * (x + base[0] + right * v[0]), y, z


@compiled(error_model="numpy")
def _middle(u, v, base):
    """Middle of the common perpendicular of two rays."""
    a = _cross(u, v)
    square = _dot(a, a)
    left = _dot(_cross(base, v), a) / square
    right = _dot(_cross(base, u), a) / square
    return (
        0.5 * (left * u[0] + base[0] + right * v[0]),
        0.5 * (left * u[1] + base[1] + right * v[1]),
        0.5 * (left * u[2] + base[2] + right * v[2]),
    )


@compiled(error_model="numpy")
def _cross(a, b):
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


@compiled(error_model="numpy")
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
