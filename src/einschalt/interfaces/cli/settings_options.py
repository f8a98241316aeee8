"""Options that are fields of Settings: names, words and help are those of the field."""

import functools
import inspect
from pathlib import Path
from typing import Annotated

import typer

from einschalt.interfaces.cli.exits import print_error
from einschalt.pipeline.settings import FORMER_WORDS, Settings, words_of

PLACE = "given"  # argument of a command in whose place the options stand


def with_settings_options(show_default):
    """Give a command one option for each field of Settings.

    They stand in the place of its argument ``given``, and it receives those that were
    given, a dict by name. ``show_default``: what help says of one that is left out.
    """

    def decorate(command):
        @functools.wraps(command)
        def run(**arguments):
            chosen = {name: arguments.pop(name) for name in Settings.model_fields}
            given = {name: word for name, word in chosen.items() if word is not None}
            return command(**arguments, given=given)

        parameters = []
        for parameter in inspect.signature(command).parameters.values():
            is_place = parameter.name == PLACE
            parameters += _options(show_default) if is_place else [parameter]
        run.__signature__ = inspect.Signature(parameters)
        run.__annotations__ = {one.name: one.annotation for one in parameters}
        return run

    return decorate


def _options(show_default):
    for name, field in Settings.model_fields.items():
        kind, more = _kind(name, field)
        option = typer.Option(show_default=show_default, help=field.description, **more)
        yield inspect.Parameter(
            name,
            inspect.Parameter.KEYWORD_ONLY,
            default=None,
            annotation=Annotated[kind | None, option],
        )


def _kind(name, field):
    """Type of an option, and how typer is to read it."""
    if name in FORMER_WORDS:
        words = words_of(name)
        shown = {"metavar": f"<{'|'.join(words)}>", "autocompletion": lambda: words}
        return str, {"parser": _present_word(name), **shown}
    if words_of(name):
        return field.annotation, {}
    if name == "grids":  # block.toml means its own folder, the command line this one
        parser = {"parser": lambda path: str(Path(path).absolute())}
        return str, {**parser, "metavar": "<folder>"}
    # a preset or a number is read as text, and understood by Settings
    return field.annotation if field.annotation in (int, float) else str, {}


def _present_word(name):
    """Make what reads a word of a field, or the word that it had before."""
    allowed, former = words_of(name), FORMER_WORDS[name]

    def read(word):
        if word in former:
            print_error(f"einschalt: {name} {word} is now called {former[word]}")
            return former[word]
        if word not in allowed:
            words = ", ".join(map(repr, allowed))
            raise typer.BadParameter(f"{word!r} is not one of {words}.")
        return word

    return read
