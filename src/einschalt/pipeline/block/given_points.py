"""Given points that no model holds, those given twice, and errors that none has.

Lists often hold more points than a block, but the name of a point may be misspelt.
Points that are given as known points and as approximate points show, before anything is
computed, where one of them is wrong: of a region, or of a single point.
"""

from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
import pandas as pd

from einschalt.foundations import tables
from einschalt.foundations.errors import ConsistencyError, TableError, name_some
from einschalt.foundations.frame_columns import PLAN, values_of
from einschalt.foundations.key_columns import row_codes
from einschalt.foundations.names import encode, is_among
from einschalt.foundations.names_as_numbers import (
    is_of_workbook,
    made_or_typed,
    number_made_of,
    pair_made_or_typed,
)
from einschalt.foundations.near_words import (
    looks_the_same,
    names_meant,
    pair_meant,
    told_apart,
)
from einschalt.foundations.typesetting import number
from einschalt.foundations.units import METRES_PER_UM
from einschalt.stages.transformation_kinds import more_points_for
from einschalt.theory.adjustment.multiple_testing import bonferroni
from einschalt.theory.adjustment.significance import FINDING_SIGNIFICANCE

# of the median distance: TOTAL errors of the low flight; maps of large scales make less
FEWEST_GIVEN_TWICE, TOO_COARSE = 3, 20.0
NAMES_OF_POINTS = "Correct the names of its points, or delete the model"
# where neighbours tie it well enough
ONE_ADJUSTMENT = (
    "Measure more common points in it, or adjust all models together: "
    'method = "auto" in [settings]'
)
MOST_NAMES = 1000  # that tell whether names look like others by chance
# what programs write where no height is known, and how far it must lie from the others
NO_HEIGHT = (-9999.0, -99999.0, -999999.0, -32768.0, -32767.0, -999.0, 9999.0, 99999.0)
FAR_FROM_OTHERS = 500.0  # metres
LEAST_ABOVE_0 = 20.0  # metres, of all other heights, where 0 is doubted
LARGEST_STANDARD_ERROR_M = 10.0
STANDARD_ERRORS = (
    *("standard_error_m", *tables.PLAN_ERRORS),
    "standard_error_height",
)
COVARIANCES = {
    "covariance_en": ("easting", "northing"),
    "covariance_eh": ("easting", "height"),
    "covariance_nh": ("northing", "height"),
}
NO_FILES = MappingProxyType({})
# of numbers that were rounded as they were written
ROUNDED = 1e-6
SQUARE_M_PER_SQUARE_MM = 1e-6


def contradictions(block, control, approximate, sources):
    """Note the points that are given in two places, farther apart than chance explains.

    Parameters
    ----------
    block : Block
        With the errors of the approximate coordinates; without these, only that all
        of them are far coarser than what is measured is noted.
    control, approximate : DataFrame
        point_id, easting, northing; control with standard_error_m (TOTAL) where it has
        errors.
    sources : tuple of str
        Names of the files of both.

    Returns
    -------
    list of str
        One note, or none.
    """
    names = encode(control["point_id"])
    place = encode(approximate["point_id"]).locate(names)[names.codes]
    known = control[place >= 0]
    other = values_of(approximate, PLAN)[place[place >= 0]]
    apart = np.hypot(*(other - values_of(known, PLAN)).T)
    error = block.approximate_m_0_m
    if not (isinstance(error, (int, float)) and error > 0.0):
        return _note_of_coarse(block.low_flight, apart, sources)
    groups = ("control_points", "approximate_points")
    shared = [block.group_errors_m.get(table, 0.0) or 0.0 for table in groups]
    own = np.zeros(len(known))
    if "standard_error_m" in known:
        own = known["standard_error_m"].fillna(0.0).to_numpy(dtype=float)
    # normal errors of both coordinates: TOTAL squares are twice those of each
    p_value = np.exp(-(apart**2) / (np.sum(np.square([error, *shared])) + own**2))
    rows = np.flatnonzero(bonferroni(p_value) < FINDING_SIGNIFICANCE)
    if not len(rows):
        return []
    rows = rows[np.argsort(-apart[rows], kind="stable")]
    points = name_some(known["point_id"].iloc[rows])
    note = (
        f"{sources[1]}: {len(rows)} of {len(known)} points that {sources[0]} gives too "
        f"lie elsewhere here, by up to {number(apart[rows[0]])} m, more than the "
        f"stated errors explain: {points}"
    )
    return [note]


def _note_of_coarse(flight, apart, sources):
    """Note approximate points of unknown errors that are far coarser than a flight.

    ``apart``: distances of those that are known points from where these are [m].
    """
    if len(apart) < FEWEST_GIVEN_TWICE:
        return []
    middle = float(np.median(apart))
    measured = flight.m_g_um * METRES_PER_UM * flight.scale_number
    if not middle > TOO_COARSE * measured:
        return []
    most = apart.max()
    note = (
        f"{sources[1]}: the {len(apart)} points that {sources[0]} gives too lie "
        f"elsewhere here, by {number(middle)} m (median) and up to {number(most)} m, "
        f"and the low flight is measured to {number(measured)} m: compare names, "
        "reference systems and units of both files"
    )
    return [note]


def heights_that_are_none(frame, file):
    """Refuse heights that stand for none in other programs, and note those that may.

    Gives errors, and a note of zeros beside heights that all lie well above; none of
    either where the table has no heights.
    """
    if "height" not in frame:
        return [], []
    height = frame["height"].to_numpy(dtype=float)
    is_none = np.isin(height, NO_HEIGHT)
    known = height[np.isfinite(height) & ~is_none & (height != 0.0)]
    if len(known):
        is_none &= np.abs(height - np.median(known)) > FAR_FROM_OTHERS

    def problem(place):
        return ConsistencyError(
            f"height = {height[place]:g}, as programs write where none is known",
            expected="a height, or an empty cell",
            remedy="Leave the cell empty",
            file=file,
            **tables.row_location(frame, place),
        )

    zeros = np.flatnonzero(height == 0.0)
    notes = []
    if 0 < len(zeros) < len(known) and known.min() > LEAST_ABOVE_0:
        points = name_some(frame["point_id"].iloc[zeros])
        notes.append(
            f"{file}: {len(zeros)} of {len(height)} heights are 0, the others "
            f"{known.min():.0f} to {known.max():.0f} m; leave the cells empty where "
            f"none is known: {points}"
        )
    places = np.flatnonzero(is_none)
    return tables.listed(places, problem, "so it is"), notes


def points_in_no_model(frame, is_lost, measured, given, sources=NO_FILES):
    """Problems of names that look misspelt, and a note that counts the other points.

    If no point at all is measured, names are of another kind: all of them are problems.

    Parameters
    ----------
    frame : DataFrame
        The given points: point_id.
    is_lost : ndarray of bool
        Those that no model holds.
    measured : ndarray
        Names that models hold.
    given : tuple of str
        Section of block.toml, name of the file, and name of the flight.
    sources : dict, optional
        Names of the files of a block, by table.

    Returns
    -------
    tuple of list
        Errors and notes.
    """
    ground, file, flight_name = given
    names, flight = frame["point_id"], flight_name.replace("_", " ")
    files = file, _file_of(flight_name, sources)
    meant = _meant(names, is_lost, measured, files) if is_lost.any() else {}

    def problem(place):
        found = f"no model of the {flight} holds the point"
        other = meant.get(names.iloc[place])
        if other is not None and looks_the_same(names.iloc[place], other):
            here, there = told_apart(names.iloc[place], other)
            found = (
                f"no model of the {flight} holds the point, but '{other}', which looks "
                f"the same: it is '{here}' here and '{there}' there"
            )
        elif other is not None:
            found = f"no model of the {flight} holds the point, but '{other}'"
        return ConsistencyError(
            found,
            expected="every point in at least one model",
            remedy="Correct its name, take the row out, or set "
            f"may_be_unmeasured = true in [{ground}]",
            file=file,
            **tables.row_location(frame, place),
        )

    notes, is_wrong = _lost_zeros(names, measured, file, flight), is_lost
    if not is_lost.all():
        is_wrong = is_lost & names.isin(list(meant)).to_numpy()
        lost = names[is_lost & ~is_wrong]
        if len(lost):
            notes.append(
                f"{file}: {len(lost)} of {len(names)} points lie in no model of the "
                f"{flight} and take no part: {name_some(lost)}"
            )
    rest = f"no model of the {flight} holds the points"
    return tables.listed(np.flatnonzero(is_wrong), problem, rest), notes


def _lost_zeros(names, measured, file, flight):
    """Note names of a workbook that fit, and others of which a number was made too.

    A flight with 1.1 and 1.10, and control 1.1, which the second may be.
    """
    if not is_of_workbook(file):
        return []
    measured, known = [*dict.fromkeys(map(str, measured))], {*names}
    ending = [name for name in measured if number_made_of(name) != name]
    both = known.intersection(measured)
    doubtful = [n for n in ending if n not in known and number_made_of(n) in both]
    if not doubtful:
        return []
    pairs = name_some(f"'{number_made_of(name)}' ('{name}')" for name in doubtful)
    n_points = len({number_made_of(name) for name in doubtful})
    note = (
        f"{file}: {n_points} of {len(names)} points may be others that the {flight} "
        "holds as well, since a spreadsheet makes one number of both names; give names "
        f"the format Text: {pairs}"
    )
    return [note]


def _file_of(name, sources):
    """Name of the file of a table, or of the measured points of a flight."""
    name = name.removeprefix("the ").replace(" ", "_")  # as errors say it
    tables_of = f"{name}.image_points", f"{name}.model_points", name
    return next((sources[one] for one in tables_of if one in sources), "")


def _meant(names, is_lost, measured, files):
    """Measured names without coordinates that given ones may be, a dict."""
    measured = pd.Series(measured)
    others = measured[~is_among(measured, names)]
    meant = names_meant(names[is_lost], names[~is_lost][:MOST_NAMES], others)
    return made_or_typed(names[is_lost], others, files) | meant


@dataclass(frozen=True, eq=False)
class KnownOfModels:
    """How many points of each model are known; arrays of one value for each row.

    ``is_tied``: whether what is known and what other models of the flight hold as well
    would be enough for one adjustment of all models, which needs as many known points
    in all as a model for itself.
    """

    is_known: np.ndarray  # of the point of the row
    is_first: np.ndarray  # row of its model
    number: np.ndarray  # of known points of its model
    least: int  # that the transformation needs
    is_tied: np.ndarray
    n_known: int  # points

    @property
    def is_lacking(self):
        """First rows of the models of which too few points are known."""
        return self.is_first & (self.number < self.least)

    def lack(self, place, ground, kind):
        """Say of the model of a row what it lacks, for an error: a dict.

        ``ground``: from where points are known, ``kind``: of the transformation.
        """
        number, expected = self.number[place], f"at least {self.least} common points"
        # one adjustment takes no approximate coordinates
        is_tied = self.is_tied[place] and ground != "approximate_points"
        remedy = ONE_ADJUSTMENT if is_tied else more_points_for(kind)
        if number == 0 and not is_tied:
            expected, remedy = "common points", NAMES_OF_POINTS
        found = _common_points_text(number, ground.replace("_", " "))
        return {"found": found, "expected": expected, "remedy": remedy}

    def too_few(self, ground, file):
        """Error of a block with fewer known points than a single model needs."""
        points = ground.replace("_", " ")
        return ConsistencyError(
            f"models show {self.n_known} of these {points}",
            expected=f"at least {self.least}",
            remedy=f"Measure more {points} in models, or give more",
            file=file,
        )

    def note_of_tied(self, table, ground, file):
        """Count the models that one adjustment can use, and two steps cannot."""
        models = table["model_id"][self.is_lacking & self.is_tied].astype(str)
        if not len(models):
            return []
        names = name_some(models)
        note = (
            f"{file}: fewer than {self.least} points with coordinates from "
            f"{ground.replace('_', ' ')} in {len(models)} of {self.is_first.sum()} "
            f"models; one adjustment ties these to their neighbours: {names}"
        )
        return [note]


def known_of_models(table, known, least) -> KnownOfModels:
    """Count the known points of models.

    ``table``: coverage, model_id, point_id of a flight; ``known``: names of points.
    """
    is_known = is_among(table["point_id"], known)
    model = row_codes([table[name] for name in ("coverage", "model_id")])
    is_first = ~pd.Series(model).duplicated().to_numpy()
    number = np.bincount(model, weights=is_known)[model].astype(int)
    is_tied = np.zeros(len(table), dtype=bool)
    point = row_codes([table["point_id"]])
    n_known = len(np.unique(point[is_known]))
    if (number < least).any() and n_known >= least:
        is_tie = is_known | (np.bincount(point)[point] > 1)
        is_tied = np.bincount(model, weights=is_tie)[model] >= least
    return KnownOfModels(is_known, is_first, number, least, is_tied, n_known)


def fitted_onto(ground, control):
    """Names of the given points that models are fitted onto: all but check points.

    ``control``: the control points, or None.
    """
    names = ground["point_id"]
    if control is None or "role" not in control:
        return names
    check = control.loc[control["role"] == "check", "point_id"]
    return names[~names.isin(check)]


def nothing_but_check_points(file):
    """Error of given points onto which no model may be fitted."""
    return ConsistencyError(
        "all points are check points, onto which no model is fitted",
        expected="points with role = control as well",
        remedy="Give those that are not kept for the check role = control",
        file=file,
    )


def with_names_alike(problems, table, known, of, sources=NO_FILES):
    """Errors of models that share no name with what is known.

    With a pair of names as remedy, where they are written otherwise there. ``of``: what
    the models and the known points are of, a flight and a table or another flight.
    """
    names, files = table["point_id"], [_file_of(name, sources) for name in of]
    pair = pair_meant(names, known) or pair_made_or_typed(names, known, files)
    if pair is None:
        return problems
    here, there = told_apart(*pair)
    remedy = f"Write '{here}' here as there, where it is '{there}'"
    return [problem.with_facts(remedy=remedy) for problem in problems]


def _common_points_text(number, ground):
    """How many points of a model are known, and from where."""
    if number > 1:
        return f"{number} of its points have coordinates from {ground}"
    if number == 0:
        return f"none of its points has coordinates from {ground}"
    return f"{number} of its points has coordinates from {ground}"


def standard_error_problems(control, file):
    """Standard errors of control that no survey has, and covariances beyond them."""
    columns = [name for name in STANDARD_ERRORS if name in control]
    found = [problem for name in columns for problem in _too_large(control, name, file)]
    return found + _covariance_problems(control, file)


def _too_large(control, column, file):
    values = control[column].to_numpy()

    def problem(place):
        return TableError(
            f"{column} {values[place]:g}",
            expected=f"metres, at most {LARGEST_STANDARD_ERROR_M:g}",
            remedy="Did you give millimetres?",
            file=file,
            **tables.row_location(control, place),
        )

    places = np.flatnonzero(values > LARGEST_STANDARD_ERROR_M)
    return tables.listed(places, problem, "it is too large")


def _covariance_problems(control, file):
    """Covariances of control points beyond the product of their standard errors."""
    columns = [name for name in COVARIANCES if name in control]
    return [problem for name in columns for problem in _beyond(control, name, file)]


def _beyond(control, column, file):
    values = control[column].fillna(0.0).to_numpy(float)
    one, other = (_standard_error(control, axis) for axis in COVARIANCES[column])
    largest = one * other

    def problem(place):
        limit, size = largest[place], abs(values[place])
        remedy = "Delete the column, or give the standard errors of both coordinates"
        if size <= 1.0 and limit > 0.0:
            remedy = "Did you give a correlation? Multiply it by both standard errors"
        elif size * SQUARE_M_PER_SQUARE_MM <= limit:
            remedy = "Did you give square millimetres?"
        return TableError(
            f"{column} {values[place]:g}, with standard errors of {one[place]:g} and "
            f"{other[place]:g} m",
            expected=f"square metres, at most their product, {limit:g}",
            remedy=remedy,
            file=file,
            **tables.row_location(control, place),
        )

    places = np.flatnonzero(np.abs(values) > (1.0 + ROUNDED) * largest)
    return tables.listed(places, problem, "it is too large")


def _standard_error(control, axis):
    """That of the axis, otherwise its part of the total one; 0 where there is none."""
    own = np.zeros(len(control))
    if "standard_error_m" in control:
        own = control["standard_error_m"].fillna(0.0).to_numpy(float) / np.sqrt(2.0)
    given = control.get(f"standard_error_{axis}")
    return (
        own
        if given is None
        else given.fillna(pd.Series(own, given.index)).to_numpy(float)
    )
