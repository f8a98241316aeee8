"""Where a result comes from: versions, settings, input files, facts of the flights.

Nothing in it tells of the computer: no absolute path, no name of host or user.
"""

import hashlib
import math
import platform
from dataclasses import asdict
from datetime import UTC, datetime
from functools import cache
from importlib import metadata
from pathlib import PurePosixPath, PureWindowsPath

import pyproj
from pyproj.database import get_database_metadata

from einschalt.pipeline.block.block import plain_fields
from einschalt.theory.interior_orientation import Camera

SCHEMA = 1
# statsmodels is not among them: nothing that is written depends on it
LIBRARIES = (
    *("numpy", "scipy", "pandas", "pyarrow", "numba", "pyproj", "pyogrio"),
    "shapely",
)
# what PROJ knows of systems, and of the ways between them
DATABASE = {"EPSG": "EPSG.VERSION", "PROJ-data": "PROJ_DATA.VERSION"}


def provenance(result) -> dict:
    """Collect where a result comes from, ready for JSON.

    ``inputs`` has file and SHA-256 of each table, and is empty where the tables came
    from a script; ``figures`` are in metres. From run to run only ``created`` (UTC) and
    ``seconds`` differ.
    """
    block = result.block
    return {
        **_head(),
        "block": _block_facts(block),
        **_output_facts(result.output_system),
        "flights": {name: _flight_facts(f) for name, f in block.flights.items()},
        "settings": result.settings.model_dump(mode="json"),
        "inputs": _inputs(block),
        "versions": versions(),
        "figures": figures_of(result),
        "seconds": round(result.seconds, 3),
    }


def provenance_of_tables(command, inputs) -> dict:
    """Collect where the results of a command come from that reads single tables."""
    return {**_head(), "command": command, "inputs": inputs, "versions": versions()}


def digest(texts) -> str:
    """Digest of texts, in their order: 16 hexadecimal digits."""
    data = "\0".join(texts).encode("utf-8", errors="surrogatepass")
    return hashlib.sha256(data).hexdigest()[:16]


def digest_of_inputs(block):
    """Digest of all files of a block; None where its tables came from a script."""
    return digest(sorted(set(block.checksums.values()))) if block.files else None


def version():
    """Version of this program."""
    return metadata.version("einschalt")


def _head():
    return {
        "schema": SCHEMA,
        "program": "einschalt",
        "version": version(),
        "created": created_now(),
    }


def created_now():
    """Say date and time, as ``created`` of provenance.json has them."""
    return datetime.now(UTC).isoformat(timespec="microseconds")


def figures_of(result):
    """Figures of the block; null where one is not known."""
    figures = {key: _plain(value) for key, value in asdict(result.figures).items()}
    figures["n_suspects"] = _n_suspects(result)
    figures["credible"] = result.assessment.credible.value
    figures["claim_is_supported"] = result.assessment.claim_is_supported
    return {
        key: value if value is not None and math.isfinite(value) else None
        for key, value in figures.items()
    }


def _n_suspects(result):
    """Count points that their residuals or their coverages make suspect."""
    tables = (result.points, result.residuals)
    suspects = [
        table.loc[table["is_suspect"].fillna(value=False).astype(bool), "point_id"]
        for table in tables
        if "is_suspect" in table
    ]
    return len(set().union(*suspects))


def versions() -> dict:
    """Versions of what computed: Python, the libraries, PROJ and its database."""
    return dict(_versions())


def libraries() -> dict:
    """Versions of that on which results depend: these without Python's.

    What is written is the same to the byte for every Python from 3.11 on.
    """
    return {name: one for name, one in versions().items() if name != "python"}


@cache  # the metadata of each library is a file to be read
def _versions():
    return {
        "python": platform.python_version(),
        **{name: metadata.version(name) for name in LIBRARIES},
        "PROJ": pyproj.proj_version_str,
        **{name: get_database_metadata(key) or "" for name, key in DATABASE.items()},
    }


def _block_facts(block):
    return {
        "name": block.name,
        **{n: getattr(block, n) for n in ("project", "operator") if getattr(block, n)},
        "crs": block.crs,
        "approximate_m_0_m": _plain(block.approximate_m_0_m),
        "shared_errors_m": dict(block.shared_errors_m),
        "group_errors_m": dict(block.group_errors_m),
        "correlation_lengths_m": dict(block.correlation_lengths_m),
        "may_be_unmeasured": block.may_be_unmeasured,
        "notes": [_without_paths(note, block) for note in block.notes],
    }


def _output_facts(output):
    """System of the results and the way into it, where it is not that of the block."""
    if output is None:
        return {}
    operation = output.operation
    facts = {
        "crs": output.crs,
        "operation": operation.name,
        "codes": list(operation.codes),
        "accuracy_m": operation.accuracy_m,
        "grids": [name for name, _ in operation.grids],
    }
    return {"output": facts}


def _flight_facts(flight):
    facts = plain_fields(flight)
    return {
        name: _plain(value)
        for name, value in facts.items()
        if value is not None and not hasattr(value, "columns")
    }


def _plain(value):
    """Turn a number of numpy into one of Python, and a camera into its constants."""
    if isinstance(value, Camera):
        return {name: _plain(constant) for name, constant in value.given.items()}
    return value.item() if hasattr(value, "item") else value


def _inputs(block):
    return [
        {
            "table": table,
            "file": within_block(source),
            "sha256": block.checksums.get(source),
        }
        for table, source in block.sources.items()
    ]


def within_block(source):
    """Keep a path within the block; of one from elsewhere only its name."""
    for kind in (PurePosixPath, PureWindowsPath):
        if kind(source).is_absolute():
            return kind(source).name
    return source


def _without_paths(note, block):
    for source in block.sources.values():
        note = note.replace(source, within_block(source))
    return note
