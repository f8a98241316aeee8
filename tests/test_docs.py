"""The pages hold together: links lead somewhere, and no module lacks its page."""

import contextlib
import io
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
THEORY = ROOT / "src" / "einschalt" / "theory"
FOLDERS = ("docs", "pipelines", "data_examples")
BUILT = {"gallery", "recipes", "generated"}  # by make docs
PAGES = sorted(
    page
    for folder in FOLDERS
    for page in (ROOT / folder).rglob("*.md")
    if not BUILT & set(page.relative_to(ROOT).parts)
)
EXAMPLE = re.compile(r"```python\n(.*?)```\n\n```text\n(.*?)```", re.DOTALL)
THEORY_EXAMPLES = [
    (page.name, *example)
    for page in PAGES
    if page.parent.name == "theory"
    for example in EXAMPLE.findall(page.read_text(encoding="utf-8"))
]
REFERENCE = (ROOT / "docs" / "reference" / "index.md").read_text(encoding="utf-8")
CODE = re.compile(r"^```.*?^```$", re.DOTALL | re.MULTILINE)
LINK = re.compile(r"\]\(([^)\s]+)\)")


def headings(page):
    # comments of code are no headings
    lines = CODE.sub("", page.read_text(encoding="utf-8")).splitlines()
    titles = [line.lstrip("#").strip() for line in lines if line.startswith("#")]
    return {re.sub(r"[^\w\- ]", "", t.lower()).replace(" ", "-") for t in titles}


@pytest.mark.parametrize("page", PAGES, ids=lambda p: str(p.relative_to(ROOT)))
def test_links_lead_somewhere(page):
    for link in LINK.findall(page.read_text(encoding="utf-8")):
        if link.startswith("http"):
            continue
        target, _, heading = link.partition("#")
        linked = (page.parent / target).resolve() if target else page
        if linked.parent.name == "generated":  # by make docs: the reference lists them
            entry = f"generated/{linked.stem}"
            assert f"<{entry}>" in REFERENCE, link
            continue
        assert linked.exists(), link
        assert not heading or heading in headings(linked), link


def test_every_theory_module_has_a_page():
    overview = (ROOT / "docs" / "theory" / "README.md").read_text(encoding="utf-8")
    modules = [m for m in THEORY.rglob("*.py") if m.stem != "__init__"]
    assert modules
    for module in modules:
        dotted = ".".join(module.relative_to(THEORY).with_suffix("").parts)
        assert f"`{dotted}`" in overview


def test_the_overview_names_only_modules_that_are_there():
    overview = (ROOT / "docs" / "theory" / "README.md").read_text(encoding="utf-8")
    rows = [line.split("|")[2] for line in overview.splitlines() if line[:3] == "| ["]
    named = {name for row in rows for name in re.findall(r"`([\w.]+)`", row)}
    assert len(named) > 50
    for name in named:
        place = Path(*name.split("."))
        homes = (THEORY / place, THEORY.parent / place)
        assert any(h.is_dir() or h.with_suffix(".py").exists() for h in homes), name


def test_pages_that_the_code_names_exist():
    named = set()
    for module in (ROOT / "src").rglob("*.py"):
        named |= set(re.findall(r"docs/[\w/]+\.md", module.read_text(encoding="utf-8")))
    assert named
    assert not [page for page in sorted(named) if not (ROOT / page).exists()]


def test_german_stands_in_the_glossary_only():
    words = ("Einschaltpunkt", "Restklaffung", "Passpunkt", "Ausgleichung")
    for page in PAGES:
        # what stands in the tables of surveyors is said as it stands there
        is_of_tables = page.name in {"glossary.md", "tables.md"}
        if is_of_tables or "docs" not in page.relative_to(ROOT).parts:
            continue
        text = page.read_text(encoding="utf-8")
        assert not [word for word in words if word in text], page


def test_theory_has_examples():
    assert "transformation.md" in [page for page, *_ in THEORY_EXAMPLES]


@pytest.mark.parametrize(("page", "code", "printed"), THEORY_EXAMPLES)
def test_examples_print_what_stands_below_them(page, code, printed, monkeypatch):
    monkeypatch.chdir(ROOT)
    shown = io.StringIO()
    with contextlib.redirect_stdout(shown):
        exec(compile(code, page, "exec"), {})
    assert shown.getvalue() == printed
