"""block.toml with comments: of what was found in files, and a template for the hand."""

import os
from pathlib import Path

import tomli_w

from einschalt.foundations.kept_texts import retold
from einschalt.foundations.language import mark, mark_each, translated
from einschalt.interfaces.files.block_parts import FLIGHT_TABLES
from einschalt.interfaces.new_block.looked_at import PITCH

HEAD = mark(
    "# A block of einschalt. What is behind a # is a comment: why a value is what it "
    "is, or\n# what else could stand here. `einschalt check` says everything that is "
    "wrong.\n"
)
MORE = mark_each(
    {
        "control_points": "# may_be_unmeasured = true       "
        "# where points may lie in no model\n",
        "approximate_points": "# m_0_m = 0.10                   "
        "# TOTAL standard error of these points, metres\n",
        "flight": '# transformation = "affine"      '
        "# affine, helmert, rigid or helmert_3d\n",
    }
)
SHOWN = {"approximate_points": "m_0_m", "flight": "transformation"}  # in MORE
WITH_PITCH = mark("# of {file}, which does not say how large a pixel is")
TEMPLATE = mark("""\
# A block of einschalt: this file and the tables that it names, all in one folder.
# Lines that begin with # are examples. `einschalt check FOLDER` says what is wrong.

[block]
name = "My block"
# project = "Survey of 2026"     # both stand at the head of the report
# operator = "A. Surveyor"
crs = "EPSG:31255"               # of all ground coordinates; a local block has none

[control_points]                 # point_id, easting, northing [, height, role]
file = "control_points.csv"      # or .xlsx, .ods, .gpkg, .shp, .geojson, .parquet
standard_error_m = 0.03          # TOTAL, where the table has no such column
# sheet = "Punkte"               # of a workbook
# layer = "points"               # of a GeoPackage
# columns = {easting = "Y_GK", northing = "X_GK"}
# decimal = ","                  # where the numbers of the table do not tell

[high_flight]                    # or [approximate_points] in its place
scale_number = 15000
m_g_um = 7.5                     # TOTAL error of one setting in the image, micrometres
model_points = "high_flight.csv" # coverage, model_id, point_id, x, y [, z, n_settings]
model_unit = "mm"                # mm, cm, m or um
# transformation = "affine"      # affine, helmert, rigid or helmert_3d

# [approximate_points]
# file = "approximate_points.csv"
# m_0_m = 0.10                   # TOTAL standard error of these points, metres

[low_flight]
scale_number = 8000
m_g_um = 5.0
model_points = "low_flight.csv"
# instead of model_points, a flight of image coordinates:
# image_points = "image_points.csv" # image_id, point_id, x, y [mm]
# models = "models.csv"          # coverage, model_id, left_image, right_image
# principal_distance_mm = 153.0  # or camera = "camera.toml"
# and parallaxes, which orient machine models:
# y_parallaxes = "y_parallaxes.csv"
# base = "models.csv"

[settings]
# tolerance = 0.05               # metres: which points keep to it is said
""")


def block_text(proposal, folder, name):
    """Text of block.toml for a proposal; files are named from the folder."""
    sections = ["block", "control_points", "approximate_points", "high_flight"]
    present = {section for section, _ in (*proposal.tables, *proposal.values)}
    present |= {"block"}
    lines = [translated(HEAD)]
    for section in [*sections, "low_flight", "settings"]:
        if section not in present:
            continue
        lines.append(f"[{section}]")
        if section == "block":
            lines.append(_key("name", name))
        lines += _values(proposal, section)
        lines += _tables(proposal, section, folder)
        lines.append(_more(proposal, section))
    return "\n".join(lines).rstrip("\n") + "\n"


def _more(proposal, section):
    """What else could stand in a section, unless it stands there."""
    kind = "flight" if section.endswith("flight") else section
    stands = (section, SHOWN.get(kind)) in proposal.values
    return translated(MORE[kind]) if kind in MORE and not stands else ""


def _key(name, value, comment=""):
    text = tomli_w.dumps({name: value}).rstrip("\n")
    return f"{text}  # {' '.join(comment.split())}" if comment else text


def _values(proposal, section):
    lines = []
    for (own, key), guess in proposal.values.items():
        if own != section or key == PITCH:  # which stands in its camera
            continue
        if guess is None:
            lines.append(f"# {key} = …")
        else:
            value = guess.value
            is_whole = isinstance(value, float) and value.is_integer()
            value = int(value) if is_whole else value
            lines.append(_key(key, value, retold(guess.reason)))
    return lines


def _tables(proposal, section, folder):
    lines = []
    for (own, key), table in proposal.tables.items():
        if own != section:
            continue
        file = _relative(table.path, folder)
        if key == "camera" and table.lacks_pitch:
            pitch = proposal.values[section, PITCH].value
            lines.append(translated(WITH_PITCH, file=file))
            lines.append(_inline(key, {**table.camera, PITCH: float(pitch)}))
            continue
        said = {
            "sheet": table.said.sheet,
            "layer": table.said.layer,
            "decimal": table.said.decimal,
            "angles": table.said.angles if "longitude" in table.frame else None,
            "columns": table.said.columns or None,
            "crs": _crs_of_its_own(table, proposal.values.get(("block", "crs"))),
            "where": table.said.where or None,
        }
        said = {name: value for name, value in said.items() if value is not None}
        if key == "file":
            lines.append(_key("file", file, table.description))
            lines += [_inline(name, value) for name, value in said.items()]
        elif said and key in FLIGHT_TABLES:
            lines.append(_inline(key, {"file": file, **said}))
        else:
            lines.append(_key(key, file, table.description))
    return lines


def _crs_of_its_own(table, of_block):
    """System of ground points that is not that of the block, where a user says it.

    ``of_block``: guess of that, or None. A file that states one needs no word.
    """
    if table.kind != "ground" or table.crs is not None:
        return None
    is_other = of_block is not None and table.said.crs != of_block.value
    return table.said.crs if is_other or "longitude" in table.frame else None


def _inline(name, value):
    """A key whose value is a table, on one line."""
    return f"{name} = {_inline_value(value)}"


def _inline_value(value):
    if not isinstance(value, dict):
        return tomli_w.dumps({"x": value}).rstrip("\n").removeprefix("x = ")
    parts = (
        f"{tomli_w.dumps({k: 1}).partition(' = ')[0]} = {_inline_value(v)}"
        for k, v in value.items()
    )
    return f"{{{', '.join(parts)}}}"


def _relative(path, folder):
    """Path of a file from the folder, as TOML and every system take it."""
    try:
        return Path(os.path.relpath(path.resolve(), Path(folder).resolve())).as_posix()
    except ValueError:  # another drive
        return path.resolve().as_posix()
