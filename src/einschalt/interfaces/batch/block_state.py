"""Whether a block's result is there, whole, and still that of its input.

Nothing is remembered beside the results: provenance.json tells of which input, settings
and version a result is, and failure.json the same of a failure. Times of files play no
part, so that a wrong clock spoils nothing.
"""

import json
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

from einschalt.foundations.errors import EinschaltError
from einschalt.interfaces.files.block_parts import FLIGHT_TABLES, POINT_TABLES
from einschalt.interfaces.files.block_toml import BLOCK_FILE, read_block_toml
from einschalt.interfaces.files.input_files import checksum
from einschalt.interfaces.files.result_folder import PROVENANCE

FAILURE = "failure.json"
NO_RESULT = "no result yet"
INPUT = {"table", "file", "sha256"}
SAID = ("stage", "reason", "remedy")
LARGEST_FIGURE = 1e15


@dataclass(frozen=True)
class BlockState:
    """A block, and what is known of its result.

    Attributes
    ----------
    name : str
    block, folder : Path
        Of the block, and of its result.
    signature : dict
        Version, settings, and checksums of the inputs, as they are now.
    why : str
        Why it must be computed; empty where its result is whole and of this input.
    size : int
        Bytes of the inputs.
    provenance : dict or None
        Of a result that is whole, whatever its input was.
    failure : dict or None
        Of the last run of this very input, where that failed.
    has_failed : bool
        Whether the last run failed, of this input or of an older one.
    """

    name: str
    block: Path
    folder: Path
    signature: dict
    why: str
    size: int
    provenance: dict | None
    failure: dict | None
    has_failed: bool

    def mark(self):
        """Tell this result from any other one: checksum of its provenance, or None."""
        return _checksum(self.folder / PROVENANCE)


def look_at(name, block, folder, given=None) -> BlockState:
    """Find out whether a block must be computed.

    Parameters
    ----------
    name : str
    block, folder : Path
    given : dict, optional
        Settings that go before those of block.toml.

    Returns
    -------
    BlockState
    """
    files, settings = _files_of(block)
    signature = {
        "version": metadata.version("einschalt"),
        "settings": _plain_settings(settings, given or {}),
        "inputs": {table: _checksum(path) for table, path in files.items()},
    }
    provenance = whole_result(folder)
    why = _why(provenance, signature, folder)
    failure = read_failure(folder)
    has_failed = bool(why) and failure is not None
    if failure is not None and failure.get("signature") != signature:
        failure = None
    return BlockState(
        name=name,
        block=block,
        folder=folder,
        signature=signature,
        why=why,
        size=sum(_size(path) for path in files.values()),
        provenance=provenance,
        failure=failure,
        has_failed=has_failed,
    )


def _files_of(block):
    """Files that a block reads, by table, and its settings, as far as known."""
    toml_file = block / BLOCK_FILE
    files = {"block": toml_file}
    try:
        toml = read_block_toml(toml_file)
    except EinschaltError:  # the computation will say it
        return files, None
    for name, section in toml.sections.items():
        if name in POINT_TABLES:
            named = {name: section.file}
        else:
            keys = (*FLIGHT_TABLES, "camera")
            named = {f"{name}.{key}": getattr(section, key, None) for key in keys}
        for table, source in named.items():
            if isinstance(source, str) and source.strip():
                files[table] = block / source
    return files, toml.settings


def _checksum(path):
    try:
        # a device or a pipe may never end
        return checksum(path) if path.is_file() else None
    except (OSError, ValueError):  # the computation will say it
        return None


def _size(path):
    try:
        return path.stat().st_size
    except (OSError, ValueError):
        return 0


def _plain_settings(settings, given):
    if settings is None:
        return None
    return with_settings(settings, given).model_dump(mode="json")


def with_settings(settings, given):
    """Settings with some fields replaced.

    Parameters
    ----------
    settings : Settings
    given : dict

    Returns
    -------
    Settings
    """
    return type(settings)(**{**settings.model_dump(), **given})


def whole_result(folder) -> dict | None:
    """Provenance of a result all of whose files are there, as they were written.

    Parameters
    ----------
    folder : Path

    Returns
    -------
    dict or None
    """
    provenance = read_json(folder / PROVENANCE)
    if provenance is None or not _is_provenance(provenance):
        return None
    outputs = provenance["outputs"]
    is_whole = all(_checksum(folder / name) == sign for name, sign in outputs.items())
    return provenance if is_whole else None


def _is_provenance(content):
    """Whether it has what a batch needs; another program may have written into it."""
    inputs, outputs, figures = (
        content.get(name) for name in ("inputs", "outputs", "figures")
    )
    return (
        isinstance(inputs, list)
        and all(isinstance(entry, dict) and set(entry) >= INPUT for entry in inputs)
        and all(_are_texts(entry[key] for key in ("table", "file")) for entry in inputs)
        and isinstance(outputs, dict)
        # no path, which would lead elsewhere
        and all(Path(name).name == name for name in outputs)
        and isinstance(figures, dict)
        and all(v is None or _is_number(v) for v in figures.values())
        and _is_number(content.get("seconds"))
    )


def _is_number(value):
    return isinstance(value, (int, float)) and abs(value) < LARGEST_FIGURE


def _are_texts(values):
    return all(isinstance(value, str) for value in values)


def read_failure(folder) -> dict | None:
    """Read failure.json.

    Parameters
    ----------
    folder : Path

    Returns
    -------
    dict or None
        None where the last run of the block did not fail.
    """
    failure = read_json(folder / FAILURE)
    if failure is None or not _are_texts(failure.get(key) for key in SAID):
        return None
    return failure


def read_json(path) -> dict | None:
    """Read a JSON file of ours; None where it is missing or damaged.

    Parameters
    ----------
    path : Path

    Returns
    -------
    dict or None
    """
    try:
        content = json.loads(path.read_bytes()) if path.is_file() else None
    # brackets may be nested more deeply than Python can follow
    except (OSError, ValueError, RecursionError):
        return None
    return content if isinstance(content, dict) else None


def _why(provenance, signature, folder):
    if provenance is None:
        is_there = (folder / PROVENANCE).exists()
        return "the result is not whole" if is_there else NO_RESULT
    if provenance.get("version") != signature["version"]:
        return f"computed by version {provenance.get('version')}"
    inputs = {entry["table"]: entry for entry in provenance.get("inputs", ())}
    known = {table: entry["sha256"] for table, entry in inputs.items()}
    for table in sorted({*known, *signature["inputs"]}):
        if known.get(table) != signature["inputs"].get(table):
            file = inputs.get(table, {}).get("file", table)
            return f"{file} changed"
    if provenance.get("settings") != signature["settings"]:
        return "the settings changed"
    return ""
