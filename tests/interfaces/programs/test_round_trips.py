"""What is written for another program and read again is what it was, or is refused."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import einschalt as es
from einschalt.foundations.errors import EinschaltError
from einschalt.foundations.tables import CONTROL_POINTS
from einschalt.interfaces.files.marker_files import Markers
from einschalt.interfaces.files.odm_lists import read_odm, write_odm
from einschalt.interfaces.files.tables_by_suffix import read_table, write_table
from einschalt.interfaces.programs.export import WRITERS
from einschalt.interfaces.programs.handed_over import HandedOver

pytestmark = pytest.mark.slow

PLANE = ["easting", "northing"]
COLUMNS = ["point_id", *PLANE, "height", "role"]
DECIMALS = 4  # that the formats keep
# what a surveyor, a spreadsheet and a joker call a point
SIGNS = st.characters(codec="utf-8", exclude_categories=("Cs", "Cc", "Zl", "Zp"))
NAMES = st.one_of(
    st.integers(1, 99_999).map(str),
    st.from_regex(r"[0-9A-Za-zÄÖüß/+=@'#.;,-]{1,8}", fullmatch=True),
    st.text(SIGNS, min_size=1, max_size=8),
).map(str.strip)
METRES = st.integers(-(10**11), 10**11).map(lambda n: n / 10**DECIMALS)
ROWS = st.tuples(NAMES.filter(bool), METRES, METRES, METRES, st.booleans())


def tables(*, with_heights=True):
    def table(rows):
        frame = pd.DataFrame(rows, columns=COLUMNS)
        frame["role"] = np.where(frame["role"], "check", "control")
        return frame if with_heights else frame.drop(columns="height")

    return st.lists(ROWS, min_size=1, max_size=6, unique_by=lambda r: r[0]).map(table)


def handed_over(points):
    sizes = {
        "standard_error_easting": 0.03,
        "standard_error_northing": 0.04,
        "standard_error_total": 0.05,
        "covariance_en": 1e-4,
    }
    return HandedOver("b", "EPSG:31255", "", {"points": points.assign(**sizes)})


def refused(write):
    """What is said where something cannot be written; empty where it is."""
    try:
        write()
    except EinschaltError as error:
        return str(error)
    return ""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("trips")


@pytest.mark.parametrize(
    ("suffix", "n_examples"),
    [(".xml", 40), (".csv", 40), (".con", 40), (".gkf", 40), (".dxf", 8)],
)
def test_points_come_back_from_the_file_of_a_program(folder, suffix, n_examples):
    if suffix == ".dxf":
        pytest.importorskip("ezdxf")

    @settings(max_examples=n_examples)
    @given(tables())
    def come_back(points):
        path = folder / f"p{suffix}"
        refusal = refused(lambda: WRITERS[suffix](handed_over(points), path))
        if refusal:  # a name that the format cannot hold
            assert "name" in refusal
            return
        back = es.read_points(path)
        names = points["point_id"].tolist()
        if suffix == ".con" and back["point_id"].tolist() != names:
            listed = pd.read_csv(
                folder / "p_names.csv", dtype=str, keep_default_na=False
            )
            assert listed["number"].tolist() == back["point_id"].tolist()
            back = back.assign(point_id=listed["point_id"])
        assert back["point_id"].tolist() == names
        half = 0.5001 * 10.0**-DECIMALS
        np.testing.assert_allclose(back[PLANE], points[PLANE], rtol=0, atol=half)
        if suffix != ".gkf":
            np.testing.assert_allclose(
                back["height"], points["height"], rtol=0, atol=half
            )
        if "role" in back:
            assert back["role"].tolist() == points["role"].tolist()

    come_back()


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_tables_come_back_to_the_last_digit(folder, suffix):
    @settings(max_examples=40)
    @given(tables())
    def come_back(points):
        write_table(points, folder / f"t{suffix}")
        back = read_table(folder / f"t{suffix}", CONTROL_POINTS)
        pd.testing.assert_frame_equal(
            back.reset_index(drop=True),
            points.astype({"point_id": "str", "role": "str"}),
            check_dtype=False,
            check_exact=True,
        )

    come_back()


def test_lists_of_odm_come_back(folder):
    marked = [("CHK-1", 0.0, 0.0, 0.0, False)]

    @settings(max_examples=40)
    @given(tables())
    @example(pd.DataFrame(marked, columns=COLUMNS).assign(role="control"))
    def come_back(points):
        known = points.rename(columns={"easting": "x", "northing": "y", "height": "z"})
        measured = points[["point_id"]].assign(image_id="a.jpg", x=5.5, y=6.25)
        markers = Markers(
            known, measured[["image_id", "point_id", "x", "y"]], "EPSG:31255"
        )
        path = folder / "gcp_list.txt"
        path.unlink(missing_ok=True)
        refusal = refused(lambda: write_odm(path, markers))
        if refusal:
            assert "blanks" in refusal or "CHK-" in refusal
            return
        back = read_odm(path)
        columns = ["point_id", "x", "y", "z", "role"]
        assert (
            back.points[columns].to_numpy().tolist()
            == known[columns].to_numpy().tolist()
        )

    come_back()
