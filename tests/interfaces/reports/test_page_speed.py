"""What the report of a usual block costs: bytes, time, and what it takes along."""

import subprocess
import sys
import time
from pathlib import Path

import pytest
from tests.interfaces.local_page.chromium import PROGRAM, Chromium

import einschalt as es
from einschalt.interfaces.reports.html_report import render

NEUKIRCHEN = Path(__file__).parents[3] / "data_examples" / "neukirchen"
PAN = """(async () => {
  const { map } = einschaltReport;
  const hidden = document.querySelectorAll("[data-layer]:not(:checked)");
  for (const box of hidden) box.click();
  map.drawNow();
  map.frames.length = 0;
  for (let k = 0; k < 60; k++) {
    map.view.pan(k % 2 ? 9 : -7, 5 - k % 11);
    map.drawNow();
  }
  return [...map.frames].sort((a, b) => a - b)[30];
})()"""
PAINTED = "performance.getEntriesByName('first-contentful-paint')[0].startTime"


@pytest.fixture(scope="module")
def result():
    """1190 points, judged already."""
    found = es.densify(es.read_block(NEUKIRCHEN))
    found.assessment  # noqa: B018
    return found


def test_the_report_is_small_and_made_at_once(result):
    times = []
    for _ in range(2):
        began = time.process_time()
        html = render(result)
        times.append(time.process_time() - began)
    assert len(html.encode()) <= 400_000  # 220 kB
    assert min(times) < 0.5  # 0.1 s


def test_densify_takes_no_figures_along(tmp_path):
    command = [sys.executable, "-X", "importtime", "-m", "einschalt", "densify"]
    command += [NEUKIRCHEN, "--output", tmp_path / "out", "--quiet"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert "einschalt.interfaces.reports.html_report" in done.stderr
    assert "matplotlib" not in done.stderr


@pytest.mark.skipif(PROGRAM is None, reason="no Chromium is installed")
def test_the_page_is_seen_and_moves_at_once(result, tmp_path):
    page = tmp_path / "report.html"
    page.write_text(render(result), encoding="utf-8")
    browser = Chromium(tmp_path / "profile")
    try:
        browser.start()
        painted = []
        for _ in range(3):
            browser.open("about:blank")
            browser.open(page.as_uri())
            browser.until("document.documentElement.dataset.ready")
            painted.append(browser.value(PAINTED))
        assert min(painted) < 1000.0  # 0.1 s [ms]
        assert browser.value(PAN) < 50.0  # 5 ms, all layers
        assert browser.errors == []
        assert set(browser.requests) <= {page.as_uri(), "about:blank"}
    finally:
        browser.end()
