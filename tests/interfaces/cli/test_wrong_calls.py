"""Wrong calls are told as other errors are, with options as they were typed."""

import json

import pytest

import einschalt as es
from einschalt.foundations.errors import BlockError, SettingsError
from einschalt.interfaces.cli.lengths import SHARE, with_numbers
from einschalt.interfaces.cli.typed_options import as_typed, option_of, remember_typed

OUT = ("--output", "out")
CLOSE = ("--n-coverages", 4, "--forward-overlap", 0.8, "--side-overlap", 0.6)
CAMERAS_BUT_ONE = (
    "film_wide, film_normal, film_super_wide, ultracam_eagle, dmc_3, ultracam_xp, "
    "dmc_ii_250, uav_full_frame, uav_one_inch or uav_four_thirds"
)
CALLS = {
    ("plan", "--spacng", 3): (
        "einschalt plan has no option --spacng",
        "one that its help lists",
        "Did you mean --spacing?",
    ),
    ("plan", "--foo"): (
        "einschalt plan has no option --foo",
        "one that its help lists",
        "See einschalt plan --help",
    ),
    ("plan", "--scale"): ("--scale has no value", "one behind it", "--scale VALUES"),
    ("plan", "--overwrite=3"): (
        "--overwrite has a value",
        "the option alone",
        "Write --overwrite",
    ),
    ("plan", "more"): (
        "einschalt plan has no place for 'more'",
        "einschalt plan [OPTIONS]",
        "Leave it out",
    ),
    ("densify", "block"): (
        "--output is missing",
        "a value: Folder for the results.",
        "Write --output <path> as well",
    ),
    ("densify", *OUT): (
        "BLOCK is missing",
        "a value: Folder of the block, or block.toml.",
        "Write BLOCK as well",
    ),
    ("plan", "--camera", "dmc-3"): (
        "--camera = 'dmc-3'",
        CAMERAS_BUT_ONE,
        "Did you mean 'dmc_3'?",
    ),
    ("plan", "--camera", "kodak"): ("--camera = 'kodak'", CAMERAS_BUT_ONE, None),
    ("plan", "--transformation", "afine"): (
        "--transformation = 'afine'",
        "affine, helmert or rigid",
        "Did you mean 'affine'?",
    ),
    ("simulate", "--seed", "x", *OUT): ("--seed = 'x'", "a whole number", None),
    ("transform", "a", "b", *OUT, "--cell=0"): ("--cell = '0'", "0.001 or more", None),
    ("densify", "block", "--output", ""): (
        "--output: the path is empty",
        "a file or folder",
        None,
    ),
    ("plan", "--target", "5feet"): (
        "--target: '5feet' has a unit that is not known",
        "one of km, m, dm, cm, mm, um, µm, ft",
        None,
    ),
    ("plan", "--expect", "--spacing", "10m,20yd"): (
        "--spacing: '20yd' has a unit that is not known",
        "one of km, m, dm, cm, mm, um, µm, ft",
        None,
    ),
    ("plan", "--image-format", "68 x 106feet"): (
        "--image-format: '106feet' has a unit that is not known",
        "one of km, m, dm, cm, mm, um, µm, ft",
        None,
    ),
    # what is refused behind the call
    ("plan", "--scale", 50): ("--scale = 50", "100 to 200000", None),
    ("plan", "--scale-number", 0.000125): (
        "--scale-number = 0.000125",
        "100 to 200000",
        "Give the denominator",
    ),
    ("plan", "--point-spacing", 0.3): (
        "--point-spacing = 0.3",
        "0.5 to 50000 metres",
        "Did you give kilometres?",
    ),
    ("plan", "--target", "5cm", "--spacing", 0.4): (
        "--spacing = 0.4",
        "0.5 to 50000 metres",
        None,
    ),
    # nobody has given the distance of the points of its layout
    (*("plan", "--expect", "--width", "1000km", "--height", "1000km"), *CLOSE): (
        (
            "the layout of an area of 1000000 x 1000000 m would have "
            "points 80000 m apart, to be computed in time"
        ),
        "at most 50000 m",
        "Give a smaller --width and --height, less overlap, or fewer coverages",
    ),
    (
        *("plan", "--expect", "--spacing", 1900, "--scale", 190_000),
        *("--high-scale-number", 200_000, "--n-coverages", 4),
        *("--forward-overlap", 0.95, "--side-overlap", 0.85),
    ): (
        (
            "the layout of an area of 133000 x 133000 m would have "
            "points 479662 m apart, to be computed in time"
        ),
        "at most 50000 m",
        "Give a smaller --spacing, less overlap, or fewer coverages",
    ),
    ("plan", "--scale", "8000,x"): ("--scale 'x'", "numbers as 6000,8000", None),
    ("plan", "--expect", "--scale", "8000,9000"): (
        "--scale has 2 values",
        "one value: a layout has one",
        "Write --scale 8000",
    ),
    ("plan", "--target", "5cm", "--m-g-um", "4;5", "--high-m-g-um", 5): (
        "--m-g-um has 2 values beside --high-m-g-um",
        "one value: a search has one ratio of the errors of both flights",
        "Write --m-g-um 4, or leave --high-m-g-um out",
    ),
    ("simulate", "--scale", 5, *OUT): ("--scale = 5", "100 to 200000", None),
    ("simulate", "--low-scale", 5, *OUT): ("--low-scale = 5", "100 to 200000", None),
    ("simulate", "--camera", "dmc_3", "--spacing", 0.1, *OUT): (
        "--spacing = 0.1",
        "0.5 to 50000 metres",
        None,
    ),
    ("plan", "--target", "5cm", "--n-settings", 0): (
        "--n-settings = 0",
        "a whole number, 1 to 100",
        None,
    ),
    ("plan", "--target", "5cm", "--max-height", 1): (
        "--max-height = 1",
        "5 to 20000 metres above ground",
        None,
    ),
    ("plan", "--target", "5cm", "--costs", "image=-1"): (
        "--costs: image = -1",
        "0 to 1e+09",
        None,
    ),
}


@pytest.mark.parametrize("call", CALLS)
def test_a_wrong_call_says_what_was_found_expected_and_how_to_mend_it(
    call, invoke, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)  # where no folder "out" is
    found, expected, remedy = CALLS[call]
    shown = invoke(call[0], "--json", *call[1:])
    told = json.loads(shown.stdout)
    assert told["status"] == shown.exit_code == 2
    (problem,) = told["problems"]
    assert problem["found"] == found
    assert problem["expected"].startswith(expected)
    assert (remedy or "") in (problem["remedy"] or "")
    assert f"{found}; expected {expected}" in " ".join(shown.stderr.split())
    if remedy:
        assert remedy in shown.stderr
    german = invoke("--language", "de", *call).stderr
    assert "erwartet: " in german
    assert "expected" not in german


def test_an_unknown_command_is_told_to_programs_too(invoke):
    told = json.loads(invoke("plna", "--json").stdout)
    assert told["status"] == 2
    (problem,) = told["problems"]
    assert problem["found"] == "einschalt has no command 'plna'"
    assert problem["remedy"] == "Did you mean 'plan'?"
    alone = invoke("--language", "de")
    assert alone.exit_code == 2
    assert "wurde ohne Befehl aufgerufen; erwartet: demo, init" in alone.stderr


def test_cameras_are_known_in_capitals(invoke):
    plain, capitals = (invoke("plan", "--camera", name) for name in ("dmc_3", "DMC_3"))
    assert plain.exit_code == capitals.exit_code == 0
    assert plain.stdout == capitals.stdout


@pytest.mark.parametrize("text", ["60%", "60 %", "0.6", "0,6", "60,0%"])
def test_overlaps_may_be_per_cent(text, invoke):
    options = {"--forward-overlap": (SHARE, True)}
    for words in (["--forward-overlap", text], [f"--forward-overlap={text}"]):
        given = "=".join(with_numbers(words, options)).rpartition("=")[2]
        assert float(given) == 0.6
    shown = invoke("plan", "--forward-overlap", text, "--side-overlap", "25%")
    assert "overlaps 60 % and 25 %" in " ".join(shown.stdout.split())
    refused = invoke("plan", "--forward-overlap", "60")
    assert "--forward-overlap = 60; expected 0.01 to 0.99" in refused.stderr


def test_python_names_its_arguments():
    with pytest.raises(es.EinschaltError, match=r"^spacing = 1e.06; expected"):
        es.plan_precision(scale_number=8000, spacing=1e6, m_0=0.1, m_g_um=5)


class _Option:
    param_type_name = "option"

    def __init__(self, name, *opts):
        self.name, self.opts = name, list(opts)


def test_errors_of_files_keep_the_names_of_the_file():
    options = [_Option("scale_number", "--scale-number", "--scale")]
    remember_typed(options, ["--scale=50", "--other", "1"])
    assert option_of("scale_number") == "--scale"
    assert option_of("low_scale_number") == "--scale"
    assert option_of("m_0") == "--m-0"
    wrong = SettingsError("scale_number = 50", remedy="Give another --scale-number")
    mended = as_typed(wrong)
    assert (mended.found, mended.remedy) == ("--scale = 50", "Give another --scale")
    in_file = SettingsError("scale_number = 50", file="block.toml", row=3)
    assert as_typed(in_file) is in_file
    both = as_typed(BlockError([wrong, in_file]))
    assert [one.found for one in both.problems] == ["--scale = 50", "scale_number = 50"]
    twice = as_typed(BlockError([wrong, SettingsError(**vars(wrong))]))
    assert str(twice) == str(mended)
    many = BlockError([SettingsError("a row", stands_for=12)])
    assert as_typed(many).problems[0].stands_for == 12
    assert as_typed(SettingsError('scale_number="a"')).found == "--scale a"
    advised = SettingsError("a gap", remedy="Raise low_scale_number, not point_id")
    assert as_typed(advised).remedy == "Raise --scale, not point_id"


@pytest.mark.parametrize(
    ("option", "value", "expected"),
    [
        ("--memory", "0", "a number above 0 (gigabytes for each process)"),
        ("--time-limit", "0", "a number above 0 (seconds for each task)"),
        ("--tolerance", "'1e9'", "none, vermv_1994"),
        ("--crs-epoch", "'3'", "a decimal year from 1900"),
    ],
)
def test_a_batch_names_options_and_not_what_they_become(
    invoke, block_folder, option, value, expected
):
    call = ("batch", block_folder, *OUT, "--dry-run", option, value.strip("'"))
    start = f"einschalt: {option} = {value}; "
    assert invoke(*call).stderr.startswith(f"{start}expected {expected}")
    assert invoke(*call, "--language", "de").stderr.startswith(f"{start}erwartet: ")
    (problem,) = json.loads(invoke(*call, "--json").stdout)["problems"]
    assert problem["found"] == f"{option} = {value}"


def test_settings_of_block_toml_keep_their_names():
    remember_typed([_Option("tolerance", "--tolerance")], ["--tolerance", "1"])
    facts = {"section": "settings", "key": "tolerance"}
    wrong = SettingsError("[settings] tolerance = 2", file="block.toml", **facts)
    assert as_typed(wrong) is wrong
    other = SettingsError("[settings] grids = 2", section="settings", key="grids")
    assert as_typed(other) is other


def test_a_wrong_price_is_told_in_words_that_can_be_typed(invoke):
    call = ["plan", "--target", "5cm", "--costs", "foo=3"]
    said = invoke(*call).stderr
    assert "expected costs as image=10,model=20,setting=0.5,control_point=100" in said


@pytest.mark.parametrize(
    ("question", "option", "found"),
    [
        (["--target", "5cm"], ["--forward-overlap", "45%"], "0.45; expected 0.522 to"),
        (["--target", "5cm"], ["--forward-overlap", "50%"], "0.5; expected 0.522 to"),
        (["--expect"], ["--forward-overlap", "50%"], "0.5; expected 0.522 to"),
        (["--expect"], ["--forward-overlap", "60"], "60; expected 0.522 to"),
        (["--target", "5cm"], ["--side-overlap", "1%"], "0.01; expected 0.0435 to"),
    ],
)
def test_overlaps_that_no_layout_has_are_refused_before_the_search(
    question, option, found, invoke
):
    refused = invoke("plan", *question, *option)
    assert refused.exit_code == 2
    assert f"{option[0]} = {found}" in refused.stderr
    assert not refused.stdout


@pytest.mark.parametrize(
    ("option", "value", "hint"),
    [
        ("--target", "5", "centimetres"),
        ("--target", "1km", None),
        ("--target", "1e9", None),
        ("--spacing", "0.3", "kilometres"),
        ("--spacing", "1e9", None),
        ("--forward-overlap", "60", "per cent"),
        ("--forward-overlap", "101 %", None),
        ("--m-g-um", "1e9", None),
        ("--m-0", "1e9", None),
    ],
)
def test_units_are_asked_about_where_the_number_is_one_in_them(
    option, value, hint, invoke
):
    target = () if option in ("--target", "--m-0") else ("--target", "5cm")
    refused = invoke("plan", *target, option, value)
    assert refused.exit_code == 2
    assert "; expected " in refused.stderr
    if hint is None:
        assert "Did you" not in refused.stderr
    else:
        assert f"Did you give {hint}?" in refused.stderr


def test_german_hints_have_decimal_commas(invoke):
    said = invoke("--language", "de", "plan", "--target", "5").stderr
    assert "Waren es Zentimeter? 5 cm sind 0,05" in said
    assert invoke("--language", "de", "plan", "--target", "0,05").exit_code == 0


@pytest.mark.parametrize(
    ("typed", "is_asked"),
    [("0.3", True), ("0.3e0", True), ("300mm", False), ("30 cm", False)],
)
def test_nobody_who_wrote_a_unit_is_asked_for_it(typed, is_asked, invoke):
    refused = invoke("plan", "--scale-number", "6000", "--spacing", typed)
    assert "--spacing = 0.3; expected 0.5 to 50000 metres" in refused.stderr
    assert ("Did you give kilometres?" in refused.stderr) == is_asked
