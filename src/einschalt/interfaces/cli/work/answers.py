"""Options that answer what is otherwise asked of block.toml."""

COMMAS_ANSWERED = {
    'Say angles = "D.MMSS"': (
        "Give --angles D.MMSS or --angles degrees, or write [D.MMSS] or [deg] behind "
        "the names in the header"
    ),
    'decimal = ","': (
        "Give --decimal , if they are decimal commas; otherwise take them out"
    ),
}
# of convert, which has no other columns than those that a table names
OF_TABLES = COMMAS_ANSWERED | {
    "Give --points-crs": (
        "Say which by --crs, such as --crs EPSG:4326, or the system of the receiver"
    ),
    "in block.toml, or correct crs": (
        "Call the two columns easting and northing as they are, or correct --crs"
    ),
    "leave them out to take the geometry": (
        "Correct one of them in the layer, or export it without these columns"
    ),
    "Say crs, such as EPSG:5514": (
        "Name the system by --crs, such as EPSG:5514 for S-JTSK, or call the two "
        "columns easting and northing"
    ),
    "Say columns = {easting": (
        "Name the system by --crs, or write a line point_id, easting, northing, or the "
        "other way round, above the values"
    ),
    "Name it: columns": "Rename that column to point_id",
    "Say which: columns": "Rename the one that is not meant",
    "say columns in block.toml": (
        "Name the columns as docs/tables.md has them, in the first line"
    ),
    'Say which: sheet = "': "Say which by --sheet",
}
