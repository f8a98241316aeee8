"""What users of other command lines expect of every command."""

import json
import os
import re
import shutil
import subprocess
import sys

import pandas as pd
import pytest
import typer
from typer.testing import CliRunner

import einschalt as es
from einschalt.interfaces.cli import lengths
from einschalt.interfaces.cli.main import COMMANDS, app
from einschalt.interfaces.cli.plan_values import costs_of
from einschalt.interfaces.cli.wrong_calls import WrongValueError
from einschalt.interfaces.files.glossary import entries

KEYS = ["command", "status", "problems", "paths", "figures"]


@pytest.fixture(scope="module")
def help_of():
    runner = CliRunner()

    def call(name, width):
        words = [*filter(None, [name]), "--help"]
        return runner.invoke(app, words, env={"COLUMNS": str(width)}).output

    return call


def parts_of(text):
    return [part for part in re.split(r"\s+|(?<=,)", text) if part]


@pytest.mark.parametrize("language", ["en", "de"])
@pytest.mark.parametrize("name", COMMANDS)
def test_the_help_of_options_fits_into_narrow_terminals(name, language):
    """It was written for 50 columns, which terminals of 40 cut inside words."""
    words = ["--language", language, name, "--help"]
    for width in (40, 60, 80):
        shown = CliRunner().invoke(app, words, env={"COLUMNS": str(width)}).output
        # names and their words, and calls to be copied, stand on lines of their own
        said = [line for line in shown.splitlines() if line.startswith(" " * 8)]
        said = [line for line in said if not line.startswith("        --")]
        assert max(map(len, said)) <= width


@pytest.mark.parametrize("name", ["", *COMMANDS])
def test_help_is_never_cut_inside_a_word(name, help_of):
    """Lists of numbers and names may be broken behind a comma."""
    words = parts_of(help_of(name, 1000))
    for width in (40, 50, 60, 70, 80, 90, 120):
        shown = help_of(name, width)
        assert parts_of(shown) == words, width
        if width > 60:  # names of options and their words may be longer than a line
            assert max(map(len, shown.splitlines())) <= max(width, 80)


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_has_the_options_of_all(name, help_of):
    shown = help_of(name, 80)
    assert "--json" in shown
    assert "--verbose" in shown
    assert "-v" in shown


def said(shown):
    """The one object on standard output."""
    (line,) = shown.stdout.splitlines()
    found = json.loads(line)
    assert list(found) == KEYS
    assert found["status"] == shown.exit_code
    return found


@pytest.fixture(scope="module")
def transformed(invoke, tmp_path_factory):
    """Four points of a model and of the ground, and their transformation."""
    folder = tmp_path_factory.mktemp("transformed")
    points = [("a", 0, 0), ("b", 1, 0), ("c", 0, 1), ("d", 1, 1)]
    model = "".join(f"{name},{x},{y}\n" for name, x, y in points)
    ground = "".join(f"{n},{100 + 2 * x},{200 + 2 * y}\n" for n, x, y in points)
    files = folder / "model.csv", folder / "ground.csv"
    files[0].write_text(f"point_id,x,y\n{model}", encoding="utf-8")
    files[1].write_text(f"point_id,easting,northing\n{ground}", encoding="utf-8")
    return invoke("transform", *files, "--output", folder / "out", "--json"), folder


def test_a_result_is_one_object_and_its_text_is_beside(transformed):
    shown, folder = transformed
    found = said(shown)
    assert (found["command"], found["status"]) == ("transform", 0)
    assert found["paths"] == [str(folder / "out")]
    assert found["figures"]["n_usable"] == 1
    assert found["figures"]["m_0"] < 1e-9
    assert "affine transformation of 1 of 1 models" in shown.stderr


def test_a_sound_block_has_its_models_and_no_problem(invoke, block_folder):
    figures = said(invoke("check", block_folder, "--json"))["figures"]
    table = pd.concat(
        [pd.read_csv(block_folder / f"{name}_flight.csv") for name in ("high", "low")],
        keys=["high", "low"],
    )
    names = table.reset_index(level=0)[["level_0", "coverage", "model_id"]]
    assert figures["n_models"] == len(names.drop_duplicates())
    assert figures["n_problems"] == figures["n_model_problems"] == 0


def test_notes_are_told_whole(invoke, block_folder, tmp_path):
    folder = shutil.copytree(block_folder, tmp_path / "noted")
    control = folder / "control_points.csv"
    lines = control.read_text(encoding="utf-8").splitlines()
    lines = [f"{lines[0]},Bemerkung", *(f"{line},Bolzen" for line in lines[1:])]
    control.write_text("\n".join(lines), encoding="utf-8")
    figures = said(invoke("check", folder, "--json"))["figures"]
    assert figures["notes"] == ["control_points.csv: ignored column Bemerkung"]
    assert figures["n_notes"] == 1


def test_a_fault_is_told_by_its_parts(invoke, spoilt_folder, tmp_path):
    found = said(invoke("check", spoilt_folder, "--json"))
    assert found["status"] == 2
    assert found["figures"]["n_problems"] == len(found["problems"]) > 1
    (first, *_) = (one for one in found["problems"] if one["row"] == 5)
    assert first["file"] == "low_flight.csv"
    assert "n/a" in first["found"]
    assert first["expected"]
    lost = said(invoke("densify", tmp_path / "no", "-o", tmp_path / "o", "--json"))
    assert lost["problems"][0]["found"]
    assert lost["paths"] == []


@pytest.mark.parametrize("name", COMMANDS)
def test_a_wrong_call_is_an_object_too(name, invoke):
    found = said(invoke(name, "--json", "--no-such-option"))
    assert (found["command"], found["status"]) == (name, 2)
    (problem,) = found["problems"]
    assert problem["found"] == f"einschalt {name} has no option --no-such-option"
    assert problem["expected"] == "one that its help lists"
    assert problem["remedy"] == f"See einschalt {name} --help"


@pytest.mark.parametrize("words", [("explain", "all"), ("completion", "bash")])
def test_what_is_printed_is_in_the_object(words, invoke):
    figures = said(invoke(*words, "--json"))["figures"]
    assert "point_id" in figures.get("columns", "") or "complete" in figures["script"]


def test_prices_that_plan_takes_by_default_are_the_usual_ones():
    plan = typer.main.get_command(app).get_command(None, "plan")
    (costs,) = (one for one in plan.params if one.name == "costs")
    assert costs_of(costs.default) == es.PlanCosts()


@pytest.mark.slow
def test_headline_figures(invoke, block_folder, tmp_path):
    done = invoke("densify", block_folder, "-o", tmp_path / "out", "--json", "-v")
    figures = said(done)["figures"]
    assert figures["block"] == "Demo (simulated)"
    assert 0.01 < figures["credible"] < 0.2
    assert isinstance(figures["claim_is_supported"], bool | None)
    assert "overwrite = False" in done.stderr
    assert re.search(r"einschalt \S+, Python \S+: \d+\.\d\d s", done.stderr)
    plan = said(invoke("plan", "--spacing", "300m", "--scale-number", 8000, "--json"))
    rows = plan["figures"]["combinations"]
    assert len(rows) > 1
    assert {row["spacing"] for row in rows} == {300.0}


@pytest.mark.parametrize(
    ("text", "wrong"),
    [
        *[("10yd", "10yd"), ("10yd,20yd", "10yd"), ("1m, 2 feet ,3m", "2 feet")],
        *[("68x105feet", "105feet"), ("10px x 20cm", "10px"), ("100:300:5yd", "5yd")],
        *[("1x2px", "2px"), ("3yd x", "3yd")],
    ],
)
def test_an_unknown_unit_is_named_in_a_list_too(text, wrong):
    with pytest.raises(WrongValueError, match=f"^{wrong!r} has a unit that is not"):
        lengths.in_unit(text, "m")


@pytest.mark.parametrize(
    ("text", "unit", "number"),
    [
        *[("5cm", "m", 0.05), ("250m", "m", 250.0), ("3 mm", "m", 0.003)],
        *[("0.3km", "m", 300.0), ("0.05", "m", 0.05), ("15.2cm", "mm", 152.0)],
        *[("7.5um", "µm", 7.5), ("7.5µm", "µm", 7.5), ("0.01mm", "µm", 10.0)],
        *[("400ft", "m", 121.92), ("1 ft", "mm", 304.8)],
    ],
)
def test_lengths_have_the_unit_that_is_written(text, unit, number):
    assert float(lengths.in_unit(text, unit)) == pytest.approx(number, rel=1e-12)


def test_numbers_have_decimal_commas_too(invoke):
    def table(*words):
        return invoke("plan", "--scale-number", "8000", *words)

    plain = table("--m-0", "0.1,0.2", "--principal-distance", "152.5")
    assert "152.5 mm" in plain.output
    comma = table("--m-0", "0,1;0,2", "--principal-distance", "15,25cm")
    assert comma.output == plain.output
    for words in (("--m-0", "0,1"), ("--m-0=0,1m",)):
        refused = table(*words)
        assert refused.exit_code == 2
        assert "--m-0: '0,1" in refused.output
        assert "may be two numbers or one; expected decimals" in refused.output
    # five metres are no precision of control points, but five centimetres forgotten
    refused = invoke("plan", "--target", "5,5", "--json")
    assert said(refused)["problems"][0]["expected"] == "0.0001 to 1 metres"


@pytest.mark.parametrize(
    "text",
    ["7,5", "7,5um", "10,5", "5,5", "12,5 µm", "300,50", "3,05", "0,125", "2,5", "5,8"],
)
def test_two_numbers_that_may_be_one_are_refused(text, invoke):
    point, both = text.replace(",", "."), text.replace(",", ";")
    for words in (("--m-g-um", text), (f"--m-g-um={text}",)):
        refused = invoke("plan", *words)
        assert refused.exit_code == 2
        said = " ".join(refused.stderr.split())
        assert f"--m-g-um: '{text}' may be two numbers or one; expected" in said
        assert said.endswith(f" Write '{point}' or '{both}'.")


@pytest.mark.parametrize(
    ("text", "meant"),
    [
        *[("200,300", "200,300"), ("5,10", "5,10"), ("8000,10000", "8000,10000")],
        *[("10,5,3", "10,5,3"), ("10m,5m", "10,5"), ("10.0,5", "10.0,5")],
        *[("10, 5", "10,5"), ("10;5", "10,5"), ("7,5;10,5", "7.5,10.5")],
        *[("7.5", "7.5"), ("300,250", "300,250"), ("20,30cm", "0.2,0.3")],
    ],
)
def test_lists_stay_lists(text, meant):
    given = lengths.with_numbers(["--spacing", text], {"--spacing": ("m", False)})
    assert given == ["--spacing", meant]


def test_lists_of_whole_numbers_have_no_decimals():
    plan = typer.main.get_command(app).get_command(None, "plan")
    words = ["--n-settings", "2,1", "--n-coverages", "1,2", "--control-per-model=5,9"]
    context = plan.make_context("plan", list(words))
    given = [context.params[name] for name in sorted(lengths.WHOLE_NUMBERS)]
    assert given == [["5,9"], ["1,2"], ["2,1"]]
    with pytest.raises(Exception, match="'2,5' may be two numbers or one"):
        plan.make_context("plan", ["--high-over-low", "2,5"])
    with pytest.raises(Exception, match="'8,000' may be thousands, two numbers or one"):
        plan.make_context("plan", ["--scale-number", "8,000"])


IN_HELP = re.compile(r"\[(m|mm|µm)[\],]|\bmetres[,;]|\b(0 to 1|1:N)\b")


def test_units_of_options_are_those_of_their_help():
    """Read from help, ``--terrain 2024heights`` was taken for a length."""
    group = typer.main.get_command(app)
    seen = set()
    for command in COMMANDS:
        for option in group.get_command(None, command).params:
            said = IN_HELP.search(getattr(option, "help", None) or "")
            unit = said and (said[1] or said[2] or "m")
            if "Path" in str(option.type_descriptor.annotation):
                assert option.name not in lengths.UNITS
            elif said or option.name in lengths.UNITS:
                seen.add(option.name)
                of_low_flight = "The same for the low" in (option.help or "")
                assert of_low_flight or lengths.UNITS.get(option.name) == unit
    assert seen == set(lengths.UNITS)


def test_a_name_of_a_file_is_no_length(invoke):
    shown = invoke("plan", "--terrain", "2024heights").stderr
    assert shown.startswith("einschalt: 2024heights: ")


def test_options_that_take_no_list_offer_none(invoke, block_folder, tmp_path):
    words = ("-o", tmp_path / "out", "--tolerance", "0,05")
    shown = invoke("densify", block_folder, *words).stderr
    assert "Write 0.05" in shown
    assert "may be two numbers" not in shown


def test_a_decimal_comma_with_a_unit_is_cited_as_it_was_written(
    invoke, block_folder, tmp_path
):
    words = ("-o", tmp_path / "out", "--tolerance", "2,5cm")
    shown = invoke("densify", block_folder, *words).stderr
    assert "--tolerance: '2,5cm' has a decimal comma; expected a decimal" in shown
    assert "Write '2.5cm'." in shown
    assert "0.02" not in shown


@pytest.mark.parametrize("text", ["10,000", "1,500", "250,000m", "-1,250 km"])
def test_thousands_that_may_be_decimals_are_refused(text, invoke):
    refused = invoke("plan", f"--width={text}")
    assert refused.exit_code == 2
    whole, decimals = text.replace(",", ""), text.replace(",", ".")
    said = " ".join(refused.stderr.split())
    assert f"--width: '{text}' may be thousands or decimals; expected" in said
    assert said.endswith(f" Write '{whole}' or '{decimals}'.")


@pytest.mark.parametrize(
    ("text", "meant"),
    [
        *[("0,125", "0.125"), ("5,5", "5.5"), ("5,55", "5.55"), ("1,2345", "1.2345")],
        *[("1234,567", "1234.567"), ("10.000", "10.000"), ("1,250e3", "1.250e3")],
    ],
)
def test_commas_that_part_no_thousands_are_decimal(text, meant):
    given = lengths.with_numbers([f"--width={text}"], {"--width": ("m", True)})
    assert given == [f"--width={meant}"]


def test_commas_of_two_meanings_are_told_in_german(invoke):
    refused = invoke("--language", "de", "plan", "--width", "10,000").stderr
    assert "'10,000' können Tausender sein oder Dezimalstellen; erwartet" in refused
    assert refused.endswith(" '10000' oder '10.000' schreiben.\n")
    refused = invoke("--language", "de", "plan", "--m-g-um", "7,5").stderr
    assert "'7,5' können zwei Zahlen sein oder eine; erwartet: ein Dezimal" in refused
    assert refused.endswith(" '7.5' oder '7;5' schreiben.\n")


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (("plan", "--target", "abc"), "--target = 'abc'; expected a number."),
        (
            ("plan", "--kind", "foo"),
            "--kind = 'foo'; expected affine, helmert or rigid.",
        ),
        (("simulate", "--seed", "1,5"), "--seed = '1,5'; expected a whole number."),
        (("serve", "--port", "99999"), "--port = '99999'; expected 65535 or less."),
        (("serve", "--port", "-1"), "--port = '-1'; expected 0 or more."),
    ],
)
def test_a_wrong_value_is_told_in_no_library_s_words(call, said, invoke):
    shown = invoke(*call)
    assert shown.exit_code == 2
    assert said in " ".join(shown.stderr.split())
    assert not re.search(r"Input should|Value error|pars(e|ing)", shown.stderr)


@pytest.mark.parametrize("text", ["cm", "", "points.csv", "5m.csv", "vermv_2016"])
def test_what_is_no_length_stays_as_it_is(text):
    assert lengths.in_unit(text, "m") == text


def test_lengths_in_every_form_of_an_option(invoke):
    def table(*words):
        return invoke("plan", "--scale-number", "8000", *words).output

    plain = table("--spacing", "200,300", "--m-0", "0.1", "--m-g-um", "7.5")
    assert "200 m" in plain
    written = ("--spacing=20000cm,300m", "--m-0", "10 cm", "--m-g-um", "0.0075mm")
    assert table(*written) == plain
    assert table("--image-format", "6.8x10.58cm") == table(
        "--image-format", "68.0x105.8"
    )
    assert table("--spacing", "200:300:50m") == table("--spacing", "200:300:50")


def test_an_unknown_unit_is_refused(invoke):
    shown = invoke("plan", "--target", "5feet")
    assert shown.exit_code == 2
    said = "--target: '5feet' has a unit that is not known; expected one of km, m, dm"
    assert said in " ".join(shown.stderr.split())


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish", "powershell"])
def test_a_shell_gets_a_script_that_asks_the_program(shell, invoke):
    script = invoke("completion", shell).stdout
    told = re.sub(r'[ "]', "", script)  # PowerShell sets it in quotes
    assert f"_EINSCHALT_COMPLETE=complete_{shell}" in told
    assert "einschalt" in script


@pytest.mark.parametrize("shell", ["fish", "powershell"])
def test_each_word_has_a_line_of_its_own(shell):
    asked = {
        "_EINSCHALT_COMPLETE": f"complete_{shell}",
        "_TYPER_COMPLETE_ARGS": "einschalt densify --",
        "_TYPER_COMPLETE_WORD_TO_COMPLETE": "--",
        "_TYPER_COMPLETE_FISH_ACTION": "get-args",
        "COLUMNS": "40",
    }
    lines = answer_to(asked).splitlines()
    assert len(lines) > 20
    assert all(line.startswith("--") for line in lines)


def completed(line):
    words = {"COMP_WORDS": line, "COMP_CWORD": str(len(line.split(" ")) - 1)}
    return answer_to(words | {"_EINSCHALT_COMPLETE": "complete_bash"}).split()


def answer_to(asked):
    """What the program answers a shell that asks by these variables."""
    code = "from einschalt.interfaces.cli.main import run; run()"
    done = subprocess.run(
        [sys.executable, "-c", "import sys; sys.argv = ['einschalt']\n" + code],
        env={**os.environ, **asked},
        capture_output=True,
        text=True,
        check=False,
    )
    return done.stdout


@pytest.mark.slow
def test_commands_and_options_are_completed():
    assert completed("einschalt de") == ["demo", "densify"]
    assert completed("einschalt densify --coverage") == ["--coverage-mean"]
    assert completed("einschalt densify --method s") == ["simultaneous"]


def test_terms_are_found_in_both_languages(invoke):
    assert len(entries()) > 60
    for term in ("Passpunkt", "control point", "passpunkt", "control_points"):
        shown = invoke("explain", term).stdout
        assert shown.startswith("control point, control, c. point (Points")
    column = invoke("explain", "Rechtswert").stdout
    assert column.startswith("Rechtswert: easting")
    assert "  remedy: " in invoke("explain", "claim_that_does_not_stand").stdout
    unknown = invoke("explain", "Paspunkt")
    assert unknown.exit_code == 2
    assert "Passpunkt" in unknown.stderr
