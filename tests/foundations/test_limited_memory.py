"""What a process is told that has little memory of its own."""

import subprocess
import sys

import pytest

resource = pytest.importorskip("resource")  # Windows has no such limits

from einschalt.foundations import limited_memory  # noqa: E402
from einschalt.foundations.errors import GeometryError  # noqa: E402

# Arrow, LLVM or OpenBLAS end the process, or wait for ever, below 1.35 GB
LIMITED = """
import resource, sys
resource.setrlimit(resource.RLIMIT_AS, (1_200_000_000, resource.RLIM_INFINITY))
from einschalt.interfaces.cli.main import run
sys.argv = ["einschalt", "densify", "data_examples/neukirchen", "-o", "none"]
run()
"""
ROOM = """
import resource, sys
from einschalt.foundations.limited_memory import is_there_room_for
resource.setrlimit(resource.RLIMIT_AS, (1_000_000_000, resource.RLIM_INFINITY))
sys.exit(not (is_there_room_for(1e8) and not is_there_room_for(1e9)))
"""


def run(script):
    return subprocess.run(
        [sys.executable, "-c", script],
        capture_output=True,
        check=False,
        text=True,
        timeout=60,
    )


def test_an_address_space_that_libraries_alone_fill_is_refused():
    said = run(LIMITED)
    assert said.returncode == 2
    assert "is limited to 1.2 GB; expected at least 1.5 GB" in said.stderr
    assert "Traceback" not in said.stderr


def test_room_is_what_the_system_grants_at_once():
    assert run(ROOM).returncode == 0


def test_without_limits_nothing_is_asked(monkeypatch):
    none = {"addresses": float("inf"), "data": float("inf")}
    monkeypatch.setattr(limited_memory, "memory_limits", lambda: none)
    monkeypatch.setattr(limited_memory.mmap, "mmap", None)
    limited_memory.prepare_for_limits()
    assert limited_memory.is_there_room_for(1e18)


def test_the_limit_itself_is_named(monkeypatch):
    limits = {"addresses": 1.4849e9, "data": float("inf")}
    monkeypatch.setattr(limited_memory, "memory_limits", lambda: limits)
    with pytest.raises(GeometryError, match=r"limited to 1\.48 GB; expected at least"):
        limited_memory.prepare_for_limits()
