"""A result as a folder: tables, map, report, what to think of it, and where it is from.

provenance.json is taken away first and written last: where it stands, the folder is
complete.
"""

import json

from einschalt.foundations.arguments import require_choice
from einschalt.foundations.display_names import as_unicode
from einschalt.foundations.errors import FileError, SettingsError
from einschalt.foundations.language import ENGLISH, written_in
from einschalt.foundations.projections import read_crs
from einschalt.interfaces.files.arrow_columns import table_as_arrow
from einschalt.interfaces.files.atomic import write_bytes, write_text
from einschalt.interfaces.files.csv_tables import write_csv
from einschalt.interfaces.files.ellipse_layer import require_scale
from einschalt.interfaces.files.geopackage import write_geopackage
from einschalt.interfaces.files.output_folder import (
    PREVIOUS,
    InputFiles,
    Output,
    write_folder,
)
from einschalt.interfaces.files.parquet_tables import write_parquet
from einschalt.interfaces.files.table_output import write_file
from einschalt.interfaces.files.written_files import (
    FAILURE,
    GEOPACKAGE,
    PROVENANCE,
    Source,
)
from einschalt.interfaces.provenance import digest_of_inputs, provenance
from einschalt.interfaces.reports.pdf_printer import pdf_of, require_browser
from einschalt.pipeline.summary.summary import lasting_summary

TABLES = ("points", "models", "residuals", "orientations")
IF_ANY = (
    "orientation_residuals",
    "gross_measurements",
    "coverages",
    "error_sources",
    "neighbours",
    "ellipses",
    "control_left_out",
    "iterations",
    "repeated_settings",
)
TABLE_NAMES = (*TABLES, *IF_ANY, "failures")
SYSTEM = "points.prj"  # GDAL reads it beside points.csv
ASSESSMENT = "assessment.json"
CHANGES = "changes.csv"
OF_PAGES = (".html", ".htm", "")
PAPERS = {"a4": "A4", "letter": "letter"}
RESULT_NAMES = frozenset(
    (
        *(f"{n}{s}" for n in (*TABLES, *IF_ANY) for s in (".csv", ".parquet")),
        *("failures.csv", GEOPACKAGE, "report.html", "report.pdf", "summary.txt"),
        *(ASSESSMENT, SYSTEM, PROVENANCE),
        *(PREVIOUS, CHANGES, FAILURE),  # of a batch
    )
)
FIRST_COLUMNS = {
    "points": (
        "point_id",
        "easting",
        "northing",
        "height",
        "standard_error_easting",
        "standard_error_northing",
        "standard_error_height",
        "covariance_en",
        "standard_error_total",
        "standard_error_paper",
        "standard_error_internal",
        "standard_error_checked",
        "is_within_tolerance",
        "n_models",
        "n_coverages",
        "spread_total",
        "role",
        "is_suspect",
        "is_set_aside",
        "difference_easting",
        "difference_northing",
        "difference_height",
        "distributed_easting",
        "distributed_northing",
    ),
    "models": (
        "flight",
        "coverage",
        "model_id",
        "transformation",
        "n_points",
        "redundancy",
        "m_0",
        "s_0",
        "is_usable",
        "reason",
    ),
    "residuals": (
        "flight",
        "coverage",
        "model_id",
        "point_id",
        "residual_easting",
        "residual_northing",
        "residual_height",
        "leverage",
        "redundancy_number",
        "w",
        "p_value",
        "is_suspect",
    ),
    "orientations": ("flight", "coverage", "model_id"),
    "orientation_residuals": ("flight", "coverage", "model_id", "point_id"),
    "gross_measurements": ("flight", "coverage", "model_id", "point_id"),
    "coverages": ("point_id", "coverage", "easting", "northing"),
    "error_sources": ("point_id", "standard_error_total"),
    "neighbours": ("point_id", "neighbour_id", "distance"),
    "ellipses": ("point_id", "easting", "northing"),
    "control_left_out": ("point_id", "difference_easting", "difference_northing"),
    "iterations": ("iteration", "largest_move", "point_id", "move_rms"),
    "repeated_settings": ("flight", "n_points", "n_settings", "redundancy"),
    "failures": ("flight", "coverage", "model_id", "stage", "reason", "remedy"),
}
# what people read: 0.1 mm of a coordinate, 0.01 mm of an error; Parquet has it all
DECIMALS = {
    "easting": 4,
    "northing": 4,
    "height": 4,
    "spread": 4,
    "largest_move": 5,
    "move_rms": 5,
    "difference": 4,
    "residual": 5,
    "standard_error": 5,
    "m_0": 5,
    "s_0": 5,
    "distance": 3,
    "semi_major": 5,
    "semi_minor": 5,
    "azimuth_gon": 2,
    "leverage": 6,
    "redundancy_number": 6,
    "w": 3,
    "p_value": 6,
}


def output_of(block, *, overwrite=False, is_known=False) -> Output:
    """Tell what densifying a block writes, and from what."""
    inputs = digest_of_inputs(block)
    source = Source("densify", block.name, block.files[:1], inputs)
    options = {"overwrite": overwrite, "is_known": is_known}
    return Output(source, RESULT_NAMES, InputFiles(block.files), **options)


def write_result(
    result,
    folder,
    *,
    ellipse_scale=None,
    report=True,
    paper=None,
    overwrite=False,
    is_known=False,
    beside=False,
    write_more=None,
):
    """Write everything that a result holds, or nothing.

    An older result of the same block is replaced. ``ellipse_scale``: how much larger
    the ellipses are drawn in block.gpkg. Without ``report`` there is no report.html,
    and one of an older result goes. ``paper``: "a4" or "letter" where a Chromium prints
    the report into report.pdf as well. ``is_known``: a batch has written results of the
    block there before. ``write_more`` writes further files into the folder that it is
    given. ``overwrite`` and ``beside`` as in :func:`write_folder`.
    """
    require_scale(ellipse_scale)
    require_printable(paper, report=report)
    assessment = result.assessment  # its time is part of what provenance.json tells

    def write(staging):
        with written_in(ENGLISH):  # what is read by machines
            write_data(staging)
        if report:
            write_text(staging / "report.html", render(result))
        if paper is not None:
            page = render(result, paper=PAPERS[paper])
            write_bytes(staging / "report.pdf", pdf_of(page))
        write_text(staging / "summary.txt", lasting_summary(assessment))

    def write_data(staging):
        if write_more is not None:
            write_more(staging)
        _write_tables(result, staging)
        if result.output_system is not None:
            write_text(staging / SYSTEM, f"{read_crs(result.crs).to_wkt()}\n")
        write_geopackage(result, staging / GEOPACKAGE, ellipse_scale=ellipse_scale)
        write_text(staging / ASSESSMENT, _json(assessment))

    output = output_of(result.block, overwrite=overwrite, is_known=is_known)
    write_folder(folder, output, provenance(result), write, beside=beside)


def require_printable(paper, *, report=True):
    """Refuse, before the work, a report on paper that cannot be printed."""
    if paper is None:
        return
    require_choice("paper", paper, PAPERS)
    if not report:
        raise SettingsError(
            "a PDF of the report is asked for, and no report",
            expected="one of the two",
            remedy="Leave one of them out: the PDF is a print of the report",
        )
    require_browser()


def write_report(result, path, *, overwrite=False):
    """Write the report alone; neither an input nor, unasked, another file is lost."""
    if path.suffix.lower() not in OF_PAGES:
        raise FileError(
            f"{path.suffix!r} is no suffix of a report, which is one HTML page",
            expected=" or ".join(OF_PAGES[:2]),
            remedy=f"Name it {path.with_suffix('.html').name}",
            file=path,
        )
    inputs = result.block.files
    source = Source("report", result.block.name, tuple(inputs))
    output = Output(source, frozenset(), InputFiles(inputs), overwrite)
    write_file(path, output, lambda file: write_text(file, render(result)))


def render(result, **options) -> str:
    """Render the report, as :func:`einschalt.interfaces.reports.html_report.render`."""
    # imported when there is to be one: its templates take their time
    from einschalt.interfaces.reports import html_report  # noqa: PLC0415

    return html_report.render(result, **options)


def tables_of(result):
    """Tables of a result by name, columns in their order; those with rows alone."""
    tables = {name: getattr(result, name) for name in TABLE_NAMES}
    return {
        name: frame[_in_order(frame.columns, FIRST_COLUMNS[name])]
        for name, frame in tables.items()
        if frame is not None and len(frame)
    }


def _write_tables(result, folder):
    # a table of its own where there is anything in it
    further = [name for name in IF_ANY if len(getattr(result, name))]
    for name in (*TABLES, *further, "failures"):
        table = table_as_arrow(getattr(result, name))
        table = table.select(_in_order(table.column_names, FIRST_COLUMNS[name]))
        decimals = {column: decimals_of(column) for column in table.column_names}
        write_csv(table, folder / f"{name}.csv", decimals=decimals)
        if name != "failures":
            write_parquet(table, folder / f"{name}.parquet")


def _json(assessment):
    """Everything that is to be thought of the result, for other programs."""
    content = assessment.to_dict()
    text = json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False)
    return as_unicode(f"{text}\n")


def _in_order(names, first):
    known = [name for name in first if name in names]
    return [*known, *(name for name in names if name not in known)]


def decimals_of(column):
    """Decimals of a column by its name, or by the word that it begins with."""
    if column in DECIMALS:
        return DECIMALS[column]
    for word in ("standard_error", "residual", "difference", "spread"):
        if column.startswith(f"{word}_"):
            return DECIMALS[word]
    return None
