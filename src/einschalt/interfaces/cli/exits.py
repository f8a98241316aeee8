"""How commands end: errors without traceback, exit statuses, readers that go away."""

import functools
import inspect
import os
import sys
from importlib import import_module
from time import perf_counter
from typing import Annotated, Literal

import typer

from einschalt.foundations.compiled_code import NO_CACHE, is_cache_temporary
from einschalt.foundations.display_names import printable
from einschalt.foundations.errors import EinschaltError
from einschalt.foundations.garbage import made_for_good
from einschalt.foundations.interruptions import Terminated, ended_in_order
from einschalt.foundations.kept_texts import retold
from einschalt.foundations.language import (
    LANGUAGES,
    figure,
    language,
    mark,
    translated,
    written_in,
)
from einschalt.foundations.limited_memory import prepare_for_limits
from einschalt.foundations.system_errors import reason_of
from einschalt.interfaces.batch.memory_errors import lack_of_memory
from einschalt.interfaces.cli.outcome import is_recorded, report_problems
from einschalt.interfaces.cli.typed_options import as_typed, told_as_typed

FAULT = 1  # of the program, which keeps its traceback, as Python has it
UNREACHED = 1  # the work is done, and no plan reaches what was asked for
WRONG = 2
REFUTED = 3  # with --strict: the work is done, and its claim does not stand
INTERRUPTED = 130
BY_SIGNAL = 128  # and its number, as a shell has it
INTERRUPTED_WHOLE = mark("einschalt: interrupted; files that are there are whole")
ENDED_WHOLE = mark("einschalt: ended by {signal}; files that are there are whole")
JSON = "--json"
# options of every command
HABITS = {
    "json": (JSON, "Print one JSON object; text goes to standard error."),
    "verbose": ("--verbose -v", "Report the options in effect and the time taken."),
}
KINDS_TO_PRINT = (str, bool, int, float, os.PathLike)
NO_MEMORY = (
    "einschalt: there is not enough memory for this. Take fewer points of a model, "
    "such as a tenth of a matched cloud, or give it more memory."
)


def with_exit_status(command):
    """End a command with a message and a status instead of a traceback.

    An :class:`EinschaltError`, an error of the operating system, or a lack of memory
    ends with status 2, an interruption with 130, a signal that ends it with 128 and its
    number; a fault of the program keeps its traceback. What is printed is in the
    language of ``--language``, or that of the whole command line.
    """

    @functools.wraps(command)
    def run(*args, **kwargs):
        verbose = kwargs.pop("verbose", False)
        kwargs.pop("json", None)  # heard before: see the group of commands
        spoken = kwargs.pop("language", None) or language()
        with written_in(spoken):
            end(args, kwargs, verbose=verbose)

    def end(args, kwargs, *, verbose):
        started = perf_counter()
        try:
            with ended_in_order():
                command(*args, **kwargs)
        except EinschaltError as error:
            report_problems(as_typed(error))
            print_error(f"einschalt: {told_as_typed(error)}")
            raise typer.Exit(WRONG) from None
        except Exception as error:
            said = _said_of(error)
            if said is None:
                raise
            report_problems(said)
            print_error(retold(said))
            raise typer.Exit(WRONG) from None
        except Terminated as signal:
            print_error(translated(ENDED_WHOLE, signal=signal))
            raise typer.Exit(BY_SIGNAL + signal.number) from None
        except KeyboardInterrupt:
            print_error(translated(INTERRUPTED_WHOLE))
            raise typer.Exit(INTERRUPTED) from None
        finally:
            if verbose:
                _print_circumstances(kwargs, perf_counter() - started)

    return _with_habits(run, command)


def _said_of(error):
    """What to say of an error of the system; None of a fault of the program."""
    if lack_of_memory(error, "") is not None:
        return NO_MEMORY
    if not isinstance(error, OSError):
        return None
    where = f"{error.filename}: " if error.filename else ""
    return f"einschalt: {where}{reason_of(error)}"


def _with_habits(run, command):
    """The command with the options that every command has."""
    parameters = list(inspect.signature(command).parameters.values())
    for name, (words, text) in HABITS.items():
        option = typer.Option(*words.split(), help=text)
        kind, annotation = inspect.Parameter.KEYWORD_ONLY, Annotated[bool, option]
        new = inspect.Parameter(name, kind, default=False, annotation=annotation)
        parameters.append(new)
    parameters.append(_language_option())
    run.__signature__ = inspect.Signature(parameters)
    run.__annotations__ = {one.name: one.annotation for one in parameters}
    return run


def _language_option():
    """The option ``--language`` of every command."""
    option = typer.Option(
        show_default="that of the locale", help="Language of output, reports and help."
    )
    annotation = Annotated[Literal[LANGUAGES] | None, option]
    kind = inspect.Parameter.KEYWORD_ONLY
    return inspect.Parameter("language", kind, default=None, annotation=annotation)


def _print_circumstances(options, seconds):
    """Say on standard error what a call amounted to."""
    from importlib.metadata import version  # noqa: PLC0415 - for a quick start

    given = {k: v for k, v in options.items() if isinstance(v, KINDS_TO_PRINT)}
    for name, value in given.items():
        print_error(f"  {name} = {value}")
    python = ".".join(map(str, sys.version_info[:3]))
    print_error(
        f"einschalt {version('einschalt')}, Python {python}: {figure(seconds, '.2f')} s"
    )


def done_in_work(command):
    """Give a command, of options and help alone, the function of its name in ``work/``.

    That is imported when the command runs, so that help does not wait for it.
    """

    @functools.wraps(command)
    def run(**options):
        name = command.__name__
        prepare_for_limits()
        if is_cache_temporary():
            print_error(f"einschalt: {NO_CACHE}")
        module = _imported_for_good(f"{__package__}.work.{name}")
        getattr(module, name)(**options)

    return run


def _imported_for_good(name):
    """Import a module; what that makes stays until the process ends."""
    if name in sys.modules:
        return sys.modules[name]
    with made_for_good():
        return import_module(name)


def print_out(text=""):
    """Print to standard output; a reader that has gone away is no fault.

    Where an object of JSON will stand there, to standard error.
    """
    if is_recorded():
        print_error(text)
        return
    try:
        typer.echo(_shown(text))
        sys.stdout.flush()
    except BrokenPipeError:
        _forget(sys.stdout)
    except OSError as error:
        _forget(sys.stdout)
        raise OSError(error.errno, error.strerror, "standard output") from None


def print_error(text):
    """Print to standard error."""
    try:
        typer.echo(_shown(text), err=True)
    except OSError:  # nobody listens, or the disk of the log is full: nowhere to say it
        _forget(sys.stderr)


def _shown(text):
    """Lines of text in which no name from a file steers the terminal."""
    return "\n".join(printable(line) for line in str(text).split("\n"))


def open_closed_streams():
    """Give streams that the caller has closed a place where nothing is kept.

    Otherwise the next file that is opened takes the place of standard output, and what
    is printed goes into it.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # the system gives the smallest free number
    if sys.stdout is None:
        sys.stdout = os.fdopen(1, "w", encoding="utf-8", closefd=False)
    if sys.stderr is None:
        sys.stderr = os.fdopen(2, "w", encoding="utf-8", closefd=False)


def _forget(stream):
    """Send the rest of a stream nowhere, so that its last flush does not fail."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, stream.fileno())
    os.close(nowhere)
