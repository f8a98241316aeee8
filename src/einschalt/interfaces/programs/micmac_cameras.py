"""Calibrations of MicMac and MMVII, as keys of a camera.toml.

Both distort on the way from the ground into the image (``DistM2C``), as Metashape does:
r², r⁴ … along the radius, (r² + 2x², 2xy) and (2xy, r² + 2y²), and (x, 0) and (y, 0).
MicMac counts them in pixels from the centre of the distortion, which is seldom the
principal point: the convention ``micmac`` has its numbers as they are. MMVII has focal
lengths from the principal point, as the convention ``metashape``.
"""

import itertools

from einschalt.interfaces.files.damaged_files import damaged
from einschalt.interfaces.files.plain_xml import each, local, text_of
from einschalt.interfaces.programs.foreign import is_finite

EXPECTED = "a calibration as MicMac writes it"
MOST_RADIAL, MOST_RADIAL_OF_MICMAC = 4, 5
KNOWN_WAY = "eConvApero_DistM2C"
KNOWN_PROJECTION = "Stenope"
# of a point at the corner: the affinity is told of undistorted coordinates by MMVII,
# and of distorted ones in the convention metashape
SMALLEST_PX = 0.1
RADIAL = ("K1", "K2", "K3", "K4")
OTHERS = ("p1", "p2", "b1", "b2")


def cameras_of(root, file):
    """Keys of a camera.toml by the name of the camera; why there are no others.

    A file of MicMac is named as its camera, MMVII says the name.
    """
    keys, unusable = {}, {}
    for one in each(root, "CalibrationInternConique"):
        _add(keys, unusable, file.path.stem, _of_micmac, one, file.source)
    for one in each(root, "InternalCalibration"):
        name = text_of(one, "Name").strip('"') or file.path.stem
        _add(keys, unusable, name, _of_mmvii, one, file.source)
    return keys, unusable


def _add(keys, unusable, name, read, element, source):
    try:
        keys[name] = read(element, name, source)
    except _UnknownTermError as error:
        unusable[name] = str(error)


class _UnknownTermError(Exception):
    """A term that camera.toml does not have."""


def _of_micmac(calibration, name, source):
    """Keys of a calibration whose coefficients are in pixels."""
    way = text_of(calibration, "KnownConv") or KNOWN_WAY
    if way != KNOWN_WAY:
        raise _UnknownTermError(
            f"camera {name} distorts by the convention {way}: its calibration is left "
            "out"
        )
    point, size = (_numbers(calibration, n, 2, source) for n in ("PP", "SzIm"))
    (f,) = _numbers(calibration, "F", 1, source)
    _require_image(f, size, source)
    keys = {"convention": "micmac", "f": f, "cx": point[0], "cy": point[1]}
    parts = [o for part in each(calibration, "CalibDistortion") for o in part]
    models = [part for part in parts if local(part) != "ModNoDist"]
    if len(models) > 1:
        raise _UnknownTermError(
            f"camera {name} has {len(models)} distortions one after the other: its "
            "calibration is left out"
        )
    return keys | (_distortion(models[0], name, source) if models else {})


def _distortion(model, name, source):
    """Keys of a distortion, whose coefficients stay as they are."""
    kind = local(model)
    if kind not in ("ModRad", "ModPhgrStd"):
        raise _UnknownTermError(
            f"camera {name} has a distortion of the kind {kind}: its calibration is "
            "left out"
        )
    centre = _numbers(next(each(model, "CDist"), model), None, 2, source)
    radial = [
        _number(one.text, "CoeffDist", source) for one in each(model, "CoeffDist")
    ]
    if any(radial[MOST_RADIAL_OF_MICMAC:]):
        raise _UnknownTermError(
            f"camera {name} has {len(radial)} radial coefficients: its calibration is "
            "left out"
        )
    keys = {"centre_x": centre[0], "centre_y": centre[1]}
    known = radial[:MOST_RADIAL_OF_MICMAC]
    keys |= {f"k{k}": value for k, value in enumerate(known, 1)}
    texts = {term: text_of(model, term) for term in ("P1", "P2", "b1", "b2")}
    others = {term: _number(t, term, source) for term, t in texts.items() if t}
    return keys | {term.lower(): value for term, value in others.items()}


def _of_mmvii(calibration, name, source):
    """Keys of a calibration whose coefficients are in focal lengths."""
    projection = text_of(calibration, "Projection").strip('"')
    if projection not in ("", KNOWN_PROJECTION):
        raise _UnknownTermError(
            f"camera {name} has the projection {projection}: its calibration is left "
            "out"
        )
    frame = next(each(calibration, "PixelFrame"), calibration)
    perfect = next(each(calibration, "PerfectProj"), calibration)
    size = _numbers(frame, "NbPix", 2, source)
    (f,), point = (_numbers(perfect, n, k, source) for n, k in (("F", 1), ("PP", 2)))
    keys = _principal(f, point, size, source)
    parts = [part for one in each(calibration, "Distorsion") for part in one]
    for term in itertools.chain.from_iterable(parts):
        kind, value = local(term), _number(term.text, local(term), source)
        if kind in RADIAL:
            keys[kind.lower()] = value
        elif kind in OTHERS:
            keys[kind] = value * (f if kind.startswith("b") else 1.0)
        elif value:
            raise _UnknownTermError(
                f"camera {name} has the term {kind}: its calibration is left out"
            )
    _require_small_affinity(keys, name)
    return keys


def _require_image(f, size, source):
    if not (f > 0.0 and min(size) >= 1.0):
        found = f"the focal length is {f:g}, the image {size[0]:g} x {size[1]:g} pixels"
        raise damaged(source, found, EXPECTED)


def _principal(f, point, size, source):
    _require_image(f, size, source)
    return {
        "convention": "metashape",
        "f": f,
        "cx": point[0] - size[0] / 2,
        "cy": point[1] - size[1] / 2,
        "width": int(size[0]),
        "height": int(size[1]),
    }


def _require_small_affinity(keys, name):
    """See that the order of affinity and distortion is no matter."""
    f, half = keys["f"], (keys["width"] / 2, keys["height"] / 2)
    square = (half[0] ** 2 + half[1] ** 2) / f**2
    radial = sum(keys.get(f"k{k}", 0.0) * square**k for k in range(1, MOST_RADIAL + 1))
    shear = abs(keys.get("b1", 0.0)) + abs(keys.get("b2", 0.0))
    if shear * abs(radial) * square**0.5 > SMALLEST_PX:
        raise _UnknownTermError(
            f"camera {name} has an affinity beside a large distortion: its calibration "
            "is left out"
        )


def _numbers(element, name, count, source):
    """Numbers of an element below one, or of itself where no name is said."""
    text = (element.text or "") if name is None else text_of(element, name)
    words = text.split()
    if len(words) != count or not all(map(is_finite, words)):
        what = name or local(element)
        raise damaged(source, f"{what}: {text[:60]!r} is not {count} numbers", EXPECTED)
    return [float(word) for word in words]


def _number(text, name, source):
    word = (text or "").strip()
    if not is_finite(word):
        raise damaged(source, f"{name}: {word[:60]!r} is no number", EXPECTED)
    return float(word)
