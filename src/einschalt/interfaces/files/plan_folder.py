"""What a plan leaves behind: tables, figures and its text."""

from einschalt.foundations.errors import FileError
from einschalt.interfaces.files.atomic import make_folder, write_bytes, write_text
from einschalt.interfaces.files.tables_by_suffix import write_in_both_formats
from einschalt.interfaces.reports import figure_files


def write_plan(folder, tables, figures, text):
    """Write tables, figures (bytes by name and suffix) and summary into a folder."""
    folder = make_folder(folder)
    write_in_both_formats(tables, folder)
    for name, files in figures.items():
        for suffix, data in files.items():
            write_bytes(folder / f"{name}.{suffix}", data)
    write_text(folder / "summary.txt", f"{text}\n")


def write_figure(draw, file):
    """Write a figure as its suffix says; it is not drawn where that is unknown."""
    kind = require_figure_suffix(file)
    write_bytes(file, figure_files.figure_bytes(draw(), (kind,))[kind])


def require_figure_suffix(file):
    """Give the kind of a figure that is to be written, if it can be."""
    kind = file.suffix.lower().removeprefix(".")
    if kind not in figure_files.FIGURE_FORMATS:
        raise FileError(
            f"the suffix {file.suffix!r} is none of a figure",
            expected=" or ".join(f".{known}" for known in figure_files.FIGURE_FORMATS),
            remedy=f"Write {file.stem or 'plan'}.png",
            file=file.name,
        )
    return kind
