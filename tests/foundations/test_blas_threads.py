"""BLAS has one thread while a block is computed, and all of them afterwards."""

import numpy as np
import pytest
from threadpoolctl import threadpool_info

from einschalt.foundations.blas_threads import one_blas_thread
from einschalt.pipeline import densify as driver
from einschalt.pipeline.simulation.simulate_block import simulate_block


def n_threads():
    return [
        one["num_threads"] for one in threadpool_info() if one["user_api"] == "blas"
    ]


def test_one_blas_thread_may_stand_inside_another():
    before = n_threads()
    with one_blas_thread():
        with one_blas_thread():
            pass
        assert set(n_threads()) == {1}
    assert n_threads() == before


@pytest.mark.slow
def test_a_block_is_computed_and_judged_on_one_blas_thread(monkeypatch):
    seen = []
    monkeypatch.setattr(
        driver, "with_output_system", lambda block, _: seen.append(n_threads()) or block
    )
    result = driver.densify(simulate_block("demo", seed=1))
    monkeypatch.setattr(
        np.linalg, "lstsq", _watched(np.linalg.lstsq, lambda: seen.append(n_threads()))
    )
    assert result.assessment is not None
    assert len(seen) > 1
    assert {number for numbers in seen for number in numbers} == {1}


def _watched(function, tell):
    def watched(*args, **options):
        tell()
        return function(*args, **options)

    return watched
