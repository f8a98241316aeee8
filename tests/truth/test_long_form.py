"""The judge of the long form; its studies are run by ``make truth``."""

import re
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]


@pytest.fixture
def part(monkeypatch):
    monkeypatch.syspath_prepend(ROOT)
    return lambda name: import_module(f"tests.truth.long_form.{name}")


def test_error_of_a_ratio_is_its_scatter(part):
    # blocks of correlated points: sums with a common factor in each block
    rng = np.random.default_rng(0)
    ratio = part("figures").ratio
    found = []
    for _ in range(400):
        sizes = rng.integers(50, 150, 60).astype(float)
        sums = sizes * (2.0 + 0.3 * rng.standard_normal(60))
        found.append(ratio(sums, sizes))
    values = np.array([f.value for f in found])
    # 400 draws know a standard deviation to 3.5 %
    claimed = np.mean([f.error for f in found])
    assert claimed == pytest.approx(values.std(ddof=1), rel=0.12)
    assert values.mean() == pytest.approx(2.0, abs=0.01)


def test_root_of_a_ratio(part):
    figures = part("figures")
    plain = figures.ratio([4.1, 3.9, 4.4], [1.0, 1.0, 1.1])
    root = figures.root_of_ratio([4.1, 3.9, 4.4], [1.0, 1.0, 1.1])
    assert root.value == pytest.approx(np.sqrt(plain.value))
    assert root.error == pytest.approx(plain.error / (2 * np.sqrt(plain.value)))


@pytest.mark.parametrize(
    ("value", "error", "passes"),
    [(1.0, 0.005, True), (1.04, 0.005, False), (1.0, 0.02, False)],
)
def test_a_figure_passes_within_its_bounds_and_if_it_is_known(
    part, value, error, passes
):
    figure = part("figures").Figure(value, error, low=0.97, high=1.03)
    assert figure.passes is passes
    assert str(figure).endswith("**out**") is not passes


def test_sections_of_one_part_are_made_new(part):
    main, figures = part("__main__"), part("figures")

    def table(value):
        row = ("a", figures.Figure(value))
        return figures.Table("Title", "What it shows.", ("head", "figure"), [row])

    page = main.with_sections("", "components", [table(1.0)])
    page = main.with_sections(page, "precision", [table(2.0)])
    page = main.with_sections(page, "precision", [table(3.0)])
    assert page.count("## Title") == 2
    assert page.index("| a | 3.000 |") < page.index("| a | 1.000 |")
    assert "2.000" not in page


def test_the_page_holds_every_part_and_no_figure_is_out(part):
    page = (ROOT / "docs" / "truth.md").read_text(encoding="utf-8")
    assert tuple(re.findall(r"<!-- (\w+) -->", page)) == part("__main__").PARTS
    assert "**out**" not in page


def test_every_short_form_exists(part):
    stems = [stem for *_, stem in part("__main__").SHOWN]
    tests = Path(__file__).parent
    assert [s for s in stems if not (tests / f"test_{s}.py").exists()] == []


def test_unknown_part():
    done = subprocess.run(
        [sys.executable, "-m", "tests.truth.long_form", "faith"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert "unknown part faith; expected precision" in done.stdout
