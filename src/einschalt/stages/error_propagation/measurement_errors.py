"""Errors of measuring of each flight, from the sources that stand behind them.

Machine coordinates of oriented models are sources themselves. Models that were oriented
by y-parallaxes have the errors of their orientation beside them; of models that were
formed from images the sources are the image points, which neighbouring models share.
"""

from dataclasses import dataclass

import numpy as np

from einschalt.foundations.units import METRES_PER_MM
from einschalt.stages.error_propagation.orientation_errors import orientation_chains
from einschalt.stages.error_propagation.own_deformation_errors import (
    bending_chains,
)
from einschalt.stages.relative_orientation.image_errors import ImageErrors
from einschalt.stages.transformation_kinds import TRANSFORMATION_KINDS
from einschalt.theory.adjustment.point_operator import Axes, PointOperator, unchanged
from einschalt.theory.adjustment.propagation import scattered
from einschalt.theory.relative_orientation.model_precision import N_CHANGES
from einschalt.theory.transformation.sensitivity import CONFORMAL

ORIENTATION = "orientation"
OWN_DEFORMATION = "own_deformation"


@dataclass(frozen=True, eq=False)
class MeasurementErrors:
    """Errors that the flights of a block bring."""

    # of each flight: its measuring errors on the ground [m] from each source
    chains: dict[str, dict[str, PointOperator]]
    axes: Axes  # of the operators
    # number of sources of variance 1 in ``orientation`` and ``own_deformation``
    n_unit: dict[str, int]
    is_complete: bool  # whether the errors of all orientations are known


def measurement_errors(block, points, fits, oriented, bent=None) -> MeasurementErrors:
    """Find what stands behind the errors of measuring of each flight.

    ``points``, ``fits`` and ``oriented`` are by flight; an orientation that is left out
    has no errors. ``bent`` is the OwnDeformation of the flights in their order, if it
    is known.
    """
    kinds = {fit.kind for fit in fits.values()}
    images = {n: e for n, e in oriented.items() if isinstance(e, ImageErrors)}
    others = {n: e for n, e in oriented.items() if n not in images}
    turned = orientation_chains(others, fits)
    # what orientations make in easting and northing is not alike
    is_alike = kinds <= set(CONFORMAL) and not turned and not images
    n_coordinates = max(len(TRANSFORMATION_KINDS[kind].target) for kind in kinds)
    axes = Axes.COMPLEX if is_alike else Axes(n_coordinates)
    chains = {name: {name: unchanged(axes)} for name in fits}
    for name, chain in turned.items():
        chains[name][ORIENTATION] = chain
    for name, errors in images.items():
        scale_number = block.flights[name].scale_number
        fit = fits[name]
        linear = fit.fit.linear[fit.observed.models.codes]
        chains[name] = {name: image_chain(errors, linear, scale_number)}
    bending = bending_chains(bent, points, fits, axes)
    for name, chain in bending.items():
        chains[name][OWN_DEFORMATION] = chain
    n_unit = {
        source: next(iter(found.values())).n_sources
        for source, found in ((ORIENTATION, turned), (OWN_DEFORMATION, bending))
        if found
    }
    is_complete = not any(
        flight.is_oriented_numerically and name not in {*turned, *images}
        for name, flight in block.flights.items()
    )
    return MeasurementErrors(chains, axes, n_unit, is_complete)


def image_chain(errors, linear, scale_number, centres=None) -> PointOperator:
    """Operators from the errors of image points to those of model points.

    To measuring errors on the ground [m]: straight from image points to model points,
    and to the changes of base and turn of each orientation, and from these to all
    points of a model. With three axes the third of each source, an image point, moves
    nothing. Errors of the sources are those on the ground at ``scale_number``.
    ``linear`` (n_points, d, d) leads from each model point to the ground; so it does
    for the ``centres`` that follow: pair and side (0 left, 1 right) of each,
    (n_centres, 2).
    """
    influence = errors.influence
    n_points, n_coordinates = len(influence.model), linear.shape[1]
    gain, model = influence.gain, influence.model
    if centres is not None:
        pair, side = np.asarray(centres).T
        gain = np.concatenate([gain, influence.centres[pair, side]])
        model = np.append(model, pair)
    axes = Axes(n_coordinates)
    n_rows, n_columns = axes.size(len(model)), axes.size(errors.n_sources)
    image_mm = 1.0 / (METRES_PER_MM * scale_number)
    # columns of x', y', x", y" of each point, and of the changes of its orientation
    of_image = axes.rows(errors.sources)[:, :, :2].reshape(n_points, 4)
    of_changes = N_CHANGES * model[:, None] + np.arange(N_CHANGES)
    of_point = axes.rows(np.arange(len(model)))
    n_changes = N_CHANGES * errors.n_models
    by_image = linear[:n_points] @ influence.by_image[:, :n_coordinates] * image_mm
    by_changes = linear @ gain[:, :n_coordinates]
    own = scattered(by_image, of_point[:n_points], of_image, (n_rows, n_columns))
    through = scattered(by_changes, of_point, of_changes, (n_rows, n_changes))
    changes = scattered(
        influence.by_point * image_mm,
        of_changes[:n_points],
        of_image,
        (n_changes, n_columns),
    )
    return PointOperator((own,), axes) + PointOperator((through, changes), axes)
