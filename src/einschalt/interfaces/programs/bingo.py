"""Files of BINGO, after its manual: geoin.dat, image.dat and itera.dat."""

from einschalt.foundations.rotations import angles_from_rotation, rotation_from_angles
from einschalt.foundations.units import RADIANS_PER_GON
from einschalt.interfaces.files.damaged_files import damaged
from einschalt.interfaces.programs.foreign import (
    Foreign,
    lines_of,
    numbers_of,
    orientations,
    points_on_ground,
    unseen,
)
from einschalt.interfaces.programs.pat_b import read_photos

COMMENTS = ("*", "C ")
GEOIN = "CONT or CHCK, then name E N H"
IMAGE = "a line with the photo, lines of point x y [mm], and -99"
ITERA = "ORIA photo X Y Z phi omega kappa [gon], and CORD point X Y Z"
ROLES = {"CONT": "control", "CHCK": "check"}


def read_control(file) -> Foreign:
    """Read control and check points of geoin.dat."""
    lines = [
        line
        for line in lines_of(file, comments=COMMENTS)
        if line.words[0].upper() in ROLES
    ]
    if not lines:
        raise damaged(file.source, "holds no CONT or CHCK", GEOIN)
    values = numbers_of(lines, file.source, 2, 5, GEOIN)
    table = points_on_ground([line.words[1] for line in lines], values)
    table["role"] = [ROLES[line.words[0].upper()] for line in lines]
    return Foreign({"control_points": table}, None, (unseen(file.source),))


def read_images(file) -> Foreign:
    """Read image coordinates of image.dat [mm]."""
    return read_photos(file, factor=1.0, expected=IMAGE)


def read_result(file) -> Foreign:
    """Read orientations and points of itera.dat."""
    lines = lines_of(file, comments=COMMENTS)
    photos = [line for line in lines if line.words[0].upper() == "ORIA"]
    points = [line for line in lines if line.words[0].upper() == "CORD"]
    if not photos and not points:
        raise damaged(file.source, "holds no ORIA or CORD", ITERA)
    tables = {}
    if photos:
        values = numbers_of(photos, file.source, 2, 8, ITERA)
        phi, omega, kappa = (values[:, 3:] * RADIANS_PER_GON).T
        # from the ground to the image: phi first, then omega, then kappa
        turn = rotation_from_angles(omega, 0.0, kappa)
        turn = turn @ rotation_from_angles(0.0, phi, 0.0)
        angles = angles_from_rotation(turn)
        names = [line.words[1] for line in photos]
        tables["orientations"] = orientations(names, values[:, :3], angles)
    if points:
        values = numbers_of(points, file.source, 2, 5, ITERA)
        table = points_on_ground([line.words[1] for line in points], values)
        tables["control_points"] = table.assign(role="new")
    return Foreign(tables, None, (unseen(file.source),))
