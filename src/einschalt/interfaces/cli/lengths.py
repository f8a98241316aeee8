"""Lengths on the command line: with a unit, "5cm", or in the unit of the option."""

import re

import typer

# written so by surveyors and by keyboards without Greek letters
METRES = {
    "km": 1e3,
    "m": 1.0,
    "dm": 1e-1,
    "cm": 1e-2,
    "mm": 1e-3,
    **dict.fromkeys(("um", "µm", "μm"), 1e-6),
}
# what the help of an option says of its unit
MARK = re.compile(r"\[(m|mm|µm)[\],]|\bmetres[,;]")
NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
PIECE = re.compile(rf"({NUMBER})\s*({'|'.join(METRES)})?(?![^\s,:x×])")
OTHER_UNIT = re.compile(rf"{NUMBER}\s*[A-Za-zµμ'\"]+")
TEXT = re.compile(rf"{PIECE.pattern}(?:\s*[,:x×]\s*{PIECE.pattern})*")


def unit_of(help_text):
    """Unit in which an option takes a length, by its help; None of other options.

    >>> unit_of("Side of the image [mm], or its sides."), unit_of("0 to 1.")
    ('mm', None)
    """
    found = MARK.search(help_text or "")
    return found and (found[1] or "m")


def in_unit(text, unit):
    """The same lengths without units, in the unit of the option.

    Several are separated by commas, colons or an x; those without a unit have that of
    the next one that has one. What is no length stays as it is.

    >>> in_unit("5cm", "m"), in_unit("200,300 m", "m"), in_unit("68x105.8", "mm")
    ('0.05', '200,300', '68x105.8')
    >>> in_unit("2,3cm", "m"), in_unit("vermv_2016", "m")
    ('0.02,0.03', 'vermv_2016')
    """
    if OTHER_UNIT.fullmatch(text.strip()) and not PIECE.fullmatch(text.strip()):
        known = ", ".join(METRES)
        message = f"{text!r} has a unit that is not known; expected one of {known}."
        raise typer.BadParameter(message)
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


def with_numbers(words, options):
    """Words of a command line, those that follow options of lengths as numbers.

    ``options``: unit by option, ``{"--spacing": "m"}``.

    >>> with_numbers(["--spacing", "250m", "--target=5cm"],
    ...              {"--spacing": "m", "--target": "m"})
    ['--spacing', '250', '--target=0.05']
    """
    done, unit = [], None
    for word in words:
        option, sign, value = word.partition("=")
        if unit is not None:
            done.append(in_unit(word, unit))
        elif sign and option in options:
            done.append(f"{option}={in_unit(value, options[option])}")
        else:
            done.append(word)
        unit = options.get(word) if unit is None else None
    return done
