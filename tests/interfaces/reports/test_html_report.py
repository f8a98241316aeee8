"""The page of a block: self-contained, escaped, complete."""

import base64
import hashlib
import re
from dataclasses import replace
from html import unescape
from html.parser import HTMLParser

import pandas as pd
import pytest
from tests.changed_results import changed, judged_before

from einschalt.interfaces.reports.html_report import render
from einschalt.pipeline.densify import densify
from einschalt.pipeline.simulation.simulate_block import PRESETS, simulate_block
from einschalt.pipeline.summary.verdict import verdict_on

HOSTILE = '<script>alert("x")</script>&\'{{ 7 * 7 }}$\\frac'
VOID = {"meta", "link", "br", "img", "hr", "input"}
RESOURCES = ("src", "href", "xlink:href", "action", "data", "poster", "srcset")


class Page(HTMLParser):
    """Text and references of a page; fails where tags do not match."""

    def __init__(self, html):
        super().__init__()
        self.open, self.text, self.references, self.ids = [], [], [], []
        self.scripts = []
        self.rows = 0
        self.feed(html)
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self._see(tag, attrs)
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self._see(tag, attrs)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] not in ("style", "script"):
            self.text.append(data)

    def _see(self, tag, attrs):
        assert tag not in ("link", "iframe", "object", "embed")
        if tag == "script":
            self.scripts.append(dict(attrs)["type"])
        self.rows += tag == "tr"
        for name, value in attrs:
            assert not name.startswith("on")
            if name in RESOURCES:
                self.references.append(value)
            if name == "id":
                self.ids.append(value)


@pytest.fixture(scope="module")
def html(good_result):
    return render(good_result)


@pytest.fixture(scope="module")
def page(html):
    return Page(html)


def renamed(result):
    """The result with hostile names of block, points, models, coverages and file."""
    block = replace(result.block, name=HOSTILE, sources={"low_flight": HOSTILE})
    first = result.models["model_id"].iloc[-1]
    return changed(
        result,
        block=block,
        # then no adjustment is made beside it, which needs the names of the flights
        settings=result.settings.updated({"iterations": 2}),
        points=result.points.assign(
            point_id=lambda p: p["point_id"].where(p["role"] == "new", HOSTILE)
        ),
        models=result.models.assign(
            model_id=lambda m: m["model_id"].replace(first, HOSTILE), reason=HOSTILE
        ),
        single_values=result.single_values.assign(
            coverage=lambda v: v["coverage"] + HOSTILE
        ),
        failures=pd.DataFrame(
            [["low_flight", HOSTILE, HOSTILE, "stage", HOSTILE, HOSTILE]],
            columns=result.failures.columns,
        ),
    )


def test_page_needs_nothing_else(page, html):
    assert all(reference.startswith("#") for reference in page.references)
    assert "url(" not in html
    assert "@import" not in html
    assert "@font-face" not in html
    # its own script, and data that no browser takes for one
    assert page.scripts == ["application/octet-stream", "module"]


def test_only_its_own_style_and_script_are_allowed(html):
    policy = re.search(r'Content-Security-Policy" content="([^"]+)"', html)[1]
    assert policy.startswith("default-src &#39;none&#39;")
    for tag in ("style>", 'script type="module">'):
        content = html[html.index(f"<{tag}") + len(tag) + 1 :]
        content = content[: content.index(f"</{tag.split()[0].rstrip('>')}>")]
        digest = hashlib.sha256(content.encode("utf-8")).digest()
        assert f"sha256-{base64.b64encode(digest).decode()}" in unescape(policy)


@pytest.mark.slow
def test_hostile_names_stay_text(good_result):
    html = render(renamed(good_result))
    page = Page(html)
    assert "<script>" not in html
    assert html.count("</script>") == len(page.scripts) == 2
    assert "".join(page.text).count(HOSTILE) >= 6


def test_page_has_verdict_problems_and_definitions(page, faulty_result):
    text = "".join(Page(render(faulty_result)).text)
    assert verdict_on(faulty_result.assessment) in text
    assert "3 of 30 models failed." in text
    assert "The figure of the paper neglects shared errors" in text
    assert "It reflects only the uncorrelated part of the error." in text
    assert "None." in page.text
    for figure in ("total", "m_g", "m_0", "s_0", "m_t", "spread_total", "residual"):
        assert figure in page.text


def test_all_models_are_on_the_page(page, good_result):
    for model in good_result.models.itertuples():
        assert model.model_id in page.text


def test_of_many_models_the_worst_are_shown_and_that_is_said(good_result):
    many = pd.concat([good_result.models] * 20, ignore_index=True)
    many["model_id"] = [f"M{k}" for k in range(len(many))]
    many.loc[7, ["is_usable", "reason", "m_0"]] = [
        False,
        "too few points",
        float("nan"),
    ]
    many.loc[8, "m_0"] = 9.0
    page = Page(render(judged_before(good_result, models=many)))
    assert "The worst 100 of 600 models; the tables have the others." in page.text
    shown = [text for text in page.text if re.fullmatch(r"M\d+", text)]
    assert len(shown) == 100
    assert shown[:2] == ["M7", "M8"]
    assert "failed: too few points" in page.text


def test_many_failures_are_cut_and_that_is_said(good_result):
    failures = pd.DataFrame(
        [["low_flight", "1", f"{k}", "stage", "reason", "remedy"] for k in range(300)],
        columns=good_result.failures.columns,
    )
    page = Page(render(judged_before(good_result, failures=failures)))
    assert "The first 200 of 300 failures; the tables have the others." in page.text


def test_ids_are_unique(page):
    assert len(page.ids) == len(set(page.ids))


def test_the_same_result_gives_the_same_page(good_result, html):
    assert render(good_result) == html


@pytest.mark.parametrize("name", ["given_approximations", "unchecked"])
def test_blocks_of_other_kinds_have_a_page(name, request):
    Page(render(request.getfixturevalue(f"{name}_result")))


@pytest.mark.slow
def test_a_block_without_points_has_a_page(good_result):
    result = changed(
        good_result,
        points=good_result.points.iloc[:0],
        figures=replace(good_result.figures, n_new=0, n_check=0, n_control=0),
    )
    assert "There are no new points." in Page(render(result)).text


@pytest.fixture(scope="module")
def oriented_result():
    """A block whose models are oriented from y-parallaxes, some near a danger."""
    geometry = replace(PRESETS["demo"].geometry, measurement="parallaxes")
    result = densify(simulate_block("demo", seed=1, geometry=geometry))
    rows = result.orientations.copy()
    rows.loc[3, ["verdict", "inflation", "reason"]] = ["weak", 2.5, "<a valley>"]
    rows.loc[5, ["verdict", "inflation", "reason"]] = ["critical", 99.0, "a cylinder"]
    return changed(result, orientations=rows)


@pytest.mark.slow
def test_relative_orientations_stand_worst_first(oriented_result):
    html = render(oriented_result)
    page = Page(html)
    assert "relative_orientation" in page.ids
    start = html.index('id="relative_orientation"')
    section = html[start : html.index("</section>", start)]
    assert "sigma_0 [µm]" in section
    places = [
        section.index(word) for word in ("a cylinder", "&lt;a valley&gt;", "safe")
    ]
    assert places == sorted(places)
    names = oriented_result.orientations["model_id"]
    assert section.index(f"<td>{names[5]}</td>") < section.index(f"<td>{names[3]}</td>")
    assert "µm of a y-parallax; it reflects y-parallax only." in section
    assert "near a dangerous surface: 1 model critical" in html


@pytest.mark.slow
def test_many_orientations_are_cut_short(oriented_result):
    rows = pd.concat([oriented_result.orientations] * 3, ignore_index=True)
    html = render(changed(oriented_result, orientations=rows))
    assert f"The worst 50 of {len(rows)} models; the tables have" in html


def test_no_section_without_orientations(page):
    assert "relative_orientation" not in page.ids
