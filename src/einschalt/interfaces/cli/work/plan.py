"""What ``einschalt plan`` does; its tables take neither pandas nor numba along."""

from dataclasses import replace

import typer

from einschalt.foundations.language import mark, translated, written_in
from einschalt.foundations.typesetting import wrapped
from einschalt.interfaces.cli import plan_answers
from einschalt.interfaces.cli.exits import UNREACHED, print_out
from einschalt.interfaces.cli.outcome import is_recorded, report, report_problems
from einschalt.interfaces.cli.plan_values import asked_of
from einschalt.interfaces.cli.progress import late_steps
from einschalt.interfaces.cli.typed_options import option_of

QUESTION = {
    "tables": mark("the tables"),
    "target": "--target",
    "area": "--area",
    "expect": "--expect",
}


def plan(context, **options):
    """Answer what a planner asks: print it, and write what was asked for."""
    source = context.get_parameter_source
    # in the order in which they were typed
    typed = [name for name in context.params if source(name).name == "COMMANDLINE"]
    asked = asked_of(options, typed)
    figure, output = options["figure"], options["output"]
    place = None if output is None and figure is None else _place(options)
    unused = ""
    if asked.unused:  # told before the work, which may be waited for
        with written_in("en"):  # as all problems that programs are told
            report_problems(_said_of_unused(asked))
        unused = wrapped(_said_of_unused(asked), indent="  ") + "\n"
        print_out(unused)
    answer = _answer(asked)
    if options["terrain"] is not None:
        # imported when a terrain is given: the tables alone come faster
        from einschalt.interfaces.cli.plan_terrain import with_terrain  # noqa: PLC0415

        answer = with_terrain(answer, options["terrain"], asked)
    if is_recorded():  # tables are made when they are asked for
        report(question=asked.question, **_headline(answer))
        report_problems(*answer.notes)
    print_out(answer.text)
    answer = replace(answer, text="\n".join(filter(None, (unused, answer.text))))
    if output is not None:
        _write(answer, output, place)
        report(output)
        print_out("\n" + translated("Plan in {output}", output=output))
    if figure is not None:
        _write_figure(answer, figure, place)
        report(figure)
        print_out("\n" + translated("Figure in {figure}", figure=figure))
    if answer.problem is not None:
        report_problems(answer.problem)
        raise typer.Exit(UNREACHED)


def _answer(asked):
    """Answer what was asked."""
    if asked.question == "tables":
        return plan_answers.tables(asked)
    return _way_to(asked.question)(asked)


def _said_of_unused(asked):
    """Say which options do not count for the question."""
    return translated(
        "Not used for {question}: {options}.",
        question=translated(QUESTION[asked.question]),
        options=", ".join(map(option_of, asked.unused)),
    )


def _way_to(question):
    """What answers a question; it is imported when it is asked for."""
    if question == "area":
        # polygons take shapely along, and heights formats of theirs
        from einschalt.interfaces.cli import plan_area  # noqa: PLC0415

        return plan_area.over_area
    # propagation takes numba along
    from einschalt.interfaces.cli import plan_layouts  # noqa: PLC0415

    return {"target": plan_layouts.search, "expect": plan_layouts.layout}[question]


def _headline(answer):
    """What was recommended, or the rows of the first table."""
    if answer.headline is not None:
        return answer.headline()
    rows = next(iter(answer.tables().values())).to_dict("records")
    # names of one of several rows would say that it is chosen
    return {**(rows[0] if len(rows) == 1 else {}), "combinations": rows}


def _place(options):
    """What is written, known by all that was asked; refused at once if it cannot be."""
    # imported when something is written: the text needs nothing of it
    from einschalt.interfaces.files.atomic import require_writable  # noqa: PLC0415
    from einschalt.interfaces.files.output_folder import require_free  # noqa: PLC0415
    from einschalt.interfaces.files.plan_folder import (  # noqa: PLC0415
        require_figure_suffix,
    )
    from einschalt.interfaces.files.table_output import (  # noqa: PLC0415
        output_of_question,
        require_file_place,
    )
    from einschalt.interfaces.files.tables_by_suffix import (  # noqa: PLC0415
        require_written_suffix,
    )

    apart = {"output", "figure", "overwrite"}
    asked = {name: value for name, value in options.items() if name not in apart}
    given = (options[name] for name in ("terrain", "area", "ground_heights"))
    files = [file for file in given if file is not None]
    names, overwrite = ("summary.txt", "provenance.json"), options["overwrite"]
    place = output_of_question("plan", asked, names, files, overwrite=overwrite)
    output, figure = options["output"], options["figure"]
    if figure is not None:
        require_figure_suffix(figure)
        require_file_place(figure)
    if output is not None and _is_file(output):
        require_written_suffix(output)
        require_file_place(output)
    elif output is not None:
        require_free(output, place)
        require_writable(output)
    return place


def _is_file(output):
    """Whether the name is that of a file; one as plan_v1.2 is that of a folder."""
    return bool(output.suffix) and not output.suffix[1:].isdigit()


def _write(answer, output, place):
    """Write one table, or a folder with everything."""
    # imported when something is written: the text needs no pandas
    from einschalt.interfaces.files import (  # noqa: PLC0415
        plan_file,
        plan_folder,
        table_output,
    )
    from einschalt.interfaces.files.tables_by_suffix import write_table  # noqa: PLC0415
    from einschalt.interfaces.reports.figure_files import figure_bytes  # noqa: PLC0415

    if _is_file(output):
        table = next(iter(answer.tables().values()))
        table_output.write_file(output, place, lambda path: write_table(table, path))
        return
    drawn, figures = answer.figures(), {}
    with late_steps() as progress:
        for k, (name, one) in enumerate(drawn.items()):
            progress("drawing figures", k / len(drawn))
            figures[name] = figure_bytes(one)

    def write(new):
        plan_folder.write_plan(new, answer.tables(), figures, answer.text)
        if answer.files is not None:
            answer.files(new)
        if answer.planned is not None:
            planned, frame = answer.planned()
            plan_file.write_plan_file(new, planned, _headline(answer), frame)

    table_output.write_tables_of(place, output, write)


def _write_figure(answer, file, place):
    """Write the first figure in the format that the suffix names."""
    # imported when a figure is written: matplotlib takes its time
    from einschalt.interfaces.files.plan_folder import write_figure  # noqa: PLC0415
    from einschalt.interfaces.files.table_output import write_file  # noqa: PLC0415

    def first():
        return next(iter(answer.figures().values()))

    write_file(file, place, lambda path: write_figure(first, path))
