"""All files and columns, explained: as a page, and one column at a time.

Units, what may be missing and which values are allowed come from the schemas that check
the tables, other names from the dictionary that understands them: the page can say
nothing else than what is done.
"""

from difflib import get_close_matches

from einschalt.foundations import tables
from einschalt.foundations.column_meanings import (
    INPUT_TABLES,
    RESULT_TABLES,
    TABLES,
    meaning_of,
)
from einschalt.foundations.column_words import folded
from einschalt.foundations.errors import SettingsError, name_some
from einschalt.foundations.language import mark, mark_each, translated
from einschalt.foundations.plan_column_meanings import (
    PLAN_COLUMNS,
    PLAN_TABLES,
    meaning_in_plan,
)
from einschalt.foundations.words_of_surveyors import KINDS, WORDS
from einschalt.interfaces.files.result_folder import FIRST_COLUMNS

SCHEMAS = {
    "control_points": (tables.CONTROL_POINTS,),
    "approximate_points": (tables.APPROXIMATE_POINTS,),
    "model_points": (tables.MEASURED_MODEL_POINTS,),
    "y_parallaxes": (tables.Y_PARALLAXES,),
    "models": (tables.MODEL_BASES, tables.IMAGE_MODELS),
    "image_points": (tables.IMAGE_POINTS,),
    "image_pairs": (tables.IMAGE_PAIRS,),
}
# columns that results have beside the first ones, which are in their order
FURTHER = {
    "points": (
        *("two_step_easting", "two_step_northing", "two_step_height"),
        *("standard_error_height_checked", "covariance_eh", "covariance_nh"),
    ),
    "models": (
        *("a0", "a1", "a2", "b0", "b1", "b2", "a", "b", "te", "tn", "th"),
        *("scale", "omega", "phi", "kappa"),
    ),
    "residuals": ("minimal_detectable_bias", "external_reliability", "weight"),
    "orientations": (
        *("case", "n_points", "redundancy", "sigma_0", "base", "is_converged"),
        *("is_ambiguous", "verdict", "inflation", "reason", "m_g_intersection_um"),
        *("m_g_orientation_um", "bx", "by", "bz", "omega", "phi", "kappa"),
        *("d_omega", "d_phi", "d_kappa", "d_phi_1", "d_phi_2", "d_kappa_1"),
        *("d_kappa_2", "d_by", "d_bz"),
    ),
    "orientation_residuals": (
        *("residual_x_left", "residual_y_left", "residual_x_right"),
        *("residual_y_right", "residual", "redundancy_number", "weight", "w"),
        *("p_value", "is_suspect"),
    ),
    "gross_measurements": (
        *("residual_easting", "residual_northing", "residual_height", "w", "p_value"),
    ),
    "coverages": (
        *("difference_easting", "difference_northing", "difference_height"),
        *("standard_error_difference", "p_value", "is_suspect"),
    ),
    "error_sources": (
        *("standard_error_control", "standard_error_high_flight"),
        *("standard_error_low_flight", "standard_error_orientation"),
        *("standard_error_own_deformation", "standard_error_shared_bend"),
        "standard_error_control_groups",
        *("standard_error_approximate_points", "standard_error_approximate_groups"),
        *("standard_error_reference_system", "largest_source"),
    ),
    "neighbours": (
        *("standard_error_easting", "standard_error_northing", "covariance_en"),
        *("standard_error_total", "standard_error_distance"),
        *("standard_error_across", "standard_error_if_independent"),
    ),
    "ellipses": ("semi_major", "semi_minor", "azimuth_gon", "confidence"),
    "control_left_out": (
        *("difference_height", "standard_error_easting", "standard_error_northing"),
        *("covariance_en", "standard_error_total", "standard_error_height"),
        *("w", "p_value", "p_value_height", "is_suspect"),
    ),
    "repeated_settings": (
        *("m_g_um", "m_g_settings_um", "standard_error_um", "p_value"),
        *("is_larger", "is_smaller"),
    ),
}
EXAMPLES = {
    **dict.fromkeys(("point_id", "neighbour_id"), "0012"),
    "model_id": "11/12",
    **dict.fromkeys(("image_id", "left_image"), "11"),
    "right_image": "12",
    "coverage": "1",
    "setting": "2",
    "n_settings": "2",
    "flight": "low_flight",
    "role": "control",
    "easting": "13000.25",
    "northing": "322000.50",
    "height": "411.25",
    "x": "12.3456",
    "y": "-98.7654",
    "z": "-152.3400",
    "base": "92.00",
    "y_parallax": "0.012",
    "standard_error_m": "0.03",
    "transformation": "affine",
}
LANGUAGES = mark_each(
    {
        "de": "German",
        "en": "English",
        "fr": "French",
        "it": "Italian",
        "es": "Spanish",
        "pt": "Portuguese",
        "pl": "Polish",
        "nl": "Dutch",
        "cs": "Czech and Slovak",
        "hu": "Hungarian",
        "sl": "Slovene",
        "hr": "Croatian",
        "sv": "Swedish",
        "no": "Norwegian",
        "da": "Danish",
        "fi": "Finnish",
        "ro": "Romanian",
        "tr": "Turkish",
        "ja": "Japanese and Chinese",
    }
)
WRITTEN = {"models": "transformations of the models, and how they fit"}
ALL = "all"
HEAD = mark("""\
# Files and columns

This page is written by `einschalt check --explain all`, from the schemas that check
the tables; `einschalt check --explain NAME` explains a single column. Other names,
units and encodings are described in [tables.md](tables.md). Lengths on the ground are
in metres. A TOTAL error is the root of the sum of both variances in plan; other errors
are those of one coordinate.
""")


def written_columns(table):
    """Names of the columns that a table of the results may have."""
    return tuple(dict.fromkeys((*FIRST_COLUMNS[table], *FURTHER.get(table, ()))))


def read_columns(table):
    """Names of the columns that a table of a block may have."""
    names = (name for schema in SCHEMAS[table] for name in schema.names)
    return tuple(dict.fromkeys(names))


def columns_page():
    """Page of all tables and columns, as Markdown."""
    parts = [translated(HEAD), f"## {translated('Tables that are read')}\n"]
    parts += [_input_table(name) for name in INPUT_TABLES]
    parts.append(f"## {translated('Tables that are written')}\n")
    parts += [_result_table(name) for name in RESULT_TABLES]
    parts.append(f"## {translated('Tables of plans')}\n")
    parts += [_plan_table(name) for name in PLAN_TABLES]
    return "\n".join(parts)


def _input_table(name):
    lines = [f"### {name}", "", f"{_capital(translated(TABLES[name]))}.", ""]
    header = translated("| column | unit | needed | meaning | example |")
    lines += [header, "|---|---|---|---|---|"]
    for column in read_columns(name):
        found = _column(name, column)
        _, meaning = meaning_of(column, name)
        cells = (_unit(found), _needed(name, found), _allowed(found, meaning))
        lines.append(_row(f"`{column}`", *cells, f"`{EXAMPLES.get(column, '')}`"))
    return "\n".join([*lines, ""]).replace("``", "")


def _column(table, name):
    found = (c for schema in SCHEMAS[table] for c in schema.columns if c.name == name)
    return next(found)


def _unit(column):
    return translated(column.unit or "text")


def _needed(table, column):
    if any(column.name not in schema.names for schema in SCHEMAS[table]):
        is_base = column.name == "base"
        return translated("for bases") if is_base else translated("for images")
    if column.is_required:
        return translated("yes")
    if column.default:
        return translated("no ({default} if omitted)", default=column.default)
    # the word alone is the number in the catalogue
    return translated("no ({default} if omitted)", default="").partition(" ")[0]


def _allowed(column, meaning):
    words = [translated(meaning)]
    if column.choices and "or" not in meaning:
        words.append(translated(" or ").join(column.choices))
    words += [translated("above 0")] if column.is_positive else []
    words += [translated("may be empty")] if column.may_be_missing else []
    if other := column.belongs_to:
        words.append(translated("may be empty where {column} is", column=f"`{other}`"))
    return "; ".join(words)


def _result_table(name):
    title = translated("{table} (result)", table=name)
    about = WRITTEN.get(name, TABLES[name])
    columns = [(column, meaning_of(column, name)) for column in written_columns(name)]
    return _written_table(title, about, columns)


def _plan_table(name):
    title = translated("{table} (plan)", table=name)
    columns = [(column, meaning_in_plan(column, name)) for column in PLAN_COLUMNS[name]]
    return _written_table(title, PLAN_TABLES[name], columns)


def _written_table(title, about, columns):
    lines = [f"### {title}", "", f"{_capital(translated(about))}.", ""]
    lines += [translated("| column | unit | meaning |"), "|---|---|---|"]
    for column, (unit, meaning) in columns:
        lines.append(_row(f"`{column}`", unit, translated(meaning)))
    return "\n".join([*lines, ""])


def _row(*cells):
    return f"| {' | '.join(cells)} |"


def _capital(text):
    return f"{text[:1].upper()}{text[1:]}"


def explanation_of(name):
    """Explain a column, or all of them; a SettingsError where there is none of it.

    A word that stands for a column, such as Rechtswert, is explained as that.
    """
    if name == ALL:
        return columns_page()
    column = _meant(name)
    lines = [column if column == name else f"{name}: {column}", *_in_tables(column)]
    if column in EXAMPLES:
        lines.append(f"  {translated('example')}: {EXAMPLES[column]}")
    for language, words in WORDS.get(column, {}).items():
        known = LANGUAGES.get(language, mark("where no better word stands"))
        lines.append(f"  {translated(known)}: {', '.join(words.split())}")
    if column == "role":
        for kind, languages in KINDS.items():
            words = " ".join(languages.values()).split()
            lines.append(f"  {kind}: {', '.join(words)}")
    return "\n".join(lines)


def _in_tables(column):
    """What a column is in each table that has it, one line for each."""
    lines = []
    for table in INPUT_TABLES:
        if column in read_columns(table):
            found = _column(table, column)
            said = _allowed(found, meaning_of(column, table)[1])
            needed = translated("needed: {needed}", needed=_needed(table, found))
            lines.append(f"  {table}: {said} [{_unit(found)}], {needed}")
    for table in RESULT_TABLES:
        if column in written_columns(table):
            unit, said = meaning_of(column, table)
            where = translated("{table} (result)", table=table)
            lines.append(in_place(where, said, unit))
    for table, columns in PLAN_COLUMNS.items():
        if column in columns:
            unit, said = meaning_in_plan(column, table)
            where = translated("{table} (plan)", table=table)
            lines.append(in_place(where, said, unit))
    return lines


def facts_of_column(name):
    """What :func:`explanation_of` says of a column, for programs."""
    column, tables_of = _meant(name), []
    for table in INPUT_TABLES:
        if column in read_columns(table):
            found = _column(table, column)
            said = _allowed(found, meaning_of(column, table)[1])
            facts = {"meaning": said, "unit": _unit(found)}
            needed = {"needed": _needed(table, found)}
            tables_of.append({"table": table, "of": "block"} | facts | needed)
    written = [
        (table, "result", meaning_of(column, table))
        for table in RESULT_TABLES
        if column in written_columns(table)
    ]
    written += [
        (table, "plan", meaning_in_plan(column, table))
        for table, columns in PLAN_COLUMNS.items()
        if column in columns
    ]
    tables_of += [
        {"table": table, "of": of, "meaning": translated(said), "unit": unit or None}
        for table, of, (unit, said) in written
    ]
    words = {lang: text.split() for lang, text in WORDS.get(column, {}).items() if lang}
    example = EXAMPLES.get(column)
    facts = {"name": column, "tables": tables_of, "example": example, "words": words}
    return facts | {"text": explanation_of(name).rstrip("\n")}


def in_place(where, said, unit):
    """What a name means in one place, as a line of its explanation."""
    unit = f" [{unit}]" if unit else ""
    return f"  {where}: {translated(said)}{unit}"


def names_of_columns():
    """Names of all columns of all tables."""
    known = {c for table in INPUT_TABLES for c in read_columns(table)}
    known |= {c for table in RESULT_TABLES for c in written_columns(table)}
    return known | {c for columns in PLAN_COLUMNS.values() for c in columns}


def _meant(name):
    known = names_of_columns()
    if name in known:
        return name
    word = folded(name)
    for column, languages in WORDS.items():
        if any(word in words.split() for words in languages.values()):
            return column
    near = get_close_matches(name.casefold(), known, n=3)
    raise SettingsError(
        f"'{name[:40]}' is no column",
        expected=name_some(near, 3) if near else f"a column of a table, or '{ALL}'",
        remedy="einschalt check --explain all lists them",
    )
