"""Wrong calls: what was found, what is expected, and how to mend it.

The library that reads the command line has sentences of its own; all of them are told
here as any other error is.
"""

import re

import typer

from einschalt.foundations.errors import SettingsError
from einschalt.foundations.language import mark
from einschalt.foundations.near_words import nearest
from einschalt.interfaces.cli.typed_options import typed_options

# of the copy of click that typer brings
UsageError = typer.BadParameter.__base__
ALIKE = 0.7  # of a name that is written wrongly
CHOICE = re.compile(r"(?P<value>.+) is not one of (?P<known>'.+')\.?", re.DOTALL)
QUOTED = re.compile("'([^']*)'")
LEFT_OVER = re.compile(r"Got unexpected extra argument\(s\) \((.*)\)", re.DOTALL)
NO_COMMAND = re.compile(r"No such command '(?P<name>.*?)'\..*", re.DOTALL)
VALUE = "VALUE"  # where an option has no other word for what stands behind it
NO_COMMAND_AT_ALL = "Missing command."
OF_CHECKED_VALUE = "Value error, "
# what the library of the types says of a value, and what is expected
OF_VALUES = (
    (r"Input should be a valid number.*", mark("a number")),
    (r"Input should be a valid integer.*", mark("a whole number")),
    (r"Input should be greater than or equal to (.+)", mark("{0} or more")),
    (r"Input should be less than or equal to (.+)", mark("{0} or less")),
)


class WrongValueError(typer.BadParameter):
    """A value that an option cannot have, told as other errors are."""

    def __init__(self, found, *, expected, remedy=""):
        super().__init__(found)
        self.facts = {"expected": expected, "remedy": remedy}


def fault_of(error, context) -> SettingsError:
    """Tell what the library finds wrong with a call."""
    if isinstance(error, WrongValueError):
        return _of_own(error)
    tell = {
        "NoSuchOption": _of_unknown_option,
        "BadOptionUsage": _of_option,
        "MissingParameter": _of_missing,
        "BadParameter": _of_value,
    }
    tell = tell.get(type(error).__name__, _of_message)
    return tell(error, error.ctx or context)


def _of_own(error):
    found, name = error.message, _name_of(error)
    return SettingsError(f"{name}: {found}" if name else found, **error.facts)


def _name_of(error):
    """Option or argument that an error is about, as it was typed."""
    param = error.param
    if param is None:
        return error.param_hint or ""
    if param.param_type_name == "argument":
        return param.metavar or param.name.upper()
    return typed_options().typed.get(param.name, param.opts[0])


def _of_unknown_option(error, context):
    name, command = error.option_name, context.command_path
    words = [word for one in context.command.params for word in one.opts]
    known = [word for word in words if word.startswith("--")]
    near = nearest(name, known, alike=ALIKE)
    remedy = f"See {command} --help"
    return SettingsError(
        f"{command} has no option {name}",
        expected="one that its help lists",
        remedy=f"Did you mean {near}?" if near else remedy,
    )


def _of_option(error, context):
    name = error.option_name
    if "does not take" in error.message:
        return SettingsError(
            f"{name} has a value", expected="the option alone", remedy=f"Write {name}"
        )
    among = [one for one in context.command.params if name in one.opts]
    value = (among and among[0].metavar) or VALUE
    return SettingsError(
        f"{name} has no value",
        expected="one behind it",
        remedy=f"Write {name} {value}",
    )


def _of_missing(error, _context):
    param, name = error.param, _name_of(error)
    to_write = name
    if param.param_type_name == "option":
        to_write = f"{name} {param.metavar or VALUE}"
    help_text = getattr(param, "help", None) or name
    return SettingsError(
        f"{name} is missing",
        expected=f"a value: {help_text}",
        remedy=f"Write {to_write} as well",
    )


def _of_value(error, _context):
    name = _name_of(error)
    why = error.message.removeprefix(OF_CHECKED_VALUE)
    if choice := CHOICE.fullmatch(why):
        return _of_choice(name, choice["value"], QUOTED.findall(choice["known"]))
    value = error.param and typed_options().values.get(error.param.name)
    found = name if value is None else f"{name} = {value!r}"
    for pattern, expected in OF_VALUES:
        if limit := re.fullmatch(pattern, why):
            return SettingsError(found, expected=expected.format(*limit.groups()))
    return SettingsError(f"{found}: {why}" if found else why)


def _of_choice(name, value, known):
    near = nearest(value.strip("'"), known, alike=ALIKE)
    return SettingsError(
        f"{name} = {value}",
        expected=_one_of(known),
        remedy=f"Did you mean {near!r}?" if near else "",
    )


def _of_message(error, context):
    command = context.command_path
    pieces = context.command.collect_usage_pieces(context)
    if left := LEFT_OVER.fullmatch(error.message):
        return SettingsError(
            f"{command} has no place for {left[1]!r}",
            expected=" ".join([command, *pieces]),
            remedy="Leave it out; a name with blanks in it stands in quotes",
        )
    if error.message == NO_COMMAND_AT_ALL:
        return SettingsError(
            f"{command} was called without a command", expected=_commands_of(context)
        )
    if unknown := NO_COMMAND.fullmatch(error.message):
        known = list(context.command.commands)
        near = nearest(unknown["name"], known, alike=ALIKE)
        return SettingsError(
            f"{command} has no command {unknown['name']!r}",
            expected=_commands_of(context),
            remedy=f"Did you mean {near!r}?" if near else "",
        )
    return SettingsError(error.message)


def _commands_of(context):
    return _one_of(list(context.command.commands))


def _one_of(words):
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} or {words[-1]}"
