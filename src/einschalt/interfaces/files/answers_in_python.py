"""Remedies of ``es.read_points``: what block.toml says of a table, arguments do."""

# by words of the remedies in whose place they stand, the first that fits
OF_ARGUMENTS = {
    'Say which: layer = "': "Say which by the argument layer",
    'Say which: sheet = "': "Say which by the argument sheet",
    "Say crs, such as EPSG:5514": (
        'Give crs, such as "EPSG:5514" for S-JTSK, or columns={"easting": …, '
        '"northing": …}'
    ),
    "Say columns = {easting": (
        'Give columns={"easting": …, "northing": …}, or the crs, which tells its axes'
    ),
    "Say which: columns": (
        "Give columns with the one that is meant, or rename the other"
    ),
    'Say crs = "EPSG:4326"': (
        'Give crs="EPSG:4326", or the system of the receiver: longitudes and latitudes '
        "are read then"
    ),
    "Correct columns in block.toml": "Correct columns",
    'Say angles = "D.MMSS"': (
        'Give angles="D.MMSS" or angles="degrees", or write [D.MMSS] or [deg] behind '
        "the names in the header"
    ),
    'Say decimal = ","': (
        'Give decimal="," if they are decimal commas; otherwise take them out'
    ),
    'Take decimal = ","': "Leave decimal out, or correct the number",
}
