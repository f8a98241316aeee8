"""block.toml: every key, and what is said of those that are wrong."""

import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from einschalt.foundations.errors import EinschaltError, SettingsError
from einschalt.interfaces.files.block_toml import read_block_toml, write_block_toml
from einschalt.pipeline.settings import Settings

GOLDEN = Path(__file__).parents[2] / "golden" / "bad_block_toml.txt"
WHOLE = """\
[block]
name = "Neukirchen"
crs = "EPSG:31255"

[control_points]
file = "control_points.csv"
crs = "EPSG:31258"
standard_error_m = 0.03
may_be_unmeasured = true

[high_flight]
scale_number = 15000
m_g_um = 7.5
transformation = "helmert"
image_points = "image_points.csv"
models = "models.csv"
principal_distance_mm = 153.0

[low_flight]
scale_number = 8000
m_g_um = 5
model_points = "low_flight.csv"
model_unit = "um"
y_parallaxes = "y_parallaxes.csv"
base = 92.5

[settings]
coverage_mean = "most_central"
"""


def written(tmp_path, text):
    path = tmp_path / "block.toml"
    path.write_bytes(text if isinstance(text, bytes) else text.encode("utf-8"))
    return path


def said_of(tmp_path, text):
    return [
        str(problem) for problem in read_block_toml(written(tmp_path, text)).problems
    ]


def test_the_former_word_of_a_method_is_understood(tmp_path):
    text = '[settings]\nmethod = "pipeline"\n'
    with pytest.warns(DeprecationWarning, match='"pipeline" is now called "two_step"'):
        toml = read_block_toml(written(tmp_path, text))
    assert toml.settings.method == "two_step"
    assert toml.problems == []


def test_every_key_is_read(tmp_path):
    toml = read_block_toml(written(tmp_path, WHOLE))
    assert toml.problems == []
    given = tomllib.loads(WHOLE)
    for name, section in toml.sections.items():
        fields = section.model_dump(exclude_unset=True)
        assert fields == given[name]
    assert toml.settings.coverage_mean == "most_central"


def test_defaults(tmp_path):
    text = '[low_flight]\nscale_number = 8000\nm_g_um = 5\nmodel_points = "a.csv"\n'
    toml = read_block_toml(written(tmp_path, text))
    flight = toml.sections["low_flight"]
    assert (flight.transformation, flight.model_unit) == ("affine", "mm")
    assert list(toml.sections) == ["low_flight"]


def test_byte_order_mark_and_crlf(tmp_path):
    data = b"\xef\xbb\xbf" + WHOLE.replace("\n", "\r\n").encode()
    assert read_block_toml(written(tmp_path, data)).problems == []


# what is said of each stands in golden/bad_block_toml.txt, under the same name
CHANGES = {
    "decimal comma in quotes": ("m_g_um = 7.5", 'm_g_um = "7,5"'),
    "truth value for a number": ("m_g_um = 7.5", "m_g_um = true"),
    "not a number": ("m_g_um = 7.5", "m_g_um = nan"),
    "infinite": ("scale_number = 15000", "scale_number = inf"),
    "millimetres for metres": ("= 0.03", "= 30"),
    "negative standard error": ("= 0.03", "= -0.03"),
    "text for a truth value": ("unmeasured = true", 'unmeasured = "yes"'),
    "number for a system": ('crs = "EPSG:31255"', "crs = 31255"),
    "truth value for a base": ("base = 92.5", "base = true"),
    "list for a file": ('file = "control_points.csv"', "file = []"),
    "unknown value of a setting": ("most_central", "most-central"),
    "key without a neighbour": ("name =", "colour ="),
    "misspelt section": ("[settings]", "[setings]"),
    "missing key": ("m_g_um = 7.5\n", ""),
}


def expected():
    """Read the golden file: a line with the name, then the indented message."""
    lines = GOLDEN.read_text(encoding="utf-8").splitlines()
    return dict(zip(lines[::2], (line.strip() for line in lines[1::2]), strict=True))


@pytest.mark.parametrize("change", CHANGES)
def test_wrong_value_or_key(tmp_path, change):
    old, new = CHANGES[change]
    assert old in WHOLE
    assert said_of(tmp_path, WHOLE.replace(old, new, 1)) == [expected()[change]]


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ('name = "x"', "name = 'x' stands outside of all .*Put it below [block]."),
        (
            "m_g_um = 5",
            "m_g_um = 5 stands .*Put it below [high_flight] or [low_flight].",
        ),
        ("colour = 1", "colour = 1 stands outside of all sections; .*Take it out."),
        ("block = 3", "block = 3; expected a section [block]. Write [block], and its"),
        ("settings = 3", "settings = 3; expected a section [settings]. Write [settin"),
    ],
)
def test_keys_outside_of_sections(tmp_path, line, said):
    (found,) = said_of(tmp_path, line)
    pattern = re.escape(f"block.toml, row 1: {said}").replace(re.escape(".*"), ".*")
    assert re.match(pattern, found)


def test_misspelt_setting_names_the_known_ones(tmp_path):
    (said,) = said_of(tmp_path, WHOLE.replace("coverage_mean", "coverage_maen"))
    assert said == (
        "block.toml, row 28: [settings] coverage_maen: unknown key; expected "
        f"{', '.join(Settings.model_fields)}. Write coverage_mean."
    )


def test_a_setting_in_another_section_is_told_where_it_belongs(tmp_path):
    begin = "[control_points]\n"
    assert begin in WHOLE
    (said,) = said_of(tmp_path, WHOLE.replace(begin, f"{begin}crs_accuracy_m = 2\n"))
    assert "[control_points] crs_accuracy_m: unknown key" in said
    assert said.endswith("Write it below [settings] of block.toml.")


@pytest.mark.parametrize(
    ("key", "remedy"),
    [
        ("scale_number = 8000", "Put it below [high_flight] or [low_flight]."),
        ('crs = "EPSG:31255"', " [block] or [control_points] or [approximate_points]."),
        ("tolerances = 1", "Write tolerance."),
    ],
)
def test_a_key_of_a_section_below_settings_is_told_where_it_belongs(
    tmp_path, key, remedy
):
    begin = "[settings]\n"
    assert begin in WHOLE
    (said,) = said_of(tmp_path, WHOLE.replace(begin, f"{begin}{key}\n"))
    assert "[settings] " in said
    assert "unknown key; expected" in said
    assert said.endswith(remedy)


def test_what_is_right_is_kept_beside_what_is_wrong(tmp_path):
    text = WHOLE.replace("m_g_um = 5", 'm_g_um = "5"').replace(
        "scale_number = 8000", ""
    )
    toml = read_block_toml(written(tmp_path, text))
    flight = toml.sections["low_flight"]
    assert (flight.model_points, flight.base) == ("low_flight.csv", 92.5)
    assert (flight.m_g_um, flight.scale_number) == (None, None)
    assert toml.said == {("low_flight", "m_g_um"), ("low_flight", "scale_number")}


def test_misspelt_key_is_said_once_although_a_key_is_missing(tmp_path):
    text = WHOLE.replace("m_g_um = 5", "m_g_mu = 5")
    toml = read_block_toml(written(tmp_path, text))
    assert len(toml.problems) == 1
    assert ("low_flight", "m_g_um") in toml.said


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[block]\nname = x\n", r"row 2: 'name = x' is no TOML: invalid value at col"),
        ("[block]\n[block]\n", "row 2: .*Give each key and each section once"),
        ('[block]\nname = "a"\nname = "b"', "row 3: .*Give each key and each section"),
        ("[high_flight]\nm_g_um = 7,5 # µm\n", "row 2: .*Write a decimal point"),
        ("[block]\nname = “x”\n", "row 2: .*Put texts into straight quotes"),
        ("[block]\nname =", "row 2: 'name =' is no TOML: invalid value; expected"),
        ("[block]\nname = 'x", "row 2: .*Put texts into straight quotes"),
    ],
)
def test_what_is_no_toml_names_its_line(tmp_path, text, said):
    with pytest.raises(SettingsError, match=said):
        read_block_toml(written(tmp_path, text))


def test_latin1_names_its_line(tmp_path):
    data = WHOLE.replace("Neukirchen", "Mürzzuschlag").encode("latin-1")
    with pytest.raises(EinschaltError, match="row 2: 'name = \"Mürzzuschlag\"' is not"):
        read_block_toml(written(tmp_path, data))


def test_written_sections_come_back(tmp_path):
    sections = {
        "block": {"name": 'A "quoted" \\ name\twith Ö \x7f', "crs": None},
        "control_points": {"standard_error_m": 0.1 + 0.2, "may_be_unmeasured": True},
        "settings": {},
        "low_flight": {"scale_number": 8000.0, "m_g_um": 5, "base": 1e-7, "x": (1, 2)},
    }
    write_block_toml(tmp_path / "block.toml", sections)
    text = (tmp_path / "block.toml").read_text(encoding="utf-8")
    back = tomllib.loads(text)
    assert back["block"] == {"name": sections["block"]["name"]}
    assert back["control_points"] == sections["control_points"]
    assert back["low_flight"] == {**sections["low_flight"], "x": [1, 2]}
    assert "settings" not in back
    assert "scale_number = 8000\n" in text


TEXTS = st.text(st.characters(codec="utf-8"), max_size=8)
VALUES = (
    TEXTS
    | st.booleans()
    | st.integers(-(2**53), 2**53)
    | st.floats(allow_nan=False)
    | st.floats(allow_nan=False, width=32).map(np.float32)
    | st.integers(0, 1000).map(np.int64)
)


@pytest.mark.slow
@given(keys=st.dictionaries(TEXTS, VALUES, max_size=4))
def test_every_value_comes_back(tmp_path_factory, keys):
    path = tmp_path_factory.mktemp("toml") / "block.toml"
    write_block_toml(path, {"low_flight": keys})
    back = tomllib.loads(path.read_text(encoding="utf-8"))
    assert back == ({"low_flight": keys} if keys else {})


def test_what_is_written_reads_as_a_person_would_write_it(tmp_path):
    sections = {
        "block": {"name": "Mürz", "crs": None},
        "low_flight": {"scale_number": np.float64(8000.0), "m_g_um": 7.5, "base": "b"},
    }
    write_block_toml(tmp_path / "block.toml", sections)
    assert (tmp_path / "block.toml").read_bytes().decode("utf-8") == (
        '[block]\nname = "Mürz"\n\n'
        '[low_flight]\nscale_number = 8000\nm_g_um = 7.5\nbase = "b"\n'
    )
