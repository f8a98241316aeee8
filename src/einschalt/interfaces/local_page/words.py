"""What the local page says beside its templates, in one place."""

from einschalt.foundations.language import mark, mark_each

WRONG_HOST = mark(
    "This page is served for this computer alone: open the address that einschalt "
    "serve has printed."
)
WRONG_ORIGIN = mark(
    "This request comes from another page, and is refused: open the address that "
    "einschalt serve has printed."
)
NO_KEY = mark(
    "This page belongs to a session of einschalt serve: open the address that it has "
    "printed. Each start has an address of its own."
)
TOO_MANY_REQUESTS = mark(
    "Too many requests at once: wait a moment, and load the page again."
)
NOT_FOUND = mark("There is no such page.")
FAULT = mark(
    "A fault of the program: the terminal of einschalt serve has what happened."
)

SERVING = "einschalt serve: {folder}"
ADDRESS = mark("Open {address}")
HOW_TO_END = mark("Ctrl+C ends it; nothing leaves this computer.")
ENDED_HERE = mark("einschalt serve has ended; this page may be closed.")

STAGES = mark_each(
    {
        "starting": "starting",
        "cancelling": "cancelling",
        "cancelled": "cancelled: nothing was written",
        "batch cancelled": "cancelled: blocks that were done are whole",
        "batch": "computing",
        "done": "done",
        "failed": "failed",
    }
)
ENDED = mark("the process that computed it ended without an answer ({how})")
NO_MEMORY = mark(
    "There is not enough memory for this. Take fewer points of a model, or a computer "
    "with more memory."
)
METHODS = mark_each(
    {
        "": "as block.toml says",
        "two_step": "two steps: high flight, then low flight",
        "simultaneous": "all models in one adjustment",
        "auto": "both, and the one that the measurements support",
    }
)
OUTLIERS = mark_each(
    {
        "": "as block.toml says",
        "keep": "are named, and kept",
        "snoop": "are taken out, the worst first",
        "huber": "get less weight (Huber)",
        "tukey": "get less weight (Tukey)",
    }
)

# sections and keys of block.toml, where its parts are listed
PARTS = mark_each(
    {
        "block": "block",
        "control_points": "control points",
        "approximate_points": "approximate coordinates",
        "high_flight": "high flight",
        "low_flight": "low flight",
        "crs": "reference system",
        "scale_number": "scale number",
        "standard_error_m": "standard error [m]",
        "model_unit": "unit of the models",
        "model_points": "model points",
        "image_points": "image points",
        "models": "models",
        "camera": "camera",
    }
)

# remedies of those who drop files, by words of those of einschalt init, in whose place
# they stand
INSTEAD_OF_OPTIONS = mark_each(
    {
        "Give --points-crs": (
            "Name the system of longitudes and latitudes below, such as EPSG:4326"
        ),
        "Name it after --from": "Drop its file with the others",
        "Name one of them after --from": "Drop the files again, with one of them alone",
        "Name that one after --from": "Drop the files again, with that one alone",
        "name it after --from: convention": (
            'Write a camera.toml and drop it with the others: convention = "mm", c = '
            "principal distance in mm, pixel_size_um, width and height of the images "
            "in pixels"
        ),
        "name the files that belong together after --from": (
            "Rename the points in one of them, or drop the files that belong together"
        ),
        "Name after --from the model points": (
            "Drop the model points as well, or the image points and models"
        ),
        "Name the flight after --from": (
            "Drop the flight as well, or leave the file out"
        ),
        'decimal = ","': (
            "Choose the decimal sign below, if they are decimal commas; otherwise take "
            "them out"
        ),
        "Say crs, such as EPSG:5514": (
            "Choose the system below, such as EPSG:5514 for S-JTSK, or name the two "
            "columns for a local one"
        ),
        "Name it: columns": "Name that column below, as the names of the points",
        "columns = {point_id": "Name the column that is meant below",
        'Say angles = "D.MMSS"': (
            "Choose below how longitudes and latitudes are written"
        ),
        "columns = {easting": "Name the column that is the easting, and the northing",
    }
)
