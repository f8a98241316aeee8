"""Whether a block's result is there, whole, and still that of its input.

Nothing is remembered beside the results: provenance.json tells of which input, settings
and version a result is, and failure.json the same of a failure. Times of files play no
part, so that a wrong clock spoils nothing. What cannot be understood, since another
program has written into it, counts as not there.
"""

from dataclasses import dataclass, replace
from pathlib import Path

from einschalt.interfaces.batch.block_task import BlockTask, task_of
from einschalt.interfaces.files.input_files import checksum_or_none
from einschalt.interfaces.files.plain_json import read_own_json
from einschalt.interfaces.files.written_files import FAILURE, PROVENANCE
from einschalt.pipeline.settings import with_present_words

COMPARISON = ("changes.csv", "previous_points.parquet")
NO_RESULT = "no result yet"
INPUT = {"table", "file", "sha256"}
SAID = ("stage", "reason", "remedy")
LARGEST_FIGURE = 1e15


@dataclass(frozen=True)
class BlockState:
    """A block, and what is known of its result."""

    task: BlockTask
    why: str  # it must be computed; empty where its result is whole and of this input
    provenance: dict | None  # of a result that is whole, whatever its input was
    failure: dict | None  # of the last run of this very input, where that failed
    has_failed: bool  # the last run failed or ended in the middle, on whatever input


def look_at(name, block, folder, given=None) -> BlockState:
    """Find out whether a block must be computed."""
    former = checksum_or_none(folder / PROVENANCE)
    task = replace(task_of(name, block, folder, given or {}), former=former)
    provenance = whole_result(folder)
    why = _why(provenance, task)
    failure = read_failure(folder)
    # on a full disk a failure may have left nothing but half a result
    is_half = provenance is None and folder.is_dir()
    return BlockState(
        task=task,
        why=why,
        provenance=provenance,
        failure=failure if _is_of(failure, task) else None,
        has_failed=bool(why) and (failure is not None or is_half),
    )


def result_since(task) -> dict | None:
    """Provenance of a whole result of this input that came after the block was seen.

    A worker that is killed after its last file has told nobody: the block is given to
    another one, which finds the result of the first.
    """
    if checksum_or_none(task.folder / PROVENANCE) == task.former:
        return None
    state = look_at(task.name, task.block, task.folder, task.given)
    return None if state.why else state.provenance


def _is_of(failure, task):
    if failure is None or not isinstance(failure.get("signature"), dict):
        return False
    signature = failure["signature"]
    settings = _present(signature.get("settings"))
    return {**signature, "settings": settings} == task.signature


def _present(settings):
    """Settings of an earlier run in the words of today; what is none, as it is."""
    return with_present_words(settings) if isinstance(settings, dict) else settings


def whole_result(folder) -> dict | None:
    """Provenance of a result all of whose files are there, as they were written.

    The comparison with the run before is no part of it.
    """
    provenance = read_own_json(folder / PROVENANCE)
    if provenance is None or not _is_provenance(provenance):
        return None
    is_whole = all(
        checksum_or_none(folder / name) == sign
        for name, sign in provenance["outputs"].items()
        if name not in COMPARISON
    )
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
        and all(v is None or _is_figure(name, v) for name, v in figures.items())
        and _is_number(content.get("seconds"))
    )


def _is_number(value):
    return isinstance(value, (int, float)) and abs(value) < LARGEST_FIGURE


def _is_figure(name, value):
    """Whether it is a number; of things that are counted, a whole one."""
    is_count = name.startswith("n_")
    return _is_number(value) and (not is_count or float(value).is_integer())


def _are_texts(values):
    return all(isinstance(value, str) for value in values)


def read_failure(folder) -> dict | None:
    """What failure.json tells; None where the last run of the block did not fail."""
    failure = read_own_json(folder / FAILURE)
    if failure is None or not _are_texts(failure.get(key) for key in SAID):
        return None
    return failure


def _why(provenance, task):
    if provenance is None:
        is_there = (task.folder / PROVENANCE).exists()
        return "the result is not whole" if is_there else NO_RESULT
    signature = task.signature
    if provenance.get("version") != signature["version"]:
        return f"computed by version {provenance.get('version')}"
    former = provenance.get("versions")
    former = former if isinstance(former, dict) else {}
    for name, now in signature["versions"].items():
        if former.get(name) != now:
            return f"computed with {name} {former.get(name) or 'unknown'}, not {now}"
    inputs = {entry["table"]: entry for entry in provenance["inputs"]}
    known = {table: entry["sha256"] for table, entry in inputs.items()}
    for table in sorted({*known, *signature["inputs"]}):
        if known.get(table) != signature["inputs"].get(table):
            file = inputs.get(table, {}).get("file", table.removeprefix("grids."))
            return f"{file} changed"
    if _present(provenance.get("settings")) != signature["settings"]:
        return "the settings changed"
    return ""
