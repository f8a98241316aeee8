"""Everything that is wrong with a block's input, that of its computation included."""

from dataclasses import replace

from einschalt.foundations.errors import EinschaltError
from einschalt.interfaces.programs.block_tables import find_problems
from einschalt.pipeline.block.memory import require_memory
from einschalt.pipeline.block.output_system import with_output_system


def everything_wrong(block, given=None):
    """Findings of a block's folder; its faults are collected and not raised.

    ``given``: settings that go before those of block.toml.
    """
    return _with_size(_with_output(find_problems(block, given)))


def _with_output(found):
    """Findings with what is wrong with the system in which results are to be told."""
    if found.block is None:
        return found
    try:
        with_output = with_output_system(found.block, found.block.settings)
    except EinschaltError as error:
        return replace(found, problems=(*found.problems, error))
    return replace(found, notes=with_output.notes)


def _with_size(found):
    """Findings with a lack of memory that the computation would have."""
    if found.block is None:
        return found
    try:
        require_memory(found.block)
    except EinschaltError as error:
        return replace(found, problems=(*found.problems, error))
    return found
