"""What ``einschalt simulate`` does."""

from dataclasses import replace
from functools import partial

from einschalt.interfaces import python_api
from einschalt.interfaces.cli.exits import print_out
from einschalt.interfaces.files.block_writing import require_block_place
from einschalt.interfaces.files.output_folder import held_folder, write_folder
from einschalt.interfaces.files.table_output import output_of_question
from einschalt.interfaces.files.tables_by_suffix import write_table
from einschalt.interfaces.files.written_files import PROVENANCE
from einschalt.interfaces.provenance import provenance_of_tables
from einschalt.pipeline.simulation.repetitions import (
    Experiment,
    repeat_simulation,
    summarize_repetitions,
)
from einschalt.pipeline.simulation.simulate_block import PRESETS

REPETITIONS = "repetitions.csv"


def chosen_design(preset, geometry, noise):
    """Preset, geometry and noise, with the values replaced that were given."""
    geometry = replace(PRESETS[preset].geometry, **geometry)
    noise = replace(PRESETS[preset].noise, **noise)
    return preset, geometry, noise


def simulate_folder(design, seed, output, *, overwrite):
    """Simulate a block, and write it as a folder."""
    require_block_place(output, overwrite=overwrite)
    preset, geometry, noise = design
    block = python_api.simulate_block(preset, seed=seed, geometry=geometry, noise=noise)
    block.write(output, overwrite=overwrite)
    print_out(f"{block.name}: {len(block.truth)} points, seed {seed}")
    print_out(f"Block in {output}, true coordinates in {output / 'truth.csv'}")


def repeat_design(design, count, seed, where, output, *, overwrite):
    """Simulate and compute so many blocks, and write what is true and claimed."""
    engine = python_api.chosen_engine(*where)
    asked = {"simulated": design, "count": count, "seed": seed}
    names = (REPETITIONS, PROVENANCE)
    place = output_of_question("simulate", asked, names, overwrite=overwrite)
    with held_folder(output, place):
        table = repeat_simulation(Experiment(*design), count, engine, first_seed=seed)
        facts = provenance_of_tables("simulate")
        write = partial(_write_repetitions, table)
        write_folder(output, place, facts, write, beside=True)
    print_out(summarize_repetitions(table))
    print_out(f"Every repetition in {output / REPETITIONS}")


def _write_repetitions(table, folder):
    write_table(table, folder / REPETITIONS)
