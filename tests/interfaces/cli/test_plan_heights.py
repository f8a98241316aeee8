"""Flying heights in answers of ``einschalt plan`` and ``einschalt simulate``."""

import json
from dataclasses import replace
from types import SimpleNamespace

import pytest

from einschalt.foundations import kernels
from einschalt.foundations.language import written_in
from einschalt.interfaces.cli import plan_layouts, progress
from einschalt.interfaces.local_page.plan_pages import figures_of
from einschalt.pipeline.planning.flights.cameras import (
    CAMERAS,
    said_of_height,
    said_of_scales,
)
from einschalt.pipeline.planning.flights.flight_design import FlightDesign

SMALL = ("--width", 300, "--height", 300)
UAV = ("plan", "--camera", "uav_full_frame")
EXPECTED = (*UAV, "--expect", *SMALL)
OVER_120 = "is higher than the 120 m that drones may usually fly."
LAYOUT = ("plan", "--expect", "--spacing", 300, "--width", 4000, "--height", 4000)


def one_line(shown):
    assert shown.exit_code == 0, shown.stderr
    return " ".join(shown.stdout.split())


@pytest.mark.parametrize(
    ("camera", "says"),
    [
        (
            "film_wide",
            "Low flight 1216 m above ground, GSD 12 cm; high flight 2280 m, GSD 22 cm",
        ),
        (
            "dmc_3",
            "Low flight 1840 m above ground, GSD 7.8 cm; high flight 3450 m, GSD 15 cm",
        ),
    ],
)
def test_heights_and_gsd_of_a_layout_are_said(camera, says, invoke):
    said = one_line(invoke(*LAYOUT, "--camera", camera))
    assert says in said
    assert ("GSD: of film that is scanned at 15 µm." in said) == (camera == "film_wide")
    assert "higher than" not in said


def test_the_json_has_them_as_that_of_a_target_has(invoke):
    told = json.loads(invoke(*EXPECTED, "--json").stdout)["figures"]
    distance, pixel = CAMERAS["uav_full_frame"].principal_distance, 4.4e-6
    for flight in ("", "high_"):
        scale = told[f"{flight}scale_number"]
        assert told[f"{flight}flying_height"] == pytest.approx(distance * scale)
        assert told[f"{flight}gsd"] == pytest.approx(pixel * scale)


@pytest.mark.slow
def test_a_flight_above_the_usual_limit_is_told(invoke, tmp_path):
    first = f"The high flight, 164 m above ground, {OVER_120}"
    assert f"{first} Give a --high-scale-number of at most 3428" in one_line(
        invoke(*EXPECTED)
    )
    simulated = ("simulate", "--camera", "uav_full_frame", *SMALL)
    shown = invoke(*simulated, "--output", tmp_path / "block")
    assert first in one_line(shown)
    for n, call in enumerate((EXPECTED, (*simulated, "--output", tmp_path / "again"))):
        told = json.loads(invoke(*call, "--json").stdout)
        (problem,) = told["problems"]
        assert told["status"] == 0, n
        assert problem["found"] == first.removesuffix(".")
        assert problem["expected"] == "at most 120 m above ground"
        assert "--high-scale-number of at most 3428" in problem["remedy"]


@pytest.mark.slow
def test_what_is_advised_keeps_the_limit(invoke, tmp_path):
    kept = ("--high-scale-number", 3428)
    said = one_line(invoke(*EXPECTED, *kept))
    assert "higher than" not in said
    assert "Up to 120 m above ground, as usual for it (--max-height)." in said
    call = ("simulate", "--camera", "uav_full_frame", *SMALL, *kept)
    assert "higher than" not in one_line(invoke(*call, "--output", tmp_path / "block"))


@pytest.mark.slow
def test_a_limit_that_is_given_counts(invoke):
    said = one_line(invoke(*EXPECTED, "--max-height", "200m"))
    assert "Not used" not in said
    assert "higher than" not in said
    assert "Up to 200 m above ground." in said
    said = one_line(invoke(*EXPECTED, "--max-height", 80))
    both = "Both flights, 88 and 164 m above ground, are higher than the limit of 80 m."
    assert f"{both} Give scale numbers of at most 2285 to both flights" in said
    shown = invoke(*LAYOUT, "--max-height", 2000)
    assert "is higher than the limit of 2000 m." in one_line(shown)
    refused = invoke(*LAYOUT, "--max-height", 0)
    assert refused.exit_code == 2
    assert "--max-height = 0; expected 5 to 20000 metres" in refused.stderr


def test_tables_tell_the_heights_of_their_scales(invoke):
    said = one_line(invoke("plan", "--scale", "6000,8000"))
    assert "flown 912 to 1216 m above ground, GSD 9.0 cm to 12 cm" in said
    assert "higher than" not in said
    assert "flown 1380 m above ground, GSD 5.8 cm" in one_line(
        invoke("plan", "--camera", "dmc_3", "--scale", 15000)
    )
    assert "higher than" not in one_line(invoke(*UAV))
    high = (*UAV, "--scale", "3000,4000")
    above = "Flights at 1:4000 are 140 m above ground, which is higher than the 120 m"
    assert above in one_line(invoke(*high))
    (problem,) = json.loads(invoke(*high, "--json").stdout)["problems"]
    assert problem["found"].startswith(above)
    assert "higher than" not in one_line(invoke(*high, "--max-height", 150))


@pytest.mark.parametrize("camera", ["uav_full_frame", "uav_one_inch", "film_wide"])
def test_the_local_page_says_the_same_sentence(camera):
    answer = figures_of({"camera": camera})
    preset = CAMERAS[camera]
    (height,) = (text for text, what in answer["figures"] if what.endswith("ground"))
    is_above = preset.max_height is not None
    said = f"The high flight, {height} above ground, {OVER_120}"
    assert answer["said"].startswith(said) == is_above


def test_heights_on_the_limit_keep_it_and_one_above_is_seen_to_be():
    def said(height, limit):
        plan = {"flying_height": 50.0, "high_flying_height": height}
        return said_of_height(plan, limit)

    assert not said(120.0 * (1.0 + 1e-12), 120.0)
    assert not said(5000.0, None)
    assert "120.04 m above ground" in said(120.04, 120.0)
    assert "121 m above ground" in said(120.6, 120.0)
    assert not said_of_scales([2000.0, 3000.0], 0.04, 120.0)
    assert "1:3010" in said_of_scales([2000.0, 3010.0], 0.04, 120.0)


@pytest.mark.slow
def test_they_are_german_too(invoke, tmp_path):
    asked = ("--language", "de")
    for call in (
        EXPECTED,
        (*EXPECTED, "--max-height", 80),
        (*UAV, "--scale", "3000,4000"),
        ("simulate", "--camera", "uav_full_frame", *SMALL, "--output", tmp_path / "b"),
    ):
        said = one_line(invoke(*call, *asked))
        assert "über Grund" in said
        assert "Maßstabszahlen von höchstens" in said or "--high-scale-number" in said
        for english in ("above", "higher", "Give", "flight", "permitted"):
            assert english not in said
    with written_in("de"):  # the local page
        assert (
            "höher als die 120 m, die Drohnen"
            in figures_of({"camera": "uav_full_frame"})["said"]
        )


def test_a_layout_shows_its_progress_and_what_is_compiled(monkeypatch, capsys):
    """As a search does: half a minute passes while kernels are compiled."""

    def propagated(design):
        kernels._watch.n_kernels += 1
        kernels._watch.announce("_fit")
        return SimpleNamespace(design=design)

    monkeypatch.setattr(progress, "PATIENCE", 0.0)
    monkeypatch.setattr(kernels, "_watch", kernels._Watch())
    monkeypatch.setattr(plan_layouts, "expect_precision", propagated)
    design = FlightDesign(scale_number=8000, spacing=300, m_g_um=5)
    blocks = plan_layouts._expected_of(design)
    assert [block.design.coverage_shift for block in blocks] == [None, 0.0]
    shown = capsys.readouterr().err.splitlines()
    assert "  0%  propagating the layout" in shown
    assert " 50%  propagating coverages that are not shifted" in shown
    assert any(line.startswith("  0%  compiling 1 of about") for line in shown)
    single = replace(design, n_coverages=1)
    assert plan_layouts._expected_of(single)[1] is None
