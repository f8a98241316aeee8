"""Whether control can be what it is taken for: metres, easting before northing.

A block whose control is in feet, or has its axes exchanged, is transformed without a
residual where models are affine. What film can hold, and which way round a photograph
shows the ground, tell what residuals cannot.
"""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from einschalt.foundations.batches import segments_present
from einschalt.foundations.frame_columns import PLAN, columns_of, values_of
from einschalt.foundations.key_columns import row_codes
from einschalt.foundations.units import METRES_PER_MM
from einschalt.pipeline.assessment.evidence.control.displacements import (
    NOTHING,
    Displacement,
    largest,
)
from einschalt.pipeline.assessment.evidence.ground.stretch import (
    DETERMINANT,
    Stretch,
    affinities_onto_control,
    are_negative,
    stretch_of,
)
from einschalt.pipeline.block.axis_order import tells_axes
from einschalt.pipeline.block.facts import POINT_TABLES
from einschalt.stages.transformation_kinds import SPATIAL
from einschalt.theory.adjustment.point_operator import GROUND_NAMES
from einschalt.theory.adjustment.significance import FINDING_SIGNIFICANCE

# no aerial camera has a larger photograph than 30 x 30 cm: its diagonal
LARGEST_DIAGONAL_M = 0.30 * np.sqrt(2.0)
# film and paper shrink by less, one way more than the other
LARGEST_STRETCH = 0.005
# of a model of 23 cm film with 60 % overlap
USUAL_DIAGONAL_M = 0.23 * np.hypot(0.6, 1.0)
# of the scale of photographs by their scale number: relief and tilt make less
LARGEST_SCALE_RATIO = 1.5
# flights that differ by less from their scale numbers have one cause
ALIKE = 1.25
# flat terrain fits nearly as well either way: a few may be so by chance
MOST_UPSIDE_DOWN = 0.9
# directions in which a model's width is taken: the widest is its diameter within 4 %
DIRECTIONS = np.arange(6) * np.pi / 6.0


class Doubt(StrEnum):
    """Why the frame of a block's coordinates cannot be believed."""

    NONE = ""
    MIRRORED = "mirrored"  # all models, where no reference system tells the axes
    STRETCHED = "stretched"  # one axis against the other, more than film or paper is
    UPSIDE_DOWN = "upside_down"  # nearly all spatial models
    LARGER_THAN_FILM = "larger_than_film"  # models, with the scale that is given
    OUT_OF_SCALE = "out_of_scale"  # the ground, by the photographs of all flights


@dataclass(frozen=True)
class FilmSize:
    """Models of a flight as their photographs would have to be."""

    flight: str
    scale_number: float
    diameter: float  # of the median model on the ground [m]
    # of photographs: what their points measure on the ground by what they measure in
    # them, by the scale number; NaN where no image coordinates tell
    scale_ratio: float = np.nan

    @property
    def is_out_of_scale(self):
        """Whether image coordinates and ground contradict the scale number."""
        off = np.abs(np.log(self.scale_ratio))
        return bool(off > np.log(LARGEST_SCALE_RATIO))

    @property
    def on_film(self):
        """Diameter in the photograph [m]."""
        return self.diameter / self.scale_number

    @property
    def is_impossible(self):
        """Whether no photograph is as large."""
        return self.on_film > LARGEST_DIAGONAL_M


@dataclass(frozen=True)
class Frame:
    """What the models of a block say of its ground coordinates."""

    films: tuple[FilmSize, ...]
    # usable affine models; of other kinds those with enough control to tell
    n_affine: int
    n_mirrored: int  # of these
    n_spatial: int  # usable spatial models
    n_upside_down: int  # of these
    common: Stretch  # of one axis against the other, of all models alike
    # whether a reference system says which axis is which, and where the block lies
    has_system: bool
    # easting, northing, height of the new points, RMS [m]: how far they are from zero
    coordinates: tuple[float, float, float]

    @property
    def stretch(self):
        """Of one axis against the other, common to the models."""
        return self.common.size

    @property
    def is_mirrored(self):
        """Whether all models are mirrored."""
        return 0 < self.n_affine == self.n_mirrored

    @property
    def is_stretched(self):
        """Whether models have an affinity that is not one of film."""
        is_significant = self.common.p_value < FINDING_SIGNIFICANCE
        return is_significant and self.stretch > LARGEST_STRETCH

    @property
    def impossible_films(self):
        """Flights whose models are larger than film."""
        return tuple(film for film in self.films if film.is_impossible)

    @property
    def films_out_of_scale(self):
        """Flights whose photographs have another scale than their scale number."""
        return tuple(film for film in self.films if film.is_out_of_scale)

    @property
    def is_out_of_scale(self):
        """Whether all flights are out of scale alike: what they share is the ground."""
        ratios = [film.scale_ratio for film in self.films_out_of_scale]
        are_all = len(ratios) == len(self.films) > 1
        return are_all and max(ratios) < ALIKE * min(ratios)

    @property
    def doubts(self) -> tuple[Doubt, ...]:
        """All reasons not to believe the frame, the gravest first."""
        is_over = self.n_upside_down > MOST_UPSIDE_DOWN * self.n_spatial
        held = {
            Doubt.LARGER_THAN_FILM: bool(self.impossible_films),
            Doubt.STRETCHED: self.is_stretched,
            Doubt.OUT_OF_SCALE: self.is_out_of_scale,
            Doubt.UPSIDE_DOWN: is_over,
            Doubt.MIRRORED: self.is_mirrored and not self.has_system,
        }
        return tuple(doubt for doubt, holds in held.items() if holds)

    @property
    def doubt(self) -> Doubt:
        """The gravest reason not to believe the frame, if there is one."""
        return next(iter(self.doubts), Doubt.NONE)

    @property
    def could_be_off(self) -> Displacement:
        """How far coordinates are off if a doubt is right, RMS; 0 without."""
        return largest(NOTHING, *map(self._off_by, self.doubts))

    def _off_by(self, doubt):
        east, north, height = self.coordinates
        if doubt in (Doubt.OUT_OF_SCALE, Doubt.LARGER_THAN_FILM):
            share = self._share_of_scale(doubt)
            return Displacement(share * np.hypot(east, north), share * height)
        if doubt is not Doubt.STRETCHED:
            # an axis of the wrong sign, or taken for the other one
            return Displacement(2.0 * max(east, north), 0.0)
        ratio = self.common.east_by_north
        long, short = (east, north) if ratio > 1.0 else (north, east)
        ratio = max(ratio, 1.0 / ratio)
        # one axis is too long, or the other one too short
        off = max(long * (1.0 - 1.0 / ratio), short * (ratio - 1.0))
        return Displacement(float(off), 0.0)

    def _share_of_scale(self, doubt):
        """What coordinates in another unit are off by, of their own size."""
        if doubt is Doubt.OUT_OF_SCALE:
            ratio = np.mean([film.scale_ratio for film in self.films])
            return float(abs(1.0 - 1.0 / ratio))
        # of one flight alone it is the scale number
        least = min(film.on_film for film in self.films)
        return float(max(1.0 - USUAL_DIAGONAL_M / least, 0.0))


def frame_of(examined) -> Frame:
    """Compare the models with film, and with the way round that it shows the ground."""
    mirrored = shaped = are_mirrored(examined.models)
    if mirrored.empty:
        mirrored, shaped = _onto_control(examined)
    over = are_upside_down(examined.models)
    places = examined.points.drop_duplicates("point_id").set_index("point_id")
    places = columns_of(places, PLAN)
    is_new = (examined.points["role"] == "new").to_numpy()
    new = examined.points[is_new].reindex(columns=GROUND_NAMES)
    return Frame(
        films=tuple(
            _film_of(name, flight, places)
            for name, flight in examined.block.flights.items()
        ),
        n_affine=len(mirrored),
        n_mirrored=int(mirrored["is_mirrored"].sum()),
        n_spatial=len(over),
        n_upside_down=int(over["is_upside_down"].sum()),
        common=stretch_of(shaped),
        has_system=_has_system(examined.block),
        coordinates=tuple(_rms(axis) for axis in new.to_numpy(dtype=float).T),
    )


def _has_system(block):
    """Whether systems that tell easting from northing have let all points pass."""
    if block.crs is None:
        return False
    given = {name: getattr(block, name) for name in POINT_TABLES}
    return all(
        block.axes_told.get(name, tells_axes(table, block.crs))
        for name, table in given.items()
        if table is not None
    )


def are_mirrored(models):
    """Usable affine models, with ``is_mirrored``: a negative determinant."""
    if not set(DETERMINANT) <= set(models.columns):
        return models.iloc[:0].assign(is_mirrored=False)
    is_affine = (models["transformation"] == "affine") & models["is_usable"]
    affine = models[is_affine.astype(bool)]
    return affine.assign(is_mirrored=are_negative(affine))


def _onto_control(examined):
    """Affine parameters onto control of models that cannot be stretched themselves.

    Of x and y as they are, and of spatial models turned as the ground lies.
    """
    block = examined.block
    points = block.high_flight and block.high_flight.model_points
    if block.high_flight is not None and block.high_flight.has_images:
        points = examined.oriented_high_points
    if points is None:
        return (are_mirrored(examined.models).iloc[:0],) * 2
    control = block.control_points
    found = affinities_onto_control(points, control)
    mirrored = found.assign(is_mirrored=are_negative(found))
    if block.high_flight.transformation != SPATIAL:
        return mirrored, mirrored
    if "z" not in points or "height" not in control:
        return mirrored, mirrored.iloc[:0]
    return mirrored, affinities_onto_control(points, control, is_turned=True)


def _rms(values):
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(known**2))) if len(known) else 0.0


def are_upside_down(models):
    """Usable spatial models, with ``is_upside_down``: turned over to fit at all."""
    if not {"omega", "phi"} <= set(models.columns):
        return models.iloc[:0].assign(is_upside_down=False)
    spatial = models[models["is_usable"].astype(bool) & models["omega"].notna()]
    omega, phi = values_of(spatial, ["omega", "phi"]).T
    return spatial.assign(is_upside_down=np.cos(omega) * np.cos(phi) < 0.0)


def _film_of(name, flight, places):
    held = flight.model_table()
    plan = places.reindex(held["point_id"]).to_numpy(dtype=float)
    axes = np.stack([np.cos(DIRECTIONS), np.sin(DIRECTIONS)])
    keys = [held[key] for key in ("coverage", "model_id") if key in held]
    parts = segments_present(row_codes(keys))
    along, start = (plan @ axes)[parts.order], parts.start[:-1]
    widths = np.fmax.reduceat(along, start) - np.fmin.reduceat(along, start)
    widest = np.fmax.reduce(widths, axis=1)
    widest = widest[widest > 0.0]
    diameter = float(np.median(widest)) if len(widest) else np.nan
    ratio = _scale_of(flight, places) / flight.scale_number
    return FilmSize(name, float(flight.scale_number), diameter, ratio)


def _scale_of(flight, places):
    """Scale number of the median photograph, from ground and image; NaN without."""
    if not flight.has_images:
        return np.nan
    images = flight.image_coordinates()[["image_id", "point_id", "x", "y"]]
    both = images.join(places, on="point_id").dropna()
    spread = both.groupby("image_id")[["x", "y", *PLAN]].var()
    of_image = METRES_PER_MM * np.sqrt(spread["x"] + spread["y"])
    of_ground = np.sqrt(spread[PLAN].sum(axis=1))
    return float((of_ground / of_image).median())
