"""What ``einschalt plan`` does; its tables take neither pandas nor numba along."""

from dataclasses import replace

from einschalt.foundations.typesetting import wrapped
from einschalt.interfaces.cli import plan_answers
from einschalt.interfaces.cli.exits import print_out
from einschalt.interfaces.cli.plan_values import asked_of

QUESTION = {"tables": "the tables", "target": "--target", "expect": "--expect"}


def plan_flight(options, typed):
    """Answer what a planner asks: print it, and write what was asked for.

    Parameters
    ----------
    options : dict
        Values of all options.
    typed : list of str
        Names of the options that were written on the command line.

    Raises
    ------
    EinschaltError
        A value is not sensible, or the results cannot be written.
    """
    asked = asked_of(options, typed)
    answer = _answer(asked)
    if options["terrain"] is not None:
        # imported when a terrain is given: the tables alone come faster
        from einschalt.interfaces.cli.plan_terrain import with_terrain  # noqa: PLC0415

        answer = with_terrain(answer, options["terrain"], asked)
    print_out(answer.text)
    figure, output = options["figure"], options["output"]
    if figure is not None:
        _write_figure(answer, figure)
        print_out(f"\nFigure in {figure}")
    if output is not None:
        _write(answer, output)
        print_out(f"\nPlan in {output}")


def _answer(asked):
    """Answer what was asked, and say which options did not count."""
    if asked.question == "tables":
        given = plan_answers.tables(asked)
    else:
        # imported when they are asked for: propagation takes numba along
        from einschalt.interfaces.cli import plan_layouts  # noqa: PLC0415

        ways = {"target": plan_layouts.search, "expect": plan_layouts.layout}
        given = ways[asked.question](asked)
    if not asked.unused:
        return given
    options = ", ".join(f"--{name.replace('_', '-')}" for name in asked.unused)
    said = f"Not used for {QUESTION[asked.question]}: {options}."
    return replace(given, text=f"{given.text}\n\n{wrapped(said, indent='  ')}")


def _write(answer, output):
    """Write one table, or a folder with everything."""
    # imported when something is written: the text needs no pandas
    from einschalt.interfaces.files import tables_by_suffix  # noqa: PLC0415
    from einschalt.interfaces.files.plan_folder import write_plan  # noqa: PLC0415
    from einschalt.interfaces.reports.figure_files import figure_bytes  # noqa: PLC0415

    if output.suffix:
        table = next(iter(answer.tables().values()))
        tables_by_suffix.write_table(table, output)
        return
    figures = {name: figure_bytes(drawn) for name, drawn in answer.figures().items()}
    write_plan(output, answer.tables(), figures, answer.text)


def _write_figure(answer, file):
    """Write the first figure in the format that the suffix names."""
    # imported when a figure is written: matplotlib takes its time
    from einschalt.interfaces.reports.figure_files import write_figure  # noqa: PLC0415

    write_figure(lambda: next(iter(answer.figures().values())), file)
