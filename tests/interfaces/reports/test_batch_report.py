"""The page of a batch: what files say in it is text, and stays on its line."""

from html.parser import HTMLParser

import pytest

from einschalt.interfaces.reports.batch_report import render_batch
from einschalt.pipeline.batch.block_table import blocks_table

HOSTILE = "<script>alert(1)</script>\x1b[2J"


class Page(HTMLParser):
    """Tags, links and text of a page."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.links, self.text = set(), [], ""
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attributes):
        self.tags.add(tag)
        self.links += [value for name, value in attributes if name in {"href", "src"}]

    def handle_data(self, data):
        self.text += data


@pytest.fixture
def page():
    figures = {"n_points": 9, "seconds": 1.5, "n_suspects": 0, "n_failed_models": 0}
    errors = {"standard_error_total": 0.0634, "standard_error_paper": 0.02}
    moved = {"n_moved": 3, "largest_move": 1.25}
    names = [HOSTILE, "javascript:alert(1)", "../up", 'a" onclick="b', "2024/west"]
    rows = [
        {"block": name, "outcome": "done", **figures, **errors, **moved}
        for name in names
    ]
    said = {"stage": "reading", "reason": f"{HOSTILE} is no number"}
    failures = [("one", f"Mend {HOSTILE}"), ("two", "Did you mean 'a.csv'?")]
    for name, remedy in failures:
        row = {"block": name, "outcome": "failed", **said, "remedy": remedy}
        rows.append(row)
    return Page(render_batch(blocks_table(rows)))


def test_a_long_name_is_broken_and_pushes_no_figures_aside():
    row = {"block": "l" * 255, "outcome": "done", "seconds": 1.0}
    text = render_batch(blocks_table([row]))
    rule = text.partition("\ntbody th { white-space: normal;")[2].partition("}")[0]
    assert "overflow-wrap: anywhere" in rule
    assert "max-width" in rule


def test_what_files_say_is_text(page):
    assert "script" not in page.tags
    assert page.text.count("<script>alert(1)</script>") >= 4
    assert not [char for char in page.text if not (char.isprintable() or char == "\n")]


def test_links_lead_to_reports_below(page):
    assert page.links == [
        "%3Cscript%3Ealert%281%29%3C/script%3E%1B%5B2J/report.html",
        "javascript%3Aalert%281%29/report.html",
        "../up/report.html",
        "a%22%20onclick%3D%22b/report.html",
        "2024/west/report.html",
    ]


def test_failures_end_with_one_full_stop(page):
    assert (
        "(reading): <script>alert(1)</script>\\x1b[2J is no number. Mend" in page.text
    )
    assert "Did you mean 'a.csv'?\n" in page.text
    assert "?." not in page.text


def test_figures_have_one_unit(page):
    assert "6.3 cm" in page.text
    assert "largest move [m]" in page.text
    assert "7 blocks: 5 done, 2 failed" in page.text
