"""Whether control can be what it is taken for: metres, easting before northing.

A block whose control is in feet, or has its axes exchanged, is transformed without a
residual where models are affine. What film can hold, and which way round a photograph
shows the ground, tell what residuals cannot.
"""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from scipy.special import fdtrc  # scipy.stats takes a second to import

from einschalt.foundations.projections import extent_of
from einschalt.theory.adjustment.significance import FINDING_SIGNIFICANCE

DETERMINANT = ["a1", "a2", "b1", "b2"]
# no aerial camera has a larger photograph than 30 x 30 cm: its diagonal
LARGEST_DIAGONAL_M = 0.30 * np.sqrt(2.0)
# film and paper shrink by less, one way more than the other
LARGEST_STRETCH = 0.005
# share of an affinity beyond which the smaller axis of a model is nothing
NEARLY_FLAT = 1.0 - 1e-9
FEWEST_MODELS = 3
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


@dataclass(frozen=True)
class FilmSize:
    """Models of a flight as their photographs would have to be."""

    flight: str
    scale_number: float
    diameter: float  # of the median model on the ground [m]

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
    n_affine: int  # usable affine models
    n_mirrored: int  # of these
    n_spatial: int  # usable spatial models
    n_upside_down: int  # of these
    stretch: float  # of one axis against the other, common to the affine models
    stretch_p_value: float  # of a common stretch this large by chance
    # whether a reference system says which axis is which, and where the block lies
    has_system: bool

    @property
    def is_mirrored(self):
        """Whether all affine models are mirrored."""
        return 0 < self.n_affine == self.n_mirrored

    @property
    def is_stretched(self):
        """Whether affine models have an affinity that is not one of film."""
        is_significant = self.stretch_p_value < FINDING_SIGNIFICANCE
        return is_significant and self.stretch > LARGEST_STRETCH

    @property
    def impossible_films(self):
        """Flights whose models are larger than film."""
        return tuple(film for film in self.films if film.is_impossible)

    @property
    def doubt(self) -> Doubt:
        """The gravest reason not to believe the frame, if there is one."""
        if self.impossible_films:
            return Doubt.LARGER_THAN_FILM
        if self.is_stretched:
            return Doubt.STRETCHED
        if self.n_upside_down > MOST_UPSIDE_DOWN * self.n_spatial:
            return Doubt.UPSIDE_DOWN
        if self.is_mirrored and not self.has_system:
            return Doubt.MIRRORED
        return Doubt.NONE


def frame_of(examined) -> Frame:
    """Compare the models with film, and with the way round that it shows the ground."""
    mirrored = are_mirrored(examined.models)
    over = are_upside_down(examined.models)
    places = examined.points.drop_duplicates("point_id").set_index("point_id")
    places = places[["easting", "northing"]]
    stretch, p_value = _stretch(mirrored)
    return Frame(
        films=tuple(
            _film_of(name, flight, places)
            for name, flight in examined.block.flights.items()
        ),
        n_affine=len(mirrored),
        n_mirrored=int(mirrored["is_mirrored"].sum()),
        n_spatial=len(over),
        n_upside_down=int(over["is_upside_down"].sum()),
        stretch=stretch,
        stretch_p_value=p_value,
        has_system=_has_system(examined.block.crs),
    )


def _has_system(crs):
    """Whether a system with an area of use has let the coordinates pass."""
    return crs is not None and extent_of(crs) is not None


def are_mirrored(models):
    """Usable affine models, with ``is_mirrored``: a negative determinant."""
    if not set(DETERMINANT) <= set(models.columns):
        return models.iloc[:0].assign(is_mirrored=False)
    is_affine = (models["transformation"] == "affine") & models["is_usable"]
    affine = models[is_affine.astype(bool)]
    a1, a2, b1, b2 = affine[DETERMINANT].to_numpy(dtype=float).T
    return affine.assign(is_mirrored=a1 * b2 - a2 * b1 < 0.0)


def _stretch(affine):
    """Stretch that affine models share, and the probability of it by chance.

    Errors of a model turn its affinity into any direction: with its sign they cancel in
    the mean, and their scatter tells how well. An affinity that is common stands fast
    in the axes of the machine or in those of the ground; the clearer one is told.
    """
    if len(affine) < FEWEST_MODELS:
        return 0.0, 1.0
    a1, a2, b1, b2 = affine[DETERMINANT].to_numpy(dtype=float).T
    # ground = turned z + mirrored conj(z), z = x + i y
    turned = 0.5 * ((a1 + b2) + 1j * (b1 - a2))
    mirrored = 0.5 * ((a1 - b2) + 1j * (b1 + a2))
    is_over = np.abs(mirrored) > np.abs(turned)
    large = np.where(is_over, mirrored, turned)
    small = np.where(is_over, turned, mirrored)
    # a model that puts all of its points on a line has no axes
    is_plane = np.abs(small) < NEARLY_FLAT * np.abs(large)
    if is_plane.sum() < FEWEST_MODELS:
        return 0.0, 1.0
    large, small, is_over = large[is_plane], small[is_plane], is_over[is_plane]
    of_machine = np.where(is_over, np.conj(small / large), small / large)
    weights = affine["n_points"].to_numpy(dtype=float)[is_plane]
    found = [_common(part, weights) for part in (of_machine, small / np.conj(large))]
    affinity, p_value = min(found, key=lambda pair: (pair[1], -pair[0]))
    # the clearer of two
    return 2.0 * affinity / (1.0 - affinity), min(2.0 * p_value, 1.0)


def _common(affinities, weights):
    """Size of the weighted mean of complex affinities, and its p-value.

    Easting and northing of equal precision make their errors circular: two degrees of
    freedom each.
    """
    mean = np.average(affinities, weights=weights)
    degrees = 2 * (len(affinities) - 1)
    scatter = np.sum(weights * np.abs(affinities - mean) ** 2) / degrees
    size = np.sum(weights) * np.abs(mean) ** 2 / 2.0
    ratio = size / scatter if scatter > 0.0 else np.inf
    return float(np.abs(mean)), float(fdtrc(2, degrees, ratio))


def are_upside_down(models):
    """Usable spatial models, with ``is_upside_down``: turned over to fit at all."""
    if not {"omega", "phi"} <= set(models.columns):
        return models.iloc[:0].assign(is_upside_down=False)
    spatial = models[models["is_usable"].astype(bool) & models["omega"].notna()]
    omega, phi = spatial[["omega", "phi"]].to_numpy(dtype=float).T
    return spatial.assign(is_upside_down=np.cos(omega) * np.cos(phi) < 0.0)


def _film_of(name, flight, places):
    held = flight.model_table()
    plan = places.reindex(held["point_id"]).to_numpy(dtype=float)
    axes = np.stack([np.cos(DIRECTIONS), np.sin(DIRECTIONS)])
    keys = [held[key].to_numpy() for key in ("coverage", "model_id") if key in held]
    along = held[[]].reset_index(drop=True).assign(**_named(plan @ axes))
    models = along.groupby(keys)
    widest = (models.max() - models.min()).max(axis=1)
    widest = widest[widest > 0.0]
    diameter = float(widest.median()) if len(widest) else np.nan
    return FilmSize(name, float(flight.scale_number), diameter)


def _named(columns):
    return {str(number): column for number, column in enumerate(columns.T)}
