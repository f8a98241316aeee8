"""What a block needs beside measurements: models of photographs, and known points.

Programs measure points in photographs and know nothing of models. Pairs of photographs
are chosen for them, and become a table beside block.toml, which the user may change.
Where there is no high flight, models go straight onto the control, whose points are
then the approximate ones.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from einschalt.foundations.errors import EinschaltError, name_some
from einschalt.foundations.kept_texts import kept
from einschalt.foundations.language import mark
from einschalt.foundations.tables import with_coverage
from einschalt.interfaces.files.camera_toml import camera_of
from einschalt.interfaces.files.understood_tables import NOTHING_SAID
from einschalt.interfaces.new_block.guesses import Guess
from einschalt.interfaces.new_block.looked_at import PITCH, Looked
from einschalt.pipeline.block.facts import FLIGHTS
from einschalt.pipeline.block.given_points import known_of_models
from einschalt.pipeline.block.stereo_models import points_in_both_photographs
from einschalt.pipeline.block.ways_between_systems import standard_errors_of
from einschalt.stages.relative_orientation.model_choice import (
    LEAST_COMMON,
    choose_models,
)
from einschalt.stages.transformation_kinds import TRANSFORMATION_KINDS

APPROXIMATE, CONTROL = "approximate_points", "control_points"
MOST_NAMED = 6
MODELS_CHOSEN = "chosen: each photograph with its best partners"
HEIGHTS_LACK = mark(
    "in plan, without heights: {n:point has|points have} none ({names}); with all "
    "heights it is helmert_3d"
)
ALL_ZERO = (
    "in plan: all heights are 0, as programs write where none is known; if the points "
    "lie in a plane it is helmert_3d"
)
FEW_KNOWN = mark(
    "fewer than {least} control points in {n_few} of {n:model|models}: one adjustment "
    "ties these to their neighbours"
)
SINGLE = mark("{n:point|points} in no model, measured in one photograph only")
METHOD = "settings", "method"
CONTROL_ITSELF = "the error of the control points, onto which models go"


def completed(proposal, folder):
    """The proposal with tables that are written for it; these by path; notes.

    And with the method that models on few control points need. ``folder``: of
    block.toml.
    """
    proposal = replace(
        proposal, tables=dict(proposal.tables), values=dict(proposal.values)
    )
    written, notes = {}, []
    for name in FLIGHTS:
        is_lacking = (name, "models") not in proposal.tables
        if (name, "image_points") in proposal.tables and is_lacking:
            notes += _add_models(proposal, name, Path(folder), written)
    method = _method_of(proposal)
    if method is not None:
        proposal.values[METHOD] = method
    return proposal, written, notes


def _method_of(proposal):
    """The method that uses all models; None where two steps do.

    Models that go straight onto the control have as many known points as they show
    control points.
    """
    control = proposal.tables.get((CONTROL, "file"))
    onto = proposal.tables.get((APPROXIMATE, "file"))
    shown = _points_of_models(proposal.tables)
    if control is None or onto is not control or shown is None:
        return None
    word = proposal.values.get(("low_flight", "transformation"))
    least = TRANSFORMATION_KINDS[word.value if word else "affine"].least_points
    known = known_of_models(shown, _onto(control.frame)["point_id"], least)
    n_few, n = int(known.is_lacking.sum()), int(known.is_first.sum())
    if not (known.is_lacking & known.is_tied).any():
        return None
    return Guess("auto", kept(FEW_KNOWN, n_few=n_few, n=n, least=least))


def _points_of_models(tables):
    """Model and name of the points of the low flight; None where it has no models."""
    measured, points, models = (
        tables.get(("low_flight", key))
        for key in ("model_points", "image_points", "models")
    )
    if measured is not None:
        return with_coverage(measured.frame)
    if points is None or models is None:
        return None
    return points_in_both_photographs(with_coverage(models.frame), points.frame)


def _add_models(proposal, name, folder, written):
    """Add the models of a flight, where its principal distance is known; notes."""
    measured = _in_millimetres(proposal, name)
    if measured is None:
        return []
    chosen = choose_models(*measured)
    if not len(chosen.models):
        title = proposal.tables[name, "image_points"].title
        most = kept("{n:point|points}", n=chosen.most_common)
        note = (
            f"{title}: two photographs have {most} in common at most: a model needs "
            f"{LEAST_COMMON}, and a base"
        )
        return [note]
    notes = [MODELS_CHOSEN]
    if chosen.alone:
        said = kept("{n:image|images}", n=len(chosen.alone))
        notes.append(f"{said} in no model: {name_some(chosen.alone, MOST_NAMED)}")
    notes += _left_out(chosen)
    path = folder / f"{name}_models.csv"
    written[path] = chosen.models
    looked = Looked(path, "models", chosen.models, NOTHING_SAID, tuple(notes))
    proposal.tables[name, "models"] = looked
    return []


def _left_out(chosen):
    """Notes of the points that no chosen pair holds."""
    notes = []
    if chosen.unpaired:
        said = kept("{n:point|points}", n=len(chosen.unpaired))
        notes.append(
            f"{said} in no model, measured in two photographs or more, with fewer than "
            f"{LEAST_COMMON} common points or too short a base: "
            f"{name_some(chosen.unpaired, MOST_NAMED)}"
        )
    if chosen.n_single:
        notes.append(kept(SINGLE, n=chosen.n_single))
    return notes


def _in_millimetres(proposal, name):
    """Image points [mm] and principal distance [mm]; None where it is not known."""
    points = proposal.tables[name, "image_points"].frame
    camera = proposal.tables.get((name, "camera"))
    if camera is None:
        distance = proposal.values.get((name, "principal_distance_mm"))
        return None if distance is None else (points, distance.value)
    pitch = proposal.values.get((name, PITCH))
    more = {} if pitch is None else {PITCH: float(pitch.value)}
    try:
        made = camera_of({**camera.camera, **more})
    except EinschaltError:  # what is wrong with the user's own file, check says
        return None
    xy = made.xy_from_measured(points[["x", "y"]].to_numpy(dtype=float))
    is_whole = np.isfinite(xy).all(axis=1)
    points = points.assign(x=xy[:, 0], y=xy[:, 1])[is_whole]
    return points, made.principal_distance_mm


def error_of_control_itself(tables, values):
    """TOTAL error of approximate points that are the control, as far as it is known."""
    known = tables.get((APPROXIMATE, "file"))
    if known is None or known is not tables.get((CONTROL, "file")):
        return {}
    said = values.get((CONTROL, "standard_error_m"))
    total = standard_errors_of(known.frame, said and said.value)
    if total is None:
        return {}
    mean = np.sqrt(np.mean(np.square(np.asarray(total, dtype=float))))
    return {(APPROXIMATE, "m_0_m"): Guess(float(f"{mean:.3g}"), CONTROL_ITSELF)}


def transformation_of(tables, flights):
    """Transformation in space, where all heights for it are there; otherwise None.

    In plan where some are lacking, which is told.
    """
    if not all("image_points" in flight for flight in flights):
        return None
    ground = [tables[name] for name in (CONTROL, APPROXIMATE) if name in tables]
    given = [_onto(one.frame) for one in ground]
    if any("height" not in frame for frame in given):
        return None
    lacking = [frame[frame["height"].isna()]["point_id"] for frame in given]
    names = list(dict.fromkeys(pd.concat(lacking).astype(str)))
    if not names and len(given[0]) and all((f["height"] == 0.0).all() for f in given):
        return Guess("affine", ALL_ZERO)
    if not names:
        return Guess("helmert_3d", "models of photographs, and control with heights")
    lacking = {"n": len(names), "names": name_some(names, MOST_NAMED)}
    return Guess("affine", kept(HEIGHTS_LACK, **lacking))


def _onto(frame):
    """Points that models are fitted onto."""
    return frame if "role" not in frame else frame[frame["role"] == "control"]
