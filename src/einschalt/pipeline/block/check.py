"""What is wrong with a block: facts, each table alone, and how the tables fit.

Nothing stops at the first fault. Tables are compared only where each of them is right,
so that one misspelt column does not bring a hundred lost points with it.
"""

from dataclasses import dataclass, replace
from numbers import Real

import numpy as np
import pandas as pd

from einschalt.foundations import tables
from einschalt.foundations.arguments import is_choice
from einschalt.foundations.errors import ConsistencyError, EinschaltError
from einschalt.foundations.names import is_among
from einschalt.foundations.number_parsing import LARGEST_NUMBER
from einschalt.foundations.units import METRES_PER_UNIT
from einschalt.pipeline.block.axis_order import mirrored_problems, where_problems
from einschalt.pipeline.block.facts import FLIGHTS, check_facts
from einschalt.pipeline.block.given_points import (
    contradictions,
    fitted_onto,
    heights_that_are_none,
    known_of_models,
    nothing_but_check_points,
    points_in_no_model,
    standard_error_problems,
    with_names_alike,
)
from einschalt.pipeline.block.repeated_pointings import (
    average_settings,
    settings_problems,
)
from einschalt.pipeline.block.scales import (
    UNIT_WORDS,
    coordinate_problems,
    digit_notes,
    equal_height_problems,
    extent_problems,
    image_size_problems,
    lost_image_points,
    scale_problems,
)
from einschalt.pipeline.block.stereo_models import (
    images_without_points,
    models_of_one_photograph,
    models_of_photographs_apart,
    models_without_parallaxes,
    parallax_problems,
)
from einschalt.pipeline.block.ways_between_systems import with_total_errors
from einschalt.stages.control_in_plan import note_of_plan_alone, with_rough_plan
from einschalt.stages.transformation_kinds import TRANSFORMATION_KINDS, is_spatial


@dataclass(frozen=True, eq=False)
class Findings:
    """What the check of a block found."""

    tables: dict  # fields of the block, as checked
    problems: tuple[EinschaltError, ...]  # what stops the computation
    # models that will be rows of ``failures``
    model_problems: tuple[EinschaltError, ...]
    notes: tuple[str, ...]


def check_block(block, said=frozenset()) -> Findings:
    """Check facts, tables, and how the tables fit each other.

    ``block`` has the attributes of a Block; ``said`` are sections and keys of facts
    that are known to be wrong or missing.
    """
    check = _Check(block)
    check.problems += check_facts(block, said)
    check.tables_alone()
    check.axes()
    check.units()
    check.images()
    check.models_with_parallaxes()
    check.sizes()
    check.points_given_twice()
    check.points_in_models()
    check.models_on_points()
    # a table of control may be that of approximate points as well
    problems = {str(each): each for each in with_rough_plan(block, check.problems)}
    lists = (problems.values(), check.models, dict.fromkeys(check.notes))
    return Findings(check.checked, *map(tuple, lists))


def _ground_schema(schema, flight):
    """Schema of the points onto which a flight is transformed."""
    return schema.requiring("height") if is_spatial(flight) else schema


class _Check:
    """Collects what is wrong with the tables; each method looks at one kind."""

    def __init__(self, block):
        self.block = block
        self.checked = {}
        self.problems = []
        self.models = []
        self.notes = []
        self.are_axes_sound = True
        self.are_names_strange = False  # of all given points, which is said
        self.is_sound = {}
        self.points_of_models = {}

    def _file(self, table):
        return self.block.sources.get(table, table)

    def _sound(self, *names):
        return all(self.is_sound.get(name, False) for name in names)

    def tables_alone(self):
        """Columns and values of each table by itself."""
        high, low = self.block.high_flight, self.block.low_flight
        self._table("control_points", _ground_schema(tables.CONTROL_POINTS, high))
        self._table(
            "approximate_points", _ground_schema(tables.APPROXIMATE_POINTS, low)
        )
        self._standard_errors()
        for name in FLIGHTS:
            flight = getattr(self.block, name)
            if flight is not None:
                self.checked[name] = self._flight_tables(name, flight)

    def _table(self, name, schema):
        frame = getattr(self.block, name)
        if frame is None:
            return
        control = self._file("control_points")
        if name == "approximate_points" and self._file(name) == control:
            # the rest of its columns is read there, and is not ignored
            rest = frame.columns.intersection(tables.CONTROL_POINTS.names)
            frame = frame.drop(columns=rest.difference(schema.names))
        self.checked[name] = self._one(frame, schema, name)

    def _one(self, frame, schema, table):
        checked = tables.check_table(frame, schema, source=self._file(table))
        self.problems += checked.problems
        self.notes += checked.notes
        self.is_sound[table] = not checked.problems
        return checked.frame

    def _standard_errors(self):
        control = self.checked.get("control_points")
        if not self._sound("control_points"):
            return
        file = self._file("control_points")
        self.problems += standard_error_problems(control, file)
        self.checked["control_points"] = with_total_errors(control)

    def _flight_tables(self, name, flight):
        parts = {
            "model_points": self._model_points_schema(flight),
            "y_parallaxes": self._in_unit(tables.Y_PARALLAXES, flight),
            "image_points": tables.IMAGE_POINTS,
            "models": tables.IMAGE_MODELS,
        }
        if isinstance(flight.base, pd.DataFrame):
            parts["base"] = self._in_unit(tables.MODEL_BASES, flight)
        given = {
            key: self._one(getattr(flight, key), schema, f"{name}.{key}")
            for key, schema in parts.items()
            if getattr(flight, key) is not None
        }
        if self._sound(table := f"{name}.model_points"):
            points = given["model_points"]
            self.problems += settings_problems(points, self._file(table))
            given["model_points"] = average_settings(points)
        return replace(flight, **given)

    def _model_points_schema(self, flight):
        schema = self._in_unit(tables.MEASURED_MODEL_POINTS, flight)
        if not is_spatial(flight) and flight.y_parallaxes is None:
            return schema
        return schema.requiring("z")

    @staticmethod
    def _in_unit(schema, flight):
        """Say what is expected in the unit that the flight names."""
        is_known = is_choice(flight.model_unit, UNIT_WORDS)
        return schema.in_unit(UNIT_WORDS[flight.model_unit]) if is_known else schema

    def axes(self):
        """Easting and northing exchanged, and points in another system."""
        for name in ("control_points", "approximate_points"):
            if self._sound(name):
                frame, file = self.checked[name], self._file(name)
                problems, notes = where_problems(
                    frame, self.block.crs, file, self._all_measured
                )
                self.problems += problems
                self.notes += notes
                self.are_axes_sound &= not problems

    def units(self):
        """Coordinates that cannot have the unit that is named."""
        for name in FLIGHTS:
            flight = self.checked.get(name)
            if flight is None:
                continue
            unit = flight.model_unit
            # a rigid model has the size of the ground, and is judged elsewhere: a wrong
            # unit makes its m_0 as large as itself
            is_at_image_scale = not is_choice(flight.transformation, ("rigid",))
            is_known = is_choice(unit, METRES_PER_UNIT)
            is_sound = self._sound(f"{name}.model_points") and is_known
            if is_sound and is_at_image_scale:
                frame, file = flight.model_points, self._file(f"{name}.model_points")
                self.problems += extent_problems(frame, "model_id", unit, file)
            if self._sound(f"{name}.image_points"):
                self._undistorted(f"{name}.image_points", flight)

    def _undistorted(self, table, flight):
        """Image coordinates that the camera does not know, or that have no mm."""
        frame = flight.image_coordinates()
        is_lost = frame["x"].isna().to_numpy()
        self.problems += lost_image_points(flight, is_lost, self._file(table))
        if not is_lost.all():
            distance, file = flight.principal_distance_mm, self._file(table)
            self.problems += image_size_problems(frame[~is_lost], distance, file)

    def points_given_twice(self):
        """Points with two coordinates that contradict each other."""
        both = ("control_points", "approximate_points")
        # unless systems or units may be wrong
        if self._sound(*both) and not self.problems:
            given, files = map(self.checked.get, both), tuple(map(self._file, both))
            self.notes += contradictions(self.block, *given, files)

    def images(self):
        """Models whose images were not measured."""
        for name in FLIGHTS:
            if self._sound(f"{name}.models", f"{name}.image_points"):
                flight, file = self.checked[name], self._file(f"{name}.models")
                absent = images_without_points(
                    flight, file, self._file(f"{name}.image_points")
                )
                self.problems += absent
                if not absent:
                    table = self._model_table(name)
                    self.models += models_of_photographs_apart(flight, table, file)
                    self.models += models_of_one_photograph(flight, file)

    def models_with_parallaxes(self):
        """Models of a flight that is to be oriented, without measured parallaxes."""
        for name in FLIGHTS:
            parts = (f"{name}.model_points", f"{name}.y_parallaxes")
            if self._sound(*parts):
                files = [self._file(part) for part in parts]
                self.models += models_without_parallaxes(self.checked[name], *files)

    def sizes(self):
        """Sizes that do not fit each other: a wrong unit, or a wrong scale number."""
        self.notes += digit_notes(self.block, self.checked, self._sound, self._file)
        for ground in ("control_points", "approximate_points"):
            if self._sound(ground):
                frame, file = self.checked[ground], self._file(ground)
                self.problems += coordinate_problems(frame, file)
                problems, notes = heights_that_are_none(frame, file)
                self.problems += problems
                self.notes += notes + note_of_plan_alone(self.block, frame, file)
        ground, name = self._ground_and_flight()
        if (
            ground
            and self.are_axes_sound
            and isinstance(self.checked[name].scale_number, Real)
        ):
            flight, file = self.checked[name], self._file(ground)
            self.problems += scale_problems(
                name, flight, self._model_table(name), self.checked[ground], file
            )
            self._heights(ground, name)
            self._mirrored(ground, name)
        for name in FLIGHTS:
            if self._sound(f"{name}.y_parallaxes") and self._has_base(name):
                files = {p: self._file(f"{name}.{p}") for p in ("base", "y_parallaxes")}
                self.problems += parallax_problems(self.checked[name], files)

    def _heights(self, ground, name):
        flight = self.checked[name]
        if is_spatial(flight) and self._sound(f"{name}.model_points"):
            points, file = flight.model_points, self._file(ground)
            self.problems += equal_height_problems(
                name, points, self.checked[ground], file
            )

    def _mirrored(self, ground, name):
        """Photographs that show the ground as a mirror does: affinities undo that."""
        flight, table = self.checked[name], f"{name}.image_points"
        if self._sound(table) and flight.transformation != "affine":
            self.problems += mirrored_problems(
                flight.image_coordinates(),
                self.checked[ground],
                name,
                (self._file(table), self._file(ground)),
            )

    def _has_base(self, name):
        base = self.checked[name].base
        is_length = isinstance(base, Real) and 0.0 < base <= LARGEST_NUMBER
        return self._sound(f"{name}.base") or is_length

    def points_in_models(self):
        """Ground points that no model holds: misspelt, or merely not measured."""
        ground, flight_name = self._ground_and_flight()
        if ground is None or self.block.may_be_unmeasured:
            return
        frame, measured = self.checked[ground], self._measured(flight_name)
        is_lost = ~is_among(frame["point_id"], measured)
        if ground == "control_points" and self._has_models("low_flight"):
            in_low = is_among(frame["point_id"], self._measured("low_flight"))
            is_lost &= ~((frame["role"] == "check").to_numpy() & in_low)

        given = ground, self._file(ground), flight_name
        problems, notes = points_in_no_model(
            frame, is_lost, measured, given, self.block.sources
        )
        self.problems += problems
        self.notes += notes
        self.are_names_strange = bool(is_lost.all())

    def _all_measured(self):
        flights = [name for name in FLIGHTS if self._has_models(name)]
        return np.concatenate([[], *map(self._measured, flights)])

    def _measured(self, flight_name):
        return self._model_table(flight_name)["point_id"].unique()

    def _ground_and_flight(self):
        if self._sound("approximate_points") and self._has_models("low_flight"):
            return "approximate_points", "low_flight"
        if self._sound("control_points") and self._has_models("high_flight"):
            return "control_points", "high_flight"
        return None, None

    def _has_models(self, name):
        flight = self.checked.get(name)
        if flight is None:
            return False
        if flight.has_images:
            return self._sound(f"{name}.image_points", f"{name}.models")
        return self._sound(f"{name}.model_points")

    def _model_table(self, name):
        if name not in self.points_of_models:
            self.points_of_models[name] = self.checked[name].model_table()
        return self.points_of_models[name]

    def models_on_points(self):
        """Models that hold no point with ground coordinates."""
        ground, flight_name = self._ground_and_flight()
        if ground is None:
            return
        known = fitted_onto(self.checked[ground], self.checked.get("control_points"))
        if known.empty:
            self.problems += [nothing_but_check_points(self._file(ground))]
        elif not self.are_names_strange:
            self._models_without(flight_name, known, ground)
        if flight_name == "high_flight" and self._has_models("low_flight"):
            self._models_without(
                "low_flight", self._measured("high_flight"), "the high flight"
            )

    def _named(self, ground, known):
        """What known points are called: control, where it stands for others."""
        if ground != "approximate_points" or not self._sound("control_points"):
            return ground
        control = self.checked["control_points"]["point_id"]
        return "control_points" if is_among(known, control).all() else ground

    def _models_without(self, flight_name, known, ground):
        flight, table = self.checked[flight_name], self._model_table(flight_name)
        is_word = is_choice(word := flight.transformation, TRANSFORMATION_KINDS)
        least = TRANSFORMATION_KINDS[word].least_points if is_word else 1
        counted = known_of_models(table, known, least)
        onto = self._named(ground, known)
        part = "models" if flight.has_images else "model_points"
        file = self._file(f"{flight_name}.{part}")

        def problem(place):
            facts = tables.row_location(table, place)
            return ConsistencyError(
                **counted.lack(place, onto, word),
                file=file,
                row=facts["row"] if part == "model_points" else None,
                model=facts["model"],
            )

        is_lost = counted.is_lacking
        # all models together may have enough control for the simultaneous adjustment
        if 0 < counted.n_known < least and onto.endswith("_points"):
            self.problems += [counted.too_few(onto, self._file(ground))]
            return
        has_enough = onto == "control_points" and counted.n_known >= least
        if onto != "approximate_points" and self._is_adjusted_in_one():
            self.notes += counted.note_of_tied(table, onto, file)
            is_lost = is_lost & ~counted.is_tied
        places = np.flatnonzero(is_lost)
        if has_enough or is_lost.sum() < counted.is_first.sum():
            self.models += [problem(place) for place in places]
        else:
            faults = tables.listed(places, problem, "no model has enough common points")
            if not counted.is_known.any():
                faults = with_names_alike(
                    faults, table, known, (flight_name, onto), self.block.sources
                )
            self.problems += faults

    def _is_adjusted_in_one(self):
        """Whether the block's own settings ask for one adjustment of all models."""
        settings = getattr(self.block, "settings", None)
        return settings is not None and settings.method != "two_step"
