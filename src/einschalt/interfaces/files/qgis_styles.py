"""How the layers of a GeoPackage look when QGIS opens them.

QGIS takes the default style of a layer from the table ``layer_styles`` of the same
file. Symbols are written in both forms that QGIS 3 has had for their properties.
"""

import sqlite3
from contextlib import closing
from dataclasses import dataclass
from xml.sax.saxutils import quoteattr

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


@dataclass(frozen=True)
class Category:
    """Features of one value: what they are called, and how they are drawn."""

    value: str
    label: str
    properties: dict


@dataclass(frozen=True)
class Style:
    """Look of one layer: an expression, and a category for each of its values.

    ``kind`` and ``symbol`` are QGIS's names: marker and SimpleMarker, line and
    SimpleLine, fill and SimpleFill.
    """

    kind: str
    symbol: str
    expression: str
    categories: tuple[Category, ...]

    def as_qml(self):
        """Return the style as QGIS stores it.

        Returns
        -------
        str
        """
        categories = "".join(
            f'<category symbol="{place}" render="true" type="string" '
            f"value={quoteattr(c.value)} label={quoteattr(c.label)}/>"
            for place, c in enumerate(self.categories)
        )
        symbols = "".join(
            self._symbol(place, c.properties) for place, c in enumerate(self.categories)
        )
        return (
            '<!DOCTYPE qgis PUBLIC "http://mrcc.com/qgis.dtd" "SYSTEM">'
            '<qgis version="3.22.0" styleCategories="Symbology">'
            '<renderer-v2 type="categorizedSymbol" symbollevels="0" forceraster="0" '
            f'enableorderby="0" attr={quoteattr(self.expression)}>'
            f"<categories>{categories}</categories><symbols>{symbols}</symbols>"
            "</renderer-v2><blendMode>0</blendMode>"
            "<featureBlendMode>0</featureBlendMode></qgis>"
        )

    def _symbol(self, place, properties):
        options = "".join(
            f'<Option type="QString" name={quoteattr(k)} value={quoteattr(v)}/>'
            for k, v in properties.items()
        )
        older = "".join(
            f"<prop k={quoteattr(k)} v={quoteattr(v)}/>" for k, v in properties.items()
        )
        return (
            f'<symbol type="{self.kind}" name="{place}" alpha="1" clip_to_extent="1" '
            f'force_rhr="0"><layer class="{self.symbol}" enabled="1" locked="0" '
            f'pass="0"><Option type="Map">{options}</Option>{older}</layer></symbol>'
        )


def _marker(value, label, shape, color, size):
    properties = {
        "name": shape,
        "color": color,
        "outline_color": "35,35,35,255",
        "outline_width": "0.2",
        "outline_width_unit": "MM",
        "size": size,
        "size_unit": "MM",
    }
    return Category(value, label, properties)


def _line(value, label, color):
    properties = {"line_color": color, "line_width": "0.35", "line_width_unit": "MM"}
    return Category(value, label, properties)


def _outline(value, label, color, pen="solid"):
    properties = {
        "style": "no",
        "outline_style": pen,
        "outline_color": color,
        "outline_width": "0.26",
        "outline_width_unit": "MM",
    }
    return Category(value, label, properties)


STYLES = {
    "models": Style(
        "fill",
        "SimpleFill",
        "CASE WHEN is_usable THEN flight ELSE 'unusable' END",
        (
            _outline("unusable", "not usable", "200,30,30,255", "dash"),
            _outline("high_flight", "model of the high flight", "90,90,90,255"),
            _outline("low_flight", "model of the low flight", "150,180,210,255"),
        ),
    ),
    "residual_vectors": Style(
        "line",
        "SimpleLine",
        "flight",
        (
            _line("high_flight", "residual, high flight", "213,94,0,255"),
            _line("low_flight", "residual, low flight", "0,114,178,255"),
        ),
    ),
    "ellipses": Style(
        "fill",
        "SimpleFill",
        "role",
        (
            _outline("new", "ellipse of a new point", "60,60,60,255"),
            _outline("control", "ellipse of a control point", "213,94,0,255"),
            _outline("check", "ellipse of a check point", "0,158,115,255"),
        ),
    ),
    "points": Style(
        "marker",
        "SimpleMarker",
        "role",
        (
            _marker("new", "new point", "circle", "255,255,255,255", "1.6"),
            _marker("control", "control point", "triangle", "213,94,0,255", "3.2"),
            _marker("check", "check point", "square", "0,158,115,255", "2.6"),
        ),
    ),
}


def add_styles(path, date):
    """Give the layers of a GeoPackage their default styles.

    Parameters
    ----------
    path : Path
        Holds layers named as ``STYLES``, with their geometries in ``geom``.
    date : str
        Said as the time of the change, ISO 8601.

    Raises
    ------
    sqlite3.Error
        The file cannot be written.
    """
    with closing(sqlite3.connect(path)) as database, database:
        database.execute(CREATE)
        database.execute(REGISTER, (date,))
        database.executemany(
            INSERT,
            [
                (layer, "geom", layer, style.as_qml(), f"einschalt: {layer}", date)
                for layer, style in STYLES.items()
            ],
        )
