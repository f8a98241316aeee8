"""The command as a whole: help, version, start-up, statuses."""

import subprocess
import sys
from importlib import import_module

import pytest

from einschalt.interfaces.cli.main import COMMANDS

NAMES = list(COMMANDS)
HEAVY = {
    *("numpy", "pandas", "numba", "matplotlib", "pyogrio", "scipy", "pyarrow"),
    "shapely",
}


def test_help_lists_the_commands(invoke):
    shown = invoke("--help")
    assert shown.exit_code == 0
    for name in NAMES:
        assert f"\n  {name} " in shown.output
    assert "..." not in shown.output.split("Commands:")[1].split("Examples")[0]


@pytest.mark.parametrize("name", NAMES)
def test_the_list_says_of_a_command_what_its_help_begins_with(name, invoke):
    shown = " ".join(invoke(name, "--help").output.split())
    assert COMMANDS[name] in shown.partition("Options:")[0]
    assert COMMANDS[name] in " ".join(invoke("--help").output.split())


def test_a_mistaken_command_is_refused(invoke):
    shown = invoke("densifi")
    assert shown.exit_code == 2
    assert "einschalt has no command 'densifi'; expected demo, init, " in shown.stderr
    assert shown.stderr.endswith("or orient. Did you mean 'densify'?\n")


@pytest.mark.parametrize("name", ["", *NAMES])
def test_help_has_examples_one_a_line(name, invoke):
    shown = invoke(*filter(None, [name]), "--help").output
    examples = shown.split("Examples:\n")[1].strip().split("\n")
    assert examples
    calls = "\n".join(examples).replace(" \\\n", " ").split("\n")
    assert all(call.strip().startswith("einschalt ") for call in calls)


@pytest.mark.parametrize("name", NAMES)
def test_examples_use_options_that_exist(name, invoke):
    shown = invoke(name, "--help").output
    module = import_module(f"einschalt.interfaces.cli.{name}")
    for example in module.EXAMPLES:
        for word in example.partition("|")[0].split():
            if word.startswith("--"):
                assert word in shown


def test_version(invoke):
    shown = invoke("--version")
    assert shown.exit_code == 0
    assert shown.output.startswith("einschalt ")


@pytest.mark.parametrize(
    "arguments", [["nonsense"], ["densify", "x", "--methd", "y"], ["densify", "x"]]
)
def test_a_wrong_call_has_status_2_and_a_usage(arguments, invoke):
    shown = invoke(*arguments)
    assert shown.exit_code == 2
    assert "Usage:" in shown.stderr
    assert shown.stdout == ""


@pytest.mark.parametrize("name", ["", *NAMES])
def test_help_imports_nothing_heavy(name):
    call = [name, "--help"] if name else ["--help"]
    code = (
        "import sys; from einschalt.interfaces.cli.main import app\n"
        f"app({call!r}, standalone_mode=False)\n"
        f"print(sorted({HEAVY!r} & set(sys.modules)), file=sys.stderr)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert done.stderr.strip() == "[]"


def test_the_list_of_commands_imports_none_of_them():
    code = (
        "import sys; from einschalt.interfaces.cli.main import app\n"
        "app(['--help'], standalone_mode=False)\n"
        "print(*(m for m in sys.modules if '.cli.' in m), file=sys.stderr)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    imported = {name.rpartition(".")[2] for name in done.stderr.split()}
    assert "main" in imported
    assert imported & {*NAMES, "work"} == set()


@pytest.mark.slow
def test_help_takes_little_more_than_its_library(processor_seconds):
    call, library = ("-m", "einschalt", "--help"), ("-c", "import typer")
    ours, without = processor_seconds(call, library)
    assert ours < 3.0 * without  # usually 1.5 times, 0.2 s


def test_entry_point_is_the_module(spawn):
    assert spawn("--version").stdout == spawn("--version").stdout != ""
