"""Whatever lies in a folder, no command changes a byte of what it did not write.

Random folders with files of the user, links, blocks and results; random commands into
them. The computation and the figures are stand-ins, everything that writes is real.
"""

import os
import shutil
import tempfile
from pathlib import Path

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from tests.changed_results import from_elsewhere
from typer.testing import CliRunner

import einschalt as es
from einschalt.interfaces import python_api, python_simulation
from einschalt.interfaces.batch import block_run
from einschalt.interfaces.cli.main import app
from einschalt.interfaces.files import orientation_folder, result_folder
from einschalt.interfaces.publication import publish
from einschalt.interfaces.reports import figure_files, planning_figures
from einschalt.pipeline.batch.local_engine import Answer

pytestmark = pytest.mark.slow

POINTS = [(0, 0), (92, 0), (0, 90), (92, 90), (0, -90), (92, -90), (46, 5)]
TABLES = {
    "models.csv": "model_id,point_id,x,y\n"
    + "".join(f"1,{k},{x},{y}\n" for k, (x, y) in enumerate(POINTS)),
    "points.csv": "point_id,easting,northing\n"
    + "".join(f"{k},{8 * x},{8 * y + x % 3}\n" for k, (x, y) in enumerate(POINTS)),
    "residuals.csv": "model_id,point_id,x,y,z,y_parallax\n"
    + "".join(f"1,{k},{x},{y},-150,0.0{k}\n" for k, (x, y) in enumerate(POINTS)),
}
FOLDERS = (
    *("out", "out/one", "user", "tables", "blocks/one", "blocks/two", "link", "."),
    "results",
)
NAMES = (
    *("points.csv", "models.csv", "summary.txt", "plan.csv", "block.toml", "one"),
    *("provenance.json", "failure.json", "changes.csv", "blocks.csv", "notes.txt"),
    *(".einschalt-lock", ".einschalt-coming.json", ".einschalt-batch.json"),
    *("block.schema.json", "own.db", "operations.csv", "README.md"),
)
PLACE = "PLACE"  # of the output; "-o PLACE" stands at the end where it does not occur
COMMANDS = {
    "densify one": ("densify", "blocks/one"),
    "densify two": ("densify", "blocks/two"),
    "batch": ("batch", "blocks"),
    "transform": ("transform", "tables/models.csv", "tables/points.csv"),
    "orient": ("orient", "tables/residuals.csv", "--base", "92"),
    "plan": ("plan", "--scale-number", "6000", "--spacing", "200"),
    "simulate": ("simulate", "--preset", "demo"),
    "export": ("export", "results", "--to", f"{PLACE}/points.csv"),
    "publish": ("publish", "results", "--as", "own"),
    "convert": ("convert", "tables/points.csv", f"{PLACE}/points.csv"),
    "init": ("init", PLACE, "--template", "--schema"),
}
NEVER = {"convert", "init"}  # have no --overwrite: they replace nothing at all
# what a command may replace of what another one, or itself, has written
SAME = {
    "densify one": {"densify one", "batch"},
    "batch": {"densify one", "densify two"},
}

runs = st.tuples(
    st.sampled_from(sorted(COMMANDS)), st.sampled_from(FOLDERS), st.booleans()
)
deeds = st.tuples(
    st.sampled_from(["write", "symbolic", "hard", "edit"]),
    st.sampled_from(FOLDERS),
    st.sampled_from(NAMES),
)
steps = st.lists(st.one_of(runs, deeds), min_size=1, max_size=5)


class InThisProcess:
    """An engine whose answers come at once."""

    def answers(self, function, tasks):
        for place, task in enumerate(tasks):
            yield Answer(place, function(task))


@pytest.fixture(scope="module")
def template(tmp_path_factory, make_block):
    root = tmp_path_factory.mktemp("template")
    make_block(root / "blocks" / "one")
    two = make_block(root / "blocks" / "two")  # a copy would count as the same block
    two.replace("low_flight.csv", ",10.0000,", ",10.0010,")
    for folder in ("tables", "user"):
        (root / folder).mkdir()
    for name, text in TABLES.items():
        (root / "tables" / name).write_text(text)
    (root / "user" / "letter.txt").write_text("Dear Sir,")
    (root / "link").symlink_to("user")
    es.densify(es.read_block(root / "blocks" / "two")).write(root / "results")
    return root


@pytest.fixture(scope="module")
def quick(template):
    """Stand-ins for what computes and draws."""
    computed = es.densify(es.read_block(template / "blocks" / "one"))
    simulated = es.simulate_block("demo")
    svg = "<svg xmlns='http://www.w3.org/2000/svg'/>"

    def densify(block, *_, **__):
        return from_elsewhere(computed, block)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(python_api, "densify", densify)
        patch.setattr(block_run, "densify", densify)
        patch.setattr(python_api, "chosen_engine", lambda *_: InThisProcess())
        patch.setattr(python_simulation, "simulate_block", lambda *_, **__: simulated)
        # PROJ searches a database that is written, for seconds, and writes nothing
        patch.setattr(publish, "require_database_returns", lambda *_: None)
        patch.setattr(result_folder, "render", lambda _: "<!doctype html>")
        patch.setattr(
            result_folder,
            "write_geopackage",
            lambda _, path, **__: path.write_bytes(b"SQLite format 3"),
        )
        for name in ("parallax_figure", "krames_figure"):
            patch.setattr(orientation_folder, name, lambda *_: svg)
        patch.setattr(planning_figures, "diagrams_figure", lambda _: None)
        patch.setattr(figure_files, "figure_bytes", lambda *_: {"svg": svg.encode()})
        yield


def snapshot(root):
    """What every name holds: bytes of files, targets of links."""
    return {
        path: path.readlink() if path.is_symlink() else path.read_bytes()
        for path in root.rglob("*")
        if path.is_symlink() or path.is_file()
    }


def do(root, deed, folder, name):
    """Something that a user may do; nothing where it cannot be done."""
    path = root / folder / name
    if not path.parent.exists():
        path.parent.mkdir(parents=True)
    if not path.parent.is_dir() or path.is_dir():
        return
    letter = root / "user" / "letter.txt"
    if deed == "edit" and path.is_file():
        path.write_bytes(path.read_bytes() + b" ")
    elif not os.path.lexists(path):
        if deed == "write":
            path.write_text("the user's own\n")
        elif deed == "symbolic":
            path.symlink_to(letter)
        elif deed == "hard":
            path.hardlink_to(root / "tables" / "points.csv")


def may_replace(command, owner):
    return owner is not None and (owner == command or owner in SAME.get(command, ()))


@settings(
    max_examples=30,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@example([("transform", "tables", True)])
@example([("convert", "tables", False)])
@example([("export", "results", True), ("publish", "results", True)])
@example([("write", "out", "block.schema.json"), ("init", "out", False)])
@example([("symbolic", "user", "points.csv"), ("convert", "link", False)])
@example([("write", "out", "points.csv"), ("export", "out", False)])
@example([("write", "out", "README.md"), ("publish", "out", False)])
@example([("orient", "tables", True)])
@example([("densify one", "blocks/one", True)])
@example([("write", "out", "points.csv"), ("densify two", "out", False)])
@example([("hard", "out", "points.csv"), ("transform", "out", True)])
@example([("symbolic", "out", ".einschalt-lock"), ("batch", "out", True)])
@example([("densify one", "out/one", False), ("densify two", "out/one", False)])
@given(steps)
def test_no_byte_of_a_file_changes_but_of_results_of_the_same_block(
    template, quick, steps
):
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder).resolve() / "root"
        shutil.copytree(template, root, symlinks=True)
        owners = {}  # of each result: the command that wrote it, and what it wrote
        for first, second, third in steps:
            if first not in COMMANDS:
                do(root, first, second, third)
                continue
            before = snapshot(root)
            run(root, first, second, is_overwriting=third)
            after = snapshot(root)
            for path, held in before.items():
                if after.get(path) == held:
                    continue
                owner, written = owners.get(path, (None, None))
                is_own = written == held and may_replace(first, owner)
                place = (root / second).resolve()
                is_asked = third and first not in NEVER and place in path.parents
                assert is_own or is_asked, f"{first} -o {second}: {path}"
                assert not is_input(root, first, path), f"{first}: input {path}"
            for path, held in after.items():
                if before.get(path) != held:
                    owners[path] = (first, held)


def is_input(root, command, path):
    if command.startswith("densify"):
        return path.parent == root / "blocks" / command.split()[1]
    if command == "batch":
        return path.parent.parent == root / "blocks"
    if command in {"export", "publish"}:
        return path.parent == root / "results"
    return command in {"transform", "orient", "convert"} and (
        path.parent == root / "tables"
    )


def run(root, command, folder, *, is_overwriting):
    words = [
        str(root / word) if (root / word).exists() else word
        for word in COMMANDS[command]
    ]
    if not any(PLACE in word for word in words):
        words += ["-o", PLACE]
    words = [word.replace(PLACE, str(root / folder)) for word in words]
    more = ["--overwrite"] * (is_overwriting and command not in NEVER)
    done = CliRunner().invoke(app, [*words, *more])
    is_known = done.exception is None or isinstance(done.exception, SystemExit)
    if not is_known:
        raise done.exception
    assert done.exit_code in {0, 1, 2}
    if done.exit_code == 2:
        sentence = done.stderr.rstrip().split("\n")[-1]
        assert sentence.endswith((".", "?")), done.stderr
