"""Calibrations of programs that count in pixels, as keys of a camera.toml.

COLMAP, OpenSfM and Pix4D distort as OpenCV does, and need not know how large a pixel
is. Where no file says it, ``pixel_size_um`` is lacking in the keys: it is the user who
knows the sensor, and errors in micrometres would be wrong by whatever is guessed.
"""

import math

NAMES = ("k1", "k2", "p1", "p2", "k3")  # in the order of OpenCV


def corner_keys(fx, fy, cx, cy, size, distortion=(), pixel_size_um=None):
    """Keys of a camera whose pixels are counted from the corner of the image.

    The centre of the first pixel is (0.5, 0.5), as in the convention ``metashape``,
    whose p1 and p2 have the roles of each other. ``size``: width and height;
    ``distortion``: up to five coefficients in the order of OpenCV.

    >>> corner_keys(2000.0, 2001.0, 2010.0, 1490.0, (4000, 3000))["cx"]
    10.0
    """
    width, height = (int(side) for side in size)
    k1, k2, p1, p2, k3 = (*distortion, *[0.0] * (len(NAMES) - len(distortion)))
    keys = {"convention": "metashape", "f": fy, "b1": fx - fy}
    keys |= {"cx": cx - 0.5 * width, "cy": cy - 0.5 * height}
    keys |= {"width": width, "height": height}
    keys |= {"k1": k1, "k2": k2, "k3": k3, "p1": p2, "p2": p1}
    return _with_pitch(keys, pixel_size_um)


def centre_keys(fx, fy, cx, cy, distortion=()):
    """Keys of a camera for which the centre of the first pixel is (0, 0), as OpenCV."""
    keys = {"convention": "opencv", "fx": fx, "fy": fy, "cx": cx, "cy": cy}
    return _with_pitch(keys | dict(zip(NAMES, distortion, strict=False)))


def _with_pitch(keys, pixel_size_um=None):
    plain = (str, int)
    keys = {n: v if isinstance(v, plain) else float(v) for n, v in keys.items()}
    is_known = pixel_size_um is not None and math.isfinite(pixel_size_um)
    return keys | ({"pixel_size_um": float(pixel_size_um)} if is_known else {})


def without_pitch(cameras, source):
    """Notes on cameras of whose pixels no size is known: one, or none."""
    if all("pixel_size_um" in keys for keys in cameras.values()):
        return []
    return [
        f"{source}: does not say how large a pixel is: add pixel_size_um to camera.toml"
    ]
