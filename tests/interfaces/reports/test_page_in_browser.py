"""The report in a Chromium: drawn, linked, searched, dark, on paper and on a phone.

A script of the test is put at the end of the page's own, under the page's own policy,
and writes what it found into the page.
"""

import base64
import csv
import hashlib
import json
import os
import re
import shutil
import subprocess
from dataclasses import replace
from html import escape, unescape
from pathlib import Path

import numpy as np
import pytest
from tests.changed_results import judged_before

from einschalt.foundations.errors import SettingsError
from einschalt.foundations.language import written_in
from einschalt.interfaces.reports import pdf_printer
from einschalt.interfaces.reports.html_report import render
from einschalt.interfaces.reports.pdf_printer import BROWSERS, OPTIONS, pdf_of
from einschalt.pipeline.densify import densify
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block

BROWSER = next((found for name in BROWSERS if (found := shutil.which(name))), None)
needs_browser = pytest.mark.skipif(BROWSER is None, reason="no Chromium is installed")

# by make browser
AXE = Path(__file__).parents[3] / "node_modules" / "axe-core" / "axe.min.js"
AUDIT = """
const audited = async () => {
  const isReady = () => document.documentElement.dataset.ready;
  while (!isReady()) await new Promise((done) => setTimeout(done, 20));
  for (const details of document.querySelectorAll("details")) details.open = true;
  const { violations } = await axe.run(document, { resultTypes: ["violations"] });
  const found = violations.map(({ id, impact, nodes }) => [id, impact, nodes[0].html]);
  parent.postMessage(JSON.stringify(found), "*");
};
audited();
"""
HOSTILE = "</script><img src=x onerror=\"document.title='taken'\">"
DRIVER = Path(__file__).with_name("page_driver.js").read_text(encoding="utf-8")


def driven(html, driver):
    """The page with a driver in its own script, and the policy that allows it."""
    script = html[html.rindex('<script type="module">') + 22 : html.rindex("</script>")]
    longer = script + driver
    digests = [
        f"sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}"
        for text in (script, longer)
    ]
    assert escape(digests[0]) in html
    return html.replace(*map(escape, digests)).replace(script, longer)


# no window is narrower than 500 pixels, but frames in it may be
FRAME = '<iframe src="page.html" width="{}" height="844"></iframe>'
FRAMES = """<!DOCTYPE html>{}
<script>addEventListener("message", ({{ data, source }}) => {{
  const frames = [...document.querySelectorAll("iframe")];
  const place = frames.findIndex((one) => one.contentWindow === source);
  document.body.append(Object.assign(document.createElement("pre"),
    {{ id: `found-${{place}}`, textContent: data }}));
}});</script>"""


def looked_at(html, folder, width, driver=DRIVER):
    """What the driver found, and what the browser said of the page."""
    (found,), said = looked_at_in(html, folder, [width], driver)
    return found, said


def looked_at_in(html, folder, widths, driver=DRIVER):
    """The same in frames of several widths, in one browser."""
    (folder / "page.html").write_text(driven(html, driver), encoding="utf-8")
    framed = FRAMES.format("".join(FRAME.format(width) for width in widths))
    (folder / "frame.html").write_text(framed, encoding="utf-8")
    command = [BROWSER, *OPTIONS, "--no-sandbox", f"--user-data-dir={folder / 'p'}"]
    command += ["--enable-logging=stderr", "--window-size=1500,1000", "--dump-dom"]
    page = (folder / "frame.html").as_uri()
    done = subprocess.run(
        [*command, page], capture_output=True, text=True, timeout=120, check=True
    )
    posted = re.findall(r'<pre id="found-(\d)">(.*?)</pre>', done.stdout, re.DOTALL)
    found = {int(place): json.loads(unescape(text)) for place, text in posted}
    lines = [line for line in done.stderr.splitlines() if "CONSOLE" in line]
    # advice for whoever reads pixels often, as the driver does
    said = [line for line in lines if "willReadFrequently" not in line]
    said = [line for line in said if "will-read-frequently" not in line]
    return [found[place] for place in range(len(widths))], said


@pytest.fixture(scope="module")
def result(good_result):
    """A sound block, with hostile names of a point, a model and the block."""
    points, models = good_result.points.copy(), good_result.models.copy()
    points.loc[7, "point_id"] = HOSTILE
    models.loc[2, "model_id"] = HOSTILE
    block = replace(good_result.block, name=HOSTILE, operator=HOSTILE)
    return judged_before(good_result, points=points, models=models, block=block)


@pytest.fixture(scope="module")
def oriented_result():
    """A spatial block: its tables have the most columns."""
    geometry = replace(
        PRESETS["demo"].geometry, measurement="images", transformation="helmert_3d"
    )
    return densify(simulate_block("demo", seed=1, geometry=geometry))


@pytest.fixture(scope="module")
def seen(result, tmp_path_factory):
    """The page on a screen of 1280 pixels."""
    if BROWSER is None:
        pytest.skip("no Chromium is installed")
    folder = tmp_path_factory.mktemp("screen")
    return looked_at(render(result), folder, 1280)


@pytest.mark.slow
def test_nothing_fails_and_nothing_is_asked_for(seen, result):
    found, said = seen
    assert found["errors"] == []
    assert said == []
    assert found["requests"] == 0
    # names are text, wherever they stand
    assert found["images"] == 0
    assert found["title"].startswith("</script>")
    assert found["light"]["colours"] > 50


def test_the_map_answers_pointer_and_keys(seen):
    found, _ = seen
    is_hidden, said, name, readout = found["hovered"]
    assert not is_hidden
    assert said == name
    assert re.fullmatch(r"E \d+\.\d{3}  N \d+\.\d{3}", readout)
    assert found["zoomed"] == pytest.approx(1.5)
    assert found["whole"] == pytest.approx(1.0)
    before, zoomed = found["errorScales"]
    assert before == zoomed > 0.0  # an error is as long at every scale
    assert {"heat", "ellipses", "footprints", "apart", "points"} <= set(found["layers"])


def test_a_row_leads_to_its_point_on_the_map_and_in_the_table(seen):
    chosen = seen[0]["chosen"]
    assert chosen["isMarked"]
    assert chosen["off"] < 1.0
    assert chosen["name"] == chosen["row"]
    assert chosen["inTable"] == [chosen["name"]]


def test_tables_are_searched_sorted_folded_and_saved(seen, result):
    found, _ = seen
    assert found["isFolded"]
    assert found["searched"] == [HOSTILE]
    assert found["worst"][0] == found["worst"][1]
    assert found["csv"] == len(result.points) + 2  # its head, and the end
    # as docs/files.md has it
    expected = ["'=1+1", "'-7/8", "-5", "-5A", "7/8", "--", "''=x"]
    assert found["tamed"] == expected
    said, n_rows = found["highlighted"]
    assert n_rows == (result.points["role"] == "new").sum()
    assert said.startswith(f"{n_rows} points")


def test_bars_of_the_residuals_lead_to_their_points(seen, result):
    said, n_rows, rows = seen[0]["brushed"]
    residuals = result.residuals
    free = np.sqrt(residuals["redundancy_number"].astype(float))
    large = set()
    for side in ("residual_easting", "residual_northing"):
        size = residuals[side].astype(float) / free
        # a coordinate in the standard deviations of its flight
        squares = (residuals["residual_easting"] / free) ** 2
        squares += (residuals["residual_northing"] / free) ** 2
        scale = np.sqrt(squares.groupby(residuals["flight"]).mean() / 2.0)
        is_large = size / residuals["flight"].map(scale) >= 2.0
        large |= set(residuals.loc[is_large, "point_id"])
    shown = result.points["point_id"].iloc[rows]
    # the point whose name was made hostile has other residuals
    assert large - set(shown) <= {"1008"}
    assert set(shown) <= large
    assert n_rows == len(rows) > 5
    assert (
        said == f"{n_rows} points with a residual of 2.00 standard deviations or more"
    )
    assert seen[0]["faded"] == 28  # of 40 bars of a quarter each
    assert re.fullmatch(
        r"\d+ points? with a residual of \d\.\d\d to \d\.\d\d standard deviations",
        seen[0]["clicked"],
    )


GERMAN = """
const tried = async () => {
  while (!document.documentElement.dataset.ready) {
    await new Promise((done) => setTimeout(done, 20));
  }
  const { map, tables, selection } = globalThis.einschaltReport;
  const field = document.querySelector("#plot-residuals .range input");
  const brushed = (text) => {
    field.value = text;
    selection.clear();
    document.querySelector("#plot-residuals .range button").click();
    return map.said.textContent;
  };
  map._hover(map.view.width / 2, map.view.height / 2);
  return {
    csv: tables.points.csv(),
    columns: tables.points.columns.map(({ isNumber }) => Boolean(isNumber)),
    typed: ["6,0", "6.0", "-0,5", "\\u22120.5"].map(typedFigure),
    none: brushed(""), comma: brushed("1,5"), point: brushed("1.5"),
    word: brushed("x"),
    readout: map.readout.textContent,
  };
};
tried().catch(String).then((found) => parent.postMessage(JSON.stringify(found), "*"));
"""


@pytest.fixture(scope="module")
def german(good_result, tmp_path_factory):
    """What the German page says of itself."""
    if BROWSER is None:
        pytest.skip("no Chromium is installed")
    folder = tmp_path_factory.mktemp("german")
    with written_in("de"):
        html = render(good_result)
    return looked_at(html, folder, 1280, GERMAN)[0]


@pytest.mark.slow
def test_a_typed_figure_has_either_decimal_sign(german):
    assert german["typed"] == [6, 6, -0.5, -0.5]
    assert german["comma"] == german["point"] != german["none"]
    # what is no figure highlights nothing
    assert german["word"] not in (german["none"], german["comma"])


def test_a_german_csv_is_as_german_spreadsheets_read_it(german, good_result):
    text = german["csv"].removeprefix("\ufeff")
    rows = list(csv.reader(text.splitlines(), delimiter=";"))
    assert len(rows) == len(good_result.points) + 1
    assert {len(row) for row in rows} == {len(german["columns"])}
    figures = [
        cell
        for row in rows[1:]
        for cell, is_figure in zip(row, german["columns"], strict=True)
        if is_figure and cell
    ]
    assert any("," in cell for cell in figures)
    assert [cell for cell in figures if not re.fullmatch(r"-?\d+(,\d+)?", cell)] == []


def test_the_readout_of_the_map_is_german(german):
    assert re.fullmatch(r"Rechtswert \S+\s+Hochwert \S+", german["readout"])


def test_the_dark_form_is_dark(seen):
    light, dark = (seen[0][name]["paper"] & 0xFF for name in ("light", "dark"))
    assert light == 255
    assert dark < 64


@pytest.mark.slow
@needs_browser
def test_on_a_phone_nothing_is_clipped(result, tmp_path):
    found, said = looked_at(render(result), tmp_path, 390)
    assert found["errors"] == said == []
    inner, wide = found["width"]
    assert inner == 390
    assert wide <= inner
    assert found["clipped"] == []
    # wide tables are cards, each cell with its heading
    assert found["cards"] >= 3
    assert found["named"][0] == found["named"][1]


@pytest.mark.slow
@needs_browser
@pytest.mark.parametrize("chosen", ["en", "de"])
def test_no_table_is_clipped_on_any_screen(oriented_result, tmp_path, chosen):
    with written_in(chosen):
        html = render(oriented_result)
    widths = (768, 1280, 1400)
    pages, said = looked_at_in(html, tmp_path, widths)
    assert said == []
    for width, found in zip(widths, pages, strict=True):
        assert found["width"][0] == width
        assert found["errors"] == found["clipped"] == []
        assert (found["cards"] > 0) is (width == 768)


def test_bars_hold_as_many_of_the_errors_that_the_page_can_tell_apart(seen):
    """Errors of many points are multiples of a step: no comb may appear."""
    n_steps, low, high = seen[0]["bars"]
    assert round(n_steps) == pytest.approx(n_steps)
    assert n_steps > 0.5
    assert low < 0.0335
    assert high > 0.0622


def test_numbers_of_known_points_are_sorted_both_ways(seen):
    up, down, n = seen[0]["numbers"]
    assert len(up) == len(down) == min(n, 10) > 1
    assert up == [f"K{k + 1}" for k in range(len(up))]
    assert down == [f"K{n - k}" for k in range(len(down))]


def test_who_picks_a_row_by_keys_stays_on_it(seen):
    for picked, name, is_same_place in seen[0]["held"]:
        assert name == picked
        assert is_same_place


def test_pages_of_a_table_end_at_its_ends(seen, result):
    first, before, last, after = seen[0]["turned"]
    n = len(result.points)
    assert first == before == [f"1–10 of {n} points", [True, True, False, False]]
    start = (n - 1) // 10 * 10 + 1
    assert last == after
    assert last[0].startswith(f"{start}–{n} of {n} ")
    assert last[1] == [False, False, True, True]


def test_on_paper_every_row_of_a_short_table_is_printed(seen, result):
    (n_printed, width, n_buttons), (n_shown, wide, n_sorting) = seen[0]["printed"]
    assert n_printed == len(result.points) > n_shown == 10
    assert width == 660 < wide
    # a button in a head would not be repeated on the next page
    assert n_buttons == 0 < n_sorting


@needs_browser
@pytest.mark.skipif(not AXE.exists(), reason="axe-core is not installed by npm")
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing_serious(result, tmp_path, scheme):
    chosen = f"scheme.chosen = '{scheme}'; schemeChanged();\n"
    driver = AXE.read_text(encoding="utf-8") + chosen + AUDIT
    found, _ = looked_at(render(result), tmp_path, 1280, driver)
    assert [one for one in found if one[1] in ("serious", "critical")] == []


@pytest.mark.slow
@needs_browser
def test_it_is_printed_on_the_paper_that_is_wanted(result):
    printed = pdf_of(render(result, paper="letter"))
    assert printed.startswith(b"%PDF")
    assert b"/MediaBox [0 0 612 792]" in printed
    assert 3 <= printed.count(b"/Type /Page\n") <= 12


@pytest.mark.skipif(os.name != "posix", reason="the browser is a shell script")
@pytest.mark.parametrize(
    ("text", "then"),
    [
        ("%PDF-1.4 half", "exit 0"),
        ("%PDF-1.4 %%EOF", "exit 3"),
        ("%PDF-1.4 %%EOF", "exec sleep 60"),
        (None, "exit 0"),
    ],
    ids=["cut_off", "failed", "too_slow", "nothing"],
)
def test_half_a_pdf_is_none(monkeypatch, tmp_path, text, then):
    browser = a_browser(tmp_path / "chromium", text, then)
    monkeypatch.setattr(pdf_printer.shutil, "which", lambda _: str(browser))
    monkeypatch.setattr(pdf_printer, "SECONDS", 1.0)
    with pytest.raises(SettingsError, match="printed no PDF"):
        pdf_of("<p>")


@pytest.mark.skipif(os.name != "posix", reason="the browser is a shell script")
def test_a_whole_pdf_is_taken_as_it_is(monkeypatch, tmp_path):
    browser = a_browser(tmp_path / "chromium", "%PDF-1.4 %%EOF\n", "exit 0")
    monkeypatch.setattr(pdf_printer.shutil, "which", lambda _: str(browser))
    assert pdf_of("<p>") == b"%PDF-1.4 %%EOF\n"


def a_browser(path, text, then):
    """A program that prints a text in the place of a PDF."""
    path.with_suffix(".txt").write_text(text or "")
    prints = 'cat "$0.txt" > "${one#*=}"' if text else ":"
    lines = ["#!/bin/sh", 'for one in "$@"; do case "$one" in']
    lines += [f"--print-to-pdf=*) {prints} ;; esac; done", then]
    path.write_text("\n".join(lines))
    path.chmod(0o700)
    return path


def test_without_a_browser_it_is_said_what_to_do(monkeypatch):
    monkeypatch.setattr(pdf_printer.shutil, "which", lambda _: None)
    with pytest.raises(SettingsError, match="Install Chromium") as caught:
        pdf_printer.require_browser()
    assert "none is installed" in str(caught.value)
