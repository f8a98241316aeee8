"""Pictures of the report and of the local page: ``python -m tests.screenshots``.

They go into out/screenshots: each on a phone and on two screens, light and dark, in
English and German; the report on both papers as well. Wants Chromium (make browser).
"""

import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from tests.interfaces.local_page.chromium import PATIENCE, Chromium

import einschalt as es
from einschalt.foundations.language import LANGUAGES, written_in
from einschalt.interfaces.files.result_folder import write_result
from einschalt.interfaces.reports.html_report import render
from einschalt.interfaces.reports.pdf_printer import pdf_of

ROOT = Path(__file__).parents[1]
OUTPUT = ROOT / "out" / "screenshots"
BLOCKS = ("neukirchen", "sxb_strasbourg")
PAPERS = ("A4", "letter")
LOOKS = ((390, True), (390, False), (768, False), (1280, True), (1280, False))
PAGES = {
    "open": ("/", ".entries"),
    "block": ("/block?path=sxb_strasbourg", "#compute"),
    "plan": ("/plan", "#map svg"),
    "batch": ("/batch", "form.fields"),
    "compare": ("/compare?a=first&b=second", ".drawing"),
    "result": ("/result?path=first", "iframe.report"),
}
REST = 0.3  # seconds in which widths settle


def main():
    """Take all of them."""
    shutil.rmtree(OUTPUT, ignore_errors=True)
    OUTPUT.mkdir(parents=True)
    with tempfile.TemporaryDirectory() as scratch:
        served = Path(scratch, "blocks")
        results = _results(served)
        browser = Chromium(Path(scratch, "profile"))
        try:
            browser.start()
            for language in LANGUAGES:
                _take_reports(browser, results, language, Path(scratch))
                _take_pages(browser, served, language)
        finally:
            browser.end()
    sys.stdout.write(f"{len(list(OUTPUT.iterdir()))} files in {OUTPUT}\n")


def _results(served):
    """Results by block; two of them, and the blocks, in the folder that is served."""
    results = {}
    for name in BLOCKS:
        shutil.copytree(ROOT / "data_examples" / name, served / name)
        results[name] = es.densify(es.read_block(served / name))
    first = results["neukirchen"]
    settings = first.settings.model_copy(update={"method": "simultaneous"})
    write_result(first, served / "first")
    write_result(es.densify(first.block, settings), served / "second")
    return results


def _take_reports(browser, results, language, scratch):
    for name, result in results.items():
        with written_in(language):
            page = scratch / f"{name}_{language}.html"
            page.write_text(render(result), encoding="utf-8")
            for paper in PAPERS:
                printed = pdf_of(render(result, paper=paper))
                file = OUTPUT / f"report_{name}_{language}_{paper.lower()}.pdf"
                file.write_bytes(printed)
        title = f"report_{name}_{language}"
        _take(browser, page.as_uri(), "html[data-ready='1']", title)


def _take_pages(browser, served, language):
    command = [sys.executable, "-m", "einschalt", "--language", language]
    server = subprocess.Popen(
        [*command, "serve", served, "--no-browser"], stdout=subprocess.PIPE, text=True
    )
    try:
        said = [server.stdout.readline() for _ in range(3)]
        address = re.search(r"http://\S+", "".join(said))[0]
        browser.open(address)
        browser.until("document.querySelector('.entries')")
        for name, (page, sign) in PAGES.items():
            own = address.partition("/?")[0]
            _take(browser, f"{own}{page}", sign, f"page_{name}_{language}")
    finally:
        server.terminate()
        server.wait(PATIENCE)
        server.stdout.close()


def _take(browser, address, sign, title):
    """Pictures of a page in all looks, when it has what a CSS selector finds."""
    for width, is_dark in LOOKS:
        browser.look(width, dark=is_dark)
        browser.open(address)
        browser.until(f'document.querySelector("{sign}")')
        time.sleep(REST)
        scheme = "dark" if is_dark else "light"
        browser.picture(OUTPUT / f"{title}_{width}_{scheme}.png")


if __name__ == "__main__":
    main()
