"""Memory that a command keeps: what is freed is not fetched from the system again."""

import os
import platform
import subprocess
import sys

import pytest

pytestmark = pytest.mark.skipif(
    platform.libc_ver()[0] != "glibc", reason="another C library manages its memory"
)
# pages that were fetched for 160 MB, the first time and the fifth
CODE = """
import resource
import numpy as np
from einschalt.foundations.kept_memory import keep_freed_memory
{limit}
kept = keep_freed_memory()
pages = []
for _ in range(5):
    before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
    array = np.ones(20_000_000)
    pages.append(resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before)
    del array
print(kept, pages[0], pages[-1])
"""


def fetched(limit="", **environment):
    told = {"GLIBC_TUNABLES", "MALLOC_MMAP_MAX_", "MALLOC_TRIM_THRESHOLD_"}
    inherited = {name: os.environ[name] for name in os.environ if name not in told}
    done = subprocess.run(
        [sys.executable, "-c", CODE.format(limit=limit)],
        env=inherited | environment,
        capture_output=True,
        text=True,
        check=True,
    )
    kept, first, last = done.stdout.split()
    return kept == "True", int(first), int(last)


def test_the_same_memory_is_used_again():
    kept, first, last = fetched()
    assert kept
    assert first > 50
    assert last < 0.1 * first


def test_a_limited_process_gives_it_back():
    limit = "resource.setrlimit(resource.RLIMIT_AS, (10**12, 10**12))"
    kept, first, last = fetched(limit)
    assert not kept
    assert last > 0.5 * first


def test_who_says_how_memory_is_managed_is_heard():
    kept, first, last = fetched(MALLOC_MMAP_MAX_="1000")
    assert not kept
    assert last > 0.5 * first
