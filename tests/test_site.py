"""The site: every page is reached, and what stands on its pages runs."""

import contextlib
import importlib.util
import io
import os
import re
import shlex
import shutil
import tomllib
from pathlib import Path

import pytest
from matplotlib import pyplot as plt
from typer.testing import CliRunner

import einschalt as es
from einschalt.foundations.result_files.meanings import PARTS
from einschalt.interfaces.cli.main import COMMANDS, app

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
BUILT = {"gallery", "recipes", "generated", "_build"}  # by make docs
PAGES = {
    page.relative_to(DOCS).with_suffix("").as_posix(): page.read_text(encoding="utf-8")
    for page in sorted(DOCS.rglob("*.md"))
    if not BUILT & set(page.relative_to(DOCS).parts)
}
NOTEBOOKS = [name for name, text in PAGES.items() if "{code-cell}" in text]
WALKS = [
    name
    for name in PAGES
    if name == "getting_started" or name.startswith("tutorials/")
    if name not in NOTEBOOKS and "```sh\n" in PAGES[name]
]
TOCTREE = re.compile(r"```\{toctree\}\n((?::[^\n]*\n)*)(.*?)```", re.DOTALL)
FENCED = re.compile(r"^```(\w+)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
CELL = re.compile(r"```\{code-cell\} python\n((?::[^\n]*\n)*)(.*?)```", re.DOTALL)
CALL = re.compile(r"^(?:\./)?einschalt (\w+)([^#\n]*)", re.MULTILINE)
OPTION = re.compile(r"(?<!\w)--[a-z][a-z-]+")


def listed_in(name):
    """The pages that the toctrees of a page list."""
    folder = Path(name).parent
    for _, entries in TOCTREE.findall(PAGES[name]):
        for line in filter(None, entries.splitlines()):
            target = re.sub(r".*<(.+)>", r"\1", line)
            yield Path(os.path.normpath(folder / target)).as_posix()


def test_every_page_is_in_one_toctree_and_every_entry_leads_to_a_page():
    entries = [entry for name in PAGES for entry in listed_in(name)]
    exact = [entry for entry in entries if entry in PAGES]
    built = [entry for entry in entries if BUILT & set(Path(entry).parts)]
    assert sorted(entries) == sorted(exact + built)
    assert len(set(entries)) == len(entries)
    assert set(PAGES) - set(exact) == {"index"}


def test_cards_of_the_home_page_lead_to_pages():
    cards = re.findall(r"^:link: (\S+)", PAGES["index"], re.MULTILINE)
    assert len(cards) == 6
    assert [c for c in cards if c not in PAGES and not BUILT & set(c.split("/"))] == []


def test_the_reference_lists_every_public_name_once():
    lists = re.findall(r":toctree: generated\n\n((?: +\w+\n)+)", PAGES["reference/api"])
    listed = [name for block in lists for name in block.split()]
    assert sorted(listed) == sorted(set(es.__all__) - {"__version__"})


def extension(name):
    where = DOCS / "_ext" / f"{name}.py"
    found = importlib.util.spec_from_file_location(name, where)
    module = importlib.util.module_from_spec(found)
    found.loader.exec_module(module)
    return module


def test_the_page_of_commands_is_the_same_whoever_builds_it(monkeypatch):
    page = extension("generated_reference")
    english = page.command_page()
    assert english.count("**Options**") == len(COMMANDS)
    monkeypatch.setenv("LC_ALL", "de_DE.UTF-8")
    assert page.command_page() == english


def test_the_page_of_names_in_files_has_all_of_them():
    page = extension("generated_reference").result_files_page()
    for file, parts in PARTS.items():
        of_file = page.partition(f"\n## {file}\n")[2].partition("\n## ")[0]
        for part in parts:
            first = f"`{part.places[0]}`" if part.places[0] else "Top of the file"
            table = of_file.partition(f"### {first}\n")[2].partition("\n### ")[0]
            assert not [one for one in part.places[1:] if f"`{one}`" not in table]
            assert not [name for name in part.names if f"\n| `{name}` |" not in table]
            for values in part.values.values():
                assert not [one for one in values if f"\n`{one}`\n: " not in table]
    assert page.count("\n`measure_again`\n: ") == 1


def test_no_link_of_the_site_is_named_after_a_file():
    pages = extension("link_texts")
    assert pages.titled(PAGES["conventions"]) != PAGES["conventions"]
    left = {name: pages.titled(text) for name, text in PAGES.items()}
    assert [name for name, text in left.items() if re.search(r"\.md`?\]\(", text)] == []


def test_files_for_readers_are_there():
    named = re.findall(r"`[^`]+ <([^>]+)>`", PAGES["getting_started"])
    assert len(named) == 3
    assert [name for name in named if not (DOCS / name).exists()] == []


@pytest.fixture
def at_a_desk(monkeypatch, tmp_path, batches_here):
    """A folder with the files that readers of the site have."""
    (tmp_path / "data_examples").symlink_to(ROOT / "data_examples")
    for file in (DOCS / "tutorials" / "files").iterdir():
        shutil.copy(file, tmp_path)
    monkeypatch.chdir(tmp_path)


@pytest.mark.slow
@pytest.mark.usefixtures("at_a_desk")
@pytest.mark.parametrize("name", WALKS)
def test_commands_of_a_tutorial_print_what_stands_below_them(name):
    printed = ""
    for language, text in FENCED.findall(PAGES[name]):
        if language == "sh":
            printed = "".join(map(run, text.replace("\\\n", " ").splitlines()))
        elif language == "toml":
            (place,) = re.findall(r"Write `(\S+/block\.toml)`", PAGES[name])
            Path(place).write_text(text, encoding="utf-8")
        elif language == "text":
            for excerpt in filter(None, text.split("…\n")):
                assert excerpt in printed


def run(command):
    program, *arguments = shlex.split(command)
    assert program == "einschalt"
    shown = CliRunner().invoke(app, arguments)
    assert shown.exit_code == 0, shown.output
    return shown.stdout


@pytest.mark.slow
@pytest.mark.parametrize("name", NOTEBOOKS)
def test_cells_of_a_notebook_run(name, monkeypatch):
    monkeypatch.chdir(ROOT)
    plt.switch_backend("agg")
    cells = [code for _, code in CELL.findall(PAGES[name])]
    known = {}
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        for number, code in enumerate(cells):
            if not code.strip().startswith("%cd"):
                exec(compile(code, f"{name}, cell {number}", "exec"), known)
    plt.close("all")
    assert printed.getvalue()


def test_three_tutorials_are_notebooks():
    assert len(NOTEBOOKS) == 3


def test_commands_of_every_page_and_their_options_exist():
    text = "\n".join(
        code
        for page in PAGES.values()
        for language, code in FENCED.findall(page)
        if language in {"sh", "console"}
    ).replace("\\\n", " ")
    calls = CALL.findall(text)
    assert len(calls) > 25
    known = {
        name: set(OPTION.findall(CliRunner().invoke(app, [name, "--help"]).output))
        for name in COMMANDS
    }
    wrong = [
        (name, option)
        for name, rest in calls
        for option in OPTION.findall(rest)
        if option not in known.get(name, ())
    ]
    assert wrong == []
    assert {name for name, _ in calls} <= set(COMMANDS)


@pytest.mark.parametrize(
    ("language", "understood"),
    [("python", lambda code: compile(code, "page", "exec")), ("toml", tomllib.loads)],
)
def test_code_of_every_page_is_understood(language, understood):
    blocks = [
        code
        for page in PAGES.values()
        for one, code in FENCED.findall(page)
        if one == language
    ]
    assert len(blocks) > 3
    for code in blocks:
        understood(code)
