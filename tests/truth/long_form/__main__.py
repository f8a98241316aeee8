"""Run all parts, or those that are named, and write their figures to docs/truth.md."""

import sys
from importlib import import_module
from pathlib import Path

PAGE = Path(__file__).parents[3] / "docs" / "truth.md"
PARTS = (
    *("precision", "spatial", "components", "gross", "claim", "blunders"),
    *("simultaneous", "deformation", "real_life", "planning", "area_plans"),
    "recommended_plans",
)
OPENING = """\
# Is the claimed precision true?

This page is written by `make truth`, which simulates blocks with known truth and
compares claimed and true errors. Every figure is followed by its Monte Carlo standard
error, from the scatter between blocks, since neighbouring points are correlated.
Figures with bounds must be known to 0.01. For a single part:
`python -m tests.truth.long_form gross`.
"""
# what is shown, in which part of the page, and its short form
SHOWN = (
    (
        "precision of points, and between neighbours",
        "precision",
        "propagated_precision",
    ),
    ("precision with spatial models", "spatial", "spatial_precision"),
    ("the propagated covariance, exactly", "–", "errors_of_one_block"),
    ("sizes of errors from the data", "components", "outliers_and_components"),
    ("gross errors in either flight", "gross", "gross_errors"),
    ("false alarms of every test, 10⁵ points", "–", "false_alarms"),
    ("claims that are rejected, and others", "claim", "claim"),
    ("one blunder each, and blocks without", "blunders", "blunders"),
    ("simultaneous adjustment, film", "simultaneous", "simultaneous_truth"),
    ("deformations that models share", "deformation", "model_deformation"),
    ("realistic disturbances", "real_life", "own_deformation"),
    ("given points that share errors", "real_life", "shared_errors"),
    ("relative orientation", "–", "relative_orientation"),
    ("precision expected in planning", "planning", "expected_precision"),
    ("flight plans over areas", "area_plans", "area_plans"),
    ("recommended plans", "recommended_plans", "recommended_plans"),
)


def main(names):
    """Run the parts one after the other.

    Parameters
    ----------
    names : sequence of str
        All where it is empty.

    Returns
    -------
    int
        Exit status: 0 passed, 1 a figure is out of its bounds, 2 no such part.
    """
    unknown = [name for name in names if name not in PARTS]
    if unknown:
        print(f"unknown part {unknown[0]}; expected {', '.join(PARTS)}")
        return 2
    passes = True
    for name in names or PARTS:
        tables = import_module(f"tests.truth.long_form.{name}").tables()
        print("\n\n".join(table.markdown() for table in tables), "\n", flush=True)
        passes = passes and all(table.passes for table in tables)
        written = PAGE.read_text("utf-8") if PAGE.exists() else ""
        PAGE.write_text(with_sections(written, name, tables), "utf-8")
    print("every figure holds" if passes else "a figure is out of its bounds")
    return 0 if passes else 1


def with_sections(page, part, tables):
    """The page with the sections of one part made new.

    Parameters
    ----------
    page : str
    part : str
    tables : list of Table

    Returns
    -------
    str
    """
    marks = {name: f"<!-- {name} -->" for name in PARTS}
    kept = {}
    for name, mark in marks.items():
        _, found, rest = page.partition(mark)
        if found:
            kept[name] = rest.split("<!-- ")[0].strip()
    kept[part] = "\n\n".join(table.markdown() for table in tables)
    sections = [f"{marks[name]}\n\n{kept[name]}" for name in PARTS if name in kept]
    return "\n\n".join([OPENING.rstrip(), _contents(), *sections]) + "\n"


def _contents():
    lines = ["| what is shown | part | short form |", "|---|---|---|"]
    lines += [f"| {what} | {part} | `test_{stem}` |" for what, part, stem in SHOWN]
    lines.append("| time and memory of the propagation | – | `make bench` |")
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
