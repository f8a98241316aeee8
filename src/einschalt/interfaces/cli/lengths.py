"""Numbers on the command line: with a decimal comma, and lengths with a unit, "5cm".

An option of one number takes a decimal comma; where it takes several, commas separate
them, and decimal commas are known by semicolons: "0,1;0,2".
"""

import re

from einschalt.interfaces.cli.wrong_calls import WrongValueError

MU_M = "\u03bcm"  # with the Greek letter; µm has the sign of its own
# written so by surveyors and by keyboards without Greek letters
METRES = {
    "km": 1e3,
    "m": 1.0,
    "dm": 1e-1,
    "cm": 1e-2,
    "mm": 1e-3,
    **dict.fromkeys(("um", "µm", MU_M), 1e-6),
    "ft": 0.3048,  # the international one, as heights of flights are told in
}
SHARE = "0 to 1"  # which may be given as 60%
SCALE = "1:N"  # of which N is taken, as answers write scales
# units of options by the names of their arguments, which no two commands take
# otherwise; a test compares them with what help says
OPTIONS = {
    "m": (
        *("spacing", "point_spacing", "m_0", "target", "control_standard_error"),
        *("max_height", "width", "height", "network_strain", "cell", "tolerance"),
        *("crs_accuracy_m", "control_error_m", "flying_height", "altitude"),
    ),
    "mm": (
        *("image_format", "principal_distance", "principal_distance_mm", "base"),
        "wing",
    ),
    "µm": ("m_g_um", "high_m_g_um", "low_m_g_um", "gross_error_um", "pixel_size_um"),
    SHARE: ("forward_overlap", "side_overlap"),
    SCALE: ("high_scale", "low_scale"),
}
UNITS = {name: unit for unit, names in OPTIONS.items() for name in names}
# lists of whole numbers, in which no comma can be a decimal one
WHOLE_NUMBERS = {"n_settings", "n_coverages", "control_per_model"}
OF_SCALE = re.compile(r"1\s*:\s*(\d+)")
PER_CENT = re.compile(r"([+-]?\d+(?:[.,]\d+)?)\s*%")
NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
PIECE = re.compile(rf"({NUMBER})\s*({'|'.join(METRES)})?(?![^\s,:x×])")
# the one number of an option, or those that semicolons separate
WITH_COMMA = re.compile(r"([+-]?\d+),(\d+(?:[eE][+-]?\d+)?\s*[A-Za-zµμ]*)")
# a list, or a number with decimals: what follows has no point that would tell
COMMA_OR_LIST = re.compile(r"[+-]?(\d+),(\d+)\s*[A-Za-zµμ]*")
# ten thousand, or ten with three decimals
THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2},\d{3}\s*[A-Za-zµμ]*")
OTHER_UNIT = re.compile(rf"{NUMBER}\s*[A-Za-zµμ'\"]+")
# an x between numbers, or behind one; others are letters of a unit
JOINT = re.compile(r"[,:×]|x(?=\s*[-+.\d])|(?<=[\d\s])x$")
TEXT = re.compile(rf"{PIECE.pattern}(?:\s*[,:x×]\s*{PIECE.pattern})*")


def in_unit(text, unit):
    """The same lengths without units, in the unit of the option.

    Several are separated by commas, colons or an x; those without a unit have that of
    the next one that has one. What is no length stays as it is.

    >>> in_unit("5cm", "m"), in_unit("200,300 m", "m"), in_unit("68x105.8", "mm")
    ('0.05', '200,300', '68x105.8')
    >>> in_unit("20,30cm", "m"), in_unit("vermv_2016", "m")
    ('0.2,0.3', 'vermv_2016')
    """
    for part in map(str.strip, JOINT.split(text)):
        if OTHER_UNIT.fullmatch(part) and not PIECE.fullmatch(part):
            raise WrongValueError(
                f"{part!r} has a unit that is not known",
                # µ once: its two characters look the same
                expected=f"one of {', '.join(name for name in METRES if name != MU_M)}",
            )
    if not TEXT.fullmatch(text.strip()):
        return text
    pieces = list(PIECE.finditer(text))
    written, meant = [], unit
    for piece in reversed(pieces):
        meant = piece[2] or meant
        written.append(_number(piece[1], METRES[meant] / METRES[unit]))
    joints = re.findall(r"[,:x×]", PIECE.sub("", text))
    last = "".join(written[:1])
    before = zip(reversed(written[1:]), joints, strict=True)
    return "".join(number + joint for number, joint in before) + last


def _number(text, factor):
    """A number times a factor, as short as it can be written; as it is for 1."""
    is_same = abs(factor - 1.0) < 1e-12
    return text if is_same else f"{float(text) * factor:.12g}"


def with_decimal_points(text, *, is_one):
    """The same numbers with decimal points; what has no decimal comma as it is.

    WrongValueError where a comma of several numbers may be either, or one before three
    digits part thousands.

    >>> with_decimal_points("5,5cm", is_one=True)
    '5.5cm'
    >>> with_decimal_points("0,1;0,2", is_one=False)
    '0.1,0.2'
    >>> with_decimal_points("200,300", is_one=False)
    '200,300'
    """
    if is_one:
        _refuse_thousands(text)
        return WITH_COMMA.sub(r"\1.\2", text) if WITH_COMMA.fullmatch(text) else text
    if _may_be_one(text):
        as_list, as_number = text.replace(",", ";"), text.replace(",", ".")
        if THOUSANDS.fullmatch(text.strip()):
            raise WrongValueError(
                f"{text!r} may be thousands, two numbers or one",
                expected="a number that is read in one way only",
                remedy=f"Write {text.replace(',', '')!r} or {as_list!r}",
            )
        raise WrongValueError(
            f"{text!r} may be two numbers or one",
            expected="decimals behind a point, or semicolons between numbers",
            remedy=f"Write {as_number!r} or {as_list!r}",
        )
    if ";" not in text:
        return text
    return ",".join(WITH_COMMA.sub(r"\1.\2", part) for part in text.split(";"))


def _may_be_one(text):
    """Whether a list of two may be meant as one number: "2,5" may, "200,300" cannot.

    Lists rise, as a rule, and hold no 0 and no 05; one digit is a decimal as often.
    """
    found = COMMA_OR_LIST.fullmatch(text.strip())
    if found is None:
        return False
    whole, decimals = found.groups()
    is_short, is_digit = len(decimals) <= 2, len(decimals) == 1
    starts_with_0 = decimals.startswith("0") and len(decimals) > 1
    falls = int(decimals) <= int(whole)
    return int(whole) == 0 or starts_with_0 or is_digit or (is_short and falls)


def _refuse_thousands(text):
    """Refuse one number of which a comma may part thousands or decimals."""
    if THOUSANDS.fullmatch(text.strip()):
        raise WrongValueError(
            f"{text!r} may be thousands or decimals",
            expected="a number that is read in one way only",
            remedy=f"Write {text.replace(',', '')!r} or {text.replace(',', '.')!r}",
        )


def with_numbers(words, options):
    """Words of a command line, those that follow options of numbers as numbers.

    ``options``: by option the unit of its lengths or None, and whether it takes one
    number alone, ``{"--spacing": ("m", False)}``.

    >>> with_numbers(["--spacing", "250m", "--target=5,5cm"],
    ...              {"--spacing": ("m", False), "--target": ("m", True)})
    ['--spacing', '250', '--target=0.055']
    >>> with_numbers(["--forward-overlap", "60%"], {"--forward-overlap": (SHARE, True)})
    ['--forward-overlap', '0.6']
    """
    done, asked = [], None
    for word in words:
        option, sign, value = word.partition("=")
        if asked is not None:
            done.append(_of_option(asked, word, options))
        elif sign and option in options:
            done.append(f"{option}={_of_option(option, value, options)}")
        else:
            done.append(word)
        asked = word if asked is None and word in options else None
    return done


def _of_option(option, text, options):
    """Value of an option as a number; what is wrong with it is told of the option."""
    try:
        return _as_number(text, *options[option])
    except WrongValueError as error:
        error.param_hint = option
        raise


def _as_number(text, unit, is_one):
    if unit == SHARE and (share := PER_CENT.fullmatch(text.strip())):
        return f"{float(share[1].replace(',', '.')) / 100.0:.12g}"
    if unit == SCALE and (scale := OF_SCALE.fullmatch(text.strip())):
        return scale[1]
    if is_one is not None:
        text = with_decimal_points(text, is_one=is_one)
    elif WITH_COMMA.fullmatch(text) and not text[-1].isdecimal():
        # one value or a word: no list of lengths, which in_unit would make of it
        point = text.replace(",", ".")
        raise WrongValueError(
            f"{text!r} has a decimal comma",
            expected="a decimal point",
            remedy=f"Write {point!r}",
        )
    return text if unit in (None, SHARE, SCALE) else in_unit(text, unit)
