"""Markers of Metashape as XML: control points, and where images show them.

Pixels are counted from the upper left corner of the image, x to the right and y down.
"""

from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from einschalt.foundations.display_names import shortened
from einschalt.foundations.errors import FileError, ProjectionError
from einschalt.foundations.kept_texts import kept
from einschalt.foundations.number_parsing import is_number
from einschalt.foundations.projections import code_of
from einschalt.interfaces.files.damaged_files import damaged
from einschalt.interfaces.files.input_files import read_once
from einschalt.interfaces.files.marker_files import Markers, markers_of
from einschalt.interfaces.files.metashape_accuracies import (
    ERRORS,
    accuracy,
    in_plan,
    is_on,
    with_errors,
)
from einschalt.interfaces.files.plain_xml import read_xml

EXPECTED = "markers as Metashape exports them"


def read_metashape(path, source=None) -> Markers:
    """Read the markers of a chunk that Metashape exported as XML."""
    source = source or Path(path).name
    chunk = _chunk(read_once(path, source).data, source)
    cameras = list(chunk.iter("camera"))
    called, notes = images_of(cameras, source)
    images = {c.get("id"): name for c, name in zip(cameras, called, strict=True)}
    markers = chunk.find("markers")
    labels, points, errors = {}, [], []
    usual = _usual_accuracy(chunk)
    for one in [] if markers is None else markers.findall("marker"):
        labels[one.get("id")] = one.get("label")
        reference = one.find("reference")
        if reference is not None and reference.get("x") is not None:
            is_control = is_on(reference.get("enabled", "true"))
            errors.append(_errors(reference, usual))
            xyz = (_number(reference.get(axis), source) for axis in "xyz")
            role = "control" if is_control else "check"
            points.append((one.get("label"), *xyz, role))
    rows, n_predicted = [], 0
    for one in chunk.iterfind("frames/frame/markers/marker"):
        for place in one.findall("location"):
            if not is_on(place.get("pinned", "true")):
                n_predicted += 1
                continue
            image, name = place.get("camera_id"), one.get("marker_id")
            if image not in images or name not in labels:
                raise damaged(source, f"camera {image} or marker {name} is unknown")
            xy = (_number(place.get(axis), source) for axis in "xy")
            rows.append((images[image], labels[name], *xy))
    if n_predicted:
        predicted = kept("{n:position|positions}", n=n_predicted)
        notes.append(f"{source}: {predicted} predicted and not measured, left out")
    n_off = sum(point[-1] == "check" for point in points)
    if n_off:
        said = kept("{n:marker|markers}", n=n_off)
        notes.append(f"{source}: {said} not enabled, taken for check points")
    read = markers_of(points, rows, _crs_of_chunk(chunk, source), notes, source)
    stated = pd.DataFrame(errors, columns=list(ERRORS), dtype=float)
    known, said = with_errors(read.points.join(stated), source)
    return replace(read, points=known, notes=(*read.notes, *said))


def images_of(cameras, source):
    """Names of the images of cameras of a chunk, and notes.

    Cameras call the images of each card alike. Those with the name of another have
    their number in the chunk behind it, so that they remain two images.
    """
    labels = [one.get("label") for one in cameras]
    n_called = Counter(labels)
    shared = [label is not None and n_called[label] > 1 for label in labels]
    names = [
        f"{label} ({one.get('id')})" if is_shared else label
        for one, label, is_shared in zip(cameras, labels, shared, strict=True)
    ]
    if not any(shared):
        return names, []
    said = kept("{n:image|images}", n=sum(shared))
    note = f"{source}: {said} named like another: its camera's number stands behind"
    return names, [note]


def _usual_accuracy(chunk):
    """Accuracy of markers that have none of their own, if one of them has [m]."""
    references = chunk.iterfind("markers/marker/reference")
    if not any(np.isfinite(_errors(one, np.nan)).any() for one in references):
        return np.nan  # what Metashape sets by itself is no statement
    settings = chunk.iterfind("settings/property[@name='accuracy_markers']")
    return accuracy(next((one.get("value") for one in settings), None))


def _errors(reference, usual):
    """Standard errors of a marker in plan, TOTAL, and in height [m]."""

    def of(*names):
        stated = (accuracy(reference.get(name)) for name in (*names, "sxyz"))
        return next(filter(np.isfinite, stated), usual)

    return in_plan(np.nan, of("sx", "sxy"), of("sy", "sxy")), of("sz")


def _chunk(data, source):
    """The only chunk of a document, read without entities."""
    chunks = list(read_xml(data, source, EXPECTED).iter("chunk"))
    if not chunks:
        raise FileError(
            "holds nothing that is known",
            expected="markers or cameras of Metashape, or measured points of MicMac",
            remedy="Export one of these",
            file=source,
        )
    if len(chunks) != 1:
        raise FileError(
            f"holds {kept('{n:chunk|chunks}', n=len(chunks))}",
            expected="one chunk with markers",
            remedy="Export the markers of one chunk",
            file=source,
        )
    return chunks[0]


def _crs_of_chunk(chunk, source):
    # since 2.0 markers may have a system that is not that of the cameras
    text = chunk.findtext("marker_reference") or chunk.findtext("reference")
    if not text or text.startswith("LOCAL_CS"):
        return None
    try:
        return code_of(text)
    except ProjectionError as error:
        raise damaged(source, f"the system {shortened(text)!r} is unknown") from error


def _number(text, source):
    if text is None:
        return np.nan
    if not is_number(text):
        raise damaged(source, f"{shortened(text)!r} is not a number")
    return float(text)
