"""Numbers and names as the page gets them: they come back, and take little room."""

import base64
import json
import zlib

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from einschalt.interfaces.reports.packed_data import PackedData, quantum_of


class Unpacked:
    """What ``page/decode.js`` does, in Python."""

    def __init__(self, text):
        content = zlib.decompress(base64.b64decode(text))
        start = 4 + int.from_bytes(content[:4], "little")
        self.head = json.loads(content[4:start])
        self.planes = content[start:]

    def whole(self, facts):
        n, width = facts["n"], facts["width"]
        planes = self.planes[facts["at"] : facts["at"] + n * width]
        planes = np.frombuffer(planes, np.uint8).reshape(width, n).astype(np.int64)
        found = (planes << 8 * np.arange(width)[:, np.newaxis]).sum(axis=0)
        if facts.get("steps"):
            found = np.cumsum(np.where(found % 2, -(found + 1) // 2, found // 2))
        return found

    def numbers(self, facts):
        whole = self.whole(facts)
        values = (whole - 1 + facts["low"]) * facts["quantum"]
        return np.where(whole > 0, values, np.nan)

    def texts(self, facts):
        codes = self.whole(facts) - 1 + int(facts["low"])
        return [facts["texts"][code] for code in codes]

    def names(self, facts):
        stems, numbers = self.texts(facts["stem"]), self.numbers(facts["number"])
        ends = ["" if np.isnan(number) else f"{number:.0f}" for number in numbers]
        return [stem + end for stem, end in zip(stems, ends, strict=True)]


def unpacked(name, facts, packed):
    packed.head[name] = facts
    read = Unpacked(packed.text())
    return read, read.head[name]


@given(
    st.lists(st.floats(-2e5, 2e5) | st.just(np.nan), max_size=30),
    st.sampled_from([1e-3, 2e-4, 1.0]),
)
@example([np.nan], 1.0)
@example([5.0] * 9, 0.5)
def test_numbers_come_back_to_half_a_quantum(values, quantum):
    packed = PackedData()
    # a second array, so that places count
    packed.head["first"] = packed.numbers([1.0, 2.0], 1.0)
    read, facts = unpacked("values", packed.numbers(values, quantum), packed)
    np.testing.assert_allclose(
        read.numbers(facts), values, atol=0.5000001 * quantum, rtol=1e-12
    )


def test_a_value_far_away_costs_the_others_digits_and_not_their_places():
    packed = PackedData()
    read, facts = unpacked("e", packed.numbers([1e9, 0.0, 33.3], 1e-3), packed)
    assert facts["quantum"] == 1.0
    np.testing.assert_allclose(read.numbers(facts), [1e9, 0.0, 33.0])


@pytest.mark.slow
@given(st.lists(st.text(max_size=6) | st.from_regex(r"\A[P/]?[0-9]{1,12}\Z")))
@example(["007", "7", "P10", "7/8", "", "0", "1234567890123"])
def test_names_come_back_as_they_are_shown(names):
    from einschalt.foundations.display_names import printable

    packed = PackedData()
    read, facts = unpacked("names", packed.names(names), packed)
    assert read.names(facts) == [printable(name) for name in names]


def test_alike_points_take_little_room():
    rng = np.random.default_rng(0)
    n = 20_000
    packed = PackedData()
    packed.head = {
        "names": packed.names([f"P{k}" for k in range(n)]),
        "east": packed.numbers(rng.uniform(0, 6e4, n), 0.001),
        "error": packed.numbers(rng.normal(0.05, 0.005, n), 5e-4),
    }
    # 26 bits of coordinate and 7 of an error cannot take less than 4 bytes
    assert len(packed.text()) < 1.4 * 5.0 * n


@pytest.mark.parametrize(
    ("values", "expected"), [([0.0, np.nan], 1.0), ([], 1.0), ([7.0, -9.0], 0.05)]
)
def test_quanta_of_little(values, expected):
    assert quantum_of(values) == expected
