"""Sound files of every kind that einschalt reads: what mutations begin with."""

import io
import json
import tempfile
from pathlib import Path

import pandas as pd
import pyarrow as pa
import pyogrio
import shapely
from PIL import Image, TiffImagePlugin
from pyarrow import parquet

NAMES = ("0012", "0013", "14", "7/8", "P,1", "7/10", "21", "22", "23")
SPACING = 500.0
PRINCIPAL_DISTANCE = 153.0  # mm
HEIGHT = 1224.0  # of the flight above the ground, metres
BASE = 500.0
BLOCK = """\
[block]
name = "Nine points"
crs = "EPSG:31255"

[control_points]
file = "control_points.csv"
crs = "EPSG:31255"
standard_error_m = 0.03
may_be_unmeasured = true

[high_flight]
scale_number = 15000
m_g_um = 7.5
transformation = "affine"
model_points = "high_flight.csv"

[low_flight]
scale_number = 8000
m_g_um = 5.0
transformation = 'helmert'
model_points = "low_flight.csv"
model_unit = "mm"

[settings]
coverage_mean = "most_central"
significance = 0.01
"""
IMAGES = """\
[block]
crs = "EPSG:31255"
[control_points]
file = "control_points.csv"
[approximate_points]
file = "approximate_points.csv"
m_0_m = 1e-1
[low_flight]
scale_number = 8_000
m_g_um = 5
transformation = "helmert_3d"
image_points = "image_points.parquet"
models = "models.csv"
orientation_case = "dependent_right"
[low_flight.camera]
convention = "metashape"
f = 38250.0
width = 60_000
height = 60_000
pixel_size_um = 4.0
k1 = -1e-6
"""
PARALLAXES = """\
[control_points]
file = "control_points.csv"
[approximate_points]
file = "approximate_points.csv"
m_0_m = 0.1
[low_flight]
scale_number = 8000
m_g_um = 5
transformation = "helmert_3d"
model_points = "low_flight.csv"
y_parallaxes = "y_parallaxes.csv"
base = "bases.csv"
orientation_method = "least_squares"
"""
CAMERAS = (
    (
        'convention = "opencv"\nfx = 3000.5\nfy = 3001\ncx = 2000.0\ncy = 1500.0\n'
        "k1 = -0.1\nk2 = 0.01\np1 = 1e-4\npixel_size_um = 4.0\n"
    ),
    (
        '[camera]\nconvention = "mm"\nc = 153.0\nx0 = 0.01\ny0 = -0.02\nk1 = 1e-8\n'
        "pixel_size_um = 4.0\nwidth = 4000\nheight = 3000\n"
    ),
)


PLANS = (
    (
        '{"format": 1, "expected": 0.05, "figures": {}, "frame": null, "area": null, '
        '"design": {"scale_number": 8000, "spacing": 300, "m_g_um": 5, "width": null}}'
    ),
    (
        '{"format": 1, "expected": 0.05, "figures": {"cost": 1.5}, "frame": {"kind": '
        '"affine", "max_height": 2000.0, "costs": {"image": 10}}, "area": '
        '{"geometry": {"type": "Polygon", "coordinates": [[[0, 0], [9e3,0], [9e3,8e3],'
        '[0, 0]]]}, "crs": "EPSG:31255", "name": "north", "heights": null, "follows": '
        'false}, "design": {"scale_number": 8000.0, "spacing": 300, "m_g_um": 5.5, '
        '"image_format": [0.23, 0.2], "most_work": null, "kind": "helmert"}}'
    ),
)


def _points():
    """Number, name, and position [m] of nine points, on ground that is not level."""
    for k, name in enumerate(NAMES):
        yield k, name, SPACING * (k % 3), SPACING * (k // 3), 20.0 * (7 * k % 5)


def _quoted(name):
    return f'"{name}"' if "," in name else name


def _control():
    lines = ["point_id;easting;northing;height;standard_error_m;role"]
    for k, name, easting, northing, height in _points():
        role = "check" if k == 5 else "control"
        if k != 4:
            place = f"{13000 + easting:.2f};{322000 + northing:.2f};{height}"
            lines.append(f"{name};{place};0.03;{role}")
    return "\r\n".join([*lines, ""])


def _approximate():
    lines = ["point_id,easting,northing,height"]
    for _, name, easting, northing, height in _points():
        lines.append(f"{_quoted(name)},{13000 + easting},{322000 + northing},{height}")
    return "\n".join([*lines, ""])


def _model_points(scale_number):
    lines = ["coverage,model_id,point_id,x,y,z,n_settings,remark"]
    for coverage in (1, 2):
        for model, first in (("11/12", 0), ("12/13", 3)):
            for k, name, *ground in _points():
                if first <= k < first + 6:
                    x, y, z = (1e3 * value / scale_number for value in ground)
                    lines.append(
                        f"{coverage},{model},{_quoted(name)},{x + 10.125:.4f},"
                        f"{y + 20 + 1e-3 * (k % 2):.4f},{z - 152.5:.4f},2,"
                    )
    return "\n".join([*lines, ""])


def _y_parallaxes():
    lines = ["model_id,point_id,x,y,z,y_parallax"]
    for model, first in (("11/12", 0), ("12/13", 3)):
        for k, name, easting, northing, height in _points():
            if first <= k < first + 6:
                x, y = (easting - SPACING) / 8.0, (northing - SPACING) / 8.0
                lines.append(
                    f"{model},{_quoted(name)},{x},{y},{height / 8 - 153},0.0{k}1"
                )
    return "\n".join([*lines, ""])


def _pairs():
    lines = ["model_id\tpoint_id\tx_left\ty_left\tx_right\ty_right"]
    for _, name, easting, northing, height in _points():
        scale = PRINCIPAL_DISTANCE / (HEIGHT - height)
        x, y = scale * (easting - SPACING / 2), scale * (northing - SPACING)
        lines.append(f"7/8\t{name}\t{x:.4f}\t{y:.4f}\t{x - scale * BASE:.4f}\t{y:.4f}")
    return "\n".join([*lines, ""])


def _image_points():
    lines = ["image_id,point_id,x,y"]
    for image, station in (("11", 250.0), ("12", 750.0)):
        for _, name, easting, northing, height in _points():
            scale = PRINCIPAL_DISTANCE / 4e-3 / (HEIGHT - height)
            x, y = scale * (easting - station), scale * (northing - SPACING)
            lines.append(f"{image},{_quoted(name)},{30_000 + x:.3f},{30_000 - y:.3f}")
    return "\n".join([*lines, ""])


TABLES = {
    "control_points.csv": _control(),
    "approximate_points.csv": _approximate(),
    "high_flight.csv": _model_points(15_000.0),
    "low_flight.csv": _model_points(8_000.0),
    "y_parallaxes.csv": _y_parallaxes(),
    "bases.csv": "model_id,base\n11/12,92.0\n12/13,91.5\n",
    "image_pairs.tsv": _pairs(),
    "image_points.csv": _image_points(),
    "models.csv": "coverage,model_id,left_image,right_image\n1,11/12,11,12\n",
    "ground_points.csv": _approximate(),
    "heights.csv": "model_id,h1,h2,h3,h4,h5,h6\n7/8,500,510,498,505,520,1.5e3\n"
    "8/9,500,500,500,500,500,500\n",
}


def as_parquet(text, separator=",", **options):
    """Write a CSV text as Parquet.

    Parameters
    ----------
    text, separator : str
    **options
        ``dtype`` of pandas, and options of ``pyarrow.parquet.write_table``.

    Returns
    -------
    bytes
    """
    kind = options.pop("dtype", None)
    frame = pd.read_csv(io.StringIO(text), sep=separator, dtype=kind)
    table = pa.Table.from_pandas(frame, preserve_index=False)
    file = io.BytesIO()
    parquet.write_table(table, file, **options)
    return file.getvalue()


def as_map_or_workbook(text, suffix):
    """Write a CSV text as a workbook, or its points as a layer.

    Parameters
    ----------
    text : str
    suffix : str
        .xlsx, .ods, .gpkg or .geojson.

    Returns
    -------
    bytes
    """
    frame = pd.read_csv(io.StringIO(text), dtype={"point_id": str})
    driver = {".gpkg": "GPKG", ".geojson": "GeoJSON"}.get(suffix, suffix[1:].upper())
    shapes, kind = None, None
    if suffix in {".gpkg", ".geojson"}:
        plane = frame[["easting", "northing"]].to_numpy()
        shapes, kind = shapely.to_wkb(shapely.points(plane)), "Point"
        frame = frame.drop(columns=["easting", "northing"])
    values = [frame[n].to_numpy(float if n != "point_id" else object) for n in frame]
    options = {"driver": driver, "geometry_type": kind, "layer": "points"}
    crs = {"crs": "EPSG:31255"} if kind else {}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"t{suffix}"
        pyogrio.raw.write(path, shapes, values, list(frame), **options, **crs)
        return path.read_bytes()


def as_geoparquet(text):
    """Write the points of a CSV text as GeoParquet.

    Parameters
    ----------
    text : str

    Returns
    -------
    bytes
    """
    frame = pd.read_csv(io.StringIO(text), dtype={"point_id": str})
    shapes = shapely.to_wkb(shapely.points(frame[["easting", "northing"]].to_numpy()))
    table = pa.table({"point_id": frame["point_id"], "geometry": list(shapes)})
    column = {"encoding": "WKB", "geometry_types": ["Point"]}
    facts = {"version": "1.1.0", "primary_column": "geometry"}
    facts = json.dumps({**facts, "columns": {"geometry": column}})
    file = io.BytesIO()
    parquet.write_table(table.replace_schema_metadata({"geo": facts}), file)
    return file.getvalue()


def as_shapefile(text):
    """Write the points of a CSV text as a shapefile.

    Parameters
    ----------
    text : str

    Returns
    -------
    dict of bytes
        By suffix.
    """
    frame = pd.read_csv(io.StringIO(text), dtype={"point_id": str})
    shapes = shapely.to_wkb(shapely.points(frame[["easting", "northing"]].to_numpy()))
    names = [frame["point_id"].to_numpy(dtype=object)]
    options = {"geometry_type": "Point", "crs": "EPSG:31255"}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "t.shp"
        pyogrio.raw.write(path, shapes, names, ["point_id"], **options)
        return {one.suffix: one.read_bytes() for one in path.parent.iterdir()}


def as_area(suffix):
    """Write a square of a kilometre as a layer.

    Parameters
    ----------
    suffix : str
        .gpkg or .geojson.

    Returns
    -------
    bytes
    """
    square = shapely.box(13_000.0, 322_000.0, 14_000.0, 323_000.0)
    if suffix == ".geojson":
        crs = {"type": "name", "properties": {"name": "EPSG:31255"}}
        feature = {
            "type": "Feature",
            "geometry": json.loads(shapely.to_geojson(square)),
        }
        layer = {"type": "FeatureCollection", "features": [feature], "crs": crs}
        return json.dumps(layer).encode()
    options = {"driver": "GPKG", "geometry_type": "Polygon", "crs": "EPSG:31255"}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"t{suffix}"
        pyogrio.raw.write(path, [shapely.to_wkb(square)], [], [], layer="a", **options)
        return path.read_bytes()


def as_geotiff(image, doubles, keys):
    """Write a GeoTIFF.

    Parameters
    ----------
    image : PIL.Image.Image
    doubles : dict of sequences of float
        By the numbers of their tags.
    keys : sequence of int
        Of the directory of keys.

    Returns
    -------
    bytes
    """
    tags = TiffImagePlugin.ImageFileDirectory_v2()
    for number, values in doubles.items():
        tags.tagtype[number] = 12
        tags[number] = tuple(map(float, values))
    tags.tagtype[34735] = 3
    tags[34735] = tuple(keys)
    file = io.BytesIO()
    image.save(file, "TIFF", tiffinfo=tags)
    return file.getvalue()


IN_SYSTEM = (1, 1, 0, 1, 3072, 0, 1, 31255)
TIES = (1, 2, 0, 13_000, 322_000, 0, 3, 4, 0, 13_100, 322_100, 0)
TIED = as_geotiff(Image.new("L", (4, 4)), {33922: TIES}, IN_SYSTEM)
HEIGHTS_TIFF = as_geotiff(
    Image.new("F", (4, 3), 411.25),
    {33550: (100, 100, 0), 33922: (0, 0, 0, 13_000, 322_300, 0)},
    IN_SYSTEM,
)
HEIGHTS_XYZ = "13000 322000 411.25\n13100 322000 412\n13000 322100 413.5\n"


def write_tables(folder):
    """Write all tables into a folder, one of them as Parquet as well.

    Parameters
    ----------
    folder : Path
    """
    folder.mkdir(parents=True)
    for name, text in TABLES.items():
        (folder / name).write_bytes(text.encode("utf-8"))
    packed = as_parquet(TABLES["image_points.csv"], dtype={"image_id": str})
    (folder / "image_points.parquet").write_bytes(packed)
