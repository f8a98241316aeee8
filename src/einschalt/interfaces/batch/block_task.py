"""A block that a batch may have to compute, and by what its result is known."""

from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

from einschalt.foundations.display_names import as_unicode
from einschalt.foundations.errors import EinschaltError
from einschalt.foundations.language import ENGLISH
from einschalt.interfaces.files.block_parts import FLIGHT_TABLES, POINT_TABLES
from einschalt.interfaces.files.block_toml import (
    BLOCK_FILE,
    named_file,
    read_block_toml,
)
from einschalt.interfaces.files.grid_files import grids_of_block
from einschalt.interfaces.files.input_files import checksum_or_none, companions
from einschalt.interfaces.files.output_folder import InputFiles, Output
from einschalt.interfaces.files.result_folder import RESULT_NAMES
from einschalt.interfaces.files.written_files import Source
from einschalt.interfaces.provenance import digest, libraries


@dataclass(frozen=True)
class BlockTask:
    """A block, and where its result belongs."""

    name: str
    block: Path
    folder: Path  # of its result
    given: dict  # settings that go before those of block.toml
    # what its result depends on, as it was when the block was looked at: version of
    # einschalt, versions of libraries and of the data of PROJ, settings (None where
    # block.toml cannot be read), and inputs, SHA-256 by table
    # (None of a file that cannot be read)
    signature: dict
    size: int  # bytes of the inputs
    former: str | None = None  # checksum of the provenance that stood there then
    title: str = ""  # name of the block, as its block.toml gives it
    files: tuple[Path, ...] = ()  # its inputs, block.toml first
    overwrite: bool = False  # whether what else lies in the folder is replaced
    is_known: bool = False  # whether the batch has written a result of it before
    language: str = ENGLISH  # of its summary and report

    def is_of_present_input(self):
        """Whether nothing has changed since the block was looked at."""
        now = task_of(self.name, self.block, self.folder, self.given)
        return now.signature == self.signature


def task_of(name, block, folder, given) -> BlockTask:
    """Look at the inputs of a block."""
    files, settings, title = inputs_of(block, given)
    if settings is not None:
        settings = settings.model_dump(mode="json")
    signature = {
        "version": metadata.version("einschalt"),
        "versions": libraries(),
        "settings": settings,
        "inputs": {table: checksum_or_none(path) for table, path in files.items()},
    }
    # a grid is large, and soon read
    size = sum(_size(path) for t, path in files.items() if not t.startswith("grids."))
    facts = {"title": title, "files": tuple(files.values())}
    return BlockTask(name, block, folder, given, signature, size, **facts)


def output_of_task(task, inputs=None) -> Output:
    """Tell what the computation of a block writes; never its own, or other, inputs."""
    signs = {sign for sign in task.signature["inputs"].values() if sign is not None}
    source = Source("densify", task.title, task.files[:1], digest(sorted(signs)))
    inputs = InputFiles(task.files) if inputs is None else inputs
    options = {"overwrite": task.overwrite, "is_known": task.is_known}
    return Output(source, RESULT_NAMES, inputs, **options)


def inputs_of(block, given):
    """Files that a block reads, by table, its settings and name, as far as known."""
    title = as_unicode(block.resolve().name)
    toml_file = block / BLOCK_FILE
    files = {"block": toml_file}
    try:
        toml = read_block_toml(toml_file)
    except EinschaltError:  # the computation will say it
        return files, None, title
    for name, section in toml.sections.items():
        if name in POINT_TABLES:
            named = {name: section.file}
        else:
            keys = (*FLIGHT_TABLES, "camera")
            named = {f"{name}.{key}": getattr(section, key, None) for key in keys}
        for table, keys in named.items():
            source = named_file(keys)
            if source is not None and source.strip():
                files[table] = block / source
                beside = companions(block / source)
                files |= {f"{table}{path.suffix}": path for path in beside}
    settings = toml.settings.updated(given)
    files |= grids_of_block(toml.sections, settings, block)
    section = toml.sections.get("block")
    return files, settings, (section and section.name) or title


def _size(path):
    try:
        return path.stat().st_size
    except (OSError, ValueError):
        return 0
