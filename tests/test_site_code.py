"""Every command and code block of the site and the README runs.

What the tests of single pages run and compare is left to them, block by block (see
``ELSEWHERE``). All others run here, at a desk where the files lie that they name; so do
the examples of every command, which stand in its help and on the page Commands.
"""

import contextlib
import doctest
import io
import re
import shutil
import subprocess
import sys
import tomllib
from importlib import import_module
from pathlib import Path

import pandas as pd
import pytest
import tomli_w
from tests import site_desk
from tests.site_desk import (
    ADDRESS,
    OTHER_TARGETS,
    PORT,
    SMALLER,
    free_port,
    lines_of,
    of_ci,
    run,
    started_computers,
)
from tests.test_docs import THEORY_EXAMPLES
from tests.test_planning_guide import FENCED as FENCED_IN_THE_GUIDE
from tests.test_planning_guide import SECTIONS
from tests.test_readme import README, SUMMARY, fenced
from tests.test_site import CELL, DOCS, FENCED, PAGES, ROOT, WALKS, extension

import einschalt as es
from einschalt.interfaces.cli.main import COMMANDS
from einschalt.interfaces.cli.work import init as work_of_init

SITE = {**PAGES, "README": README}
# page and code of what other tests run, from the lists that they run
ELSEWHERE = {
    *(
        ("planning", c)
        for s in SECTIONS.values()
        for _, c in FENCED_IN_THE_GUIDE.findall(s)
    ),
    *(
        (page, code)
        for page, text in (("README", README), ("summary", SUMMARY))
        for code in (*fenced("python", text), *fenced("text", text))
    ),
    *(
        (f"theory/{page.removesuffix('.md')}", text)
        for page, *both in THEORY_EXAMPLES
        for text in both
    ),
    # commands in turn, with the files that they want and what they print
    *(
        (page, code)
        for page in WALKS
        for language, code in FENCED.findall(PAGES[page])
        if language in {"sh", "toml", "text"}
    ),
}
# directives of the site; of code there are the cells of the notebooks
DIRECTIVES = {"toctree", "image", "eval-rst", "grid", "grid-item-card", "include"}
CELLS = "{code-cell} python"
FENCE = re.compile(r"^[ \t>*+-]*(`{3,}|~{3,}|:{3,})[ \t]*(.*?)[ \t]*$", re.MULTILINE)
DIRECTIVE = re.compile(r"^(`{3})(\{.*?\}.*)\n(?:.*\n)*?\1$", re.MULTILINE)
OF_RST = re.compile(
    r"^ *\.\. [\w-]*(?:code|prompt|literal)[\w-]*::|^(?! *\.\.).*[^:\n]::$|>>>",
    re.MULTILINE,
)
EXTENSIONS = [
    file
    for file in sorted((DOCS / "_ext").glob("*.py"))
    if ">>>" in file.read_text("utf-8")
]
EXAMPLES = [
    example
    for name in COMMANDS
    for example in import_module(f"einschalt.interfaces.cli.{name}").EXAMPLES
]


def blocks_of(*languages):
    """Page and code of all blocks that no other test runs."""
    return [
        pytest.param(name, code, id=f"{name} {k + 1}")
        for name, text in SITE.items()
        for k, (language, code) in enumerate(FENCED.findall(text))
        if language in languages and (name, code) not in ELSEWHERE
    ]


COMMAND_BLOCKS = blocks_of("sh", "console")
ALONE = [one for one in COMMAND_BLOCKS if one.values[0] not in WALKS]
BEHIND_WALKS = [one for one in COMMAND_BLOCKS if one.values[0] in WALKS]
PYTHON = blocks_of("python")
PLUGINS = [one for one in blocks_of("toml") if "entry-points" in one.values[1]]
PIECES = [one for one in blocks_of("toml") if one not in PLUGINS]
RUN_ON_PAGES = {
    line for one in ALONE for line in one.values[1].replace("\\\n", " ").splitlines()
}


@pytest.fixture(scope="module")
def cupboard(tmp_path_factory):
    """Files that are made once."""
    folder = tmp_path_factory.mktemp("cupboard")
    site_desk.fill(folder)
    return folder


@pytest.fixture
def desk(cupboard, tmp_path, monkeypatch, batches_here):
    """A folder with the files that readers have; with what code makes left out."""
    (tmp_path / "data_examples").symlink_to(ROOT / "data_examples")
    (tmp_path / "Makefile").symlink_to(ROOT / "Makefile")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(work_of_init, "_is_terminal", lambda: True)
    return lambda code: site_desk.lay_out(cupboard, tmp_path, code)


@pytest.fixture(scope="module")
def port():
    return free_port()


@pytest.fixture(scope="module")
def cluster():
    """Start computers of a cluster as the pages do, each once for all of them."""
    running = set()
    with started_computers() as start:

        def starting(program, words):
            if tuple(words) not in running:
                start(program, words)
                running.add(tuple(words))

        yield starting


@pytest.fixture
def starting(cluster):
    """Start what runs until it is ended: a server with this test, or a cluster."""
    with started_computers() as start:
        yield lambda program, words: (cluster if program == "dask" else start)(
            program, words
        )


def run_lines(code, port, starting):
    before = []
    if ADDRESS in code and "dask scheduler" not in code:  # of an earlier block
        before = re.findall(r"^dask .*", PAGES["batch"], re.MULTILINE)
    for line in lines_of("\n".join([*before, code]), port):
        run(line, starting)


@pytest.mark.slow
@pytest.mark.parametrize(("page", "code"), ALONE)
def test_commands_run(page, code, desk, port, starting):
    desk(code)
    run_lines(code, port, starting)


@pytest.mark.slow
@pytest.mark.parametrize("example", [e for e in EXAMPLES if e not in RUN_ON_PAGES])
def test_examples_of_commands_run(example, desk, port, starting):
    desk(example)
    port = free_port() if "--port" in example else port
    run_lines(example, port, starting)


def test_the_page_of_commands_has_these_examples_and_no_other_code():
    page = extension("generated_reference").command_page()
    blocks = FENCED.findall(page)
    assert {language for language, _ in blocks} == {"sh", "text"}
    usages = [code for language, code in blocks if language == "text"]
    assert [usage.split()[:2] for usage in usages] == [
        ["einschalt", name] for name in COMMANDS
    ]
    shown = "".join(code for language, code in blocks if language == "sh")
    lines = re.sub(r" \\\n *", " ", shown).splitlines()
    assert lines == EXAMPLES


@pytest.mark.slow
@pytest.mark.parametrize("page", sorted({one.values[0] for one in BEHIND_WALKS}))
def test_console_blocks_of_tutorials_run(page, desk, port, starting):
    """Behind the commands of their page; what these print is compared elsewhere."""
    blocks = [c for one, c in FENCED.findall(PAGES[page]) if one in {"sh", "console"}]
    desk(" ".join(blocks))
    for code in blocks:
        for line in lines_of(code, port):
            run(line, starting)


def test_computers_of_two_tests_listen_at_ports_of_their_own():
    one, two = (
        [
            line
            for line in lines_of(PAGES["batch"], port)
            if line.startswith(("dask", "einschalt"))
        ]
        for port in (50_001, 50_002)
    )
    assert not any(PORT in line or ADDRESS in line for line in one)
    assert [line.replace("50001", "50002") for line in one] == two
    told = {line.split()[1] for line in one if "50001" in line}
    assert told == {"scheduler", "worker", "batch", "simulate"}


def test_the_one_check_runs_the_targets_that_the_pages_name():
    """And in the order in which a reader does: the demo first."""
    makefile = (ROOT / "Makefile").read_text("utf-8")
    targets = set(re.findall(r"^([a-z-]+):", makefile, re.MULTILINE))
    assert of_ci() | set(OTHER_TARGETS) <= targets
    assert not of_ci() & set(OTHER_TARGETS)
    called = (ROOT / ".ci" / "run").read_text("utf-8")
    assert called.index("\nmake demo\n") < called.index("\nmake test\n")


@pytest.mark.slow
@pytest.mark.parametrize(("page", "code"), PYTHON)
def test_python_runs(page, code, desk):
    desk(code)
    for large, small in SMALLER.items():
        code = code.replace(large, small)
    if "os.environ" in code:  # of the libraries of a process of its own
        subprocess.run([sys.executable, "-c", code], check=True, capture_output=True)
    else:
        with contextlib.redirect_stdout(io.StringIO()):
            exec(compile(code, page, "exec"), {})
    for picture in re.findall(r"savefig\(\"(.*?)\"", code):
        assert Path(picture).stat().st_size > 10_000


def tables_as_the_pages_name_them(code):
    """Write the files that a piece of block.toml names, from those of the block."""
    control = pd.read_csv("control_points.csv", dtype={"point_id": str})
    if "Festpunkte.xlsx" in code:
        names = {"easting": "Y_GK", "northing": "X_GK"}
        table = control.rename(columns=names)
        options = {"index": False, "engine": "xlsxwriter"}
        table.to_excel("Festpunkte.xlsx", sheet_name="Lage", **options)
        low = pd.read_csv("low_flight.csv", dtype={"point_id": str, "coverage": str})
        low = low.rename(columns={"x": "x red", "y": "y red"})
        low.to_csv("auswertung.txt", sep=";", decimal=",", index=False)
    if "auswertung.csv" in code:
        words = {"high_flight.csv": "hoch", "low_flight.csv": "tief"}
        flights = [
            pd.read_csv(name, dtype=str).assign(Flug=word)
            for name, word in words.items()
        ]
        pd.concat(flights).to_csv("auswertung.csv", index=False)
    control.to_csv("control.csv", index=False)
    if "approximate.csv" in code:
        truth = es.simulate_block("demo", seed=1).truth
        truth.assign(group="a").to_csv("approximate.csv", index=False)


def merged(whole, part):
    """A table of TOML with the keys of a part in place of its own."""
    for key, value in part.items():
        is_table = isinstance(value, dict) and isinstance(whole.get(key), dict)
        whole[key] = merged(whole[key], value) if is_table else value
    return whole


@pytest.mark.parametrize(("page", "code"), PIECES)
def test_pieces_of_a_block_file_are_read(page, code, cupboard, tmp_path, monkeypatch):
    of_images = page == "theory/interior_orientation"
    source = ROOT / "data_examples/sxb_strasbourg" if of_images else cupboard / "BLOCK"
    shutil.copytree(source, tmp_path / "block")
    monkeypatch.chdir(tmp_path / "block")
    tables_as_the_pages_name_them(code)
    whole = tomllib.loads(Path("block.toml").read_text("utf-8"))
    part = tomllib.loads(code)
    if of_images:
        pixels = pd.read_csv("image_points.csv", dtype={"point_id": str})
        within = 0.4 * pixels[["x", "y"]] / 0.0045 * [1, -1]  # a smaller image
        pixels[["x", "y"]] = within.add([4010.5, 2985.2])
        pixels.to_csv("image_points.csv", index=False)
        del whole["low_flight"]["principal_distance_mm"]
        (camera,) = (
            tomllib.loads(c.values[1])["low_flight"]["camera"]
            for c in PIECES
            if "low_flight.camera" in c.values[1]
        )
        Path("camera.toml").write_text(tomli_w.dumps(camera), "utf-8")
    if "approximate_points" in part:
        del whole["high_flight"]
    Path("block.toml").write_text(tomli_w.dumps(merged(whole, part)), "utf-8")
    block = es.read_block(tmp_path / "block")
    assert len(block.low_flight.image_points if of_images else block.control_points)


@pytest.mark.parametrize(("page", "code"), PLUGINS)
def test_a_writer_of_ones_own_is_found_by_its_entry_point(
    page, code, desk, tmp_path, monkeypatch
):
    """A package with the entry point of the page, as pip installs it."""
    desk(code)
    ((group, points),) = tomllib.loads(code)["project"]["entry-points"].items()
    ((name, place),) = points.items()
    module, function = place.split(":")
    Path(f"{module}.py").write_text(
        f"def {function}(handed, path):\n    path.write_text(str(len(handed.points)))\n"
    )
    described = Path(f"{module}-1.0.dist-info")
    described.mkdir()
    (described / "METADATA").write_text(f"Name: {module}\nVersion: 1.0\n")
    (described / "entry_points.txt").write_text(f"[{group}]\n{name} = {place}\n")
    monkeypatch.syspath_prepend(tmp_path)
    (written,) = es.export("RESULT", f"points{name}")
    assert int(written.path.read_text()) > 50


def test_no_block_of_the_site_is_left_out():
    """Every block is run by a test that is named here."""
    run_here = {
        one.values
        for blocks in (ALONE, BEHIND_WALKS, PYTHON, PIECES, PLUGINS)
        for one in blocks
    }
    left = [
        (name, language, code)
        for name, text in SITE.items()
        for language, code in FENCED.findall(text)
        if (name, code) not in run_here | ELSEWHERE
    ]
    assert left == []


@pytest.mark.parametrize("page", SITE)
def test_every_fence_of_a_page_is_a_block_a_cell_or_a_directive(page):
    """Indented ones, with tildes, or without a language, no test would see."""
    assert unknown_fences(SITE[page]) == []
    cells = SITE[page].count("{code-cell}")
    assert cells == len(CELL.findall(SITE[page]))


def unknown_fences(text):
    """Lines that open code which FENCED and CELL do not find."""
    unknown, rest = [], DIRECTIVE.sub(r"\1\2", FENCED.sub("", text))
    for sign, said in FENCE.findall(rest):
        directive = re.match(r"\{([\w-]+)\}", said)
        is_known = directive and directive[1] in DIRECTIVES
        closes = sign[0] == ":" and not said
        if not (is_known or closes or said == CELLS):
            unknown.append(sign + said)
    if OF_RST.search(text):
        unknown.append("code of reStructuredText")
    return unknown


@pytest.mark.parametrize(
    "block",
    [
        "```\neinschalt\n```\n",
        "~~~sh\neinschalt\n~~~\n",
        "- so:\n\n  ```sh\n  einschalt\n  ```\n",
        "````sh\neinschalt\n````\n",
        "``` sh\neinschalt\n```\n",
        "```{code-block} sh\neinschalt\n```\n",
        ":::{code-block} sh\neinschalt\n:::\n",
        "```{code-cell} ipython3\n1\n```\n",
        "```{eval-rst}\n.. code-block:: sh\n\n   einschalt\n```\n",
    ],
)
def test_a_block_that_no_test_runs_is_seen(block):
    assert unknown_fences(f"# A page\n\n{block}\nText.\n")


@pytest.mark.parametrize("file", EXTENSIONS, ids=lambda f: f.stem)
def test_examples_of_the_extensions_run(file):
    failed, tried = doctest.testmod(extension(file.stem))
    assert failed == 0
    assert tried > 0
