"""How every command reads its words and writes its help, in the language asked for."""

import os
import re
import shutil
from contextlib import contextmanager
from itertools import pairwise

import typer
from typer.core import TyperCommand, TyperGroup

from einschalt.foundations.display_names import printable
from einschalt.foundations.kept_texts import retold
from einschalt.foundations.language import (
    LANGUAGES,
    language_of_locale,
    mark,
    mark_each,
    numbers_set,
    translated,
)
from einschalt.foundations.number_parsing import is_number
from einschalt.foundations.told_errors import told
from einschalt.interfaces.cli.lengths import UNITS, WHOLE_NUMBERS, with_numbers
from einschalt.interfaces.cli.outcome import report_problems
from einschalt.interfaces.cli.typed_options import remember_typed
from einschalt.interfaces.cli.wrong_calls import UsageError, fault_of

LANGUAGE = "--language"
# what click writes by itself
HEADINGS = mark_each(
    {"Options": "Options", "Arguments": "Arguments", "Commands": "Commands"}
)
USAGE = mark("Usage: ")
PLACES = (mark("[OPTIONS]"), mark("COMMAND"), mark("[ARGS]..."))
HELP = mark("Show this message and exit.")
# behind the help of an option: what it is where it is left out, whether it may be
BESIDE = re.compile(r"(?P<text>.*?)(?:  \[(?P<beside>[^\[]*)\])?", re.DOTALL)
# kinds of values, and ranges of them, as click names them
KINDS = mark_each(
    {
        **dict.fromkeys(("float", "float range", "int", "int range"), "<number>"),
        "str": "<text>",
    }
)
KIND = re.compile(r"<((?:float|int)(?: range)?|str)>")
RANGE = re.compile(r"(?:x>=(?P<least>[\d.]+)|(?P<low>[\d.]+)<=x<=(?P<high>[\d.]+))")
# a hyphen at which no line is broken, of the same width; made a plain one at the end
UNBROKEN = "\u2011"


# behind a comma: a place at which a long word without spaces may be broken
BREAK = " \u2060"
LONG = 20  # characters of a word
LONG_WORD = re.compile(rf"\S{{{LONG},}}")
# of a terminal: below it words are cut; and what is left for the help of options
NARROWEST, WIDTH_OF_HELP = 24, 40


class WholeWords(typer.Context.formatter_class):
    """Help whose lines break between words, and not at the hyphens in them."""

    def __init__(self, indent_increment=2, width=None, max_width=None):
        if width is None:  # narrow terminals would break the lines themselves
            columns = min(shutil.get_terminal_size().columns, max_width or 80)
            width = max(columns - 2, NARROWEST)
        super().__init__(indent_increment, width, max_width)

    def write_text(self, text):
        """Write a paragraph."""
        mark_of_examples, _, rest = text.partition("\b\n")
        if not mark_of_examples and rest:  # unwrapped; what is typed stays as it is
            title, _, calls = rest.partition("\n")
            told = f"\b\n{translated(title)}\n{calls}"
        else:
            told = translated(text)
        super().write_text(_unbroken(told))

    def write_usage(self, prog, args="", prefix=None):
        """Write the usage."""
        for place in PLACES:
            args = args.replace(place, translated(place))
        super().write_usage(prog, _unbroken(args), prefix or translated(USAGE))

    def write_heading(self, heading):
        """Write the heading of a list."""
        super().write_heading(translated(HEADINGS.get(heading, heading)))

    def write_dl(self, rows, *args, **options):
        """Write a list of options or commands."""
        whole = [
            (_unbroken(_told_kind(name)), _broken_at_commas(_unbroken(_told(text))))
            for name, text in rows
        ]
        options.setdefault("col_max", min(30, max(self.width - WIDTH_OF_HELP, 6)))
        super().write_dl(whole, *args, **options)

    def getvalue(self):
        """The text as it is shown."""
        text = super().getvalue().replace(UNBROKEN, "-")
        return text.replace(BREAK, "").replace(BREAK.strip(" "), "")


def _told_kind(name):
    """An option and the kind of its value, in no words of programmers.

    >>> _told_kind("--target <float>"), _told_kind("--port <int range>")
    ('--target <number>', '--port <number>')
    """
    return KIND.sub(lambda kind: translated(KINDS[kind[1]]), name)


def _told(text):
    """The help of an option, with what stands in brackets behind it."""
    found = BESIDE.fullmatch(text)
    told = told_help(found["text"])
    if found["beside"] is None:
        return told
    beside = "; ".join(map(_told_beside, found["beside"].split("; ")))
    return f"{told}  [{beside}]"


def told_help(text):
    """The help of an option; some begin with what the option belongs to."""
    if (told := translated(text)) != text:
        return told
    owner, _, rest = text.partition(": ")
    if rest and (told := translated(rest)) != rest:
        return f"{translated(owner)}: {told}"
    return retold(text)


def _told_beside(word):
    """What stands in brackets: ``required``, or ``default: (that of the camera)``."""
    if among := RANGE.fullmatch(word):
        return _told_range(**among.groupdict())
    kind, _, value = word.partition(": ")
    if kind != "default":
        return translated("required") if word == "required" else word
    is_said = value.startswith("(") and value.endswith(")")
    value = f"({translated(value[1:-1])})" if is_said else _told_number(value)
    return translated("default: {value}", value=value)


def _told_range(least, low, high):
    """Which values an option takes."""
    if least is not None:
        return translated("at least {value}", value=_told_number(least))
    low, high = map(_told_number, (low, high))
    return translated("{low} to {high}", low=low, high=high)


def _told_number(value):
    """A default that is one number, as it may be typed; anything else as it is."""
    return numbers_set(value) if is_number(value) else value


def language_asked(words):
    """Language that the words of a command line ask for, or the locale.

    Help and what click says come before any option is read.
    """
    given = [
        word.partition("=")[2] for word in words if word.startswith(f"{LANGUAGE}=")
    ]
    given += [value for word, value in pairwise(words) if word == LANGUAGE]
    known = [name for name in given if name in LANGUAGES]
    return known[-1] if known else language_of_locale(os.environ)


def _unbroken(text):
    return re.sub(r"(?<=\S)-(?=\S)|-(?=[-\w])", UNBROKEN, text)


def _broken_at_commas(text):
    """Let long lists without spaces be broken, as image=10,model=20,setting=0.5."""
    return LONG_WORD.sub(lambda word: word[0].replace(",", f",{BREAK}"), text)


class Context(typer.Context):
    """Context of a command, with that help."""

    formatter_class = WholeWords


class CallError(UsageError):
    """A mistaken call, told in the language asked for."""

    def __init__(self, fault, context):
        super().__init__(str(fault), context)
        self.fault = fault

    def show(self, file=None):
        """Print how the command is called, where its help is, and what is wrong."""
        command = self.ctx.command_path
        for line in (
            self.ctx.get_usage(),
            translated("Try '{command} --help' for help.", command=command),
            "",
            printable(translated("Error: {found}", found=told(self.fault))),
        ):
            typer.echo(line, file=file, err=True, color=self.ctx.color)
        report_problems(self.fault)


@contextmanager
def told_call_errors(context):
    """Tell what click finds wrong with the words of a command."""
    try:
        yield
    except UsageError as error:
        is_help = type(error).__name__ == "NoArgsIsHelpError"
        if is_help or isinstance(error, CallError):
            raise
        told_error = CallError(fault_of(error, context), error.ctx or context)
        raise told_error from None


# whether an option takes one number; others than these tell of commas themselves
IS_ONE = {float: True, list[str]: False}


class Command(TyperCommand):
    """A command whose numbers have units and decimal commas: ``--spacing 250,5m``."""

    context_class = Context

    def parse_args(self, ctx, args):
        """Parse the words, numbers as they are read and in the unit of their option."""
        options = {}
        for option in self.params:
            is_one = IS_ONE.get(option.type_descriptor.annotation)
            unit = UNITS.get(option.name)
            if option.name not in WHOLE_NUMBERS and (is_one is not None or unit):
                options |= dict.fromkeys(option.opts, (unit, is_one))
        remember_typed(self.params, args)
        with told_call_errors(ctx):
            return super().parse_args(ctx, with_numbers(args, options))


class Group(TyperGroup):
    """A group of commands with that help."""

    context_class = Context

    def parse_args(self, ctx, args):
        """Parse the words before the command."""
        with told_call_errors(ctx):
            return super().parse_args(ctx, args)

    def invoke(self, ctx):
        """Run the command, if the words name one."""
        with told_call_errors(ctx):
            return super().invoke(ctx)

    def resolve_command(self, ctx, args):
        """Find the command that the words name."""
        with told_call_errors(ctx):
            return super().resolve_command(ctx, args)
