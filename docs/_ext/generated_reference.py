"""Pages of the reference that the program writes itself, when the site is built.

Commands from their own help, settings from the model that checks them, findings and
remedies from the catalogue of the summary, terms and names in files from what
``explain`` says of them.
"""

import re
from pathlib import Path

from typer.testing import CliRunner

from einschalt.foundations.result_files.meanings import PARTS
from einschalt.interfaces.cli.explained_findings import (
    explained_finding,
    known_remedies,
)
from einschalt.interfaces.cli.main import COMMANDS, app
from einschalt.interfaces.files.glossary import entries
from einschalt.pipeline.assessment.findings.kinds import KINDS
from einschalt.pipeline.settings import Expected, Settings, words_of
from einschalt.pipeline.summary.suggestions.catalogue import WORDS

COMMANDS_TITLE = """# Commands

Written from the help of the commands themselves; `einschalt COMMAND --help` prints it.

| command | what it does |
|---|---|"""
SETTINGS_TITLE = """# Settings

A section `[settings]` of `block.toml`, options of `einschalt densify` and `batch`, or
arguments of `es.Settings`. Written from the model that checks them; all of them may be
left out.
"""
FINDINGS_TITLE = """# Findings and remedies

What the summary may report under *Problems and suggestions*, the gravest first: the
code that stands in `assessment.json`, what is judged, and what may be done about it.
`einschalt explain CODE` prints the same. Some remedies are worded for each block.
"""

TERMS_TITLE = """# What the terms mean

Each in a sentence; `einschalt explain TERM` prints the same, by the English or the
German word. Symbols, units and names in the code: the [glossary](../../glossary.md).
"""

RESULT_FILES_TITLE = """# assessment.json and provenance.json

Every name in both files, by the place at which it stands; `einschalt explain NAME`
prints the same of a name, or of a word that may stand there. A place is a path of names
from the top of the file: `[]` is any object of a list, `*` a name that the block gives.

Lengths are in metres unless a unit is given or part of the name. A TOTAL error is the
root of the sum of both variances in plan. A number that is not known is `null`.
`densify` and `batch` write both files for each block; other folders of results have
provenance.json alone.
"""
REMEDIES_TITLE = """### Words of `findings[].remedy`

`einschalt explain CODE` of a finding lists those that it may have.
"""

# signs that Markdown would take for its own
MARKUP = re.compile(r"([\\*_<>\[\]|$`])")


# whoever builds the site may have a locale of another language
ENGLISH = dict.fromkeys(("LC_ALL", "LC_MESSAGES", "LANG", "LANGUAGE"), "C")


def plain(text):
    """Text that Markdown leaves as it is."""
    return MARKUP.sub(r"\\\1", text)


def help_of(*words):
    """Help of a command, as it is printed."""
    shown = CliRunner().invoke(
        app,
        [*words, "--help"],
        prog_name="einschalt",
        terminal_width=88,
        env=ENGLISH,
    )
    if shown.exit_code:
        raise RuntimeError(f"einschalt {' '.join(words)} --help: {shown.output}")
    return shown.output.strip()


def command_page():
    """Every command with its arguments, options and examples."""
    parts = [COMMANDS_TITLE]
    parts += [f"| [`{name}`](#{name}) | {plain(COMMANDS[name])} |" for name in COMMANDS]
    parts += ["", *(plain(" ".join(one.split())) + "\n" for one in _prose(help_of()))]
    parts += [f"\n({name})=\n\n## {name}\n\n{_command(name)}" for name in COMMANDS]
    return "\n".join(parts) + "\n"


def _command(name):
    printed = help_of(name)
    usage = printed.partition("\n\n")[0]
    blocks = dict(_sections(printed))
    if "Options" not in blocks:
        raise RuntimeError(f"einschalt {name} --help lists no options: {printed}")
    text = [f"```text\n{usage.removeprefix('Usage: ')}\n```\n"]
    text += [plain(" ".join(one.split())) + "\n" for one in _prose(printed)]
    for title in ("Arguments", "Options"):
        if rows := list(_rows(blocks.get(title, ""))):
            text.append(f"**{title}**\n")
            text += [f"`{left}`\n: {plain(right)}\n" for left, right in rows]
    if examples := blocks.get("Examples"):
        lines = "\n".join(line.strip() for line in examples.splitlines())
        text.append(f"**Examples**\n\n```sh\n{lines}\n```\n")
    return "\n".join(text)


def _prose(printed):
    body = re.split(r"\n(?:Arguments|Options):\n", printed)[0].partition("\n\n")[2]
    return [one for one in body.split("\n\n") if one.strip()]


def _sections(printed):
    parts = re.split(r"^ *(Arguments|Options|Examples):\n", printed, flags=re.MULTILINE)
    yield from zip(parts[1::2], parts[2::2], strict=True)


def _rows(section):
    """Left and right column of a list of the help."""
    left, right = None, []
    for line in section.splitlines():
        if line[:2] == "  " and line[2:3].strip():
            if left:
                yield left, " ".join(right)
            left, *rest = re.split(r"\s{2,}", line.strip(), maxsplit=1)
            right = rest
        elif line.strip():
            right.append(line.strip())
    if left:
        yield left, " ".join(right)


def settings_page():
    """Every setting with what it takes, its default and its meaning."""
    parts = [SETTINGS_TITLE]
    for name, field in Settings.model_fields.items():
        expected = [one.text for one in field.metadata if isinstance(one, Expected)]
        words = ", ".join(f"`{word}`" for word in words_of(name))
        default = {None: "none", "": "empty"}.get(field.default, field.default)
        parts.append(
            f"## {name}\n\n{plain(field.description)}\n\n"
            f"- takes: {words or plain(' '.join(expected))}\n- default: `{default}`\n"
        )
    return "\n".join(parts)


def findings_page():
    """Every finding, with what it is about and what may be done."""
    parts = [FINDINGS_TITLE]
    for code in KINDS:
        if code not in WORDS:
            raise RuntimeError(f"{code} has no words")
        _, said, facts, *remedies = _unwrapped(explained_finding(code))
        parts.append(f"## {code}\n\n{plain(said)}\n\n*{plain(facts)}*\n")
        parts += [f"- {plain(one[:1].upper() + one[1:])}" for one in remedies]
        parts.append("")
    return "\n".join(parts)


def _unwrapped(explained):
    """Lines of an explanation, those that a remedy continues put together."""
    lines = []
    for line in explained.splitlines():
        if line.startswith("  ") and line[2:3] == " ":
            lines[-1] += " " + line.strip()
        else:
            lines.append(line.strip())
    return lines


def terms_page():
    """Terms of the glossary that have a meaning, by their sections."""
    parts, section = [TERMS_TITLE], ""
    for one in entries():
        if one.section != section and one.meaning:
            section = one.section
            parts.append(f"## {section}\n")
        if one.meaning:
            parts.append(f"{plain(one.english)}\n: {plain(one.meaning)}\n")
    return "\n".join(parts)


def result_files_page():
    """Names of assessment.json and provenance.json, a table for each place."""
    parts = [RESULT_FILES_TITLE]
    for file, objects in PARTS.items():
        parts.append(f"## {file}\n")
        for one in objects:
            parts += [*_object(one), *_words(one)]
            if "findings[]" in one.places:
                parts.append(REMEDIES_TITLE)
                parts += _defined(known_remedies())
    return "\n".join(parts) + "\n"


def _object(part):
    """Names of an object, as a table below its place."""
    first, *others = part.places
    yield f"### `{first}`\n" if first else "### Top of the file\n"
    if others:
        yield f"Also {', '.join(f'`{place}`' for place in others)}.\n"
    yield "| name | unit | meaning |\n|---|---|---|"
    for name in part.names:
        unit, text = part.meaning(name)
        yield f"| `{name}` | {plain(unit)} | {plain(text)} |"
    yield ""


def _words(part):
    """Words that may stand at each name of an object."""
    for name, values in part.values.items():
        yield f"Words of `{name}`:\n"
        yield from _defined(values)


def _defined(words):
    return [f"`{word}`\n: {plain(text)}\n" for word, text in words.items()]


PAGES = {
    "commands": command_page,
    "settings": settings_page,
    "findings": findings_page,
    "terms": terms_page,
    "result_files": result_files_page,
}


def write(app):
    """Write the pages that have changed."""
    folder = Path(app.srcdir) / "reference" / "generated"
    folder.mkdir(exist_ok=True)
    for name, page in PAGES.items():
        file, text = folder / f"{name}.md", page()
        if not file.exists() or file.read_text(encoding="utf-8") != text:
            file.write_text(text, encoding="utf-8")


def setup(app):
    """Write the pages before others are read."""
    app.connect("builder-inited", write, priority=100)
    return {"parallel_read_safe": True}
