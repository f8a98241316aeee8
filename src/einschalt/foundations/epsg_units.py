"""Units, and systems of heights, by their codes of EPSG, as GeoTIFF names them."""

from functools import cache

import pyproj

METRE = 9001


@cache
def unit_label(code):
    """Name of a unit with its code; the code alone where there is none.

    >>> unit_label(9002)
    'foot (EPSG:9002)'
    """
    known = pyproj.database.get_units_map(auth_name="EPSG", allow_deprecated=True)
    names = [name for name, unit in known.items() if unit.code == str(code)]
    return f"{names[0]} (EPSG:{code})" if names else f"EPSG:{code}"


@cache
def system_of_heights(code):
    """Name of a system with heights, the name of their unit, and its length [m].

    None where the code is no such system of EPSG's.

    >>> name, unit, metres = system_of_heights(6360)
    >>> name, unit, round(metres, 6)
    ('NAVD88 height (ftUS)', 'US survey foot', 0.304801)
    """
    try:
        system = pyproj.CRS.from_epsg(code)
    except pyproj.exceptions.CRSError:
        return None
    if not (system.is_vertical or len(system.axis_info) == 3):
        return None
    axis = system.axis_info[-1]
    return system.name, axis.unit_name, axis.unit_conversion_factor
