"""What ``einschalt simulate`` does."""

from dataclasses import replace

from einschalt.foundations.language import mark, translated
from einschalt.interfaces import python_api
from einschalt.interfaces.cli.exits import print_out
from einschalt.interfaces.cli.outcome import report
from einschalt.interfaces.files.block_writing import require_block_place
from einschalt.interfaces.files.output_folder import held_folder
from einschalt.interfaces.files.table_output import output_of_question, write_tables_of
from einschalt.interfaces.files.tables_by_suffix import write_table
from einschalt.interfaces.files.written_files import PROVENANCE
from einschalt.pipeline.simulation.repetitions import (
    Experiment,
    repeat_simulation,
    summarize_repetitions,
)
from einschalt.pipeline.simulation.simulate_block import PRESETS

REPETITIONS = "repetitions.csv"


def simulate(output, preset, seed, *, repeat, workers, scheduler, overwrite, **values):
    """Write a block, or repetitions of many, with what is given for the preset's."""
    for flight in ("high", "low"):
        values[f"{flight}_gross_error_share"] = values["gross_errors"]
        values[f"{flight}_gross_error_um"] = values["gross_error_um"]
    usual = PRESETS[preset]
    design = (
        preset,
        *(_replaced(part, values) for part in (usual.geometry, usual.noise)),
    )
    if repeat is None:
        _simulate_folder(design, seed, output, overwrite=overwrite)
    else:
        engine = python_api.chosen_engine(scheduler, workers)
        _repeat_design(design, repeat, seed, engine, output, overwrite=overwrite)


def _replaced(part, values):
    """Geometry or noise, with those of its fields replaced that were given."""
    names = [name for name in part.__dataclass_fields__ if values.get(name) is not None]
    return replace(part, **{name: values[name] for name in names})


def _simulate_folder(design, seed, output, *, overwrite):
    require_block_place(output, overwrite=overwrite)
    preset, geometry, noise = design
    block = python_api.simulate_block(preset, seed=seed, geometry=geometry, noise=noise)
    block.write(output, overwrite=overwrite)
    report(output, block=block.name, n_points=len(block.truth), seed=seed)
    message = mark("{block}: {n:point|points}, seed {seed}")
    facts = {"n": len(block.truth), "seed": f"{seed:d}"}
    print_out(translated(message, block=block.name, **facts))
    message = mark("Block in {folder}, true coordinates in {file}")
    print_out(translated(message, folder=output, file=output / "truth.csv"))


def _repeat_design(design, count, seed, engine, output, *, overwrite):
    asked = {"simulated": design, "count": count, "seed": seed}
    names = (REPETITIONS, PROVENANCE)
    place = output_of_question("simulate", asked, names, overwrite=overwrite)
    with held_folder(output, place):
        table = repeat_simulation(Experiment(*design), count, engine, first_seed=seed)
        write_tables_of(
            place, output, lambda new: write_table(table, new / REPETITIONS)
        )
    report(output / REPETITIONS, n_repetitions=len(table))
    print_out(summarize_repetitions(table))
    file = output / REPETITIONS
    print_out(translated("Every repetition in {file}", file=file))
