"""Units behind the names of columns: ``x [mm]``, ``Höhe (m ü. A.)``, ``X in cm``.

Where a column holds a length, any length is understood that has one meaning; a foot
has two, and is none of them.
"""

import re
import unicodedata

from einschalt.foundations.units import METRES_PER_KM, METRES_PER_UNIT

PIXELS = "px"
METRES_PER_LENGTH = METRES_PER_UNIT | {"km": METRES_PER_KM}
# as units are written out; both signs of micro are one after the first step below
SPELLED = {
    "m": "meter metern metre metres meters mètre mètres metro metri",
    "mm": "millimeter millimetern millimetre millimetres millimeters millimètres "
    "millimetri",
    "cm": "zentimeter zentimetern centimetre centimetres centimeters centimètres "
    "centimetri",
    "km": "kilometer kilometern kilometre kilometres kilometers kilomètres chilometri",
    "um": "μm mikrometer micrometre micrometres micron microns mikron",
    PIXELS: "pixel pixels pix",
    "D.MMSS": "dms gms d.mmss dd.mmss ddd.mmss d.mmssss dd.mmssss ddd.mmssss "
    "d.mmsssss dd.mmsssss ddd.mmsssss",
    "deg": "dd degrees",
    "ft": "feet foot fuss fuß",
    "US ft": "usft ftus us-ft us_ft sft",
}
SIGNS = {word: unit for unit, words in SPELLED.items() for word in words.split()}
SIGNS |= {unit.casefold(): unit for unit in SPELLED}
SIGNS |= dict.fromkeys(
    ("us feet", "us foot", "us survey feet", "us survey foot", "survey feet"), "US ft"
)
# as schemas call what they expect
NAMES_OF_LENGTHS = {
    "metres": "m",
    "centimetres": "cm",
    "millimetres": "mm",
    "micrometres": "um",
}
LONGEST_NAME = 60
IN_BRACKETS = re.compile(r"\s*[\[({<]([^\[\](){}<>]*)[\])}>]\s*$")
WITHOUT = re.compile(
    rf"(?:\s+(?:in|en)\s+|\s*[,;:/_\s-]\s*)({'|'.join(map(re.escape, SIGNS))})\.?\s*$",
    re.IGNORECASE,
)
# what heights are counted from: m ü. A., m ü. NN, m ü. M., m s.l.m., m a.s.l.
ABOVE = (
    r"(?:(?:ü|ue?|über|ueber)[\s.]*(?:a|adria|nn|nhn|m|meer|ell|ellipsoid)"
    r"|a\.?\s?s\.?\s?l|s\.?\s?l\.?\s?m|s\.?\s?m|nn|nhn|adria|ln\s?02|evrf\d*|dhhn\d*)\.?"
)
LENGTH_ABOVE = re.compile(rf"(m|cm|mm)\s*{ABOVE}", re.IGNORECASE)
DEGREES = {"deg", "°"}
# degrees, minutes, seconds as pocket calculators have them: 47.1234 is 47° 12' 34"
PACKED = "D.MMSS"
PACKED_WORD = re.compile(
    r"""[dg]{1,3}[.,]\s?mms+([.,]s+)?|[dg]ms|°\s?['′]\s?["″]""", re.IGNORECASE
)
DECIMAL_WORDS = re.compile(
    r"dd|[dg]{1,3}[.,][dg]+|dec\w*\s?deg\w*|degr?\w*|dezimalgrad|°\s?dez\w*",
    re.IGNORECASE,
)
OF_A_SYSTEM = " units"  # behind the name of that of a reference system
GONS = {"gon", "grad", "grads"}
# that measure something, and in which no column is read, or not every one
OTHERS = {
    *("nm", "dm", "hm", "in", "inch", "inches", "zoll", '"', "yd", "yard", "yards"),
    *("mi", "mile", "miles", "nmi"),
    *("rad", "mrad", "mgon", "cgon", "arcsec", "arcmin", "'", "′", "″", "%", "ppm"),
}
ALL_UNITS = {*map(str.casefold, SPELLED), *METRES_PER_LENGTH, *DEGREES, *GONS, *OTHERS}
SQUARE = re.compile(r"(\w+)(2|\^2)")


def plain_unit(text):
    """Unit without brackets, and without what heights are counted from.

    >>> plain_unit("[m ü. A.]"), plain_unit("(mm)"), plain_unit("Meter")
    ('m', 'mm', 'm')
    >>> plain_unit("(DDD.MMSSsss)"), plain_unit("[decimal degrees]"), plain_unit("DMS")
    ('D.MMSS', 'deg', 'D.MMSS')
    """
    unit = unicodedata.normalize("NFKC", text[:LONGEST_NAME]).strip("[](){}<> ")
    above = LENGTH_ABOVE.fullmatch(unit)
    unit = unit if above is None else above[1].lower()
    unit = re.sub(r"^in\s+", "", unit)
    if PACKED_WORD.fullmatch(unit):
        return PACKED
    if DECIMAL_WORDS.fullmatch(unit):
        return "deg"
    return SIGNS.get(unit.casefold(), unit)


def parted_unit(name, *, is_plain=False):
    """Part the unit from the name of a column; None where there is none.

    ``is_plain``: also one without brackets.

    >>> parted_unit("x [µm]"), parted_unit("x_mm"), parted_unit("Y {Meter}")
    (('x', 'um'), ('x_mm', None), ('Y', 'm'))
    >>> parted_unit("x_mm", is_plain=True), parted_unit("X in cm", is_plain=True)
    (('x', 'mm'), ('X', 'cm'))
    """
    said = IN_BRACKETS.search(name)
    if said is None and is_plain and len(name) <= LONGEST_NAME:
        said = WITHOUT.search(unicodedata.normalize("NFKC", name))
    if said is None or not said.start():
        return name, None
    return name[: said.start()], plain_unit(said[1])


def is_length(unit):
    """Whether a column with that unit, in the words of a schema, holds lengths.

    >>> is_length("metres"), is_length("square metres"), is_length("degrees")
    (True, False, False)
    """
    return unit.partition(",")[0] in NAMES_OF_LENGTHS


def may_be_in(said, unit):
    """Whether values in a unit can be had in another one, as a schema calls it.

    >>> may_be_in("cm", "metres"), may_be_in("ft", "metres"), may_be_in("°", "degrees")
    (True, False, True)
    >>> may_be_in("ft", "US survey foot units"), may_be_in("US ft", "foot units")
    (True, False)
    """
    if is_length(unit):
        return said in METRES_PER_LENGTH or (said == PIXELS and "pixels" in unit)
    if unit == "square metres":
        return said in ("m2", "m^2")
    if unit == "grads":
        return said in GONS
    if unit.endswith(OF_A_SYSTEM):
        return _is_of_system(said, unit.removesuffix(OF_A_SYSTEM).casefold())
    return unit == "degrees" and (said in DEGREES or said == PACKED)


def _is_of_system(said, name):
    """Whether a unit is that of a system, as PROJ calls it: a foot is its own foot."""
    if "foot" in name:
        return said == "ft" or (said == "US ft" and name.startswith("us survey"))
    return said.casefold() == name or ("yard" in name and said.casefold() == "yd")


def is_in(said, unit):
    """Whether values in a unit are what a schema expects without a conversion.

    >>> is_in("km", "metres"), is_in("m", "metres"), is_in("ft", "foot units")
    (False, True, True)
    """
    own = NAMES_OF_LENGTHS.get(unit.partition(",")[0])
    return may_be_in(said, unit) and (own is None or said in (own, PIXELS))


def is_unit(said):
    """Whether what stands in brackets behind a name is a unit, of whatever kind.

    >>> is_unit("ft"), is_unit("dm"), is_unit("cm2"), is_unit("GK M34")
    (True, True, True, False)
    """
    root = square[1] if (square := SQUARE.fullmatch(said)) else said
    return root.casefold() in ALL_UNITS
