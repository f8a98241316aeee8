"""The process of an engine: ``python -m einschalt.pipeline.batch.local_worker``.

It takes pickled questions ``(function, task)`` from standard input, each after its
length, and answers with ``(value, error)`` in the same way. When its input ends, the
one who asked is gone, and it ends at once: it writes nothing that nobody waits for.
"""

import os
import pickle
import queue
import struct
import threading
from contextlib import nullcontext

from einschalt.foundations.errors import SettingsError
from einschalt.foundations.garbage import clear_garbage, made_for_good
from einschalt.foundations.limited_memory import take_room_for_linear_algebra

LENGTH = struct.Struct("<Q")
LATER = nullcontext()  # in which questions after the first are loaded


def limit_memory(n_bytes):
    """Limit the memory that this process may use, or say that the system cannot."""
    try:
        import resource  # noqa: PLC0415 - Windows has no such module

        # not the address space, of which libraries reserve four times what they use
        resource.setrlimit(resource.RLIMIT_DATA, (n_bytes, n_bytes))
    except (ImportError, ValueError, OverflowError, OSError) as error:
        raise SettingsError(
            f"memory cannot be limited to {n_bytes / 1e9:g} GB",
            expected="a limit that this system grants",
            remedy="Leave the limit out",
        ) from error


def main():
    """Answer questions until their input ends."""
    take_room_for_linear_algebra()
    answers = os.dup(1)
    os.dup2(2, 1)  # what libraries print must not fall among the answers
    questions = queue.SimpleQueue()
    listener = threading.Thread(target=_listen, args=(os.dup(0), questions))
    listener.daemon = True
    listener.start()
    with os.fdopen(answers, "wb") as pipe:
        loading = made_for_good()  # the first question imports what answers them all
        while True:
            answer = _pickled(_answer(questions.get(), loading))
            pipe.write(LENGTH.pack(len(answer)) + answer)
            pipe.flush()
            # arrays of a block may be large; after the first, modules are left
            clear_garbage(for_good=loading is not LATER)
            loading = LATER


def _listen(descriptor, questions):
    try:
        with os.fdopen(descriptor, "rb") as pipe:
            while len(head := pipe.read(LENGTH.size)) == LENGTH.size:
                questions.put(pipe.read(*LENGTH.unpack(head)))
    finally:  # also without memory: nobody would notice any more that it is alone
        os._exit(0)


def _answer(question, loading):
    try:
        with loading:
            function, task = pickle.loads(question)
        return function(task), None
    except Exception as error:  # noqa: BLE001 - it is the answer
        return None, error


def _pickled(answer):
    value, error = answer
    try:
        text = pickle.dumps(answer)
        if error is not None:
            pickle.loads(text)  # some errors can be written and not read
    except Exception as fault:  # noqa: BLE001 - whatever it is, it cannot be sent
        said = RuntimeError(f"{type(error or value).__name__}: {error or fault}")
        text = pickle.dumps((None, said))
    return text


if __name__ == "__main__":
    main()
