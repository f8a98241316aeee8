"""What ``einschalt simulate`` does."""

from einschalt.foundations.language import mark, translated
from einschalt.foundations.typesetting import wrapped
from einschalt.interfaces import python_api, python_simulation
from einschalt.interfaces.cli.exits import print_out
from einschalt.interfaces.cli.outcome import report, report_problems
from einschalt.interfaces.cli.progress import late_progress, late_steps
from einschalt.interfaces.cli.simulated_design import Asked, asked_of
from einschalt.interfaces.files.block_writing import require_block_place
from einschalt.interfaces.files.output_folder import held_folder
from einschalt.interfaces.files.table_output import output_of_question, write_tables_of
from einschalt.interfaces.files.tables_by_suffix import write_table
from einschalt.interfaces.files.written_files import PROVENANCE
from einschalt.pipeline.block.block import plain_fields
from einschalt.pipeline.simulation.repetitions import (
    chance_of_error,
    claim_and_truth,
    describe_trial,
    figures_of_repetitions,
    repeat_simulation,
    summarize_repetitions,
)

REPETITIONS = "repetitions.csv"


def simulate(
    output, seed, *, repeat, workers, scheduler, overwrite, compare, **options
):
    """Write a block, or repetitions of many, with what is given for the preset's."""
    for flight in ("high", "low"):
        options[f"{flight}_gross_error_share"] = options["gross_errors"]
        options[f"{flight}_gross_error_um"] = options["gross_error_um"]
    if repeat is not None:
        engine = python_api.chosen_engine(scheduler, workers)
        asked = _told_of_heights(asked_of(options))
        _repeat(asked, repeat, seed, engine, output, overwrite=overwrite)
        return
    require_block_place(output, overwrite=overwrite)
    asked = _told_of_heights(asked_of(options))
    block = _write_block(asked, seed, output, overwrite=overwrite)
    if asked.planned is not None:
        report(planned=asked.planned)
        if compare:
            _compare(asked.planned, block)


def _told_of_heights(asked: Asked) -> Asked:
    """Say how high a camera's flight is, before the work, which may be waited for."""
    if asked.heights is not None:
        for line in asked.heights.lines:
            print_out(wrapped(line, indent="  "))
        report_problems(*asked.heights.problems)
    return asked


def _write_block(asked: Asked, seed, output, *, overwrite):
    simulated = asked.experiment.block(seed)
    block = python_simulation.SimulatedBlock(**plain_fields(simulated))
    block.write(output, overwrite=overwrite)
    report(output, block=block.name, n_points=len(block.truth), seed=seed)
    message = mark("{block}: {n:point|points}, seed {seed}")
    facts = {"n": len(block.truth), "seed": f"{seed:d}"}
    print_out(translated(message, block=block.name, **facts))
    message = mark("Block in {folder}, true coordinates in {file}")
    print_out(translated(message, folder=output, file=output / "truth.csv"))
    return block


def _compare(planned, block):
    """Compute a block as densify does by default, and set its precision beside."""
    with late_progress() as progress:
        result = python_api.densify(block, progress=progress)
    row, chance = claim_and_truth(block, result), chance_of_error(result)
    report(
        n_new=row["n_points"],
        standard_error_total=row["standard_error_total"],
        error_total=row["error_total"],
        error_total_by_chance=chance,
    )
    print_out("\n" + describe_trial(planned, row, chance))


def _repeat(asked: Asked, count, seed, engine, output, *, overwrite):
    facts = {"simulated": asked.experiment, "count": count, "seed": seed}
    names = (REPETITIONS, PROVENANCE)
    place = output_of_question("simulate", facts, names, overwrite=overwrite)
    with held_folder(output, place):
        with late_steps() as progress:
            given = {"first_seed": seed, "progress": progress}
            table = repeat_simulation(asked.experiment, count, engine, **given)
        write_tables_of(
            place, output, lambda new: write_table(table, new / REPETITIONS)
        )
    figures = figures_of_repetitions(table)
    report(output / REPETITIONS, n_repetitions=len(table), **figures)
    if asked.planned is not None:
        report(planned=asked.planned)
    print_out(summarize_repetitions(table, asked.planned))
    file = output / REPETITIONS
    print_out(translated("Every repetition in {file}", file=file))
