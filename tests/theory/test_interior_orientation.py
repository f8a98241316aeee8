"""Pixels and millimetres to image coordinates, and back."""

import numpy as np
import pytest

from einschalt.foundations.errors import SettingsError
from einschalt.theory.interior_orientation import CLOSED_MM, Camera

OPENCV = Camera.from_opencv(
    7980.0,
    7990.0,
    4010.5,
    2985.25,
    (-0.11, 0.08, 6e-4, -4e-4, -0.02),
    pixel_size_um=4.5,
)
METASHAPE = Camera.from_metashape(
    7980.0,
    (8000, 6000),
    (10.0, -15.0),
    {
        "b1": 3.0,
        "b2": -2.0,
        "k1": -0.11,
        "k2": 0.08,
        "k3": -0.02,
        "k4": 0.01,
        "p1": -4e-4,
        "p2": 6e-4,
    },
    pixel_size_um=4.5,
)
WIDE_ANGLE = Camera.from_mm(
    152.67,
    (0.012, -0.007),
    {"k1": 2e-8, "k2": -3e-12, "k3": 1e-16, "p1": 3e-7, "p2": -2e-7},
)
SCANNED = Camera.from_mm(
    152.67,
    (0.012, -0.007),
    {"k1": 2e-8},
    pixels={"pixel_size_um": 15.0, "width": 15_400, "height": 15_300},
)
OBLONG = Camera.from_mm(
    152.67,
    (0.012, -0.007),
    {"k1": 2e-8},
    pixels={
        "pixel_size_um": 15.0,
        "pixel_height_um": 15.1,
        "width": 15_400,
        "height": 15_300,
    },
)
MICMAC = Camera.from_micmac(
    7980.0,
    (4010.5, 2985.25),
    {"k1": -1.7e-9, "k2": 2e-17, "p1": 4e-8, "p2": -3e-8, "b1": 3e-4, "b2": -2e-4},
    (3990.0, 3001.0),
    pixel_size_um=4.5,
)
CAMERAS = {
    "opencv": OPENCV,
    "metashape": METASHAPE,
    "mm": WIDE_ANGLE,
    "scan": SCANNED,
    "oblong": OBLONG,
    "micmac": MICMAC,
}


def over_the_image(camera, half=(16.0, 12.0), n=25):
    half = (105.0, 105.0) if camera.is_correcting else half
    axes = (np.linspace(-size, size, n) for size in half)
    return np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)


# ----------------------------------------------- the formulas, as the manuals have them


def by_opencv_manual(xy_mm, distance_mm):
    """cv2.projectPoints, x right and y down, z forward."""
    x, y = xy_mm[:, 0] / distance_mm, -xy_mm[:, 1] / distance_mm
    k1, k2, p1, p2, k3 = -0.11, 0.08, 6e-4, -4e-4, -0.02
    r2 = x**2 + y**2
    radial = 1 + k1 * r2 + k2 * r2**2 + k3 * r2**3
    xd = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x**2)
    yd = y * radial + p1 * (r2 + 2 * y**2) + 2 * p2 * x * y
    return np.column_stack([7980.0 * xd + 4010.5, 7990.0 * yd + 2985.25])


def by_metashape_manual(xy_mm, distance_mm):
    """Metashape user manual, appendix on camera models."""
    x, y = xy_mm[:, 0] / distance_mm, -xy_mm[:, 1] / distance_mm
    k1, k2, k3, k4, p1, p2 = -0.11, 0.08, -0.02, 0.01, -4e-4, 6e-4
    f, b1, b2, cx, cy = 7980.0, 3.0, -2.0, 10.0, -15.0
    r = np.hypot(x, y)
    radial = 1 + k1 * r**2 + k2 * r**4 + k3 * r**6 + k4 * r**8
    xd = x * radial + (p1 * (r**2 + 2 * x**2) + 2 * p2 * x * y)
    yd = y * radial + (p2 * (r**2 + 2 * y**2) + 2 * p1 * x * y)
    u = 8000 * 0.5 + cx + xd * f + xd * b1 + yd * b2
    return np.column_stack([u, 6000 * 0.5 + cy + yd * f])


@pytest.mark.parametrize(
    ("camera", "manual"), [(OPENCV, by_opencv_manual), (METASHAPE, by_metashape_manual)]
)
def test_measured_as_in_the_manual(camera, manual):
    xy = over_the_image(camera)
    wanted = manual(xy, camera.principal_distance_mm)
    # rounding of pixels of the size of 8000
    np.testing.assert_allclose(camera.measured_from_xy(xy), wanted, atol=1e-11)


def test_brown_corrects_what_was_measured():
    measured = over_the_image(WIDE_ANGLE)
    x, y = (measured - [0.012, -0.007]).T
    r2 = x**2 + y**2
    k1, k2, k3, p1, p2 = 2e-8, -3e-12, 1e-16, 3e-7, -2e-7
    growth = k1 * r2 + k2 * r2**2 + k3 * r2**3
    wanted = [
        x + x * growth + p1 * (r2 + 2 * x**2) + 2 * p2 * x * y,
        y + y * growth + p2 * (r2 + 2 * y**2) + 2 * p1 * x * y,
    ]
    found = WIDE_ANGLE.xy_from_measured(measured)
    np.testing.assert_allclose(found, np.transpose(wanted), atol=1e-12)


# ----------------------------------------------------------------- inverse, conventions


@pytest.mark.parametrize("name", CAMERAS)
def test_there_and_back(name):
    camera = CAMERAS[name]
    xy = over_the_image(camera)
    back = camera.xy_from_measured(camera.measured_from_xy(xy))
    assert np.abs(back - xy).max() <= 2.0 * CLOSED_MM


@pytest.mark.parametrize("name", ["opencv", "mm"])
def test_shape_does_not_matter(name):
    camera = CAMERAS[name]
    measured = camera.measured_from_xy(over_the_image(camera))
    grid = camera.xy_from_measured(measured.reshape(25, 25, 2))
    together = camera.xy_from_measured(measured)
    np.testing.assert_array_equal(grid.reshape(-1, 2), together)
    np.testing.assert_allclose(
        camera.xy_from_measured(measured[7]), together[7], atol=1e-10
    )


def test_the_same_lens_in_two_conventions():
    """Half a pixel between the corners, and p1 and p2 exchanged."""
    k1, k2, p1, p2, k3 = -0.1, 0.05, 2e-4, -3e-4, 0.01
    opencv = Camera.from_opencv(
        8000.0, 8000.0, 4009.5, 2989.5, (k1, k2, p1, p2, k3), pixel_size_um=4.0
    )
    lens = {"k1": k1, "k2": k2, "k3": k3, "p1": p2, "p2": p1}
    metashape = Camera.from_metashape(
        8000.0, (8000, 6000), (10.0, -10.0), lens, pixel_size_um=4.0
    )
    xy = over_the_image(opencv)
    difference = metashape.measured_from_xy(xy) - opencv.measured_from_xy(xy)
    np.testing.assert_allclose(difference, 0.5, atol=1e-11)


def test_pixels_of_a_scanned_photograph():
    corner = SCANNED.xy_from_measured([7700.0, 7650.0])
    plain = Camera.from_mm(152.67, (0.012, -0.007), {"k1": 2e-8})
    np.testing.assert_allclose(corner, plain.xy_from_measured([0.0, 0.0]), atol=1e-12)
    right, down = SCANNED.xy_from_measured([[8700.0, 7650.0], [7700.0, 8650.0]])
    assert right[0] - corner[0] == pytest.approx(15.0, abs=1e-3)
    assert down[1] - corner[1] == pytest.approx(-15.0, abs=1e-3)


def test_pixels_that_are_not_square():
    """A row is as far from the middle as rows are high, in the mean of the lens."""
    middle = np.array([7700.0, 7650.0])
    square, oblong = (c.xy_from_measured(middle) for c in (SCANNED, OBLONG))
    np.testing.assert_allclose(square, oblong, rtol=0, atol=1e-9)
    away = OBLONG.measured_from_xy([0.0, 15.1]) - OBLONG.measured_from_xy([0.0, 0.0])
    assert away[1] == pytest.approx(-1000.0, abs=0.01)
    away = OBLONG.measured_from_xy([15.0, 0.0]) - OBLONG.measured_from_xy([0.0, 0.0])
    assert away[0] == pytest.approx(1000.0, abs=0.01)


def test_without_distortion_it_is_a_shift_and_a_scale():
    camera = Camera.from_opencv(8000.0, 8000.0, 4000.0, 3000.0, pixel_size_um=5.0)
    assert camera.principal_distance_mm == pytest.approx(40.0)
    found = camera.xy_from_measured([[4000.0, 3000.0], [5000.0, 2000.0]])
    np.testing.assert_allclose(found, [[0.0, 0.0], [5.0, 5.0]], atol=1e-14)


def test_no_inverse_where_the_polynomial_turns_back():
    camera = Camera.from_opencv(1000.0, 1000.0, 0.0, 0.0, (-1.0,), pixel_size_um=5.0)
    # r - r³ is largest for r = 1/√3: it reaches 385 pixels
    found = camera.xy_from_measured([[384.0, 0.0], [386.0, 0.0], [100.0, 0.0]])
    assert np.isfinite(found).all(axis=1).tolist() == [True, False, True]


# --------------------------------------------------------------------------- complaints


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: Camera.from_opencv(8.0, 8.0, 0.0, 0.0, pixel_size_um=4.5),
            r"principal distance of 0\.036 mm; expected 1 to 5000 mm. Check the unit",
        ),
        (
            lambda: Camera.from_mm(153.0, distortion={"k4": 1.0}),
            r"distortion has the unknown coefficient 'k4'; expected k1, k2, k3, p1, p2",
        ),
        (
            lambda: Camera.from_opencv(
                8e3, 8e3, 0, 0, [0, 0, 0, 0, 0, 1], pixel_size_um=4
            ),
            r"distortion has 6 coefficients; expected k1, k2, p1, p2, k3",
        ),
        (
            lambda: Camera.from_micmac(
                1e-90, (4e3, 3e3), {"k5": 1.0}, (1e90, -1e90), pixel_size_um=4.5
            ),
            r"principal distance of 4\.5e-93 mm; expected 1 to 5000 mm",
        ),
        (
            lambda: Camera.from_micmac(0.0, (4e3, 3e3), pixel_size_um=4.5),
            r"principal distance of 0 mm; expected 1 to 5000 mm",
        ),
        (
            lambda: Camera.from_opencv(8e3, 0.0, 0.0, 0.0, pixel_size_um=4.5),
            "not a finite number, or a scale is zero",
        ),
        (
            lambda: Camera.from_mm(153.0, pixels={"width": 10, "height": 10}),
            "not a finite number, or a scale is zero",
        ),
    ],
)
def test_what_no_camera_has_is_said(make, message):
    with pytest.raises(SettingsError, match=message):
        make()
