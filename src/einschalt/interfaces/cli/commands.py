"""How every command reads its words and writes its help."""

import re

import typer
from typer.core import TyperCommand, TyperGroup

from einschalt.interfaces.cli.lengths import unit_of, with_numbers

# a hyphen at which no line is broken, of the same width; made a plain one at the end
UNBROKEN = "\u2011"


class WholeWords(typer.Context.formatter_class):
    """Help whose lines break between words, and not at the hyphens in them."""

    def write_text(self, text):
        """Write a paragraph."""
        super().write_text(_unbroken(text))

    def write_usage(self, prog, args="", prefix=None):
        """Write the usage."""
        super().write_usage(prog, _unbroken(args), prefix)

    def write_dl(self, rows, *args, **options):
        """Write a list of options or commands."""
        whole = [tuple(map(_unbroken, row)) for row in rows]
        super().write_dl(whole, *args, **options)

    def getvalue(self):
        """The text as it is shown."""
        return super().getvalue().replace(UNBROKEN, "-")


def _unbroken(text):
    return re.sub(r"(?<=\S)-(?=\S)|-(?=[-\w])", UNBROKEN, text)


class Context(typer.Context):
    """Context of a command, with that help."""

    formatter_class = WholeWords


class Command(TyperCommand):
    """A command whose options of lengths take units: ``--spacing 250m``."""

    context_class = Context

    def parse_args(self, ctx, args):
        """Parse the words, lengths as numbers in the unit of their option."""
        units = {
            name: unit
            for option in self.params
            if (unit := unit_of(getattr(option, "help", None)))
            for name in option.opts
        }
        return super().parse_args(ctx, with_numbers(args, units))


class Group(TyperGroup):
    """A group of commands with that help."""

    context_class = Context
