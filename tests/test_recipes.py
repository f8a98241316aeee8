"""Every recipe in pipelines/ runs as it stands, and prints what it promises."""

import ast
import runpy
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
RECIPES = sorted((ROOT / "pipelines").glob("*.py"))
PRINTED = {
    "densify_block": ["approximate coordinates of 1190 points", "affine", "easting"],
    "densify_real_block": ["8811-9111", "8938-9111", "check", "351"],
    "transform_national_frames": ["767 points", "1450 triangles", "6697187.0009"],
    "simulate_and_compare": ["truth", "propagated", "formula of 1971"],
    "reproduce_kovarik_1971": ["0.1826", "17.89", "contradicts itself", "4c has the"],
    "finsterwalder_repetitions": ["25 repetitions", "Bachmann", "pass 20", "3.32"],
}


@pytest.mark.slow
@pytest.mark.parametrize("recipe", RECIPES, ids=lambda path: path.stem)
def test_recipe_runs_and_prints(recipe, monkeypatch, capsys):
    monkeypatch.chdir(ROOT)
    runpy.run_path(str(recipe), run_name="__main__")
    printed = capsys.readouterr().out
    for text in PRINTED[recipe.stem]:
        assert text in printed


@pytest.mark.parametrize("recipe", RECIPES, ids=lambda path: path.stem)
def test_recipe_is_short_and_has_no_logic(recipe):
    text = recipe.read_text(encoding="utf-8")
    assert len(text.splitlines()) <= 40
    decisions = (ast.If, ast.While, ast.Try, ast.FunctionDef, ast.ClassDef)
    assert not [
        node for node in ast.walk(ast.parse(text)) if isinstance(node, decisions)
    ]


def test_every_recipe_is_listed():
    listed = (ROOT / "pipelines" / "README.md").read_text(encoding="utf-8")
    for recipe in RECIPES:
        assert f"({recipe.name})" in listed
