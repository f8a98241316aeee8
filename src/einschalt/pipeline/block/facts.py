"""The facts of a block beside its tables: systems, numbers, words, and what is there.

Every fault is said; ``said`` names the facts that a reader of files has complained of
already, so that nobody reads the same complaint twice.
"""

from dataclasses import dataclass, field

import numpy as np
import pandas as pd

from einschalt.foundations.arguments import described, is_choice
from einschalt.foundations.errors import ProjectionError, SettingsError
from einschalt.foundations.header_units import is_unit, plain_unit
from einschalt.foundations.near_words import nearest
from einschalt.foundations.number_parsing import LARGEST_NUMBER
from einschalt.foundations.projections import read_crs
from einschalt.foundations.units import METRES_PER_UNIT
from einschalt.foundations.value_ranges import Range
from einschalt.stages.transformation_kinds import TRANSFORMATION_KINDS

TRANSFORMATIONS = tuple(TRANSFORMATION_KINDS)
FLIGHTS = ("high_flight", "low_flight")
ORIENTATION_CASES = ("independent", "dependent_left", "dependent_right")
ORIENTATION_METHODS = ("least_squares", "krames", "gruber")


RANGES = {
    "scale_number": Range(100, 200_000, "(the denominator)"),
    "m_g_um": Range(0.1, 1000, "(micrometres in the image)"),
    "principal_distance_mm": Range(1, 5000, "(millimetres)"),
    "m_0_m": Range(1e-4, 100, "(metres)"),
    "group_error_m": Range(1e-4, 100, "(metres)"),
    "correlation_length_m": Range(0, 1e7, "(metres)"),
}
# of more points the correlations would be too many: about a second
MOST_CORRELATED = 2500
POINT_TABLES = ("control_points", "approximate_points")
UM_PER_MM = 1000
ASK_BELOW = {
    "scale_number": "Give 8000 for 1:8000",
    "m_g_um": "Did you give metres?",
    "principal_distance_mm": "Did you give metres?",
}
ASK_ABOVE = {
    "principal_distance_mm": "Did you give micrometres?",
    "m_0_m": "Did you give millimetres?",
    "group_error_m": "Did you give millimetres?",
}


def check_facts(block, said=frozenset()):
    """Check all of a block that is no table, but for the facts in ``said``."""
    facts = _Facts(block, said)
    facts.system()
    facts.sections()
    facts.shared_errors()
    for name in FLIGHTS:
        flight = getattr(block, name)
        if flight is not None:
            facts.numbers(name, flight)
            facts.words(name, flight)
            facts.parts(name, flight)
    return facts.problems


def _question(key, value):
    """Guess what was meant with a positive number out of its range."""
    if value not in Range(0, np.inf) or value == 0:
        return ""
    if key == "m_g_um" and value * UM_PER_MM in RANGES[key]:
        return "Did you give millimetres?"
    return (ASK_BELOW if value < RANGES[key].low else ASK_ABOVE).get(key, "")


@dataclass
class _Facts:
    """Collects what is wrong; each method looks at one kind of fact."""

    block: object
    said: frozenset
    problems: list = field(default_factory=list)

    def _say(self, found, section=None, key=None, **facts):
        where = {"file": self.block.sources.get("block"), "section": section}
        if section is not None:
            found = f"[{section}] {found}"
        self.problems.append(SettingsError(found, key=key, **where, **facts))

    def _has(self, section, *keys):
        if (section, "") in self.said or getattr(self.block, section) is not None:
            return True
        return any((section, key) in self.said for key in keys)

    def system(self):
        """Understand the coordinate reference system."""
        if self.block.crs is None or ("block", "crs") in self.said:
            return
        try:
            read_crs(self.block.crs)
        except ProjectionError as error:
            file = self.block.sources.get("block")
            found = f"[block] {error.found}" if file else error.found
            facts = {"found": found, "file": file, "section": "block", "key": "crs"}
            self.problems.append(error.with_facts(**facts))

    def sections(self):
        """See whether there is what the computation needs."""
        has_high = self._has("high_flight")
        has_approximate = self._has("approximate_points", "file")
        one = "one of [high_flight] and [approximate_points]"
        add = "Add the section to block.toml"
        if not has_high and not has_approximate:
            found = "neither a high flight nor approximate points are given"
            self._say(found, expected=one, remedy=add)
        if has_high and has_approximate:
            found = "a high flight and approximate points are both given"
            self._say(found, expected=one, remedy="Take one of the sections out")
        if has_high and not self._has("control_points", "file"):
            found = "a high flight is given without control points"
            self._say(found, expected="[control_points]", remedy=add)
        if not self._has("low_flight"):
            self._say("no low flight is given", expected="[low_flight]", remedy=add)
        if self.block.approximate_m_0_m is not None:
            self._range("approximate_points", "m_0_m", self.block.approximate_m_0_m)

    def shared_errors(self):
        """See what given points of one group, or near each other, have in common."""
        for key, sizes in (
            ("group_error_m", self.block.group_errors_m),
            ("correlation_length_m", self.block.correlation_lengths_m),
        ):
            for table, value in sizes.items():
                if is_choice(table, POINT_TABLES):
                    self._range(table, key, value)
                    self._shared_in(table, key, value)
                else:
                    expected = " or ".join(POINT_TABLES)
                    self._say(f"{key} of {described(table)}", expected=expected)

    def _shared_in(self, table, key, value):
        points = getattr(self.block, table)
        if not isinstance(points, pd.DataFrame):
            if not self._has(table, "file"):
                self._say(f"{key}, but there are no {table}", expected=f"[{table}]")
            return
        if key == "group_error_m" and "group" not in points:
            self._say(
                f"group_error_m, but {self.block.sources.get(table, table)} has no "
                "column 'group'",
                *(table, key),
                expected="the group of each point, as a name",
                remedy=f"Add the column, or take {key} out",
            )
        is_correlated = key == "correlation_length_m" and value != 0
        if is_correlated and len(points) > MOST_CORRELATED:
            self._say(
                f"correlation_length_m of {len(points)} points",
                *(table, key),
                expected=f"at most {MOST_CORRELATED} points",
                remedy="Give a column group instead: points of a group share a shift",
            )

    def numbers(self, name, flight):
        """Compare scale number, m_g, principal distance and base with their ranges."""
        self._range(name, "scale_number", flight.scale_number)
        self._range(name, "m_g_um", flight.m_g_um)
        if flight.principal_distance_mm is not None:
            key = "principal_distance_mm"
            self._range(name, key, flight.principal_distance_mm)
        self._camera(name, flight)
        if flight.base is not None and not isinstance(flight.base, pd.DataFrame):
            self._base(name, flight.base)

    def _range(self, section, key, value):
        if (section, key) not in self.said and value not in RANGES[key]:
            self._say(
                f"{key} = {described(value)}",
                section,
                key,
                expected=str(RANGES[key]),
                remedy=_question(key, value),
            )

    def _camera(self, section, flight):
        if flight.camera is None:
            return
        own, given = flight.camera.principal_distance_mm, flight.principal_distance_mm
        is_number = given in RANGES["principal_distance_mm"]
        if is_number and not np.isclose(given, own, rtol=1e-9):
            self._say(
                f"principal_distance_mm = {described(given)}, but that of the "
                f"camera is {own:.10g}",
                section,
                "principal_distance_mm",
                expected="one of the two",
                remedy="Take principal_distance_mm out",
            )

    def _base(self, section, value):
        is_sound = value in Range(np.finfo(float).tiny, LARGEST_NUMBER)
        if (section, "base") not in self.said and not is_sound:
            expected = "a positive number in model_unit, or a table of bases"
            self._say(f"base = {described(value)}", section, "base", expected=expected)

    def words(self, name, flight):
        """Compare transformation and unit with the words that are known."""
        for key, allowed in (
            ("transformation", TRANSFORMATIONS),
            ("model_unit", tuple(METRES_PER_UNIT)),
            ("orientation_case", (None, *ORIENTATION_CASES)),
            ("orientation_method", (None, *ORIENTATION_METHODS)),
        ):
            value = getattr(flight, key)
            if (name, key) in self.said or is_choice(value, allowed):
                continue
            known = [word for word in allowed if word]
            near = _meant(key, value, known)
            found = f"{key} = {described(value)} is unknown"
            remedy = f"Write {near!r}" if near else ""
            if key == "model_unit" and near is None:
                remedy = "Convert the models to one of these units"
            self._say(found, name, key, expected=" or ".join(known), remedy=remedy)

    def parts(self, name, flight):
        """See whether a flight has the tables that it needs together."""

        def has(key):
            return getattr(flight, key) is not None or (name, key) in self.said

        if has("model_points") == has("image_points"):
            found = (
                "model_points and image_points are both given"
                if has("model_points")
                else "model_points and image_points are both missing"
            )
            self._say(found, name, "model_points", expected="one of the two")
        if has("y_parallaxes") and has("image_points"):
            self._say(
                "y_parallaxes and image_points are both given",
                *(name, "y_parallaxes"),
                expected="y_parallaxes beside model_points only",
                remedy=f"Take one of them out of [{name}]",
            )
        needs = []
        if has("image_points"):
            needs = [("models", "image_points")]
            if not has("camera"):
                needs += [("principal_distance_mm", "image_points")]
        if has("y_parallaxes"):
            needs += [("base", "y_parallaxes")]
        if flight.orientation_method is not None and not has("y_parallaxes"):
            needs += [("y_parallaxes", "orientation_method")]
        for key, beside in needs:
            if not has(key):
                expected, remedy = (
                    f"{key} beside {beside}",
                    f"Add {key} = … to [{name}]",
                )
                found = f"{key} is missing"
                self._say(found, name, key, expected=expected, remedy=remedy)


def _meant(key, value, known):
    """The known word that may be meant; None where none is.

    A unit written otherwise is that unit, and of two units none is like the other.
    """
    if key == "model_unit" and isinstance(value, str):
        unit = plain_unit(value)
        if unit in known or is_unit(unit):
            return unit if unit in known else None
    return nearest(value, known)
