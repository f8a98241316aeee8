"""Places of images, listed as control is: refused, and not taken for the ground."""

import pytest

from einschalt.foundations.errors import TableError
from einschalt.foundations.tables import CONTROL_POINTS, MODEL_POINTS
from einschalt.interfaces.files.csv_tables import understand_csv
from einschalt.interfaces.files.understood_tables import Said

HEADER = "Name;Rechtswert;Hochwert;Höhe"
GROUND = "PP{};{}.25;340100.5;412.3"
IMAGE = "DSC_0{}.JPG;{}.25;340100.5;812.3"


def read(tmp_path, lines, schema=CONTROL_POINTS, **said):
    path = tmp_path / "punkte.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return understand_csv(path, schema, Said(**said))


def listed(row, numbers):
    return [row.format(n, 600_000 + n) for n in numbers]


def test_names_of_image_files_are_no_control(tmp_path):
    with pytest.raises(
        TableError, match=r"holds places of images, such as 'DSC_010\.JPG'"
    ):
        read(tmp_path, [HEADER, *listed(IMAGE, range(10, 20))])


def test_some_of_them_are_counted_and_the_line_is_told(tmp_path):
    rows = [*listed(GROUND, range(10, 15)), *listed(IMAGE, range(20, 22))]
    with pytest.raises(TableError, match="places of images in 2 of 7 rows") as caught:
        read(tmp_path, [HEADER, *rows])
    assert caught.value.row == 7
    assert "Leave the images out" in str(caught.value)


@pytest.mark.parametrize(
    "angles", ["Omega;Phi;Kappa", "omega [deg];phi [deg];kappa [deg]", "Yaw;Pitch;Roll"]
)
def test_angles_beside_coordinates_are_asked_about(tmp_path, angles):
    rows = [f"{row};0.1;-0.3;91.2" for row in listed(GROUND, range(10, 20))]
    lines = [f"{HEADER};{angles}", *rows]
    with pytest.raises(TableError, match="does 'Name' name points or images") as caught:
        read(tmp_path, lines)
    assert 'columns = {point_id = "Name"}' in str(caught.value)
    table = read(tmp_path, lines, columns={"point_id": "Name"})
    assert list(table.frame["point_id"])[:2] == ["PP10", "PP11"]


def test_ground_points_are_read(tmp_path):
    rows = [f"{row};7" for row in listed(GROUND, range(10, 20))]
    frame = read(tmp_path, [f"{HEADER};Kappa", *rows]).frame
    assert len(frame) == 10  # one angle is none of a photograph
    named = ["point_id;easting;northing;omega;phi;kappa"]
    named += [f"P{n};{n}.0;1.0;0;0;0" for n in range(5)]
    assert len(read(tmp_path, named).frame) == 5  # the user's own word for points


def test_tables_of_models_may_name_images_and_angles(tmp_path):
    lines = ["model_id;point_id;x;y;omega;phi;kappa"]
    lines += [f"1-2.jpg;P{n};{n}.0;1.0;0;0;0" for n in range(5)]
    assert len(read(tmp_path, lines, MODEL_POINTS).frame) == 5
