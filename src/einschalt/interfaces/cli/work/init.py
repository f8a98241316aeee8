"""What ``einschalt init`` does."""

import math
import os
import sys
from pathlib import Path

import typer

from einschalt.foundations.errors import (
    EinschaltError,
    OutputError,
    ProjectionError,
    SettingsError,
    TableError,
    raise_problems,
)
from einschalt.foundations.kept_texts import retold
from einschalt.foundations.language import mark, translated
from einschalt.foundations.number_parsing import is_number
from einschalt.foundations.projections import read_crs
from einschalt.foundations.told_errors import told
from einschalt.interfaces.cli.exits import WRONG, print_out
from einschalt.interfaces.cli.outcome import is_recorded, report, report_problems
from einschalt.interfaces.cli.typed_options import option_of
from einschalt.interfaces.cli.work.answers import COMMAS_ANSWERED
from einschalt.interfaces.cli.work.systems_of_points import require_used
from einschalt.interfaces.files.atomic import make_folder, set_aside, write_text
from einschalt.interfaces.files.block_schema import (
    DIRECTIVE,
    SCHEMA_FILE,
    schema_text,
)
from einschalt.interfaces.files.block_toml import BLOCK_FILE
from einschalt.interfaces.files.csv_tables import write_csv
from einschalt.interfaces.files.understood_tables import answered_elsewhere
from einschalt.interfaces.new_block.block_text import TEMPLATE, block_text
from einschalt.interfaces.new_block.looked_at import PITCH, files_below, look_at
from einschalt.interfaces.new_block.photographs import completed
from einschalt.interfaces.new_block.proposal import propose
from einschalt.interfaces.new_block.questions import answered, expected_instead
from einschalt.interfaces.new_block.said_of_tables import said_of_tables
from einschalt.interfaces.programs.block_tables import find_problems
from einschalt.interfaces.reports import problem_list

PLACES = {
    "crs": ("block", "crs"),
    "high_scale": ("high_flight", "scale_number"),
    "low_scale": ("low_flight", "scale_number"),
    "high_m_g_um": ("high_flight", "m_g_um"),
    "low_m_g_um": ("low_flight", "m_g_um"),
    "control_error_m": ("control_points", "standard_error_m"),
}
OF_IMAGES = ("principal_distance_mm", PITCH)  # options of all flights with images
# what messages tell to say in block.toml, and the options of this command for it
ANSWERS = {
    **COMMAS_ANSWERED,
    "Say crs, such as EPSG:5514": (
        "Give --crs, such as EPSG:5514 for S-JTSK, which tells it; or --easting and "
        "--northing, the names of their columns, for a local one"
    ),
    "Name it: columns = {point_id": "Give --point-id, the name of that column",
    "columns = {point_id": "Give --point-id, the name of the column that is meant",
    "columns = {easting": "Give --easting and --northing, the names of their columns",
}
OF_FEET = {
    "and this one as crs of the table of its points": (
        "Name one in metres by --crs, such as the UTM zone of the same datum, and this "
        "one by --points-crs"
    )
}
OTHER_SCALE = 0.1  # of logarithms: relief makes less
ASSUMED = "assumed, since no file tells: correct it"


def init(folder, more, files, *, template, schema, again, yes, name, **options):
    """Write block.toml of what files hold, or of a template.

    ``again``: what was written before is set aside; otherwise it is refused.
    """
    require_new(folder, schema=schema, again=again)
    head = DIRECTIVE if schema else ""
    if template:
        text = f"{head}{translated(TEMPLATE)}"
        _make_room(folder / BLOCK_FILE)
        write_text(make_folder(folder) / BLOCK_FILE, text)
        _write_schema(folder, schema)
        report(folder / BLOCK_FILE)
        message = mark("{file}: fill it in, then: einschalt check {folder}")
        print_out(translated(message, file=folder / BLOCK_FILE, folder=folder))
        return
    if options["crs"] is not None:
        _require_metres(options["crs"])
    raise_problems(_impossible(options))
    said = _said(options)
    found = _read_tables([*(files or []), *(more or [])], folder, said)
    require_used(found, said, options["crs"])
    guessed = propose(found, {})
    proposal = propose(found, _given(options, guessed))
    _show(proposal)
    _say_of_other_scales(proposal, guessed)
    _require_answers(proposal, yes)
    while proposal.questions:
        value, reason = _answer(question := proposal.questions[0], yes)
        proposal = answered(proposal, question, value, reason)
    told = proposal.values
    proposal, written, notes = completed(proposal, folder)
    for note in notes:
        print_out(translated("note: {note}", note=retold(note)))
    if not again:
        _require_free(written)
    make_folder(folder)
    _write_tables(written)
    _show_more(proposal, written, told)
    text = block_text(proposal, folder, name or Path(folder).resolve().name)
    _make_room(folder / BLOCK_FILE)
    write_text(folder / BLOCK_FILE, f"{head}{text}")
    _write_schema(folder, schema)
    _check(folder, [note for table in proposal.tables.values() for note in table.notes])


def _require_metres(crs):
    """Refuse a system of the block that is not plane, or in feet; points may be so."""
    try:
        read_crs(crs)
    except ProjectionError as error:
        raise answered_elsewhere(error, OF_FEET) from None


def _said(options):
    """What options say of all tables; they are taken out, but for that of the block."""
    columns = {n: options.pop(n) for n in ("point_id", "easting", "northing")}
    others = {n: options.pop(n) for n in ("points_crs", "decimal", "angles")}
    return said_of_tables(columns, crs=options["crs"], **others)


def _impossible(options):
    """Numbers that no block can have, told before anything is read or written."""
    keys = {name: key for name, (_, key) in PLACES.items() if key != "crs"}
    keys |= {name: name for name in OF_IMAGES}
    found = {name: expected_instead(key, options[name]) for name, key in keys.items()}
    return [
        SettingsError(f"{option_of(name)} = {options[name]:g}", expected=expected)
        for name, expected in found.items()
        if expected and options[name] is not None
    ]


def _write_schema(folder, is_asked):
    """Write what editors check block.toml by; it is the same for all blocks."""
    if is_asked:
        write_text(folder / SCHEMA_FILE, schema_text())


def _write_tables(tables):
    for path, table in tables.items():
        _make_room(path)
        write_csv(table, path)
        report(path)


def _make_room(path):
    """Set aside what stands in the way of a file, and say where it is."""
    if os.path.lexists(path):
        message = mark("{file}: kept as {name}")
        print_out(translated(message, file=path, name=set_aside(path).name))


def require_new(folder, *, schema=False, again=False):
    """Refuse to write where a block stands, or another schema than ours.

    A block is no hindrance where it is written ``again``.
    """
    is_there = os.path.lexists(folder / BLOCK_FILE) and not again
    names = [BLOCK_FILE] if is_there else []
    if schema and not names and not _is_free_for_schema(folder / SCHEMA_FILE):
        names = [SCHEMA_FILE]
    if names:
        raise OutputError(
            f"the folder holds {names[0]} already",
            expected="a folder without one",
            remedy="Edit it, write it anew with --again, or name another folder",
            file=folder,
        )


def _is_free_for_schema(path):
    """Whether nothing is there, or what would be written."""
    if not os.path.lexists(path):
        return True
    try:
        return not path.is_symlink() and path.read_text("utf-8") == schema_text()
    except (OSError, ValueError):
        return False


def _read_tables(files, folder, said):
    if files:
        try:
            return [one for path in files for one in look_at(path, said)]
        except TableError as error:
            # block.toml has the answer later, and an option now
            raise answered_elsewhere(error, ANSWERS) from None
    found = []
    for path in files_below(folder) if Path(folder).is_dir() else []:
        try:
            found += look_at(path, said)
        except EinschaltError as error:
            print_out(translated("left out: {table}", table=told(error)))
    if not found:
        raise SettingsError(
            f"no table in {folder}",
            expected="files after --from, or tables in the folder",
            remedy="Name them after --from, or write --template",
        )
    return found


def _given(options, proposal):
    """Values that options say, by section and key."""
    given = {PLACES[n]: v for n, v in options.items() if n in PLACES and v is not None}
    distance, pitch = (options[key] for key in OF_IMAGES)
    if distance is not None:
        sections = {name for name, key in proposal.tables if key == "image_points"}
        given |= {(name, "principal_distance_mm"): distance for name in sections}
    if pitch is not None:
        lacking = {s for (s, _), one in proposal.tables.items() if one.lacks_pitch}
        given |= {(name, PITCH): pitch for name in lacking}
        if not lacking:
            raise SettingsError(
                f"--pixel-size-um = {pitch:g} is of no camera that these files hold",
                expected="a camera whose file does not say how large a pixel is",
                remedy="Leave it out, or name the camera after --from",
            )
    known = {section for section, _ in proposal.tables} | {"block"}
    unknown = [section for section, _ in given if section not in known]
    if unknown:
        raise SettingsError(
            f"an option is about {unknown[0].replace('_', ' ')}, which no file holds",
            expected="options of what the files hold",
            remedy="Leave it out, or name the file after --from",
        )
    return given


def _require_free(paths):
    """Refuse to write over tables of the user."""
    there = [path for path in paths if os.path.lexists(path)]
    if there:
        raise OutputError(
            "is there already",
            expected="a folder without it, in which init can write the table",
            remedy="Name it after --from, write it anew with --again, or name "
            "another folder",
            file=there[0],
        )


def _show_tables(proposal, paths=None):
    """Say what tables there are; of those alone that are written to these paths."""
    for (section, key), table in proposal.tables.items():
        if paths is not None and table.path not in paths:
            continue
        place = f"[{section}]" if key == "file" else f"[{section}] {key}"
        print_out(f"{place}: {table.title} ({table.description})")
        for note in table.notes:
            print_out(f"  {retold(note)}")


def _show(proposal):
    """Say what was found, and why."""
    _show_tables(proposal)
    _show_values(proposal)
    for table in proposal.left_out:
        held = f"{table.title} ({table.description})"
        print_out(translated("left out: {table}", table=held))


def _show_more(proposal, paths, told):
    """Say which tables were written to paths, and values that came with them."""
    _show_tables(proposal, paths)
    _show_values(proposal, told)


def _show_values(proposal, told=()):
    """Say the values that were found and why, but for those that were told before."""
    for (section, key), guess in proposal.values.items():
        if guess is not None and (section, key) not in told:
            value = guess.value if isinstance(guess.value, str) else f"{guess.value:g}"
            print_out(f"[{section}] {key} = {value}: {retold(guess.reason)}")


def _say_of_other_scales(proposal, guessed):
    """Say where models have another scale on the ground than the one that was given."""
    for (section, key), guess in proposal.values.items():
        found = guessed.values.get((section, key))
        if key != "scale_number" or guess is None or found is None:
            continue
        if abs(math.log(guess.value / found.value)) > OTHER_SCALE:
            message = mark(
                "Note: {reason}, and not 1:{given}. m_g counts in the photographs: "
                "right only if coordinates were measured in another scale than theirs."
            )
            given, reason = f"{guess.value:g}", retold(found.reason)
            print_out(translated(message, reason=reason, given=given))


def _require_answers(proposal, yes):
    """Refuse what nobody is there to answer, and name all options for it."""
    if not yes and _is_terminal():
        return
    open_ones = [q for q in proposal.questions if not yes or not q.has_suggestion]
    if open_ones:
        options = ", ".join(question.option for question in open_ones)
        can_be_taken = all(question.has_suggestion for question in open_ones)
        raise SettingsError(
            f"no file tells: {'; '.join(question.text for question in open_ones)}",
            expected=options,
            remedy=f"Give {options}, or --yes to take what is suggested"
            if can_be_taken
            else f"Answer with {options}",
        )


def _answer(question, yes):
    """Value of a question and why: of the user, or as suggested."""
    if not yes:
        return _asked(question), "as you say"
    place = f"[{question.section}] {question.key}"
    if question.suggested is None:
        message = mark("{place}: left out, so {without} ({option})")
        without = retold(question.without)
        facts = {"place": place, "without": without, "option": question.option}
        print_out(translated(message, **facts))
    else:
        said = f"{place} = {question.suggested:g}: {retold(ASSUMED)}"
        print_out(f"{said} ({question.option})")
    return question.suggested, ASSUMED


def _asked(question):
    """What the user answers on the terminal; None where nothing."""
    default = "" if question.suggested is None else f"{question.suggested:g}"
    while True:
        said = typer.prompt(
            retold(question.text),
            default=default,
            show_default=bool(default),
            err=is_recorded(),
        )
        if not said and question.may_be_left_out:
            return None
        if question.key != "crs":
            expected = expected_instead(
                question.key, float(said) if is_number(said) else None
            )
            if not expected:
                return float(said)
            print_out(told(SettingsError(repr(said), expected=expected)))
            continue
        try:
            read_crs(said)
        except EinschaltError as error:
            print_out(told(error))
        else:
            return said


def _is_terminal():
    return sys.stdin.isatty() and sys.stdout.isatty()


def _check(folder, shown):
    """Say what is wrong with the block that was written, and notes not shown before."""
    found = find_problems(folder)
    shown = tuple(map(retold, shown))  # with names of files as they were given
    for line in problem_list.problem_lines(found):
        if not line.startswith("note") or not line.endswith(shown):
            print_out(line)
    report(folder / BLOCK_FILE, n_problems=len(found.problems))
    report_problems(*found.problems)
    print_out(f"{folder / BLOCK_FILE}: {problem_list.conclusion(found)}")
    if found.problems:
        message = mark("Correct {file}, or write it anew with --again.")
        print_out(translated(message, file=folder / BLOCK_FILE))
        raise typer.Exit(WRONG)
    message = mark("Next: einschalt densify {folder} --output RESULTS")
    print_out(translated(message, folder=folder))
