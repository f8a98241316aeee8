"""``einschalt export``."""


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
    refused = invoke("export", tmp_path / "out", "--to", lost, "--overwrite")
    assert refused.exit_code == 2
