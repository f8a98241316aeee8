"""What is measured in the models and images of a simulated block.

Three ways to measure a flight, each from the true positions and the flight's noise:
machine coordinates of oriented models, machine coordinates of models that are not yet
oriented with the y-parallaxes that show it, and image coordinates. The results are the
tables of a :class:`~einschalt.pipeline.block.block.Flight`, lengths in mm.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from einschalt.foundations.rotations import rotation_from_angles
from einschalt.foundations.units import METRES_PER_MM
from einschalt.pipeline.simulation.geometry import BlockGeometry
from einschalt.pipeline.simulation.layout import FlightLayout, Terrain, turn
from einschalt.pipeline.simulation.noise import (
    FlightNoise,
    deform_models,
    measure_in_image_plane,
)
from einschalt.theory.relative_orientation.model_correction import disturb_model

# the base carriage of a plotter keeps the model's base within a few degrees of x
LARGEST_MACHINE_ROTATION = 0.05
MACHINE_OFFSET = (0.3, 0.7)
CASE = "independent"
# the six standard points 1 to 6: at the nadirs (in bases), and a base to either side
STANDARD_POINTS = np.array([[0, 0], [1, 0], [0, 1], [1, 1], [0, -1], [1, -1]])
TILT_MARGIN = 1.3  # images are searched for points beyond their untilted footprint
GROSS_ERROR_COLUMNS = ["flight", "coverage", "model_id", "image_id", "point_id"]


@dataclass(frozen=True, eq=False)
class Ground:
    """The true points of a block."""

    point_id: np.ndarray  # (n_points,)
    # (n_points, 2): easting, northing from the centre of the area [m]
    position: np.ndarray
    terrain: Terrain  # or another with ``height(position)``
    # (n_points, 3), of models on the curved Earth: Cartesian ones from the centre
    # of the area and heights above zero [m]; None where the map is the ground
    cartesian: np.ndarray | None = None

    def seen(self, point):
        """Places (n, 2) and heights (n,) of points as models and cameras see them."""
        if self.cartesian is None:
            position = self.position[point]
            return position, self.terrain.height(position)
        return self.cartesian[point, :2], self.cartesian[point, 2]


@dataclass(frozen=True, eq=False)
class FlightToMeasure:
    """All that a measurement of one flight needs."""

    geometry: BlockGeometry
    ground: Ground
    layout: FlightLayout
    noise: FlightNoise
    # setting (of machine), measurement, gross, height, orientation, deformation
    streams: dict[str, np.random.Generator]

    @property
    def laid_out_for(self):
        """Height of the ground for which each model has the scale, (n_models,) [m].

        Only cameras with altitudes of their own fly above other ground than the mean.
        """
        geometry, layout = self.geometry, self.layout
        if layout.altitudes is None:
            return np.full(layout.n_models, geometry.mean_height)
        nominal = geometry.principal_distance * layout.scale_number
        return layout.camera_altitude(geometry) - nominal

    @property
    def enlarged(self):
        """How much larger errors are in the model than in the image: by its depth.

        1 where all cameras fly at one height: then the model is orthogonal.
        """
        if self.layout.altitudes is None:
            return 1.0
        layout = self.layout
        height = self.ground.terrain.height(self.ground.position[layout.point])
        above = height - self.laid_out_for[layout.model]
        nominal = self.geometry.principal_distance * layout.scale_number
        return 1.0 - above / nominal


@dataclass(frozen=True, eq=False)
class MeasuredFlight:
    """Tables of a flight, and which of its measurements have gross errors."""

    tables: dict  # fields of a :class:`~einschalt.pipeline.block.block.Flight`
    # coverage, model_id, image_id, point_id; the one of model and image that was not
    # measured is empty
    gross_errors: pd.DataFrame


def measure_in_machine(flight) -> MeasuredFlight:
    """Measure oriented models in a machine, each set up anew.

    Model points x, y, and z with spatial models.
    """
    true = _in_model(flight)
    plane = _measure(flight, true, flight.enlarged)
    turned, offset = _set_up(flight, plane.values)
    xyz = np.column_stack([turned, _measured_height(flight, true)])
    names = _names_of_rows(flight)
    table = _in_mm(names, xyz + offset)
    if not flight.geometry.has_heights:
        table = table.drop(columns="z")
    return MeasuredFlight({"model_points": table}, _gross(names, plane.is_gross))


def measure_plane_in_machine(flight):
    """x, y of :func:`measure_in_machine` as an array, (n_rows, 2) [mm]."""
    plane = _measure(flight, _in_model(flight), flight.enlarged)
    turned, offset = _set_up(flight, plane.values)
    return (turned + offset[:, :2]) / METRES_PER_MM


def _set_up(flight, plane):
    """Plane coordinates as the machine has turned each model, and its offsets."""
    layout, setting = flight.layout, flight.streams["setting"]
    largest = LARGEST_MACHINE_ROTATION
    angle = setting.uniform(-largest, largest, layout.n_models)
    offset = setting.uniform(*MACHINE_OFFSET, (layout.n_models, 3))
    return turn(plane, angle[layout.model]), offset[layout.model]


def measure_parallaxes(flight) -> MeasuredFlight:
    """Measure models that are not yet oriented, and their y-parallaxes.

    Each model has its own errors of orientation, with which the machine coordinates are
    bent as an operator would read them. Origin is the left projection centre.

    Each model has its own errors of orientation, with which the machine coordinates are
    bent as an operator would read them. Origin is the left projection centre. Model
    points x, y, z; the y-parallaxes of six standard points, named 1 to 6; and the
    bases.
    """
    layout, of_row = flight.layout, flight.layout.model
    base = layout.base / layout.scale_number
    drawn = flight.streams["orientation"].standard_normal((layout.n_models, 5))
    elements = flight.noise.orientation_error * drawn
    true = _in_model(flight)
    plane = _measure(flight, true, flight.enlarged)
    measured = np.column_stack([plane.values, _measured_height(flight, true)])
    from_left = measured + _centre_from_left_image(flight.geometry, base)[of_row]
    machine, _ = disturb_model(from_left, base[of_row], elements[of_row], CASE)
    names = _names_of_rows(flight)
    tables = {
        "model_points": _in_mm(names, machine),
        "y_parallaxes": _standard_parallaxes(flight, base, elements),
        "base": _names_of_models(layout).assign(base=base / METRES_PER_MM),
    }
    return MeasuredFlight(tables, _gross(names, plane.is_gross))


def measure_images(flight) -> MeasuredFlight:
    """Take tilted photographs of the terrain and measure all points in them.

    A point is measured in every image in which it lies inside the usable rim.

    Notes
    -----
    x' = -c r_1 / r_3, y' = -c r_2 / r_3 with r = M (X - X_0),
    M = R3(kappa) R2(phi) R1(omega); kappa is the direction of the strip but for the
    tilt. The photographs of a model's strip are numbered so that model 3/12 consists
    of 3/12 and 3/13.
    """
    models = _names_of_models(flight.layout)
    strip_and_place = models["model_id"].str.split("/", expand=True)
    strip = models["coverage"] + "/" + strip_and_place[0] + "/"
    models["left_image"] = strip + strip_and_place[1]
    models["right_image"] = strip + (strip_and_place[1].astype(int) + 1).astype(str)
    wanted = set(models["left_image"]) | set(models["right_image"])
    coverages = range(len(flight.layout.rasters))
    names, xy = zip(*(_photograph(flight, k) for k in coverages), strict=True)
    names, xy = pd.concat(names, ignore_index=True), np.concatenate(xy)
    is_wanted = names["image_id"].isin(wanted).to_numpy()
    names, xy = names[is_wanted].reset_index(drop=True), xy[is_wanted]
    plane = _measure(flight, xy)
    tables = {
        "image_points": _in_mm(names, plane.values),
        "models": models,
        "principal_distance_mm": flight.geometry.principal_distance / METRES_PER_MM,
    }
    return MeasuredFlight(tables, _gross(names, plane.is_gross))


MEASURE = {
    "machine": measure_in_machine,
    "parallaxes": measure_parallaxes,
    "images": measure_images,
}


def _in_model(flight):
    """Give true x along and y across the strip from the model's centre, z from mean.

    At image scale [m], shape (n_rows, 3).
    """
    layout, ground = flight.layout, flight.ground
    position, height = ground.seen(layout.point)
    away = turn(position - layout.centre[layout.model], -layout.direction[layout.model])
    above = height - flight.laid_out_for[layout.model]
    return np.column_stack([away, above]) / layout.scale_number


def _measure(flight, true, enlarged=1.0):
    streams, noise = flight.streams, flight.noise
    bent = true[:, :2] + deform_models(true[:, :2], noise, streams["deformation"])
    drawn = streams["measurement"], streams["gross"]
    return measure_in_image_plane(bent, noise, *drawn, enlarged)


def _measured_height(flight, true):
    """Heights at image scale: their error is c/b times that of a plane coordinate."""
    layout, noise = flight.layout, flight.noise
    base = layout.base[layout.model] / layout.scale_number
    error = flight.geometry.principal_distance / base * noise.m_g / np.sqrt(2.0)
    error = error * flight.enlarged**2
    return true[:, 2] + error * flight.streams["height"].standard_normal(len(true))


def _centre_from_left_image(geometry, base):
    """Centre of each model at mean height, in the system of the model."""
    zero = np.zeros_like(base)
    return np.column_stack([base / 2.0, zero, zero - geometry.principal_distance])


def _standard_parallaxes(flight, base, elements):
    """Table of the y-parallaxes at the standard points of all models."""
    layout, noise = flight.layout, flight.noise
    model = np.repeat(np.arange(layout.n_models), len(STANDARD_POINTS))
    machine, parallax = disturb_model(
        _standard_points(flight, base), base[model], elements[model], CASE
    )
    error = flight.streams["orientation"].standard_normal(len(model))
    number = np.arange(1, 1 + len(STANDARD_POINTS)).astype(str).astype(object)
    names = _names_of_models(layout).iloc[model]
    table = _in_mm(names.assign(point_id=np.tile(number, layout.n_models)), machine)
    measured = parallax + noise.y_parallax * error
    return table.assign(y_parallax=measured / METRES_PER_MM)


def _standard_points(flight, base):
    """Six standard points of each model in its system, shape (6 * n_models, 3)."""
    geometry, layout = flight.geometry, flight.layout
    model = np.repeat(np.arange(layout.n_models), len(STANDARD_POINTS))
    from_left = np.tile(STANDARD_POINTS, (layout.n_models, 1)) * base[model, None]
    half_width = geometry.usable_model[1] / 2.0
    from_left[:, 1] = np.clip(from_left[:, 1], -half_width, half_width)
    from_centre = from_left - _centre_from_left_image(geometry, base)[model, :2]
    away = turn(from_centre, layout.direction[model])
    position = layout.centre[model] + layout.scale_number * away
    above = flight.ground.terrain.height(position) - flight.laid_out_for[model]
    depth = geometry.principal_distance - above / layout.scale_number
    return np.column_stack([from_left, -depth])


def _photograph(flight, coverage):
    """Names and true image coordinates of one coverage's photographs."""
    geometry, layout, ground = flight.geometry, flight.layout, flight.ground
    raster = layout.rasters[coverage].images()
    sides = np.array([geometry.image_format, geometry.across])
    half_format = sides / 2.0 - geometry.unusable_rim
    reach = TILT_MARGIN * layout.scale_number * half_format
    image, point = raster.holding(ground.position, reach)
    centres = raster.centres()
    drawn = flight.streams["setting"].standard_normal((len(centres), 3))
    omega, phi, kappa = geometry.camera_tilt * drawn.T
    turned = rotation_from_angles(omega, phi, raster.direction + kappa)
    position, height = ground.seen(point)
    altitude = geometry.flying_height(layout.scale_number)
    if layout.altitudes is not None:
        altitude = layout.altitudes[coverage][image]
    depth = altitude - height
    ray = np.column_stack([position - centres[image], -depth])
    in_image = np.einsum("nij,nj->ni", turned[image], ray)
    xy = -geometry.principal_distance * in_image[:, :2] / in_image[:, 2:]
    is_inside = (np.abs(xy) <= half_format).all(axis=1)
    image_id = (f"{coverage + 1}/" + raster.names())[image]
    names = pd.DataFrame({"image_id": image_id, "point_id": ground.point_id[point]})
    return names[is_inside], xy[is_inside]


def _names_of_models(layout):
    return pd.DataFrame({"coverage": layout.coverage_id, "model_id": layout.model_id})


def _names_of_rows(flight):
    layout = flight.layout
    names = _names_of_models(layout).iloc[layout.model].reset_index(drop=True)
    return names.assign(point_id=flight.ground.point_id[layout.point])


def _in_mm(names, coordinates):
    axes = dict(zip("xyz", coordinates.T / METRES_PER_MM, strict=False))
    return names.reset_index(drop=True).assign(**axes)


def _gross(names, is_gross):
    found = names[is_gross].reset_index(drop=True)
    return found.reindex(columns=GROSS_ERROR_COLUMNS[1:], fill_value="")
