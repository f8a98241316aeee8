"""The local page in German: complete, in pages, answers for scripts and refusals."""

import asyncio
import json
import re
import shutil

import pytest
from tests.pipeline.summary.test_german_summary import DATA, ENGLISH

from einschalt.foundations.language import written_in
from einschalt.interfaces.files.result_folder import write_result

PAGES = (
    *("/", "/?path=deep", "/block?path=nine", "/block?path=spoilt", "/new?path=tables"),
    *("/plan", "/plan?camera=uav_one_inch&n_coverages=1", "/batch", "/compare"),
    *("/result?path=first", "/compare?a=first&b=second", "/block?path=nothing"),
    *("/block?path=../secret", "/nothing", "/run/7", "/drop/3", "/new?path=deep"),
)


@pytest.fixture(scope="module")
def written(tmp_path_factory, good_result):
    """A folder with a result, to be copied."""
    folder = tmp_path_factory.mktemp("written") / "result"
    write_result(good_result, folder)
    return folder


@pytest.fixture
def german(visit, root, make_block, written):
    """A visitor whose pages are German, with blocks, tables and results."""
    for name in ("nine", "spoilt", "tables"):
        block = make_block(root / name)
    (block.path / "block.toml").unlink()
    spoilt = root / "spoilt" / "low_flight.csv"
    text = spoilt.read_text("utf-8").replace("1,11/12,0013,", "1,11/12,0013,x", 1)
    spoilt.write_text(text, encoding="utf-8")
    (root / "deep" / "deeper").mkdir(parents=True)
    for name in ("first", "second"):
        shutil.copytree(written, root / name)
    with written_in("de"):
        yield visit(root)


def words_of(html):
    """What is read of a page, labels and data for its scripts among it."""
    text = re.sub(r"<(style|script).*?</\1>|<[^>]*>", " ", html, flags=re.DOTALL)
    label = r'(?:aria-label|title|data-[a-z-]+|placeholder)="([^"]*)"'
    return " ".join([text, *re.findall(label, html)])


def english_in(text):
    return ENGLISH.findall(DATA.sub("", text.replace("Nine points", "")))


@pytest.mark.parametrize("page", PAGES)
def test_no_english_is_left_in_a_german_page(german, page):
    html = german.get(page).text
    assert '<html lang="de">' in html
    assert english_in(words_of(html)) == []


def test_answers_for_scripts_and_refusals_are_german(german):
    for address in ("/plan/figures", "/plan/map", "/plan/figures?n_coverages=1"):
        answer = json.loads(german.get(address).text)
        shown = [answer["said"], *(text for _, text in answer.get("figures", ()))]
        labels = re.findall(r'aria-label="([^"]*)"', answer.get("svg", ""))
        assert english_in(" ".join([*shown, *labels])) == []
    page = german.get("/plan?m_g_um=7.5").text
    assert "7,5 µm</output>" in page
    assert 'value="7.5"' in page  # as browsers read it
    german.session.drops.most_bytes = 5
    refused = german.put("/drop/1/a.csv", [b"0123456789"])
    assert english_in(refused.text) == []
    for headers in ({"host": "elsewhere"}, {"cookie": None}):
        assert english_in(german.get("/", **headers).text) == []


def test_fields_have_figures_as_germans_type_them(german):
    page = german.get("/new?path=tables").text
    assert 'name="high_flight.m_g_um" value="7,5"' in page
    # a field begins as a sentence, whatever the question is on a terminal
    labels = re.findall(r"<label>(\w)", page)
    assert labels == [letter.upper() for letter in labels]
    block = german.get("/block?path=nine").text
    assert "MGI / Austria GK" in block  # the system by its name


@pytest.mark.slow
def test_a_run_speaks_german_and_so_does_its_report(german, root):
    page = german.post("/start", {"path": "nine", "output": "out"})
    assert page.status == 303
    run = german.session.runs.get(1)
    assert english_in(words_of(german.get("/run/1").text)) == []
    run._reader.join(300.0)
    assert run.state == "done", run.problems
    assert '<html lang="de">' in (root / "out" / "report.html").read_text("utf-8")
    german.post("/start", {"path": "spoilt", "output": "out2"})
    run = german.session.runs.get(2)
    run._reader.join(300.0)
    assert run.state == "failed"
    assert "Zeile 3, Punkt 0013" in run.problems[0]
    page = german.get("/run/2").text
    assert english_in(words_of(page)) == []


def test_threads_of_the_server_keep_the_language(german):
    """What is computed beside the server is in the language of its start."""
    from einschalt.foundations.language import language
    from einschalt.interfaces.local_page.pages import worked

    assert asyncio.run(worked(language)) == "de"
