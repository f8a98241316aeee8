"""Compiled kernels are kept for their sources, and their compilation is told."""

import gc
from pathlib import Path

import numba
import numpy as np
import pytest
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler

from einschalt.foundations import kernels
from einschalt.foundations.kernel_parts import TRIED, PartCompiler, compiler_of_parts
from einschalt.foundations.kernels import (
    compilations_told_to,
    compiled,
    place_of_least,
    source_stamp,
)
from einschalt.foundations.sparse_cholesky import front_factorization
from einschalt.theory.relative_orientation import coplanarity

CALLED = "coplanarity_condition.py"


def stamp_without(monkeypatch, kernel, file):
    """Its stamp if the file had another text."""
    real = kernels._digest

    def changed(path):
        return "changed" if Path(path).name == file else real(path)

    with monkeypatch.context() as patch:
        patch.setattr(kernels, "_digest", changed)
        return source_stamp(kernel)


@pytest.mark.parametrize("file", ["coplanarity.py", CALLED])
def test_a_change_of_a_source_makes_a_kernel_stale(file, monkeypatch):
    kernel = coplanarity.estimate_precision
    assert stamp_without(monkeypatch, kernel, file) != source_stamp(kernel)


def test_functions_for_compiled_code_alone_are_sources_too(monkeypatch):
    kernel = front_factorization.factor_fronts
    stamp = stamp_without(monkeypatch, kernel, "dense_kernels.py")
    assert stamp != source_stamp(kernel)


def test_a_change_elsewhere_keeps_a_kernel(monkeypatch):
    kernel = coplanarity.estimate_precision
    assert stamp_without(monkeypatch, kernel, "krames.py") == source_stamp(kernel)


def test_numbers_and_options_make_a_kernel_stale(monkeypatch):
    kernel = coplanarity.is_determined
    stamp = source_stamp(kernel)
    monkeypatch.setitem(kernel.targetoptions, "error_model", "python")
    assert source_stamp(kernel) != stamp
    monkeypatch.undo()
    monkeypatch.setattr(coplanarity, "WEAKEST", 2 * coplanarity.WEAKEST)
    assert source_stamp(kernel) != stamp


def test_the_order_of_options_is_that_of_their_names():
    first = compiled(fastmath={"nsz", "arcp", "contract"})(kept)
    second = compiled(fastmath={"contract", "nsz", "arcp"})(kept)
    assert source_stamp(first) == source_stamp(second)


def test_the_cache_asks_for_the_stamp_of_the_kernel_with_its_options():
    kernel = coplanarity.is_determined
    assert kernel._cache._cache_file._source_stamp == source_stamp(kernel)


def kept(value):
    return value


def test_a_compilation_is_told_and_a_kernel_that_is_found_is_not(monkeypatch):
    monkeypatch.setattr(kernels, "_watch", kernels._Watch())
    kernel = compiled(kept)
    told = []
    with compilations_told_to(told.append):
        monkeypatch.setattr(kernel._cache, "_load_overload", lambda *_: "found")
        assert kernel._cache.load_overload(None, kernel.targetctx) == "found"
        assert told == []
        monkeypatch.setattr(kernel._cache, "_load_overload", lambda *_: None)
        for _ in range(2):
            assert kernel._cache.load_overload(None, kernel.targetctx) is None
    kernel._cache.load_overload(None, kernel.targetctx)  # nobody listens any more
    assert [one[:3] for one in told] == [("kept", 2, 0), ("kept", 3, 1)]
    assert 0 <= told[0].seconds <= told[1].seconds


@compiled
def doubled(value):
    return 2 * value


@compiled
def doubled_and_one(value):
    return doubled(value) + 1


def test_what_other_kernels_call_has_no_way_in_from_python_until_python_calls_it():
    assert doubled_and_one(3) == 7
    assert not doubled.signatures
    assert doubled(3) == 6
    assert len(doubled.signatures) == 1


def tripled(value):
    return 3 * value


@compiled
def quotient(a, b):
    return a / b


@compiled
def quotient_and_one(a, b):
    return quotient(a, b) + 1


@pytest.mark.skipif(
    numba.version_info.short not in TRIED, reason="not tried with this numba"
)
def test_what_other_kernels_call_gets_no_machine_code_of_its_own(monkeypatch):
    made = []
    make = JITCodeLibrary._finalize_specific

    def note_and_make(library):
        made.append(library.name)
        make(library)

    monkeypatch.setattr(quotient_and_one._cache, "load_overload", lambda *_: None)
    monkeypatch.setattr(JITCodeLibrary, "_finalize_specific", note_and_make)
    assert quotient_and_one(6, 3) == 3.0
    assert len(made) == 1
    assert quotient_and_one.__name__ in made[0]


def test_versions_that_were_not_tried_compile_parts_as_everything():
    assert compiler_of_parts((0, 60)) is Compiler
    assert all(compiler_of_parts(version) is PartCompiler for version in TRIED)


def test_errors_of_what_a_kernel_calls_are_raised_from_it():
    with pytest.raises(ZeroDivisionError):
        quotient_and_one(1, 0)


@pytest.mark.parametrize(
    "values", [[3.0, 1.0, 1.0], [2.0, np.nan, 0.0], [np.inf, np.inf], [-0.0, 0.0]]
)
def test_the_place_of_the_least_number_is_that_of_numpy(values):
    assert place_of_least(np.array(values)) == np.argmin(values)


def test_no_garbage_is_looked_for_while_a_kernel_is_compiled(monkeypatch):
    enabled = []
    kernel = compiled(tripled)
    monkeypatch.setattr(kernel._cache, "_load_overload", lambda *_: None)
    with compilations_told_to(lambda _: enabled.append(gc.isenabled())):
        assert kernel(2) == 6
    assert enabled == [False]
    assert gc.isenabled()
