"""docs/planning.md: its commands run, and print what stands there."""

import contextlib
import io
import re
import shlex
from pathlib import Path

import pytest
from typer.testing import CliRunner

from einschalt.interfaces.cli.main import app
from einschalt.pipeline.planning.flights.cameras import CAMERAS

ROOT = Path(__file__).parents[1]
INTRODUCTION, *PARTS = (ROOT / "docs" / "planning.md").read_text("utf-8").split("\n## ")
SECTIONS = dict(part.split("\n", 1) for part in PARTS)
FENCED = re.compile(r"```(\w+)\n(.*?)```", re.DOTALL)
# what a block of the page is the content of
FILES = {"csv": "heights.csv", "json": "region.geojson", "xyz": "ground.xyz"}
# a scale, or a length with its unit, as prose and tables write them
FIGURE = re.compile(r"1:\d+|\d+(?:\.\d+)?(?= (?:cm|mm|µm|m)\b)")


def run(command):
    program, *arguments = shlex.split(command)
    assert program == "einschalt"
    shown = CliRunner().invoke(app, arguments)
    is_unreached = "No plan is recommended" in shown.stdout
    assert shown.exit_code == int(is_unreached), shown.stderr
    return shown.stdout


def python(code):
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        exec(compile(code, "planning.md", "exec"), {})
    return said.getvalue()


@pytest.mark.slow
@pytest.mark.parametrize("title", SECTIONS)
def test_commands_print_what_stands_below_them(title, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    everything = printed = ""
    for language, text in FENCED.findall(SECTIONS[title]):
        if language in FILES:
            Path(FILES[language]).write_text(text, encoding="utf-8")
        elif language == "text":
            for excerpt in text.split("…\n"):
                assert excerpt in printed
        else:
            printed = run(text) if language == "sh" else python(text)
            everything += text + printed
    for file in re.findall(r"--figure (\S+)", everything):
        assert Path(file).stat().st_size > 10_000
    if title == "Cameras":  # a table, which is compared below
        return
    # what the prose says are figures of the commands or of the question
    prose = FENCED.sub("", SECTIONS[title])
    question = "".join(re.findall(r"^\*.*\*", prose, re.MULTILINE))
    known = set(re.findall(r"1:\d+|\d+(?:\.\d+)?", everything + question))
    assert set(FIGURE.findall(prose)) <= known


def test_every_camera_of_the_guide_has_its_example():
    assert {"Aerial film", "Large-format digital", "UAV", "Cameras"} <= set(SECTIONS)


def test_the_table_of_cameras_is_theirs():
    rows = {}
    for line in SECTIONS["Cameras"].splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if line.startswith("| `") and "--camera" not in cells[0]:
            names = [name.strip("` ") for name in cells[0].split(",")]
            distances = [float(one) for one in cells[2].split(",")]
            rows |= {
                name: (distance, *cells[3:])
                for name, distance in zip(names, distances, strict=True)
            }
    assert set(rows) == set(CAMERAS)
    for name, (distance, pixels, pixel, limit) in rows.items():
        camera = CAMERAS[name]
        assert 1e-3 * distance == pytest.approx(camera.principal_distance)
        assert float(pixel.split()[0]) == camera.sampled_um
        assert limit == ("–" if camera.max_height is None else f"{camera.max_height:g}")
        if camera.pixel_um is None:
            continue
        sides = [int(one) * 1e-6 * camera.pixel_um for one in pixels.split(" × ")]
        assert sides == pytest.approx(camera.image_format)
