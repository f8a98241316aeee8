"""Systems that a user names for ground points: whether there are points for them."""

from einschalt.foundations.coordinate_operations import system_label
from einschalt.foundations.errors import SettingsError
from einschalt.foundations.projections import read_source_crs


def require_used(found, said, of_block):
    """Refuse a system of the ground points that no table takes."""
    if said.degrees_crs:
        degrees = [one for one in found if "longitude" in one.frame]
        _require_use(said.degrees_crs, degrees)
    elif said.crs != of_block:
        grounds = [one for one in found if one.kind == "ground"]
        if grounds:  # that there are none is said
            _require_use(said.crs, grounds)


def _require_use(crs, tables):
    """Refuse a system that none of some tables of ground points takes."""
    if not tables:
        raise SettingsError(
            "--points-crs is about longitudes and latitudes, which no file holds",
            expected="options of what the files hold",
            remedy="Leave it out, or name the file after --from",
        )
    given = read_source_crs(crs)
    # a layer keeps the system that it states
    stated = [one.crs and read_source_crs(one.crs) for one in tables]
    if all(one and not one.equals(given, ignore_axis_order=True) for one in stated):
        raise SettingsError(
            f"--points-crs = {system_label(given)}, but the file states "
            f"{system_label(stated[0])}",
            expected="the system of the file",
            remedy="Leave it out; if the file is wrong, correct its system in a GIS",
            file=tables[0].title,
        )
