"""Bends that spatial models of a flight share, found and given to a block."""

from dataclasses import dataclass, replace

import numpy as np

from einschalt.foundations.units import METRES_PER_MM
from einschalt.stages.error_propagation.measurement_errors import image_chain
from einschalt.stages.simultaneous.image_drawings import drawing, has_images
from einschalt.theory.block_adjustment.gross_errors import examine_control
from einschalt.theory.block_adjustment.height_scale import HeightScale, examine_scales
from einschalt.theory.block_adjustment.shared_bend import (
    OF_HEIGHTS,
    SCALE,
    AnswerToBends,
    BendTerms,
    BendTest,
    MadeByErrors,
    bent_heights,
    examine_bends,
    positions_of_flights,
    scaled_heights,
    untested,
)
from einschalt.theory.relative_orientation.lens_distortion import (
    LENS_TERMS,
    lens_displacements,
)

# variances of a few sums, known to 5 per cent
N_DRAWS = 400


@dataclass(frozen=True, eq=False)
class SharedBends:
    """Which flights have models that are bent alike."""

    tests: tuple[BendTest, ...] = ()  # of each flight of spatial models
    modelled: BendTerms | None = None  # terms that the adjustment is to have
    # flights whose heights seem to be out of scale
    scales: tuple[HeightScale, ...] = ()

    @property
    def flights(self):
        """Number of the flight of each modelled term."""
        none = np.zeros(0, dtype=np.int64)
        return none if self.modelled is None else self.modelled.flight

    @property
    def names(self):
        """Name of each modelled term."""
        return () if self.modelled is None else self.modelled.names

    def given_to(self, part):
        """Part of a block with the modelled terms as unknowns."""
        columns = self.modelled.columns
        return replace(
            part, observations=replace(part.observations, shared_bend=columns)
        )


def find_shared_bends(tables, weighed, options) -> SharedBends:
    """Test the flights of a spatial part for bends that their models share.

    By an adjustment without gross errors and without control that contradicts it: one
    wrong height bends a block as well.
    """
    if options.deformation == "ignored" or not tables.is_spatial:
        return SharedBends()
    solution = weighed.block.solution
    if options.outliers == "keep":
        solution = examine_control(solution, options.significance).without
    terms = _terms_of(tables, weighed.part)
    answer = AnswerToBends.of(solution, terms)
    made = made_by_errors(tables, weighed, solution, answer)
    given = solution, terms, answer, made, options.significance
    scales = examine_scales(*given[:-1], weighed.block.solution)
    if scales:  # a part of it looks like a bend
        return SharedBends(tuple(untested(terms)), scales=tuple(scales))
    tests, found = examine_bends(*given)
    if not found or options.deformation != "modelled":
        return SharedBends(tuple(tests))
    return SharedBends(tuple(tests), terms.of_flights(found))


def _terms_of(tables, part):
    """Terms of all flights, at the observations of a part."""
    every = every_term(tables)
    return replace(
        every, columns=every.columns[part.rows], position=every.position[part.rows]
    )


def every_term(tables) -> BendTerms:
    """Terms of all flights: a lens where there are images, and a scale of heights."""
    observations = tables.observations
    is_ground = ~tables.is_centre[observations.point]
    position = positions_of_flights(observations, is_ground)
    flight_of_row = observations.flight[observations.model]
    columns, flights, names = [], [], ()
    for flight in np.unique(observations.flight):
        rows, images = flight_of_row == flight, tables.images[flight]
        own = (*(OF_HEIGHTS if images is None else LENS_TERMS), SCALE)
        terms = np.zeros((len(rows), 3, len(own)))
        if images is None:
            on_model = rows & is_ground
            bent = bent_heights(position[on_model])
            scaled = scaled_heights(observations, on_model)
            terms[on_model] = np.concatenate([bent, scaled[on_model]], axis=2)
        else:
            start = sum(tables.n_rows[:flight])
            terms[rows] = distorted_models(images)[tables.row[rows] - start]
        columns.append(terms)
        flights += [flight] * len(own)
        names += own
    found = np.concatenate(columns, axis=2)
    return BendTerms(found, np.array(flights), names, position)


def distorted_models(images):
    """What a lens makes of the models of a flight, and of their projection centres.

    By each of ``LENS_TERMS`` with a coefficient of 1 mm, and by a principal distance
    that is too short by all of itself, (n_rows, 3, n_terms) [mm].
    """
    xy = images.sources[["x", "y"]].to_numpy(dtype=float)
    moved = np.concatenate([lens_displacements(xy), -xy[:, :, None]], axis=2)
    n_rows = images.n_rows
    as_it_is = np.broadcast_to(np.eye(3), (n_rows, 3, 3))
    chain = image_chain(images.errors, as_it_is, images.scale_number, images.centres)
    on_ground = METRES_PER_MM * images.scale_number * moved
    sources = np.concatenate([on_ground, np.zeros_like(on_ground[:, :1])], axis=1)
    return np.stack([chain.of_vectors(k) for k in np.moveaxis(sources, 2, 0)], axis=2)


def made_by_errors(tables, weighed, solution, answer):
    """What errors make of the sums of a block without bends.

    Those of images and of control that shares errors are drawn: models share them.
    """
    observations = solution.observations
    is_shared = observations.shared_control is not None
    if not (has_images(tables) or is_shared) or solution.redundancy <= 0:
        return MadeByErrors(answer.normals, 1.0)
    draw = drawing(tables, weighed.part, weighed.image_sizes, solution)
    weight = observations.control_weight
    sums, squares = np.zeros_like(answer.normals), 0.0
    for rng, n_draws, control in observations.control_in_parts(N_DRAWS):
        points, residuals = solution.answer_to(draw(rng, n_draws), control)
        of_draws = answer.sums(residuals)
        sums += of_draws @ of_draws.T
        squares += np.sum(answer.weights[:, :, None] * residuals**2)
        away = points - control
        squares += np.einsum("nad,nab,nbd->", away, weight, away)
    unit_variance = squares / N_DRAWS / solution.redundancy
    return MadeByErrors(sums / N_DRAWS, float(unit_variance))
