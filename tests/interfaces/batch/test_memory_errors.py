"""Lack of memory is told from other faults, however a library says it."""

import errno
import pickle

import pyarrow as pa
import pytest

from einschalt.foundations.errors import FileError
from einschalt.interfaces.batch.memory_errors import lack_of_memory
from einschalt.interfaces.files.atomic import said_as_file_error


def wrapped():
    with said_as_file_error("points.csv"):
        raise OSError(errno.ENOMEM, "Cannot allocate memory")


# as the libraries have said it under a limit
SAID = {
    "python": lambda: bytearray(10**15),
    "arrow": lambda: pa.allocate_buffer(10**17),
    "matplotlib": lambda: fail(
        ImportError("_backend_agg.cpython-311.so: cannot map zero-fill pages")
    ),
    "threads": lambda: fail(RuntimeError("can't start new thread")),
    "threads of arrow": lambda: fail(
        pa.ArrowException(
            "Unknown error: Failed to launch worker thread: "
            "Resource temporarily unavailable"
        )
    ),
    "behind a message": wrapped,
}


def fail(error):
    raise error


@pytest.mark.parametrize("how", SAID.values(), ids=SAID)
def test_it_is_known_and_keeps_its_stage_between_processes(how):
    with pytest.raises(Exception) as caught:  # noqa: PT011 - of any library
        how()
    shortage = lack_of_memory(caught.value, "reading")
    assert pickle.loads(pickle.dumps(shortage)).stage == "reading"


def test_an_error_that_is_its_own_cause_comes_to_an_end():
    error = ValueError("no")
    error.__cause__ = error
    assert lack_of_memory(error, "reading") is None


@pytest.mark.parametrize(
    "error", [ZeroDivisionError("of memory"), FileError("'out of memory.csv' is empty")]
)
def test_other_faults_are_none(error):
    assert lack_of_memory(error, "reading") is None
