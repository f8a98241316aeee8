"""What a user says of all tables of a block that is being made."""

from einschalt.foundations.projections import read_source_crs
from einschalt.interfaces.files.understood_tables import Said


def said_of_tables(columns, *, crs=None, points_crs=None, decimal=None, angles=None):
    """How tables are to be understood, as options or fields of a form say it.

    Parameters
    ----------
    columns : dict
        Column that is meant, by the name that it has here; None or "" where not said.
    crs : str, optional
        System of the block.
    points_crs : str, optional
        System of the points, if it is another one: that of longitudes and latitudes, or
        a plane one. A ProjectionError where it is unknown.
    decimal, angles : str, optional
        As of :class:`Said`.

    Returns
    -------
    Said
    """
    is_plane = bool(points_crs) and not read_source_crs(points_crs).is_geographic
    return Said(
        columns={name: column for name, column in columns.items() if column},
        decimal=decimal or None,
        angles=angles or None,
        # longitudes and latitudes are found by their names, in whatever plane system
        crs=points_crs if is_plane else crs or None,
        degrees_crs=None if is_plane else points_crs or None,
    )
