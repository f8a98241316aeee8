"""Imports point down: interfaces, pipeline, stages, theory, foundations."""

import ast
from collections import Counter
from pathlib import Path

import pytest

SOURCE = Path(__file__).parents[1] / "src" / "einschalt"
FLOORS = ["foundations", "theory", "stages", "pipeline", "interfaces"]
# inside pipeline/, lowest first; a name is a room (a folder) or a file beside them
ROOMS = [
    "settings",
    "progress",
    "block",
    "densification",
    "assessment",
    "summary",
    "result",
    "densify",
    "batch",
    "simulation",
    "planning",
]
MOST_FILES_IN_A_ROOM = 14
FORBIDDEN_NAMES = {"utils", "helpers", "common", "misc", "util", "helper"}
# what a library may be imported by
ONLY_IN = {
    "pyproj": ["foundations/projections.py", "interfaces/provenance.py"],
    "pandas": [
        f"foundations/{name}.py" for name in ("batches", "cell_values", "tables")
    ],
    "sys": [],
    "logging": [],
}
FREE_FROM_FLOOR = {"pandas": 2, "sys": 4, "logging": 4, "pyproj": 5}

MODULES = sorted(path for path in SOURCE.rglob("*.py") if path.parent != SOURCE)


def stem(path):
    return path.relative_to(SOURCE).as_posix()


def floor_of(module):
    parts = module.split(".")
    return FLOORS.index(parts[1]) if len(parts) > 1 and parts[1] in FLOORS else None


def imported_modules(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{stem(path)} has a relative import"
            for alias in node.names:
                whole = f"{node.module}.{alias.name}"
                is_module = (
                    SOURCE.parent.joinpath(*whole.split("."))
                    .with_suffix(".py")
                    .exists()
                )
                yield whole if is_module else node.module


@pytest.mark.parametrize("path", MODULES, ids=stem)
def test_imports_point_down(path):
    own = FLOORS.index(stem(path).split("/")[0])
    for module in imported_modules(path):
        if module.split(".")[0] != "einschalt":
            continue
        floor = floor_of(module)
        assert floor is not None, f"imports the root package: {module}"
        assert floor <= own, f"imports upwards: {module}"


def room_of(module):
    parts = module.split(".")
    is_inside = parts[:2] == ["einschalt", "pipeline"] and len(parts) > 2
    return ROOMS.index(parts[2]) if is_inside else None


def test_rooms_of_the_pipeline_are_in_their_order():
    inside = [path for path in MODULES if stem(path).startswith("pipeline/")]
    for path in inside:
        if path.name == "__init__.py":
            continue
        module = "einschalt." + stem(path)[:-3].replace("/", ".")
        for other in imported_modules(path):
            room = room_of(other)
            assert room is None or room <= room_of(module), f"{module}: {other}"


def test_rooms_of_the_pipeline_can_be_overseen():
    inside = [path for path in MODULES if stem(path).startswith("pipeline/")]
    files = Counter(path.parent for path in inside if path.name != "__init__.py")
    assert max(files.values()) <= MOST_FILES_IN_A_ROOM, files.most_common(1)


def test_the_sparse_factorization_knows_nothing_of_photogrammetry():
    room = SOURCE / "foundations" / "sparse_cholesky"
    for path in room.glob("*.py"):
        others = {m for m in imported_modules(path) if m.startswith("einschalt.")}
        allowed = ("einschalt.foundations.sparse_cholesky.", "einschalt.foundations.")
        assert all(other.startswith(allowed) for other in others), path.name


def test_no_circles():
    graph = {
        "einschalt." + stem(path)[:-3].replace("/", "."): [
            module
            for module in imported_modules(path)
            if module.startswith("einschalt.")
        ]
        for path in MODULES
    }
    done, path_now = set(), []

    def visit(module):
        assert module not in path_now, f"circle: {' -> '.join([*path_now, module])}"
        if module in done:
            return
        path_now.append(module)
        for other in graph.get(module, []):
            visit(other)
        path_now.pop()
        done.add(module)

    for module in graph:
        visit(module)


@pytest.mark.parametrize("library", ONLY_IN)
def test_libraries_keep_to_their_floor(library):
    for path in MODULES:
        floor = FLOORS.index(stem(path).split("/")[0])
        if floor >= FREE_FROM_FLOOR[library] or stem(path) in ONLY_IN[library]:
            continue
        names = {module.split(".")[0] for module in imported_modules(path)}
        assert library not in names, f"{stem(path)} imports {library}"


@pytest.mark.parametrize("path", MODULES, ids=stem)
def test_files_and_printing_only_in_interfaces(path):
    if stem(path).startswith("interfaces/"):
        return
    calls = {
        node.func.id
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
    }
    assert not calls & {"print", "open"}


def test_no_drawers():
    names = {path.stem for path in MODULES} | {path.parent.name for path in MODULES}
    assert not names & FORBIDDEN_NAMES


@pytest.mark.parametrize("path", MODULES, ids=stem)
def test_functions_fit_on_a_page(path):
    lines = path.read_text(encoding="utf-8").splitlines()
    for node in ast.walk(ast.parse("\n".join(lines))):
        if isinstance(node, ast.FunctionDef):
            body = node.body
            if isinstance(body[0], ast.Expr) and isinstance(
                body[0].value, ast.Constant
            ):
                body = body[1:]
            size = body[-1].end_lineno - body[0].lineno + 1 if body else 0
            assert size <= 40 or is_kernel(node), f"{node.name}: {size} lines"


def is_kernel(node):
    # a fused kernel is one loop over the points; cutting it up would hide that
    return any("njit" in ast.unparse(mark) for mark in node.decorator_list)


@pytest.mark.parametrize("path", MODULES, ids=stem)
def test_modules_stay_short(path):
    tree = ast.parse(path.read_text(encoding="utf-8"))
    documented = (ast.Module, ast.ClassDef, ast.FunctionDef)
    docstrings = {
        id(node.body[0].value)
        for node in ast.walk(tree)
        if isinstance(node, documented) and ast.get_docstring(node) is not None
    }
    code = {
        node.lineno
        for node in ast.walk(tree)
        if isinstance(node, (ast.stmt, ast.expr)) and not is_text(node, docstrings)
    }
    assert len(code) <= 300


def is_text(node, docstrings):
    return id(node) in docstrings or id(getattr(node, "value", None)) in docstrings
