"""Tasks run in other processes, and the end of a process ends one task only.

The function is ``eval``, the one function of Python that does anything: every worker
knows it, and the task says what happens.
"""

import os
import pickle
import signal
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import pytest

from einschalt.foundations.errors import SettingsError
from einschalt.pipeline.batch.local_engine import (
    Answer,
    LocalEngine,
    ProcessEndedError,
    TimeLimitError,
    run_in_order,
)

POSIX = pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
ASKS_PROC = pytest.mark.skipif(not Path("/proc").exists(), reason="asks /proc")
KILL_ITSELF = "__import__('os').kill(__import__('os').getpid(), 9)"


@pytest.mark.parametrize("n_workers", [1, 3])
def test_values_come_in_the_order_of_the_tasks(n_workers):
    tasks = [f"{k}**2" for k in range(7)]
    values = run_in_order(LocalEngine(n_workers), eval, tasks)
    assert values == [k**2 for k in range(7)]


def test_no_tasks():
    assert run_in_order(LocalEngine(2), eval, []) == []


def test_tasks_run_in_other_processes():
    asked = "__import__('os').getpid()"
    pids = run_in_order(LocalEngine(2), eval, [asked] * 8)
    assert os.getpid() not in pids
    assert 1 <= len(set(pids)) <= 2


WAIT_FOR_THE_OTHER = """
import time
from pathlib import Path
Path({own!r}).touch()
end = time.monotonic() + 60.0
while not Path({other!r}).exists():
    assert time.monotonic() < end, "it was alone"
    time.sleep(0.01)
"""


def test_tasks_run_at_the_same_time(tmp_path):
    """Each of two waits for what the other writes."""
    one, two = str(tmp_path / "one"), str(tmp_path / "two")
    pairs = [(one, two), (two, one)]
    tasks = [WAIT_FOR_THE_OTHER.format(own=a, other=b) for a, b in pairs]
    assert run_in_order(LocalEngine(2), exec, tasks) == [None, None]


def test_errors_are_raised_as_they_were():
    with pytest.raises(ZeroDivisionError, match="division by zero"):
        run_in_order(LocalEngine(1), eval, ["1", "1/0", "2"])


def test_what_cannot_be_sent_is_an_error():
    (answer,) = LocalEngine(1).answers(eval, ["lambda: 1"])
    assert isinstance(answer.error, RuntimeError)
    assert "function" in str(answer.error)


def test_what_a_task_prints_is_no_answer(capfd):
    assert run_in_order(LocalEngine(1), eval, ["print('out') or 7"]) == [7]
    out, err = capfd.readouterr()
    assert (out, err.strip()) == ("", "out")


@pytest.mark.slow
@POSIX
@pytest.mark.parametrize(
    ("end", "said"),
    [
        ("__import__('os')._exit(3)", r"without an answer \(exit status 3\)"),
        (KILL_ITSELF, r"without an answer \(signal 9\).*Run it with fewer processes"),
    ],
)
def test_a_process_that_ends_ends_its_task_only(end, said):
    answers = list(LocalEngine(2).answers(eval, ["1", end, "2", "3"]))
    by_place = {answer.place: answer for answer in answers}
    assert [by_place[k].value for k in (0, 2, 3)] == [1, 2, 3]
    with pytest.raises(ProcessEndedError, match=said):
        raise by_place[1].error


@POSIX
def test_a_task_whose_process_was_killed_is_tried_again(tmp_path):
    """The first time it is killed by somebody, the second time it is left alone."""
    mark = tmp_path / "mark"
    task = (
        f"__import__('os').path.exists({str(mark)!r}) and 'value' or "
        f"(__import__('pathlib').Path({str(mark)!r}).touch(), {KILL_ITSELF})"
    )
    assert run_in_order(LocalEngine(2), eval, [task, "1"]) == ["value", 1]


@pytest.mark.slow
@POSIX
@pytest.mark.parametrize("hanging", ["__import__('time').sleep(60)", "10**10**10"])
def test_a_task_that_hangs_is_ended_and_its_process_replaced(hanging):
    """Asleep, or in the midst of C code that hears no signal of Python."""
    engine = LocalEngine(1, time_limit_s=2.0)
    started = time.monotonic()
    answers = list(engine.answers(eval, ["1", hanging, "2"]))
    assert [answer.value for answer in answers] == [1, None, 2]
    assert isinstance(answers[1].error, TimeLimitError)
    assert "not done within 2 s" in str(answers[1].error)
    assert time.monotonic() - started < 50.0


@pytest.mark.parametrize("limit", [0, -1.0, "soon", float("nan")])
def test_a_time_limit_is_a_number_of_seconds(limit):
    with pytest.raises(SettingsError, match="time_limit_s"):
        LocalEngine(1, time_limit_s=limit)


@pytest.mark.slow
@POSIX
def test_memory_is_limited():
    engine = LocalEngine(1, memory_gb=1.0)
    answers = list(engine.answers(eval, ["len(bytearray(2 * 10**9))", "1 + 1"]))
    assert answers[0] == Answer(1, value=2)
    assert isinstance(answers[1].error, MemoryError)


@pytest.mark.slow
@POSIX
def test_a_task_that_found_no_memory_is_tried_again_in_another_process(tmp_path):
    """What an earlier task has left in the process is nobody's fault."""
    seen = tmp_path / "pids"
    task = (
        f"(open({str(seen)!r}, 'a').write(str(__import__('os').getpid()) + ' '),"
        f" len(open({str(seen)!r}).read().split()) > 1 or bytearray(10**15))[1]"
    )
    assert run_in_order(LocalEngine(1), eval, [task, "1"]) == [True, 1]
    assert len(set(seen.read_text().split())) == 2


NO_ROOM_FOR_BLAS = """
import re, resource
from pathlib import Path
import numpy as np
from scipy.linalg import blas
matrix = np.ones((300, 300))
said = Path("/proc/self/status").read_text()
used = 1024 * int(re.search(r"VmData:\\s+(\\d+)", said)[1])
# room for the result, and none for the 32 MB that OpenBLAS works with
resource.setrlimit(resource.RLIMIT_DATA, (used + 2 * 10**7,) * 2)
assert {product}[0, 0] == 300.0
"""


@ASKS_PROC
@pytest.mark.timeout(120)
@pytest.mark.parametrize(
    "product", ["(matrix @ matrix)", "blas.dgemm(1, matrix, matrix)"]
)
def test_linear_algebra_without_memory_waits_for_nobody(product):
    """OpenBLAS waits for ever, or ends the process, where it finds no room to work."""
    assert run_in_order(
        LocalEngine(1), exec, [NO_ROOM_FOR_BLAS.format(product=product)]
    ) == [None]


# OpenBLAS asks a table of its processor whether a product needs room. That of a
# processor with AVX-512 answers anywhere: it only compares sizes.
AS_WITH_AVX_512 = """
import ctypes, sys
import scipy.linalg
from threadpoolctl import ThreadpoolController
for library in ThreadpoolController().lib_controllers:
    try:
        table = ctypes.c_void_p.in_dll(library.dynlib, "gotoblas").value
        usual, wanted = (
            ctypes.cast(library.dynlib["dgemm_small_matrix_permit_" + name],
                        ctypes.c_void_p).value
            for name in ("HASWELL", "SKYLAKEX")
        )
    except (ValueError, AttributeError):
        sys.exit(77)
    slots = (ctypes.c_void_p * 400).from_address(table)
    if usual not in list(slots):
        sys.exit(77)
    slots[list(slots).index(usual)] = wanted
"""
ROOM_OF_BLAS = """
import re
from pathlib import Path
import numpy as np
from scipy.linalg import blas, lapack
from einschalt.foundations.limited_memory import take_room_for_linear_algebra

def used():
    said = Path("/proc/self/status").read_text()
    return int(re.search(r"VmData:\\s+(\\d+)", said)[1]) / 1024

def growth(*calls):
    before = used()
    for call in calls:
        call()
    return used() - before

# of its own size, which the library needs not ask the system for afterwards
matrix, small = np.eye(300, order="F"), np.eye(2)
for_small = growth(lambda: small @ small, lambda: blas.dgemm(1, small, small))
taken = growth(take_room_for_linear_algebra)
later = growth(
    lambda: matrix @ matrix,
    lambda: matrix @ matrix.T,
    lambda: np.linalg.cholesky(matrix),
    lambda: np.linalg.solve(matrix, matrix),
    lambda: np.linalg.eigh(matrix),
    lambda: blas.dgemm(1, matrix, matrix),
    lambda: blas.dsyrk(1, matrix),
    lambda: blas.dtrsm(1, matrix, matrix),
    lambda: lapack.dpotrf(matrix),
    lambda: lapack.dpotri(matrix),
)
print(for_small, taken, later)
"""
LEAST_ROOM_MB = 16.0  # 32 for each library with OpenBLAS 0.3


def room_of_blas(script):
    """What small products took, then all the room, then larger ones [MB]."""
    environment = {
        **os.environ,
        "OPENBLAS_NUM_THREADS": "1",
        "OPENBLAS_CORETYPE": "Haswell",
    }
    done = subprocess.run(
        [sys.executable, "-c", script],
        capture_output=True,
        text=True,
        env=environment,
        timeout=100.0,
        check=False,
    )
    if done.returncode == 77:
        pytest.skip("another BLAS, or another build of it")
    assert done.returncode == 0, done.stderr
    return [float(part) for part in done.stdout.split()]


@ASKS_PROC
@pytest.mark.parametrize("core", ["", AS_WITH_AVX_512], ids=["AVX2", "AVX-512"])
def test_all_room_of_linear_algebra_is_taken_at_once(core):
    _, _, later = room_of_blas(core + ROOM_OF_BLAS)
    assert later < LEAST_ROOM_MB


@ASKS_PROC
def test_small_products_do_not_take_the_room_of_large_ones():
    """With AVX-512: what the test above would not see otherwise."""
    for_small, taken, _ = room_of_blas(AS_WITH_AVX_512 + ROOM_OF_BLAS)
    assert for_small < LEAST_ROOM_MB
    assert taken > 2 * LEAST_ROOM_MB


def test_a_process_with_limited_memory_calls_linear_algebra_from_one_thread():
    """Each thread would need room of its own."""
    asked = "__import__('os').environ['EINSCHALT_CORES']"
    assert run_in_order(LocalEngine(1, memory_gb=2.0), eval, [asked]) == ["1"]


def test_one_process_does_not_take_the_cores_of_the_others():
    asked = "__import__('os').environ['EINSCHALT_CORES']"
    cores = int(run_in_order(LocalEngine(1024), eval, [asked])[0])
    assert cores == 1


@pytest.mark.parametrize("n_workers", [0, -1, 2.5, 2.0, "2", 5000, True])
def test_number_of_workers(n_workers):
    with pytest.raises(SettingsError, match=r"workers = .*expected a whole number fro"):
        LocalEngine(n_workers)


@pytest.mark.parametrize("memory", [0.0, -1.0, float("nan"), float("inf"), 1e300, "2"])
def test_memory_above_zero(memory):
    with pytest.raises(SettingsError, match=r"memory_gb = .*a number above 0"):
        LocalEngine(1, memory_gb=memory)


@POSIX
def test_a_limit_beyond_what_the_system_can_count_is_said():
    (answer,) = LocalEngine(1, memory_gb=1e15).answers(eval, ["1"])
    with pytest.raises(SettingsError, match=r"memory cannot be limited to 1e\+15 GB"):
        raise answer.error


def test_errors_cross_the_border_with_their_facts():
    error = ProcessEndedError("it ended", remedy="Try again")
    assert str(pickle.loads(pickle.dumps(error))) == "it ended. Try again."


SCRIPT = """
    import sys
    from einschalt.pipeline.batch.local_engine import LocalEngine
    # no guard of __main__: this line runs once
    print("begin", flush=True)
    for answer in LocalEngine(2).answers(eval, sys.argv[1:]):
        print(answer.value, flush=True)
"""
# one write each: print makes two, between which another worker may come
TELL = (
    "(o := __import__('os')).write(2, b'%d\\n' % o.getpid())"
    " and __import__('time').sleep(600)"
)


def start(*tasks, **options):
    script = [sys.executable, "-c", textwrap.dedent(SCRIPT), *tasks]
    return subprocess.Popen(script, stdout=subprocess.PIPE, text=True, **options)


@pytest.mark.slow
def test_a_script_needs_no_guard():
    with start("1", "2") as script:
        said = script.stdout.read().split()
    assert said[0] == "begin"
    assert sorted(said[1:]) == ["1", "2"]


def is_running(pid):
    try:
        # a process that has ended and is not yet forgotten has no memory any more
        return bool(Path(f"/proc/{pid}/statm").read_text().split()[0] != "0")
    except (FileNotFoundError, ProcessLookupError):
        return False


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc").exists(), reason="asks /proc")
@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGINT])
def test_workers_end_with_their_runner(how):
    with start(TELL, TELL, stderr=subprocess.PIPE) as script:
        pids = [int(script.stderr.readline()) for _ in range(2)]
        script.send_signal(how)
        script.communicate()
    deadline = time.monotonic() + 120.0
    while any(map(is_running, pids)) and time.monotonic() < deadline:
        time.sleep(0.02)
    assert not any(map(is_running, pids))


def test_a_process_that_cannot_be_started_is_said(monkeypatch):
    gone = "einschalt.pipeline.batch.local_engine.get_executable"
    monkeypatch.setattr(gone, lambda: "/there/is/no/python")
    (answer,) = LocalEngine(1).answers(eval, ["1"])
    said = r"no process could be started: no such file .* permissions of Python"
    with pytest.raises(ProcessEndedError, match=said):
        raise answer.error
