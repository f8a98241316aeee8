"""Before models are transformed: what the map makes of straight lines.

A model is a true likeness of the terrain, up to its scale. Easting, northing and height
are not: a projection has a scale of its own in plan and none in height, and heights
stand over a curved Earth. Over a kilometre that is 8 cm of height. So the points of a
model are moved to where they would lie if it were a likeness of the coordinates; then
all that follows may take these for Cartesian ones.

Of a plane model only what its transformation does not take up is left: the scale of the
map that changes across it, which is millimetres in large models far from the meridian.

See docs/theory/transformation.md.
"""

from dataclasses import replace

import numpy as np

from einschalt.foundations.errors import GeometryError
from einschalt.foundations.frame_columns import values_of
from einschalt.foundations.names import encode_pairs
from einschalt.foundations.projections import read_crs
from einschalt.foundations.tables import with_coverage
from einschalt.stages.bent_map import (
    LEAST,
    PLACED_BY,
    bends_plane_models,
    flat_system,
    is_of_the_earth,
    moved_coordinates,
)
from einschalt.stages.stage1_approximate_coordinates import (
    average_high_flight,
    transform_high_flight,
)
from einschalt.stages.stage3_model_transformation import transform_models
from einschalt.stages.transformation_kinds import SPATIAL

XYZ = ["x", "y", "z"]
HIGH, LOW = "high_flight", "low_flight"


def bend_flights(block, flights, kinds=None, *, place=None):
    """Bend the models of all flights as the map of the block is bent.

    ``flights``: of str to RelativeOrientation; ``kinds``: their transformations, where
    they are not those that each states. ``place``: function that gives the ground
    coordinates of all points, or None, of flights in which spatial models have too few
    known points to be placed alone; without it these stay as they are. So do plane
    models that are too small for a millimetre, and all without a plane system of the
    Earth.
    """
    kinds = kinds or {name: block.flights[name].transformation for name in flights}
    is_bent = {n: is_worth_bending(block, n, k) for n, k in kinds.items()}
    if not any(is_bent.values()):
        return flights
    # a likeness tells where models lie, rigid ones in whichever unit they are
    placed = {n: PLACED_BY.get(k, k) for n, k in kinds.items()}
    bent, fits = _bent_where_known(block, flights, placed, is_bent)
    in_space = [n for n, kind in placed.items() if kind == SPATIAL]
    if place is None or all(n in fits and _is_whole(fits[n]) for n in in_space):
        return bent
    ground = place(bent)
    if ground is None:
        return bent
    for name in in_space:
        fit = transform_models(flights[name].model_points, ground, SPATIAL)
        bent[name] = bent_as_the_map(flights[name], fit, block.crs)
    return bent


def _is_whole(fit):
    """Whether the fit places all models."""
    return bool(fit.models["is_usable"].all())


def _bent_where_known(block, flights, placed, is_bent):
    """Flights bent where known points place their models, and the fits onto these."""
    bent, fits, ground = dict(flights), {}, block.approximate_points
    try:
        if HIGH in placed and (is_bent[HIGH] or placed.get(LOW) != SPATIAL):
            points, control = flights[HIGH].model_points, block.control_points
            fits[HIGH] = fit = transform_high_flight(points, control, placed[HIGH])
            if is_bent[HIGH]:
                bent[HIGH] = bent_as_the_map(flights[HIGH], fit, block.crs)
            is_wanted = placed[HIGH] == SPATIAL or placed.get(LOW) != SPATIAL
            if is_bent.get(LOW) and is_wanted:
                ground = average_high_flight(fit, points).points
        ground = block.control_points if ground is None else ground
        if is_bent.get(LOW) and (placed[LOW] != SPATIAL or "height" in ground):
            fit = transform_models(flights[LOW].model_points, ground, placed[LOW])
            fits[LOW] = fit
            bent[LOW] = bent_as_the_map(flights[LOW], fit, block.crs)
    except GeometryError:  # no model fits: the steps that follow say so
        return bent, fits
    return bent, fits


def is_worth_bending(block, name, kind):
    """Whether models of a flight, transformed by a kind, may move by a millimetre.

    A plane one of radius r by |∇k| r² / 2, from a scale k that changes across it; r is
    that of photographs, on the ground.
    """
    if not is_of_the_earth(block.crs):
        return False
    if kind == SPATIAL:
        return True
    known = block.control_points
    known = block.approximate_points if known is None else known
    places = values_of(known, ["easting", "northing"])
    return bends_plane_models(places, block.flights[name].scale_number, block.crs)


def bent_as_the_map(oriented, fit, crs):
    """Bend the models of a flight as the map of their ground coordinates is bent.

    Parameters
    ----------
    oriented : RelativeOrientation
        Of a flight whose models are spatial, or plane: these are bent at height 0.
    fit : ModelTransformation
        Of the flight's models onto any ground coordinates that are good to a per mille
        of the model's size.
    crs : str
        Of the ground coordinates; heights are taken for those above its ellipsoid: what
        a geoid differs from it is a scale.

    Returns
    -------
    RelativeOrientation
        With model points and projection centres where they belong; as it was where no
        point moves by a millimetre.
    """
    system = flat_system(read_crs(crs))
    moved, largest = _moved(oriented.model_points, fit, system)
    if not largest > LEAST:
        return oriented
    centres = oriented.centres
    if len(centres) and fit.kind == SPATIAL:
        centres, _ = _moved(centres, fit, system)
    return replace(oriented, model_points=moved, centres=centres)


def _moved(points, fit, crs):
    """Points of models, moved, and by how much at most [m]; others as they were."""
    place = _places(points, fit)
    rows = np.flatnonzero(place >= 0)
    names = XYZ if fit.kind == SPATIAL else XYZ[:2]
    if not len(rows):
        return points, 0.0
    xyz = values_of(points, names)[rows]
    moved, away = moved_coordinates(xyz, place[rows], fit, crs)
    is_known = np.isfinite(away)
    table = points.copy()
    columns = [table.columns.get_loc(name) for name in names]
    table.iloc[rows[is_known], columns] = moved[is_known]
    return table, float(away[is_known].max(initial=0.0))


def _places(points, fit):
    """Row of the fit for each point, -1 where its model is not usable."""
    models = with_coverage(fit.models)
    known = encode_pairs(models["coverage"], models["model_id"])
    named = with_coverage(points)
    coded = encode_pairs(named["coverage"], named["model_id"])
    place = known.locate(coded)[coded.codes]
    usable = models["is_usable"].to_numpy(dtype=bool)
    return np.where((place >= 0) & usable[place], place, -1)
