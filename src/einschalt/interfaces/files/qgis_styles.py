"""How the layers of a GeoPackage look when QGIS opens them, and what columns are.

QGIS takes the default style of a layer from the table ``layer_styles`` of the same
file. The symbols are files in ``styles/``, in both forms that QGIS 3 has had for their
properties; names of points, map tips, names of columns with their units, and colours by
precision are added to them. Other programs find the columns explained in
``gpkg_data_columns``.
"""

import sqlite3
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from xml.sax.saxutils import escape, quoteattr

from einschalt.foundations.column_meanings import meaning_of
from einschalt.interfaces.reports.precision_colours import STEPS, error_range

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
# the schema extension of GeoPackage 1.2
CREATE_COLUMNS = """
CREATE TABLE gpkg_data_columns (
  table_name TEXT NOT NULL, column_name TEXT NOT NULL, name TEXT, title TEXT,
  description TEXT, mime_type TEXT, constraint_name TEXT,
  CONSTRAINT pk_gdc PRIMARY KEY (table_name, column_name),
  CONSTRAINT gdc_tn UNIQUE (table_name, name)
)"""
CREATE_EXTENSIONS = """
CREATE TABLE IF NOT EXISTS gpkg_extensions (
  table_name TEXT, column_name TEXT, extension_name TEXT NOT NULL,
  definition TEXT NOT NULL, scope TEXT NOT NULL,
  CONSTRAINT ge_tce UNIQUE (table_name, column_name, extension_name)
)"""
INSERT_EXTENSION = """
INSERT INTO gpkg_extensions VALUES ('gpkg_data_columns', NULL, 'gpkg_schema',
  'http://www.geopackage.org/spec120/#extension_schema', 'read-write')"""
INSERT_COLUMN = """
INSERT INTO gpkg_data_columns (table_name, column_name, name, title, description)
VALUES (?, ?, ?, ?, ?)"""


LAYERS = ("models", "residual_vectors", "ellipses", "points")
# what is shown where the mouse rests; expressions of QGIS stand between [% and %]
MAP_TIPS = {
    "points": '<b>[% "point_id" %]</b> [% "role" %]<br>'
    'E [% round("easting", 3) %]<br>N [% round("northing", 3) %]',
    "residual_vectors": '<b>[% "point_id" %]</b> in [% "model_id" %]<br>'
    '[% round(100 * "residual_easting", 1) %] cm east, '
    '[% round(100 * "residual_northing", 1) %] cm north',
    "ellipses": '<b>[% "point_id" %]</b><br>[% round(100 * "semi_major", 1) %] cm x '
    '[% round(100 * "semi_minor", 1) %] cm',
    "models": '<b>[% "model_id" %]</b> [% "flight" %], coverage [% "coverage" %]<br>'
    "[% coalesce(\"reason\", '') %]",
}
TIP_OF_ERROR = '<br>[% round(100 * "{}", 1) %] cm total'
NAMED = "points"  # the layer whose points are named on the map
LABELS = """
 <labeling type="simple"><settings calloutType="simple">
  <text-style fieldName="point_id" isExpression="0" fontSize="8" fontSizeUnit="Point"
   fontFamily="Sans Serif" textColor="35,35,35,255" textOpacity="1">
   <text-buffer bufferDraw="1" bufferSize="0.7" bufferSizeUnits="MM"
    bufferColor="255,255,255,255" bufferOpacity="0.8"/>
  </text-style>
  <placement placement="6" dist="0.5" distUnits="MM"/>
  <rendering scaleVisibility="1" scaleMin="1" scaleMax="25000" obstacle="0"/>
 </settings></labeling>"""
# a property of a symbol that follows the feature
COLOURED = """
     <data_defined_properties><Option type="Map">
      <Option type="QString" name="name" value=""/>
      <Option type="Map" name="properties"><Option type="Map" name="fillColor">
       <Option type="bool" name="active" value="true"/>
       <Option type="QString" name="expression" value={}/>
       <Option type="int" name="type" value="3"/>
      </Option></Option>
      <Option type="QString" name="type" value="collection"/>
     </Option></data_defined_properties>"""
NEW_LABEL = 'label="new point"'
END_OF_SYMBOL = "\n    </layer>"
END = "</qgis>"


@dataclass(frozen=True)
class Claim:
    """The column of total errors that is to be believed, and its range [m]."""

    column: str
    low: float
    high: float


def claim_of(result):
    """What the colours of the new points say; None where none has a standard error."""
    points, column = result.points, result.assessment.credible.column
    if column not in points:
        return None
    error = points.loc[points["role"] == "new", column].dropna().to_numpy(dtype=float)
    return Claim(column, *error_range(error)) if len(error) else None


def title_of(column, layer):
    """A column in words, with its unit.

    >>> title_of("standard_error_total", "points")
    'standard error total [m]'
    """
    unit, _ = meaning_of(column, layer) or ("", "")
    words = column.replace("_", " ")
    return f"{words} [{unit}]" if unit else words


def style_of(layer, columns=(), claim=None):
    """Look of a layer as QML, a file that QGIS loads, changes and saves.

    ``columns``: of the layer; ``claim``: of the points, which are coloured by it.
    """
    file = Path(__file__).with_name("styles") / f"{layer}.qml"
    text, tip = file.read_text(encoding="utf-8"), MAP_TIPS[layer]
    is_coloured = claim is not None and layer == NAMED
    if is_coloured:
        text, tip = _coloured(text, claim), tip + TIP_OF_ERROR.format(claim.column)
    more = [
        f"<alias field={quoteattr(name)} index={quoteattr(str(place))} "
        f"name={quoteattr(title_of(name, layer))}/>"
        for place, name in enumerate(columns, 1)  # the first field is fid
    ]
    aliases = f"\n <aliases>{''.join(more)}</aliases>" if more else ""
    labels = LABELS if layer == NAMED else ""
    tip = f"\n <mapTip>{escape(tip)}</mapTip>\n"
    return text.replace(END, f"{labels.strip()}{aliases}{tip}{END}")


def _coloured(text, claim):
    """The style with new points in the colours of their errors, and what they mean."""
    low, high = (f"{100.0 * value:.1f} cm" for value in (claim.low, claim.high))
    said = f'label="new point, total error {low} (yellow) to {high} (violet)"'
    coloured = COLOURED.format(quoteattr(expression_of(claim)))
    text = text.replace(NEW_LABEL, said, 1)
    return text.replace(END_OF_SYMBOL, f"{coloured}{END_OF_SYMBOL}", 1)


def expression_of(claim):
    """Colour of a point as an expression of QGIS; white where it has no error."""
    name, width = f'"{claim.column}"', (claim.high - claim.low) / len(STEPS)
    colours = [f"'{red},{green},{blue}'" for red, green, blue in STEPS]
    bounds = [claim.low + width * step for step in range(1, len(STEPS))]
    cases = (
        f"WHEN {name} < {bound:.6g} THEN {colour}"
        for bound, colour in zip(bounds, colours, strict=False)
    )
    missing = f"WHEN {name} IS NULL THEN '255,255,255'"
    return f"CASE {missing} {' '.join(cases)} ELSE {colours[-1]} END"


def add_styles(path, date, columns, claim=None):
    """Give the ``LAYERS`` of a GeoPackage their default styles, dated in ISO 8601.

    ``columns``: by layer, all but the geometry; they are explained as well.
    """
    with closing(sqlite3.connect(path)) as database, database:
        # nobody sees the file before it is whole, and forced to the disk
        database.execute("PRAGMA synchronous = OFF")
        database.execute("PRAGMA journal_mode = MEMORY")
        database.execute(CREATE)
        database.execute(REGISTER, (date,))
        for layer in LAYERS:
            look = style_of(layer, columns[layer], claim)
            told = f"einschalt: {layer}"
            database.execute(INSERT, (layer, "geom", layer, look, told, date))
        database.execute(CREATE_COLUMNS)
        database.execute(CREATE_EXTENSIONS)
        database.execute(INSERT_EXTENSION)
        database.executemany(INSERT_COLUMN, _explained(columns))


def _explained(columns):
    """Rows of gpkg_data_columns."""
    for layer, names in columns.items():
        for name in names:
            _, meaning = meaning_of(name, layer) or ("", "")
            title = title_of(name, layer)
            yield layer, name, title, title, meaning
