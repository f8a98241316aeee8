"""What the report of a usual block costs: bytes, time, and what it takes along.

Time is that of the processor, and not of the clock on the wall: what else a computer is
doing does not decide.
"""

import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from tests.interfaces.local_page.chromium import PROGRAM, Chromium

import einschalt as es
from einschalt.interfaces.reports.html_report import render
from einschalt.interfaces.reports.packed_data import PackedData
from einschalt.interfaces.reports.page_points import pack_points

pytestmark = pytest.mark.slow

NEUKIRCHEN = Path(__file__).parents[3] / "data_examples" / "neukirchen"
SHOW_ALL = """(() => {
  const { map } = einschaltReport;
  const hidden = document.querySelectorAll("[data-layer]:not(:checked)");
  for (const box of hidden) box.click();
  map.drawNow();
})()"""
PAN = """(() => {
  const { map } = einschaltReport;
  for (let k = 0; k < 60; k++) {
    map.view.pan(k % 2 ? 9 : -7, 5 - k % 11);
    map.drawNow();
  }
})()"""


@pytest.fixture(scope="module")
def result():
    """1190 points, judged already."""
    found = es.densify(es.read_block(NEUKIRCHEN))
    found.assessment  # noqa: B018
    return found


def script_seconds(browser):
    """What the thread of the page has worked until now, of the processor's time."""
    metrics = browser("Performance.getMetrics")["metrics"]
    return next(one["value"] for one in metrics if one["name"] == "TaskDuration")


def test_the_report_is_small_and_made_at_once(result):
    times = []
    for _ in range(2):
        began = time.process_time()
        html = render(result)
        times.append(time.process_time() - began)
    assert len(html.encode()) <= 400_000  # 220 kB
    assert min(times) < 0.5  # 0.1 s


def test_the_data_of_100_000_points_are_small(result):
    many = SimpleNamespace(
        points=many_of(result.points),
        ellipses=many_of(result.ellipses),
        residuals=many_of(result.residuals),
        single_values=many_of(result.single_values),
    )
    packed = PackedData()
    pack_points(packed, many, result.assessment.credible.column)
    n = packed.head["points"]["n"]
    size = len(packed.text()) * 100_000 / n
    assert 100_000 <= n <= 102_000
    assert size <= 1_500_000  # 1.23 MB


def many_of(table):
    """A table of a hundred thousand points: the block beside itself, with noise."""
    n_copies = -(-100_000 // 1190)
    draws = np.random.default_rng(1)
    many = pd.concat([table] * n_copies, ignore_index=True)
    copy = np.repeat(np.arange(n_copies), len(table))
    many["point_id"] = many["point_id"].astype(str) + "." + pd.Series(copy).astype(str)
    for name in many.select_dtypes("float"):
        noise = draws.standard_normal(len(many))
        if name in ("easting", "northing"):
            many[name] += 10_000.0 * (copy % 10 if name == "easting" else copy // 10)
            many[name] += 10.0 * noise
        else:
            many[name] *= 1.0 + 0.1 * noise
    return many


def test_densify_takes_no_figures_along(tmp_path):
    command = [sys.executable, "-X", "importtime", "-m", "einschalt", "densify"]
    command += [NEUKIRCHEN, "--output", tmp_path / "out", "--quiet"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert "einschalt.interfaces.reports.html_report" in done.stderr
    assert "matplotlib" not in done.stderr


@pytest.mark.skipif(PROGRAM is None, reason="no Chromium is installed")
def test_the_page_is_drawn_and_moved_with_little_work(result, tmp_path):
    page = tmp_path / "report.html"
    page.write_text(render(result), encoding="utf-8")
    browser = Chromium(tmp_path / "profile")
    try:
        browser.start()
        browser("Performance.enable", timeDomain="threadTicks")
        opened = []
        for _ in range(3):
            browser.open("about:blank")
            began = script_seconds(browser)
            browser.open(page.as_uri())
            browser.until("document.documentElement.dataset.ready")
            opened.append(script_seconds(browser) - began)
        browser.value(SHOW_ALL)
        began = script_seconds(browser)
        browser.value(PAN)
        panned = script_seconds(browser) - began
        assert 0.0 < min(opened) < 1.0  # 0.1 s
        assert 0.0 < panned / 60 < 0.05  # 12 ms, all layers
        assert browser.errors == []
        assert set(browser.requests) <= {page.as_uri(), "about:blank"}
    finally:
        browser.end()
