"""The local page in a Chromium, by keyboard: opened, computed, planned, and ended."""

import shutil
import threading
from contextlib import suppress
from pathlib import Path
from urllib.request import Request, urlopen

import pytest
from tests.interfaces.local_page.chromium import PROGRAM, Chromium

from einschalt.interfaces.local_page import server

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(PROGRAM is None, reason="no Chromium is installed"),
]

# by make browser
AXE = Path(__file__).parents[3] / "node_modules" / "axe-core" / "axe.min.js"
AUDIT = """axe.run(document, { resultTypes: ["violations"], iframes: false }).then(
  ({ violations }) => violations.filter(({ impact }) => /serious|critical/.test(impact))
    .map(({ id, nodes }) => [id, nodes[0].html]))"""
CLIPPED = """[...document.querySelectorAll(".scroll, .cards th, .cards td")]
  .filter((one) => one.scrollWidth > one.clientWidth + 1)
  .map((one) => one.textContent.slice(0, 60))"""
PAGES = (
    *("/", "/block?path=nine", "/block?path=spoilt", "/new?path=tables", "/plan"),
    *("/batch", "/compare", "/result?path=first", "/compare?a=first&b=nine_results"),
    "/block?path=nothing",
)


@pytest.fixture
def served(root, make_block):
    """The address of a server with a sound block, a spoilt one, and tables."""
    for name in ("nine", "spoilt", "tables"):
        block = make_block(root / name)
    (block.path / "block.toml").unlink()
    spoilt = root / "spoilt" / "low_flight.csv"
    text = spoilt.read_text("utf-8").replace("1,11/12,0013,", "1,11/12,0013,x", 1)
    spoilt.write_text(text, encoding="utf-8")
    said, is_said = [], threading.Event()

    def say(line):
        said.append(line)
        if len(said) == 3:
            is_said.set()

    options = {"opens": False, "most_upload_mb": 10.0}
    thread = threading.Thread(
        target=server.serve, args=(root, say), kwargs=options, daemon=True
    )
    thread.start()
    assert is_said.wait(60.0)
    address = said[1].removeprefix("Open ")
    yield address, thread
    with suppress(OSError):  # it has been ended by the page
        quit_server(address)
    thread.join(60.0)
    assert not thread.is_alive()


def quit_server(address):
    own, _, key = address.partition("/?key=")
    cookie = f"einschalt-{own.rpartition(':')[2]}={key}"
    headers = {"Origin": own, "Cookie": cookie}
    urlopen(Request(f"{own}/quit", data=b"", headers=headers), timeout=10.0).close()


@pytest.fixture
def browser(served, tmp_path):
    """A Chromium on the first page."""
    one = Chromium(tmp_path / "profile")
    try:
        one.start()
        one.open(served[0])
        one.look(1280)
        one.until("document.querySelector('.entries')")
        one.own = served[0].partition("/?")[0]
        yield one
    finally:
        one.end()


def computed_by_keyboard(browser):
    browser.press("Tab")
    assert browser.value("document.activeElement.className") == "skip"
    browser.tab_to("nine")
    browser.press("Enter")
    browser.until("document.querySelector('[name=output]')")
    browser.tab_to("Compute the points")
    browser.press("Enter")
    browser.until("document.getElementById('cancel')")
    browser.until("document.querySelector('iframe.report')")
    browser.open(f"{browser.own}/report?path=nine_results")
    # it lives, in an origin of its own
    browser.until("document.documentElement.dataset.ready")
    assert browser.value("origin") == "null"


def dropped(browser, root):
    browser.open(f"{browser.own}/")
    browser.choose("#files", sorted((root / "tables").iterdir()))
    browser.until("location.pathname === '/new'")
    assert "model points: " in browser.value("document.body.innerText")


def planned(browser):
    browser.open(f"{browser.own}/plan")
    browser.until("document.querySelector('#map svg')")
    browser.tab_to("scale_number")
    figure = "document.querySelector('#figures dd').textContent"
    before = browser.value(figure)
    for _ in range(30):
        browser.press("Right")
    browser.until(f"{figure} !== {before!r}")
    browser.until("!document.querySelector('#map').classList.contains('old')")
    assert browser.value("document.querySelector('output').value") == "11000"


def test_the_page_is_worked_by_keyboard_and_asks_for_nothing_elsewhere(
    browser, root, served
):
    computed_by_keyboard(browser)
    dropped(browser, root)
    planned(browser)
    browser.value("document.querySelector('[action=\"/quit\"]').submit()")
    served[1].join(60.0)
    assert not served[1].is_alive()
    assert browser.errors == []
    elsewhere = [one for one in browser.requests if not one.startswith(browser.own)]
    assert [one for one in elsewhere if not one.startswith("about:")] == []


@pytest.fixture
def with_results(root, good_result):
    from einschalt.interfaces.files.result_folder import write_result

    write_result(good_result, root / "first")
    shutil.copytree(root / "first", root / "nine_results")


def computed_many(browser):
    """The page of a batch that was computed, with a block that failed."""
    browser.open(f"{browser.own}/batch")
    browser.value("document.querySelector('button.main').click()")
    browser.until("document.querySelector('#run[data-state=done]')")
    return browser.value("location.pathname")


def test_every_page_fits_a_phone_and_is_open_to_all(with_results, browser):
    for page in (*PAGES, computed_many(browser)):
        for width, dark in ((1280, False), (390, True)):
            browser.look(width, dark=dark)
            browser.open(f"{browser.own}{page}")
            browser.value("new Promise((done) => setTimeout(done, 200))")
            inner, wide = browser.value("[innerWidth, document.body.scrollWidth]")
            assert wide <= inner == width, page
            assert browser.value(CLIPPED) == [], page
            paper = browser.value(
                "getComputedStyle(document.documentElement).backgroundColor"
            )
            assert (paper == "rgb(255, 255, 255)") is not dark
            if AXE.exists():
                browser.value(f"{AXE.read_text('utf-8')}; 0")
                assert browser.value(AUDIT) == [], page
    # what is said of a page that is not there is no fault of the page
    assert {text[:23] for text in browser.errors} <= {"Failed to load resource"}
