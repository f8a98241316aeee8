"""A block is written to a folder: block.toml and its tables."""

import os
from pathlib import Path

import pandas as pd

from einschalt.foundations.errors import OutputError
from einschalt.interfaces.files.block_parts import (
    FLIGHT_FACTS,
    FLIGHT_TABLES,
    POINT_TABLES,
)
from einschalt.interfaces.files.block_toml import BLOCK_FILE, write_block_toml
from einschalt.interfaces.files.camera_toml import write_camera
from einschalt.interfaces.files.output_folder import (
    OR_OVERWRITE,
    InputFiles,
    Output,
    require_free,
    write_folder,
)
from einschalt.interfaces.files.tables_by_suffix import write_table
from einschalt.interfaces.files.written_files import Source


def write_block(block, folder, *, suffix=".csv", overwrite=False):
    """Write a block so that ``read_block`` gives it back; block.toml comes last.

    The ``truth`` of a simulated block is written beside. ``overwrite`` replaces files
    that have the names of the block's, but never one that the block was read from.
    """
    names = _file_names(block, suffix)
    require_block_place(folder, names, overwrite=overwrite)
    inputs = InputFiles(block.files)
    output = Output(Source("block", block.name), frozenset(names), inputs, overwrite)
    write_folder(folder, output, None, lambda new: _write_files(block, new, suffix))


def require_block_place(folder, names=(BLOCK_FILE,), *, overwrite=False):
    """Refuse to write where a block, or a table of one of its names, stands."""
    for name in () if overwrite else names:
        if os.path.lexists(Path(folder) / name):
            raise OutputError(
                f"the folder holds {name} already",
                expected="a new folder for the block",
                remedy=OR_OVERWRITE,
                file=folder,
            )
    output = Output(Source("block"), frozenset(names), InputFiles(), overwrite)
    require_free(folder, output)


def _write_files(block, folder, suffix):
    heads = {"project": block.project or None, "operator": block.operator or None}
    sections = {"block": {"name": block.name, **heads, "crs": block.crs}}
    for name in POINT_TABLES:
        frame = getattr(block, name)
        if frame is not None:
            sections[name] = {
                "file": _write_part(frame, folder, f"{name}{suffix}"),
                "may_be_unmeasured": block.may_be_unmeasured or None,
                "shared_error_m": block.shared_errors_m.get(name),
                "group_error_m": block.group_errors_m.get(name),
                "correlation_length_m": block.correlation_lengths_m.get(name),
            }
    if "approximate_points" in sections:
        sections["approximate_points"]["m_0_m"] = block.approximate_m_0_m
    for name, flight in block.flights.items():
        sections[name] = _write_flight(flight, folder, name, suffix)
    sections["settings"] = block.settings.model_dump(exclude_defaults=True)
    truth = getattr(block, "truth", None)
    if truth is not None:
        _write_part(truth, folder, f"truth{suffix}")
    write_block_toml(folder / BLOCK_FILE, sections)


def _file_names(block, suffix):
    """Names of all files of a block, block.toml first."""
    stems = [name for name in POINT_TABLES if getattr(block, name) is not None]
    if getattr(block, "truth", None) is not None:
        stems.append("truth")
    cameras = []
    for name, flight in block.flights.items():
        is_table = {
            key: hasattr(getattr(flight, key), "columns") for key in FLIGHT_TABLES
        }
        stems += [_stem(name, key) for key, is_it in is_table.items() if is_it]
        cameras += [f"{name}_camera.toml"] * (flight.camera is not None)
    return [BLOCK_FILE, *cameras, *(f"{stem}{suffix}" for stem in stems)]


def _stem(flight_name, key):
    return flight_name if key == "model_points" else f"{flight_name}_{key}"


def _write_flight(flight, folder, name, suffix):
    section = {key: getattr(flight, key) for key in FLIGHT_FACTS}
    if flight.camera is not None:
        section["principal_distance_mm"] = None
        section["camera"] = f"{name}_camera.toml"
        write_camera(folder / section["camera"], flight.camera)
    for key in FLIGHT_TABLES:
        part = getattr(flight, key)
        if isinstance(part, pd.DataFrame):
            part = _write_part(part, folder, f"{_stem(name, key)}{suffix}")
        section[key] = part
    return section


def _write_part(frame, folder, file_name):
    write_table(frame, folder / file_name)
    return file_name
