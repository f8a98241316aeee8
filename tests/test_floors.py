"""Imports point down: interfaces, pipeline, stages, theory, foundations."""

import ast
from collections import Counter
from functools import cache
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
    "result_parts",
    "result",
    "densify",
    "adjust_block",
    "batch",
    "simulation",
    "planning",
]
# the same of pipeline/planning/
ROOMS_OF_PLANNING = [
    "flights",
    "tables",
    "estimate",
    "propagation",
    "choice",
    "ground",
    "area",
]
# the same of interfaces/
ROOMS_OF_INTERFACES = [
    "provenance",
    "reports",
    "files",
    "notebook",
    "publication",
    "programs",
    "new_block",
    "batch",
    "python_plans",
    "python_api",
    "python_simulation",
    "local_page",
    "cli",
]
MOST_FILES_IN_A_ROOM = 12
MOST_LINES_IN_A_FUNCTION = 40
MOST_LINES_IN_A_MODULE = 300
FORBIDDEN_NAMES = {"utils", "helpers", "common", "misc", "util", "helper"}
# what a library may be imported by
ONLY_IN = {
    "pyproj": [
        "foundations/projections.py",
        "foundations/areas_of_use.py",
        "foundations/epsg_units.py",
        "foundations/databases_of_proj.py",
        "foundations/coordinate_operations.py",
        "foundations/likely_systems.py",
        "foundations/published_systems.py",
        *(
            f"interfaces/publication/{name}.py"
            for name in ("proj_database", "published_operation", "return_check")
        ),
        "interfaces/provenance.py",
    ],
    "pandas": [
        f"foundations/{name}.py"
        for name in ("batches", "cell_values", "frame_columns", "tables")
    ],
    # elsewhere `compiled` of kernels.py, whose cache knows all sources of a kernel
    "numba": [
        "foundations/kernels.py",
        "foundations/kernel_parts.py",
        "foundations/sparse_cholesky/dense_kernels.py",
    ],
    "sys": [],
    "logging": [],
}
FREE_FROM_FLOOR = {"pandas": 2, "sys": 4, "logging": 4, "pyproj": 5, "numba": 5}

MODULES = sorted(path for path in SOURCE.rglob("*.py") if path.parent != SOURCE)


def stem(path):
    return path.relative_to(SOURCE).as_posix()


def floor_of(module):
    parts = module.split(".")
    return FLOORS.index(parts[1]) if len(parts) > 1 and parts[1] in FLOORS else None


@cache
def nodes(path):
    """Of the syntax of a file, which is parsed once for all rules."""
    return tuple(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))


def listed(offences):
    """What a rule found in all files: it fails once, and says everything."""
    return "\n" + "\n".join(offences)


@cache
def imported_modules(path):
    return tuple(_imports(path))


def _imports(path):
    for node in nodes(path):
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


def test_there_are_modules_to_look_at():
    assert {stem(path).split("/")[0] for path in MODULES} == set(FLOORS)


@pytest.mark.slow
def test_imports_point_down():
    offences = []
    for path in MODULES:
        own = FLOORS.index(stem(path).split("/")[0])
        for module in imported_modules(path):
            if module.split(".")[0] != "einschalt":
                continue
            floor = floor_of(module)
            if floor is None:
                offences.append(f"{stem(path)} imports the root package: {module}")
            elif floor > own:
                offences.append(f"{stem(path)} imports upwards: {module}")
    assert not offences, listed(offences)


def room_of(module, floor, rooms):
    inside = f"einschalt.{floor}."
    if not module.startswith(inside):
        return None
    return rooms.index(module.removeprefix(inside).split(".")[0])


@pytest.mark.parametrize(
    ("floor", "rooms"),
    [("pipeline", ROOMS), ("pipeline.planning", ROOMS_OF_PLANNING)],
)
def test_rooms_of_the_pipeline_are_in_their_order(floor, rooms):
    inside = floor.replace(".", "/") + "/"
    offences = []
    for path in MODULES:
        if path.name == "__init__.py" or not stem(path).startswith(inside):
            continue
        module = "einschalt." + stem(path)[:-3].replace("/", ".")
        for other in imported_modules(path):
            room = room_of(other, floor, rooms)
            if room is not None and room > room_of(module, floor, rooms):
                offences.append(f"{module}: {other}")
    assert not offences, listed(offences)


def test_rooms_of_the_interfaces_are_in_their_order():
    inside = [path for path in MODULES if stem(path).startswith("interfaces/")]
    offences = []
    for path in inside:
        if path.name == "__init__.py":
            continue
        own = ROOMS_OF_INTERFACES.index(stem(path)[:-3].split("/")[1])
        for other in imported_modules(path):
            parts = other.split(".")
            is_inside = parts[:2] == ["einschalt", "interfaces"] and len(parts) > 2
            if is_inside and ROOMS_OF_INTERFACES.index(parts[2]) > own:
                offences.append(f"{stem(path)}: {other}")
    assert not offences, listed(offences)


def test_rooms_of_the_pipeline_can_be_overseen():
    inside = [path for path in MODULES if stem(path).startswith("pipeline/")]
    files = Counter(path.parent for path in inside if path.name != "__init__.py")
    assert max(files.values()) <= MOST_FILES_IN_A_ROOM, files.most_common(1)


def test_the_summary_computes_nothing():
    allowed = ("einschalt.foundations", "einschalt.pipeline.assessment")
    own = "einschalt.pipeline.summary"
    plain = {"math", "functools", "dataclasses", "typing", "collections"}
    for path in (SOURCE / "pipeline" / "summary").rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        for module in imported_modules(path):
            is_ours = module.startswith((*allowed, own))
            is_plain = module.split(".")[0] in plain
            assert is_ours or is_plain, f"{stem(path)} imports {module}"
        assert "simultaneous is" not in text, stem(path)


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


def test_files_and_printing_only_in_interfaces():
    offences = [
        f"{stem(path)}, line {node.lineno}: {node.func.id}"
        for path in MODULES
        if not stem(path).startswith("interfaces/")
        for node in nodes(path)
        if isinstance(node, ast.Call)
        and isinstance(node.func, ast.Name)
        and node.func.id in {"print", "open"}
    ]
    assert not offences, listed(offences)


def test_no_drawers():
    names = {path.stem for path in MODULES} | {path.parent.name for path in MODULES}
    assert not names & FORBIDDEN_NAMES


def test_functions_fit_on_a_page():
    offences = [
        f"{stem(path)}, {node.name}: {n_lines(node)} lines"
        for path in MODULES
        for node in nodes(path)
        if isinstance(node, ast.FunctionDef)
        and n_lines(node) > MOST_LINES_IN_A_FUNCTION
        and not is_kernel(node)
    ]
    assert not offences, listed(offences)


def n_lines(function):
    """Of the body, without the docstring."""
    body = function.body
    if isinstance(body[0], ast.Expr) and isinstance(body[0].value, ast.Constant):
        body = body[1:]
    return body[-1].end_lineno - body[0].lineno + 1 if body else 0


def is_kernel(node):
    # a fused kernel is one loop over the points; cutting it up would hide that
    return any("compiled" in ast.unparse(mark) for mark in node.decorator_list)


def test_modules_stay_short():
    sizes = {stem(path): n_code_lines(path) for path in MODULES}
    offences = [f"{k}: {n}" for k, n in sizes.items() if n > MOST_LINES_IN_A_MODULE]
    assert not offences, listed(offences)


def n_code_lines(path):
    documented = (ast.Module, ast.ClassDef, ast.FunctionDef)
    docstrings = {
        id(node.body[0].value)
        for node in nodes(path)
        if isinstance(node, documented) and ast.get_docstring(node) is not None
    }
    code = {
        node.lineno
        for node in nodes(path)
        if isinstance(node, (ast.stmt, ast.expr)) and not is_text(node, docstrings)
    }
    return len(code)


def is_text(node, docstrings):
    return id(node) in docstrings or id(getattr(node, "value", None)) in docstrings
