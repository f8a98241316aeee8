"""provenance.json: what results come from."""

from einschalt.foundations.result_figure_meanings import OF_DENSIFY
from einschalt.foundations.result_files.part import Part

FILE = Part(
    places=("",),
    names={
        "schema": "version of the layout of this file, a whole number",
        "program": "name of the program: einschalt",
        "version": "version of the program",
        "created": "date and time of writing, UTC (ISO 8601)",
        "command": (
            "command that has written the folder; absent for results of densify and "
            "batch"
        ),
        "block": (
            "the block, as it was given; absent for other commands than densify and "
            "batch"
        ),
        "output": (
            "reference system of the results and the operation that leads to it; "
            "absent if it is that of the block"
        ),
        "flights": "facts of each flight, by its name: high_flight, low_flight",
        "settings": (
            "all settings of the computation by name, for einschalt explain NAME"
        ),
        "inputs": (
            "files that were read, one object for each; empty if the tables came from "
            "a script"
        ),
        "versions": (
            "versions of Python, of the libraries, and of PROJ with its database"
        ),
        "figures": "headline figures of the result, as in densify --json",
        "seconds": "duration of the computation [s]",
        "origin": "what the results come from, by which a later run recognizes them",
        "outputs": "SHA-256 of each file that was written, by its name",
        "blocks": "names of the folders with the results of a batch; of batch only",
        "seal": (
            "SHA-256 of the other content of this file; it shows whether the file was "
            "changed"
        ),
    },
)

BLOCK = Part(
    places=("block",),
    names={
        "name": "name of the block",
        "project": "project that the block belongs to; absent if none was given",
        "operator": (
            "person or office responsible for the results; absent if none was given"
        ),
        "crs": "reference system of the block; null if none was given",
        "approximate_m_0_m": (
            "stated TOTAL of given approximate points; null if none was stated [m]"
        ),
        "shared_errors_m": (
            "TOTAL error common to all points of a table, by table: that of the "
            "operation by which they came into the system of the block [m]"
        ),
        "group_errors_m": (
            "stated TOTAL of the shift that points of one group share, by table [m]"
        ),
        "correlation_lengths_m": (
            "distance L over which errors of given points are alike, by table: their "
            "correlation is exp(−d/L) [m]"
        ),
        "may_be_unmeasured": (
            "whether given points that lie in no model are accepted even if their "
            "names look misspelt"
        ),
        "notes": "what was ignored, filled in or reprojected while reading, in English",
    },
)

OUTPUT = Part(
    places=("output",),
    names={
        "crs": "reference system of the results",
        "operation": "name of the operation in PROJ",
        "codes": "codes of the operation, such as EPSG:1619",
        "accuracy_m": (
            "accuracy of the operation, as stated by PROJ or by crs_accuracy_m [m]"
        ),
        "grids": "names of the grid files that the operation needs",
    },
)

EACH_FLIGHT = Part(
    places=("flights.*",),
    names={
        "scale_number": "denominator of the image scale",
        "m_g_um": "TOTAL error of one pointing in the image plane [µm]",
        "transformation": "transformation of the models onto the ground",
        "model_unit": "unit of the model coordinates and bases",
        "base": (
            "base of all models, in model_unit; absent if it was given for each model, "
            "or not needed"
        ),
        "principal_distance_mm": (
            "principal distance; absent without image coordinates [mm]"
        ),
        "camera": (
            "constants of the camera as given; absent if the image coordinates are "
            "already corrected"
        ),
        "orientation_case": (
            "which bundles of rays the relative orientation moves; absent if not given"
        ),
        "orientation_method": (
            "how relative orientations are computed from y-parallaxes; absent if not "
            "given"
        ),
    },
)

CAMERA = Part(
    places=("flights.*.camera",),
    names={
        "convention": (
            "axes, units and signs of the constants: opencv, metashape, mm or micmac"
        ),
        "f": "focal length in pixels (metashape, micmac)",
        "fx": "focal length in pixels along x (opencv)",
        "fy": "focal length in pixels along y (opencv)",
        "cx": (
            "principal point in pixels, column (opencv and micmac from the upper left "
            "pixel, metashape from the middle)"
        ),
        "cy": (
            "principal point in pixels, row (opencv and micmac from the upper left "
            "pixel, metashape from the middle)"
        ),
        "centre_x": "centre of the distortion in pixels, column (micmac)",
        "centre_y": "centre of the distortion in pixels, row (micmac)",
        "c": "principal distance (mm) [mm]",
        "x0": "principal point, x (mm) [mm]",
        "y0": "principal point, y (mm) [mm]",
        "width": "width of the image in pixels",
        "height": "height of the image in pixels",
        "pixel_size_um": "width of a pixel [µm]",
        "pixel_height_um": "height of a pixel that is not square (mm) [µm]",
        "b1": (
            "affinity of the pixels, in pixels (metashape) or as a ratio (micmac); "
            "absent if it is 0"
        ),
        "b2": (
            "skew of the pixels, in pixels (metashape) or as a ratio (micmac); absent "
            "if it is 0"
        ),
        "k1": "first coefficient of the radial distortion; absent if it is 0",
        "k2": "second coefficient of the radial distortion; absent if it is 0",
        "k3": "third coefficient of the radial distortion; absent if it is 0",
        "k4": (
            "fourth coefficient of the radial distortion (metashape, micmac); absent "
            "if it is 0"
        ),
        "k5": "fifth coefficient of the radial distortion (micmac); absent if it is 0",
        "p1": "first coefficient of the tangential distortion; absent if it is 0",
        "p2": "second coefficient of the tangential distortion; absent if it is 0",
    },
)

INPUT = Part(
    places=("inputs[]",),
    names={
        "table": (
            "part of the block that was read from the file, such as control_points, or "
            "block for block.toml; absent for other commands than densify and batch"
        ),
        "file": (
            "file within the folder of the block; of a file from elsewhere its name "
            "alone"
        ),
        "sha256": "SHA-256 of the file; null if it is not known",
    },
)

VERSIONS = Part(
    places=("versions",),
    names={
        "python": "version of Python",
        "numpy": "version of numpy",
        "scipy": "version of scipy",
        "pandas": "version of pandas",
        "pyarrow": "version of pyarrow",
        "numba": "version of numba",
        "pyproj": "version of pyproj",
        "pyogrio": "version of pyogrio",
        "shapely": "version of shapely",
        "PROJ": "version of PROJ, which transforms between reference systems",
        "EPSG": "version of the EPSG database in PROJ",
        "PROJ-data": (
            "version of the grids that PROJ knows of; empty if it does not say"
        ),
    },
)

ORIGIN = Part(
    places=("origin",),
    names={
        "command": "command that has written the folder",
        "name": "name of the block, or what was asked for",
        "place": (
            "digest of the path from the results to the block; null if the tables came "
            "from a script"
        ),
        "inputs": (
            "digest of the content of all inputs; null if the tables came from a script"
        ),
    },
)

FIGURES = Part(
    places=("figures",),
    names={
        **OF_DENSIFY,
        "n_points": "number of points in the table points",
        "n_new": "number of new points",
        "n_control": "number of control points in the table points",
    },
)

PARTS = (
    FILE,
    BLOCK,
    OUTPUT,
    EACH_FLIGHT,
    CAMERA,
    INPUT,
    VERSIONS,
    ORIGIN,
    FIGURES,
)
