"""``--language``: what users read is in their language, what machines read is not."""

import inspect

import pytest
from typer.main import get_command

from einschalt.foundations.column_meanings import MEANINGS, meaning_of
from einschalt.foundations.language import catalogue, written_in
from einschalt.interfaces.batch.batch_run import plan_batch
from einschalt.interfaces.batch.block_run import run_block
from einschalt.interfaces.cli import progress
from einschalt.interfaces.cli.commands import told_help
from einschalt.interfaces.cli.explained_findings import explained_finding
from einschalt.interfaces.cli.main import COMMANDS, app
from einschalt.pipeline.assessment.findings.kinds import KINDS

DATA = ("points.csv", "models.csv", "failures.csv", "residuals.csv", "assessment.json")


def test_the_option_goes_before_the_locale(invoke, block_folder, monkeypatch):
    monkeypatch.setenv("LANG", "de_AT.UTF-8")
    shown = invoke("check", block_folder)
    assert shown.stdout == f"{block_folder}: nichts falsch\n"
    shown = invoke("check", block_folder, "--language", "en")
    assert shown.stdout == f"{block_folder}: nothing wrong\n"


@pytest.mark.slow
def test_german_results_have_the_same_data(invoke, block_folder, tmp_path, monkeypatch):
    monkeypatch.setattr(progress, "PATIENCE", 0.0)
    for language in ("en", "de"):
        output = ("--output", tmp_path / language)
        shown = invoke("densify", block_folder, *output, "--language", language)
        assert shown.exit_code == 0
    assert "Modelltransformation" in shown.stderr
    assert f"Ergebnisse in {tmp_path / 'de'}, Bericht in" in shown.stdout
    english, german = tmp_path / "en", tmp_path / "de"
    assert (german / "summary.txt").read_text("utf-8") in shown.stdout
    assert '<html lang="de">' in (german / "report.html").read_text("utf-8")
    for name in DATA:
        assert (german / name).read_bytes() == (english / name).read_bytes(), name


def test_workers_write_in_the_language_of_the_batch(make_block, tmp_path):
    make_block(tmp_path / "blocks" / "one")
    with written_in("de"):
        plan = plan_batch([tmp_path / "blocks" / "one"], tmp_path / "out")
    (task,) = plan.to_run
    assert run_block(task)["outcome"] == "done"  # as in a process of its own
    summary = (tmp_path / "out" / "one" / "summary.txt").read_text("utf-8")
    assert "Probleme und Vorschläge" in summary


def test_errors_are_told_in_german_and_reported_in_english(invoke, tmp_path):
    shown = invoke("densify", tmp_path, "--output", tmp_path / "o", "--language", "de")
    assert shown.exit_code == 2
    assert "Ordner enthält kein block.toml; erwartet: ein Ordner mit" in shown.stderr
    shown = invoke("check", tmp_path / "nowhere", "--language", "de", "--json")
    assert '"found": "there is no such folder or file"' in shown.stdout


def test_an_unknown_language_is_refused(invoke, block_folder):
    shown = invoke("check", block_folder, "--language", "fr")
    assert shown.exit_code == 2
    assert "--language = 'fr'; expected en or de." in shown.stderr


def test_plans_are_told_in_german(invoke):
    shown = invoke("plan", "--expect", "--spacing", "300", "--language", "de")
    assert "Neupunkten: " in shown.stdout
    assert "Passpunkte mit halb so großem Fehler" in shown.stdout
    shown = invoke("plan", "--target", "0.05", "--m-g-um", "0.001", "--language", "de")
    assert "erwartet: 0,05 bis 500 Mikrometer im Bild" in shown.stderr


def test_a_new_block_is_commented_in_german(invoke, block_folder, tmp_path):
    names = ("control_points.csv", "high_flight.csv", "low_flight.csv")
    files = [block_folder / name for name in names]
    new = ("init", tmp_path / "new", "--language", "de", "--from", *files)
    shown = invoke(*new)
    assert "keine Datei gibt an: Bezugssystem der Koordinaten" in shown.stderr
    shown = invoke(*new, "--yes")
    assert "Modelle im Vergleich mit dem Gelände: 1:15" in shown.stdout
    text = (tmp_path / "new" / "block.toml").read_text("utf-8")
    assert "# angenommen, da keine Datei es angibt" in text


def test_words_are_explained_in_german(invoke):
    shown = invoke("explain", "standard_error_total", "--language", "de").stdout
    assert "neighbours (Ergebnis): beider Differenzen, Punktfehler [m]" in shown
    shown = invoke("explain", "exchanged_names", "--language", "de").stdout
    assert "betrifft: Messung; Schwere: schwer" in shown


@pytest.mark.parametrize("code", KINDS)
def test_no_finding_is_explained_in_english(code):
    with written_in("de"):
        german = explained_finding(code).splitlines()
    english = explained_finding(code).splitlines()
    assert not set(german) & set(english)


@pytest.mark.parametrize("column", MEANINGS)
def test_every_column_has_a_german_meaning(column):
    _, meaning = meaning_of(column)
    assert meaning in catalogue("de")._catalog


def test_the_language_may_stand_before_the_command(invoke, block_folder):
    shown = invoke("--language", "de", "check", block_folder)
    assert shown.stdout == f"{block_folder}: nichts falsch\n"
    shown = invoke("--language=de", "check", block_folder, "--language", "en")
    assert shown.stdout == f"{block_folder}: nothing wrong\n"


@pytest.mark.parametrize("command", COMMANDS)
def test_no_help_is_left_in_english(command):
    imported = get_command(app).get_command(None, command)
    said = [imported, *imported.params]
    texts = [one.help for one in said if getattr(one, "help", None)]
    texts = [inspect.cleandoc(text) for text in (*texts, COMMANDS[command])]
    defaults = [getattr(one, "show_default", None) for one in imported.params]
    texts += [text for text in defaults if isinstance(text, str)]
    with written_in("de"):
        assert not [text for text in texts if told_help(text) == text]


def test_help_is_in_the_language_asked_for(invoke):
    shown = invoke("--language", "de", "plan", "--help").stdout
    assert "Aufruf: einschalt plan [OPTIONEN]" in shown
    assert "[Vorgabe: (jene der\n" in shown
    assert "Beispiele:\n    einschalt plan\n" in shown
    assert "Bildpaare orientieren" in invoke("--help", "--language", "de").stdout


def test_mistaken_calls_are_told_in_german(invoke):
    for words, told in {
        ("plan", "--max-heigt", "3"): "hat keine Option --max-heigt",
        ("plna",): "hat keinen Befehl 'plna'; erwartet: demo, init",
        ("plan", "--where", "x"): "--where = 'x'; erwartet: everywhere, edge oder",
        ("plan", "--spacing", "3foot"): "'3foot' hat eine unbekannte Einheit",
        ("check",): "Aufruf: einschalt check",
    }.items():
        shown = invoke("--language", "de", *words)
        assert shown.exit_code == 2
        assert told in shown.output
        assert "Error" not in shown.output


@pytest.mark.usefixtures("in_this_process")
def test_simulations_and_exports_are_told_in_german(invoke, tmp_path):
    repeated = ("simulate", "--preset", "demo", "--repeat", "2", "--output", tmp_path)
    shown = invoke("--language", "de", *repeated).stdout
    assert shown.startswith("2 Wiederholungen, Neupunkte (Punktfehler, RMS)\n")
    shown = invoke("--language", "de", "export", tmp_path, "--to", tmp_path / "a.foo")
    assert "Endung „.foo“ ist unbekannt" in shown.stderr


def test_transformations_are_told_in_german(invoke, tmp_path):
    (tmp_path / "old.csv").write_text(
        "point_id,x,y\na,0,0\nb,100,0\nc,0,100\nd,90,90\n"
    )
    (tmp_path / "new.csv").write_text(
        "point_id,easting,northing\na,0,0.01\nb,100,0\nc,0,100\nd,90,90\n"
    )
    files = [tmp_path / name for name in ("old.csv", "new.csv")]
    output = ("--output", tmp_path / "out", "--kind", "helmert")
    shown = invoke("--language", "de", "transform", *files, *output)
    assert "Transformation helmert von 1 von 1 Modellen, 4 Punkte" in shown.stdout
    assert "Anmerkung: old.csv hat keine Spalte model_id" in shown.stderr
    shown = invoke("--language", "de", "publish", tmp_path / "out", "--as", "1")
    assert "der Name einer Veröffentlichung ist '1'; erwartet: ein" in shown.stderr
