"""How the layers of a GeoPackage look when QGIS opens them.

QGIS takes the default style of a layer from the table ``layer_styles`` of the same
file. The styles themselves are files in ``styles/``; symbols stand there in both forms
that QGIS 3 has had for their properties.
"""

import sqlite3
from contextlib import closing
from pathlib import Path

CREATE = """
CREATE TABLE layer_styles (
  id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL,
  f_table_catalog TEXT(256), f_table_schema TEXT(256),
  f_table_name TEXT(256), f_geometry_column TEXT(256),
  styleName TEXT(30), styleQML TEXT, styleSLD TEXT, useAsDefault BOOLEAN,
  description TEXT, owner TEXT(30), ui TEXT(30), update_time DATETIME
)"""
REGISTER = """
INSERT INTO gpkg_contents (table_name, data_type, identifier, last_change)
VALUES ('layer_styles', 'attributes', 'layer_styles', ?)"""
INSERT = """
INSERT INTO layer_styles (
  f_table_catalog, f_table_schema, f_table_name, f_geometry_column,
  styleName, styleQML, styleSLD, useAsDefault, description, owner, update_time
) VALUES ('', '', ?, ?, ?, ?, '', 1, ?, '', ?)"""


LAYERS = ("models", "residual_vectors", "ellipses", "points")


def style_of(layer):
    """Look of a layer as QML, a file that QGIS loads, changes and saves."""
    file = Path(__file__).with_name("styles") / f"{layer}.qml"
    return file.read_text(encoding="utf-8")


def add_styles(path, date):
    """Give the ``LAYERS`` of a GeoPackage their default styles, dated in ISO 8601."""
    with closing(sqlite3.connect(path)) as database, database:
        database.execute(CREATE)
        database.execute(REGISTER, (date,))
        database.executemany(
            INSERT,
            [
                (layer, "geom", layer, style_of(layer), f"einschalt: {layer}", date)
                for layer in LAYERS
            ],
        )
