"""Options as they were typed: messages name ``--scale``, and not ``scale_number``.

Errors name arguments as Python has them; on the command line the same argument may
have several options, of which one was typed.
"""

import re
from contextvars import ContextVar
from dataclasses import dataclass, field
from itertools import zip_longest

from einschalt.foundations.errors import BlockError
from einschalt.foundations.told_errors import told

# what inner parts call an argument, and what commands do; in both directions
OTHER_NAMES = {
    "low_gross_error_share": "gross_errors",
    "high_gross_error_share": "gross_errors",
    "low_gross_error_um": "gross_error_um",
    "high_gross_error_um": "gross_error_um",
    "scale_number": "low_scale_number",
    "spacing": "point_spacing",
    "m_g_um": "low_m_g_um",
    "kind": "transformation",
    "n_repetitions": "repeat",
    "memory_gb": "memory",
    "time_limit_s": "time_limit",
}
OTHER_NAMES |= {
    new: old for old, new in OTHER_NAMES.items() if "gross_error" not in new
}
SETTINGS = "settings"  # section of block.toml whose keys are options as well
PRICES = ("image", "model", "setting", "control_point")
# of a message, or of one of several
NAME_AT_FIRST = re.compile(
    r"(?:(?<=^)|(?<=^  ))(\w+)(?= (?:=|has|is|hat|ist) )", re.MULTILINE
)
# names of two words, which nothing else in a sentence has
NAME_WITHIN = re.compile(r"(?<![\w-])([a-z]+(?:_[a-z0-9]+)+)(?![\w-])")
# a whole number that was read as one with decimals, behind the name of its option
WHOLE = re.compile(r"^((?:  )?--[\w-]+(?:: \w+)? = -?\d+)\.0(?![\d.])", re.MULTILINE)
OF_UNITS = re.compile(r"Did you give \w+")
WITH_UNIT = re.compile(r"\d\s*(?!e[-+\d])[a-zµμ%]", re.IGNORECASE)
# as messages advise a word in Python
ASSIGNED = re.compile(r"""\b(\w+)=["']([^"']*)["']""")


@dataclass(frozen=True)
class TypedOptions:
    """Options of a command, and those of them that were typed."""

    known: dict = field(default_factory=dict)  # all words of an option, by its name
    typed: dict = field(default_factory=dict)  # the word that was typed
    values: dict = field(default_factory=dict)  # what was typed behind it

    def word(self, name):
        """How an option is written, by the name of its argument; None of no option."""
        for one in (name, OTHER_NAMES.get(name)):
            if one in self.known:
                return self.typed.get(one, self.known[one][0])
        return None


NOTHING_TYPED = TypedOptions()
_TYPED: ContextVar[TypedOptions] = ContextVar("typed options", default=NOTHING_TYPED)


def remember_typed(parameters, words) -> TypedOptions:
    """Keep what was typed of the options of a command, until the next one is called."""
    known = {
        one.name: one.opts for one in parameters if one.param_type_name == "option"
    }
    names = {word: name for name, words_of in known.items() for word in words_of}
    typed, values = {}, {}
    for word, following in zip_longest(words, words[1:]):
        option, sign, value = word.partition("=")
        if (name := names.get(option)) is not None:
            typed[name], values[name] = option, value if sign else following
    _TYPED.set(found := TypedOptions(known, typed, values))
    return found


def typed_options() -> TypedOptions:
    """Options of the command that is called."""
    return _TYPED.get()


def option_of(name) -> str:
    """Write an option by the name of its argument, as it was typed, if it was."""
    return typed_options().word(name) or f"--{name.replace('_', '-')}"


def as_typed(error):
    """Give an error whose words name options as they were typed.

    What was found in a file keeps the name that it has there.
    """
    error = _once(error)
    if isinstance(error, BlockError):
        return BlockError([as_typed(problem) for problem in error.problems])
    if _is_of_typed_setting(error):
        found = _with_typed_settings(error.found, [error])
        return error.with_facts(found=found, section=None, key=None)
    if _is_of_file(error):
        return error
    texts = {name: getattr(error, name) for name in ("found", "expected", "remedy")}
    said = {name: _with_typed_words(text) for name, text in texts.items()}
    said["found"] = NAME_AT_FIRST.sub(_named, said["found"])
    said = {name: NAME_WITHIN.sub(_word_of, text) for name, text in said.items()}
    said["found"] = WHOLE.sub(r"\1", said["found"])
    return error if said == texts else error.with_facts(**said)


def told_as_typed(error) -> str:
    """Write an error in the active language, with options as they were typed."""
    error = _once(error)
    is_price = getattr(error, "found", "").partition(" ")[0] in PRICES
    text = told(as_typed(error) if is_price else error)
    problems = getattr(error, "problems", (error,))
    text = _with_typed_settings(text, filter(_is_of_typed_setting, problems))
    if any(map(_is_of_file, problems)):
        return text
    text = NAME_AT_FIRST.sub(_named, _with_typed_words(text))
    return WHOLE.sub(r"\1", NAME_WITHIN.sub(_word_of, text))


def _without_question_of_unit(error):
    """The error without "Did you give kilometres?", where a unit was typed."""
    option = NAME_AT_FIRST.match(getattr(error, "found", ""))
    if option is None or not OF_UNITS.match(error.remedy or ""):
        return error
    values = typed_options().values
    typed = values.get(option[1]) or values.get(OTHER_NAMES.get(option[1])) or ""
    return error.with_facts(remedy="") if WITH_UNIT.search(typed) else error


def _once(error):
    """Leave out problems that are the same as others when options are named."""
    if not isinstance(error, BlockError):
        return _without_question_of_unit(error)
    if any(map(_is_of_file, error.problems)):
        return error
    said = {str(as_typed(problem)): problem for problem in error.problems}
    if len(said) == len(error.problems):
        return error
    problems = list(said.values())
    return BlockError(problems) if len(problems) > 1 else problems[0]


def _is_of_file(error):
    return error.file is not None or error.section is not None


def _is_of_typed_setting(error):
    """Whether it is about a setting of the command line, which goes before the file."""
    is_said = error.section == SETTINGS and error.file is None
    return is_said and error.key in typed_options().typed


def _with_typed_settings(text, errors):
    for error in errors:
        text = text.replace(f"[{SETTINGS}] {error.key} ", f"{option_of(error.key)} ")
    return text


def _named(found):
    name = found[1]
    if name in PRICES and "costs" in typed_options().typed:
        return f"{option_of('costs')}: {name}"
    return _word_of(found)


def _word_of(found):
    return typed_options().word(found[1]) or found[1]


def _with_typed_words(text):
    """Write the word of an option that was typed in place of its other words."""
    options = typed_options()
    for name, word in options.typed.items():
        others = "|".join(re.escape(one) for one in options.known[name] if one != word)
        if others:
            text = re.sub(rf"(?<![\w-])(?:{others})(?![\w-])", word, text)
    return ASSIGNED.sub(_assigned, text)


def _assigned(found):
    word = typed_options().word(found[1])
    return found[0] if word is None else f"{word} {found[2]}"
