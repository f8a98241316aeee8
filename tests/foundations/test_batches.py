import threading

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from einschalt.foundations import batches
from einschalt.foundations.batches import (
    over_segments,
    segment_min_max,
    segment_sum,
    segments,
)

examples = settings(max_examples=50, deadline=None, derandomize=True)


# segments


@examples
@given(st.lists(st.integers(0, 6)))
def test_segments_are_a_stable_sort(codes):
    parts = segments(np.array(codes, dtype=int), 7)
    assert parts.order.tolist() == np.argsort(codes, kind="stable").tolist()
    assert parts.count.tolist() == [codes.count(group) for group in range(7)]
    assert parts.group.tolist() == sorted(codes)
    assert parts.start[0] == 0
    assert parts.start[-1] == len(codes)


@examples
@given(st.lists(st.integers(0, 5), min_size=1, max_size=8), st.integers(0, 99))
def test_sums_and_extremes_of_segments(counts, seed):
    start = np.concatenate([[0], np.cumsum(counts)])
    values = np.random.default_rng(seed).normal(size=(start[-1], 2))
    total = segment_sum(values, start)
    low, high = segment_min_max(values, start)
    for group, count in enumerate(counts):
        part = values[start[group] : start[group + 1]]
        np.testing.assert_allclose(total[group], part.sum(axis=0), atol=1e-12)
        if count == 0:
            assert np.isnan(low[group]).all()
            assert np.isnan(high[group]).all()
        else:
            np.testing.assert_array_equal(low[group], part.min(axis=0))
            np.testing.assert_array_equal(high[group], part.max(axis=0))


def test_sum_of_empty_segments_is_zero():
    # np.add.reduceat gives the value at the start instead, or fails at the end
    start = np.array([0, 0, 2, 2, 2])
    np.testing.assert_array_equal(
        segment_sum(np.array([3.0, 4.0]), start), [0.0, 7.0, 0.0, 0.0]
    )


def test_sum_keeps_the_shape_and_type_of_its_values():
    found = segment_sum(np.ones((4, 2, 3), dtype=int), np.array([0, 1, 4]))
    assert found.shape == (2, 2, 3)
    assert found.dtype == int
    assert found[1, 0, 0] == 3


# threads


@pytest.fixture
def many_workers(monkeypatch):
    monkeypatch.setattr(batches, "n_cores", lambda: 3)
    monkeypatch.setattr(batches, "ROWS_WORTH_A_THREAD", 10)


@pytest.mark.usefixtures("many_workers")
@pytest.mark.parametrize(
    "counts",
    [[5] * 40, [0, 0, 200, 0], [0] * 30 + [20], [100, *[1] * 50], [0, 30, *[0] * 9]],
    ids=["even", "one large", "empty before", "uneven", "empty after"],
)
def test_every_segment_is_visited_once(counts):
    start = np.concatenate([[0], np.cumsum(counts)])
    visits = np.zeros(len(counts), dtype=int)
    lock = threading.Lock()

    def kernel(first, last, _start, visits):
        with lock:
            visits[first:last] += 1

    over_segments(kernel, start, visits)
    assert visits.tolist() == [1] * len(counts)


@pytest.mark.usefixtures("many_workers")
def test_failure_of_a_kernel_is_not_lost():
    def kernel(first, last, start):
        message = "kernel failed"
        raise ZeroDivisionError(message)

    with pytest.raises(ZeroDivisionError, match="kernel failed"):
        over_segments(kernel, np.arange(100))


def test_few_rows_stay_in_this_thread():
    names = []

    def kernel(first, last, start):
        names.append((threading.current_thread(), first, last))

    over_segments(kernel, np.array([0, 5, 9]))
    assert names == [(threading.main_thread(), 0, 2)]


@pytest.mark.usefixtures("many_workers")
def test_few_rows_that_take_long_are_worth_threads():
    ranges = []

    def kernel(first, last, start):
        ranges.append((first, last))

    over_segments(kernel, np.arange(9), work_of_row=1.2)
    assert ranges == [(0, 8)]
    ranges.clear()
    over_segments(kernel, np.arange(9), work_of_row=1.3)
    assert len(ranges) > 1
    assert sorted(k for one in ranges for k in range(*one)) == [*range(8)]


def test_cores_that_the_process_may_use(monkeypatch):
    assert batches.n_cores() >= 1
    # where the system keeps no such list, all cores count
    monkeypatch.delattr(batches.os, "sched_getaffinity", raising=False)
    monkeypatch.setattr(batches.os, "cpu_count", lambda: None)
    assert batches.n_cores() == 1
    monkeypatch.setattr(batches.os, "cpu_count", lambda: 6)
    assert batches.n_cores() == 6


def test_no_segments():
    seen = []
    over_segments(lambda *ranges: seen.append(ranges[:2]), np.array([0]))
    assert seen == [(0, 0)]


@pytest.mark.parametrize("n_cores", [1, 2, 5])
def test_parts_come_back_in_their_order(monkeypatch, n_cores):
    monkeypatch.setattr(batches, "n_cores", lambda: n_cores)
    meeting = threading.Barrier(min(n_cores, 3), timeout=30)

    def work(part):
        meeting.wait()  # each thread has a part, or it breaks
        return part**2

    assert batches.over_parts(work, range(3 * min(n_cores, 3)))[:3] == [0, 1, 4]
    assert batches.over_parts(work, []) == []


def test_failure_of_a_part_is_not_lost(monkeypatch):
    monkeypatch.setattr(batches, "n_cores", lambda: 2)
    with pytest.raises(ZeroDivisionError):
        batches.over_parts(lambda part: 1 // part, [1, 0, 2])


def test_threads_of_parts_share_the_cores(monkeypatch):
    monkeypatch.setattr(batches, "_n_own_cores", lambda: 5)
    meeting = threading.Barrier(2, timeout=30)

    def cores(_part):
        meeting.wait()
        return batches.n_cores(), threading.current_thread()

    with batches.working_on_parts(2) as results:
        first, second = results(cores, [1, 2]), results(cores, [1, 2])
        assert [n for n, _ in first + second] == [2, 2, 2, 2]
        assert {thread for _, thread in first} == {thread for _, thread in second}
        # one alone has this thread, and all of them
        alone = results(lambda part: (part, threading.current_thread()), [3])
    assert alone == [(3, threading.main_thread())]
    assert batches.n_cores() == 5


@pytest.mark.parametrize(
    "places",
    [
        np.array([[7, 5], [5, 5], [9, 7]]),
        np.array([[4_000_000, 5], [5, 70], [5, 5]]),  # few, far apart
        np.array([[3, 3]]),
        np.empty((0, 2), dtype=int),
    ],
)
def test_places_are_numbered_as_sorting_would(places):
    used, among = batches.numbered(places)
    np.testing.assert_array_equal(used, np.unique(places))
    assert among.shape == places.shape
    np.testing.assert_array_equal(used[among], places)
