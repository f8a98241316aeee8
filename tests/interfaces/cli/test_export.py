"""``einschalt export``."""

import numpy as np
import pandas as pd
import pytest

from einschalt.interfaces.programs.recognised import read_foreign

pytestmark = pytest.mark.slow

KNOWN = ("--crs", "EPSG:31255", "--high-m-g-um", "7.5", "--low-m-g-um", "5")


def test_a_folder_has_the_covariance_of_each_point_alone(
    invoke, block_folder, tmp_path
):
    made = invoke("densify", block_folder, "--output", tmp_path / "out", "--quiet")
    assert made.exit_code == 0, made.output
    to = [tmp_path / "p.gkf", tmp_path / "p.xlsx"]
    shown = invoke("export", tmp_path / "out", "--to", *to)
    assert shown.exit_code == 0, shown.output
    assert "covariance of each point by itself (2 x 2 blocks)" in shown.stdout
    again = invoke("export", tmp_path / "out", "--to", *to)  # the same: nothing lost
    assert again.exit_code == 0, again.output
    full = invoke("export", block_folder, "--to", tmp_path / "p.gkf")
    assert full.exit_code == 2
    assert "would be lost" in full.stderr
    full = invoke("export", block_folder, "--to", tmp_path / "p.gkf", "--overwrite")
    assert full.exit_code == 0, full.output
    assert "full covariance" in full.stdout
    lost = tmp_path / "out" / "points.csv"
    first = tmp_path / "first.gkf"
    refused = invoke("export", tmp_path / "out", "--to", first, lost, "--overwrite")
    assert refused.exit_code == 2
    assert "first.gkf" in refused.stdout  # what was written before is said
    assert first.exists()


def test_three_files_of_an_office_become_a_drawing_in_three_commands(
    invoke, block_folder, good_result, tmp_path
):
    control = pd.read_csv(block_folder / "control_points.csv", dtype={"point_id": str})
    words = {"point_id": "Punktnr", "easting": "Rechtswert", "northing": "Hochwert"}
    kinds = {"control": "Paßpunkt", "check": "Kontrollpunkt"}
    table = control.assign(Art=control.pop("role").map(kinds)).rename(columns=words)
    options = {"sep": ";", "decimal": ",", "encoding": "cp1252", "index": False}
    table.to_csv(tmp_path / "Punkte.csv", **options)
    flights = [block_folder / f"{name}_flight.csv" for name in ("high", "low")]
    given = ["--from", tmp_path / "Punkte.csv", *flights]
    calls = (
        ("init", tmp_path / "BLOCK", *given, *KNOWN),
        ("densify", tmp_path / "BLOCK", "--output", tmp_path / "out", "--quiet"),
        ("export", tmp_path / "out", "--to", tmp_path / "p.dxf", tmp_path / "p.xlsx"),
    )
    for call in calls:
        done = invoke(*call)
        assert done.exit_code == 0, done.output
    drawn = read_foreign(tmp_path / "p.dxf").tables["control_points"]
    points = good_result.points.set_index("point_id").loc[drawn["point_id"]]
    plane = ["easting", "northing"]
    # no digit is lost on the way
    np.testing.assert_allclose(drawn[plane], points[plane], rtol=0, atol=1e-8)


def test_folders_of_the_files_are_made_as_convert_makes_them(
    invoke, block_folder, tmp_path
):
    made = invoke("densify", block_folder, "--output", tmp_path / "out", "--quiet")
    assert made.exit_code == 0, made.output
    to = tmp_path / "for" / "cad" / "p.dxf", tmp_path / "for" / "p.csv"
    shown = invoke("export", tmp_path / "out", "--to", *to)
    assert shown.exit_code == 0, shown.output
    assert all(path.is_file() for path in to)
    refused = invoke("export", tmp_path / "out", "--to", to[1] / "p.dxf")
    assert refused.exit_code == 2
    assert "Choose another folder" in refused.stderr
