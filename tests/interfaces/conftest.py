"""A small block as a folder, made of text that a test can spoil."""

from dataclasses import fields
from types import SimpleNamespace

import pytest

BLOCK_TOML = """\
[block]
name = "Nine points"
crs = "EPSG:31255"

[control_points]
file = "control_points.csv"
standard_error_m = 0.03

[high_flight]
scale_number = 15000
m_g_um = 7.5
model_points = "high_flight.csv"

[low_flight]
scale_number = 8000
m_g_um = 5.0
model_points = "low_flight.csv"
"""
# 3 x 3 points, 500 m apart, west to east and south to north; the middle one is new
NAMES = ["0012", "0013", "0014", "7/8", "PP1", "7/10", "21", "22", "23"]
WEST, SOUTH, SPACING = 13_000.0, 322_000.0, 500.0


def ground():
    """Name, easting and northing of each point."""
    for place, name in enumerate(NAMES):
        row, column = divmod(place, 3)
        yield name, WEST + SPACING * column, SOUTH + SPACING * row


def control_points():
    lines = ["point_id,easting,northing"]
    lines += [f"{n},{e:.2f},{t:.2f}" for n, e, t in ground() if n != "PP1"]
    return "\n".join(lines) + "\n"


def model_lines(coverage, model, scale_number, names):
    """Machine coordinates in mm: the scale, and a shift of the origin."""
    for name, easting, northing in ground():
        if name in names:
            x = (easting - WEST) / scale_number * 1e3 + 10.0
            y = (northing - SOUTH) / scale_number * 1e3 + 20.0
            yield f"{coverage},{model},{name},{x:.4f},{y:.4f}"


def model_points(models, scale_number):
    lines = ["coverage,model_id,point_id,x,y"]
    for coverage, model, names in models:
        lines += model_lines(coverage, model, scale_number, names)
    return "\n".join(lines) + "\n"


FILES = {
    "block.toml": BLOCK_TOML,
    "control_points.csv": control_points(),
    "high_flight.csv": model_points([("1", "1/2", NAMES)], 15_000),
    "low_flight.csv": model_points(
        [
            ("1", "11/12", NAMES[:6]),
            ("1", "12/13", NAMES[3:]),
            ("2", "11/12", NAMES[:6]),
            ("2", "12/13", NAMES[3:]),
        ],
        8_000,
    ),
}


class BlockFolder:
    """A folder with a sound block, and ways to spoil it."""

    def __init__(self, path):
        self.path = path
        for name, text in FILES.items():
            self.write(name, text)

    def write(self, name, text):
        data = text if isinstance(text, bytes) else text.encode("utf-8")
        (self.path / name).write_bytes(data)

    def read(self, name):
        return (self.path / name).read_text(encoding="utf-8")

    def replace(self, name, old, new, count=1):
        text = self.read(name)
        assert old in text, f"{name} does not hold {old!r}"
        self.write(name, text.replace(old, new, count))


@pytest.fixture(scope="session")
def make_block():
    """Write small sound blocks, each in a folder of its own."""

    def make(folder):
        folder.mkdir(parents=True)
        return BlockFolder(folder)

    return make


@pytest.fixture
def small_block(tmp_path):
    """The folder of a small sound block."""
    folder = tmp_path / "nine_points"
    folder.mkdir()
    return BlockFolder(folder)


class Memory:
    """What was computed, judged and drawn of the same files with the same settings.

    For tests that look at what becomes of files, and not at the numbers in them.
    """

    def __init__(self):
        self.results = {}
        self.reports = {}

    def densify(self, block, settings=None, **options):
        """The result of the block, wherever it lies: its path counts as well."""
        from tests.changed_results import from_elsewhere

        from einschalt.pipeline.densify import densify

        files = sorted(block.checksums.items())
        key = (block.name, *files, repr(settings), options.get("kind"))
        if key not in self.results:
            self.results[key] = densify(block, settings, **options)
        return from_elsewhere(self.results[key], block)

    def render(self, result):
        """The report of what was judged: that of the remembered result."""
        from einschalt.foundations.language import language
        from einschalt.interfaces.reports.html_report import render

        names = [field.name for field in fields(result.solution)]
        tables = [getattr(result.solution, n) for n in names if n != "block"]
        parts = (result.assessment, *tables)
        key = (language(), *(id(part) for part in parts))
        # kept beside its report, so that nothing else can get these numbers
        if key not in self.reports:
            self.reports[key] = result, render(result)
        return self.reports[key][1]


@pytest.fixture(scope="session")
def memory():
    """What the tests of this process have computed so far."""
    return Memory()


@pytest.fixture
def computed_once(monkeypatch, memory):
    """Compute and draw only what no test has computed before; write all of it."""
    from einschalt.interfaces import python_api
    from einschalt.interfaces.batch import block_run
    from einschalt.interfaces.files import result_folder

    remembered = SimpleNamespace(densify=memory.densify)
    monkeypatch.setattr(python_api, "computed", remembered)
    monkeypatch.setattr(block_run, "densify", memory.densify)
    monkeypatch.setattr(result_folder, "render", memory.render)


class InThisProcess:
    """An engine whose answers come at once, so that nobody waits for processes."""

    def answers(self, function, tasks):
        """Call the function with each task; yield answers as they come."""
        from einschalt.pipeline.batch.local_engine import Answer

        for place, task in enumerate(tasks):
            yield Answer(place, function(task))


@pytest.fixture(scope="session")
def engine_here():
    """An engine that needs no process."""
    return InThisProcess()


@pytest.fixture
def in_this_process(monkeypatch, engine_here):
    """Batches run here; that they run in processes of their own is shown elsewhere."""
    from einschalt.interfaces import python_api

    monkeypatch.setattr(python_api, "chosen_engine", lambda *_: engine_here)
