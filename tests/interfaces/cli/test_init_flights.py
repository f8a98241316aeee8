"""``einschalt init`` of a table that holds both flights."""

import pandas as pd
import pytest

from einschalt.interfaces.files.block_folder import read_block


@pytest.mark.parametrize(
    ("values", "where"),
    [
        (("hoch", "tief"), ('{Flug = "hoch"}', '{Flug = "tief"}')),
        # as numbers; nothing but the scales of the models tells which is which
        ((2, 1), ('{Flug = "2"}', '{Flug = "1"}')),
    ],
)
def test_init_takes_the_rows_of_each_flight(small_block, invoke, values, where):
    folder = small_block.path
    whole = read_block(folder)
    both = pd.concat(
        [
            pd.read_csv(folder / f"{name}_flight.csv", dtype=str).assign(Flug=value)
            for name, value in zip(("high", "low"), values, strict=True)
        ]
    )
    both.sample(frac=1.0, random_state=0).to_csv(folder / "fluege.csv", index=False)
    files = [str(folder / name) for name in ("control_points.csv", "fluege.csv")]
    errors = ("--high-m-g-um", "7.5", "--low-m-g-um", "5", "--control-error-m", "0.03")
    new = folder / "new"
    done = invoke("init", str(new), "--from", *files, *errors, "--yes")
    assert done.exit_code == 0, done.output
    text = (new / "block.toml").read_text(encoding="utf-8")
    for one in where:
        assert f'model_points = {{file = "../fluege.csv", where = {one}}}' in text
    block = read_block(new)
    for name in ("high_flight", "low_flight"):
        found, wanted = (getattr(one, name).model_points for one in (block, whole))
        key = ["coverage", "model_id", "point_id"]
        pd.testing.assert_frame_equal(
            found.sort_values(key).reset_index(drop=True)[wanted.columns],
            wanted.sort_values(key).reset_index(drop=True),
        )


@pytest.mark.parametrize("sign", ["1:{}", "{}"])
def test_init_parts_flights_by_the_measured_scales_of_models(small_block, invoke, sign):
    """Each model has a scale of its own: the jump between the flights parts them."""
    folder = small_block.path
    whole = read_block(folder)
    parts, expected = [], []
    for name, first, step in (("high", 14820, 120), ("low", 7900, 115)):
        table = pd.read_csv(folder / f"{name}_flight.csv", dtype=str)
        # of each row: models are few in a small block
        scales = [first + step * (k % 5) for k in range(len(table))]
        parts.append(table.assign(Scale=[sign.format(scale) for scale in scales]))
        expected.append(" to ".join(map(sign.format, (min(scales), max(scales)))))
    pd.concat(parts).to_csv(folder / "models.csv", index=False)
    files = [str(folder / name) for name in ("control_points.csv", "models.csv")]
    errors = ("--high-m-g-um", "7.5", "--low-m-g-um", "5", "--control-error-m", "0.03")
    new = folder / "new"
    done = invoke("init", str(new), "--from", *files, *errors, "--yes")
    assert done.exit_code == 0, done.output
    text = (new / "block.toml").read_text(encoding="utf-8")
    for one in expected:
        assert f'where = {{Scale = "{one}"}}' in text
    block = read_block(new)
    for name in ("high_flight", "low_flight"):
        found, wanted = (getattr(one, name).model_points for one in (block, whole))
        assert len(found) == len(wanted)
