"""Which table of a block each file is, and what is still to be asked."""

from dataclasses import dataclass, field, replace

import numpy as np

from einschalt.foundations.errors import (
    FileError,
    SettingsError,
    TableError,
    name_some,
)
from einschalt.foundations.header_units import METRES_PER_LENGTH
from einschalt.foundations.language import mark_each
from einschalt.foundations.names import is_among
from einschalt.foundations.near_words import pair_meant, told_apart
from einschalt.interfaces.new_block.guesses import (
    Guess,
    flight_named,
    on_a_plane,
    scale_beside,
    scale_of,
    systems_of,
    unit_of,
)
from einschalt.interfaces.new_block.looked_at import PITCH
from einschalt.interfaces.new_block.photographs import (
    error_of_control_itself,
    may_stand_in,
    transformation_of,
)
from einschalt.pipeline.block.facts import FLIGHTS, RANGES

USUAL_SCALE_NUMBER = 10_000.0
GROUND = ("control_points", "approximate_points")
CONTROL_WORDS = ("control", "pass", "paß", "fest", "gcp", "appui", "appoggio")
APPROXIMATE_WORDS = ("approx", "näher", "naeher", "appro")
# questions of two parts are told by part, also where several stand in one sentence
EMPTY_FOR_LOCAL = "empty for a local one"
WITHOUT_SYSTEM = (
    "no place on the earth, so no KML, no other system, and no correction for the "
    "Earth's curvature"
)
CONTROL_ERROR = "TOTAL standard error of the control points [m]"
EMPTY_IF_UNKNOWN = "empty if unknown"
SCALE_QUESTIONS = mark_each(
    {
        "high_flight": "Image scale number of the high flight",
        "low_flight": "Image scale number of the low flight",
    }
)
M_G_QUESTIONS = mark_each(
    {
        "high_flight": "TOTAL error of one setting of a point in the image [um] of the "
        "high flight",
        "low_flight": "TOTAL error of one setting of a point in the image [um] of the "
        "low flight",
    }
)
DISTANCE_QUESTIONS = mark_each(
    {
        "high_flight": "Principal distance [mm] of the high flight",
        "low_flight": "Principal distance [mm] of the low flight",
    }
)
PITCH_QUESTIONS = mark_each(
    {
        "high_flight": "Size of a pixel [um] of the high flight",
        "low_flight": "Size of a pixel [um] of the low flight",
    }
)
M_G_UM = {"high_flight": 7.5, "low_flight": 5.0}  # Kovarik's, of one machine setting


@dataclass(frozen=True)
class Question:
    """What no file tells."""

    section: str
    key: str
    option: str  # of the command line
    text: str
    suggested: object = None  # taken with --yes; None: there is nothing to suggest
    may_be_left_out: bool = False
    without: str = ""  # what there is not where it is left out

    @property
    def has_suggestion(self):
        """Whether it can be answered without the user."""
        return self.suggested is not None or self.may_be_left_out


@dataclass(eq=False)
class Proposal:
    """A block as far as the files tell it."""

    tables: dict  # section and key: the table
    values: dict = field(default_factory=dict)  # section and key: Guess
    questions: list = field(default_factory=list)
    left_out: list = field(default_factory=list)  # tables, and why


def propose(found, given) -> Proposal:
    """Propose a block of the tables that were found.

    ``given``: values by section and key that the user has said. A SettingsError or
    FileError where the tables make no block.
    """
    ground, left_out = _ground_tables([one for one in found if one.kind == "ground"])
    known = ground.get("control_points", ground.get("approximate_points"))
    flights = _flights(found)
    _require_places(flights, ground)
    proposal = Proposal({(name, "file"): one for name, one in ground.items()})
    proposal.left_out = left_out
    units, scales = {}, {}
    pitch = next((said for (_, key), said in given.items() if key == PITCH), None)
    for tables in flights:
        units[id(tables)], scales[id(tables)] = _sizes(tables, known, pitch)
    has_pixels = any("camera" in tables for tables in flights)
    _require_metres(known, scales.values(), has_pixels=has_pixels)
    named = _named(flights, scales)
    for name, tables in named.items():
        proposal.tables |= {(name, key): one for key, one in tables.items()}
        if "model_points" in tables:
            proposal.values[name, "model_unit"] = units[id(tables)]
        proposal.values[name, "scale_number"] = scales[id(tables)]
    _scale_beside(proposal)
    if not ("high_flight" in named or "approximate_points" in ground):
        proposal.tables["approximate_points", "file"] = known
    in_space = transformation_of(ground, flights)
    if in_space is not None:
        proposal.values |= {(name, "transformation"): in_space for name in named}
    if known.crs and "longitude" not in known.frame:
        proposal.values["block", "crs"] = Guess(known.crs, f"{known.title} says so")
    for place, value in given.items():
        proposal.values[place] = Guess(value, "as you say")
    proposal.values |= error_of_control_itself(proposal.tables, proposal.values)
    _require_same_names(proposal, known, named)
    proposal.questions = _questions(proposal, named)
    return proposal


def _require_metres(known, scales, *, has_pixels):
    """Refuse control points against which no flight has a possible scale.

    A power of ten that makes all scales possible is the unit that they have.
    """
    numbers = np.array([scale.value for scale in scales if scale is not None])
    if not len(numbers) or _are_possible(numbers).any():
        return
    could = {u: numbers * metres for u, metres in METRES_PER_LENGTH.items()}
    could = {unit: ones for unit, ones in could.items() if _are_possible(ones).all()}
    if not could:
        return
    unit = min(could, key=lambda u: abs(np.log(could[u].mean() / USUAL_SCALE_NUMBER)))
    shown = ", ".join(f"1:{number:g}" for number in numbers)
    if has_pixels:
        raise TableError(
            f"the photographs have scales of {shown} against these points",
            expected=f"scale numbers of {RANGES['scale_number']}",
            remedy="Correct the size of the pixels, or give the points in metres",
            file=known.title,
        )
    raise TableError(
        f"the models have scales of {shown} against these points, as if their "
        f"coordinates were in {unit}",
        expected="coordinates in metres, or a unit behind the names of their columns",
        remedy=f"Write the unit behind the names, as in 'easting [{unit}]', or give "
        "metres; state the unit of model coordinates likewise if that is wrong",
        file=known.title,
    )


def _are_possible(numbers):
    possible = RANGES["scale_number"]
    return (numbers >= possible.low) & (numbers <= possible.high)


def _require_same_names(proposal, known, named):
    """Refuse names that are written otherwise in two tables, where no scale is found.

    A question for the scale number would have an answer, and the block no point.
    """
    before = [known]
    for name, tables in named.items():
        table = tables.get("model_points", tables.get("image_points"))
        if table is None:
            continue
        if proposal.values.get((name, "scale_number")) is None:
            for other in before:
                _require_alike(other, table)
        before.append(table)


def _require_alike(one, other):
    names, others = (o.frame["point_id"].astype(str) for o in (one, other))
    if is_among(names, others).any():
        return
    pair = pair_meant(names, others.unique())
    if pair is not None:
        written = told_apart(*pair)
        raise TableError(
            f"{one.title} has '{written[0]}', {other.title} has '{written[1]}', and "
            "they share no name",
            expected="the same names in both",
            remedy="Write them alike, or export one of the files anew",
        )


def _ground_tables(found):
    """Control and approximate points, and what is left out."""
    if not found:
        raise SettingsError(
            "no file holds control points",
            expected="a table of point_id, easting, northing, or points of a layer",
            remedy="Name it after --from",
        )
    approximate = [one for one in found if _says(one, APPROXIMATE_WORDS)]
    rest = [one for one in found if one not in approximate]
    control = rest if len(rest) == 1 else [o for o in rest if _says(o, CONTROL_WORDS)]
    control = control or [one for one in rest if "role" in one.frame]
    if len(control) > 1 or len(approximate) > 1 or (rest and not control):
        titles = name_some(one.title for one in (control or rest))
        raise SettingsError(
            f"{titles} could all be the control points",
            expected="one table of control, and one of approximate points",
            remedy="Name one of them after --from, a sheet or layer as FILE:NAME, and "
            "leave the others out",
        )
    tables = {"control_points": control, "approximate_points": approximate}
    left_out = [one for one in rest if one not in control]
    return {name: ones[0] for name, ones in tables.items() if ones}, left_out


def _says(table, words):
    return any(word in table.title.casefold() for word in words)


def _flights(found):
    """Tables that belong together, one dict for each flight."""
    of_kind = {}
    for one in found:
        of_kind.setdefault(one.kind, []).append(one)
    flights = [{"model_points": one} for one in of_kind.get("model_points", [])]
    flights += [{"image_points": one} for one in of_kind.get("image_points", [])]
    for kind in ("y_parallaxes", "base"):
        machines = [one for one in flights if "model_points" in one]
        for one in of_kind.get(kind, []):
            _join(machines, "model_points", "model_id", one, kind)
    images = [one for one in flights if "image_points" in one]
    for one in of_kind.get("models", []):
        _join(images, "image_points", "image_id", one, "models", "left_image")
    if images and "camera" in of_kind:
        camera = _camera_of(of_kind["camera"], found)
        for flight in images:
            flight["camera"] = camera
    if not flights or len(flights) > 2:
        raise SettingsError(
            "no files hold measurements of a flight"
            if not flights
            else f"{len(flights)} files hold measurements of a flight",
            expected="one or two: the high flight and the low flight",
            remedy="Name after --from the model points, or the image points and models",
        )
    return flights


def _require_places(flights, ground):
    """Refuse a block in which nothing would tell where points lie."""
    if len(flights) > 1 or "approximate_points" in ground:
        return
    if not may_stand_in(ground, flights):
        raise SettingsError(
            f"{next(iter(flights[0].values())).title} holds the only flight",
            expected="a high flight beside it, or approximate points",
            remedy="Name the other flight after --from, or a table of approximate "
            "points with a name such as approximate_points.csv",
        )


def _camera_of(cameras, found):
    """The camera of the flights: that of a file of its own goes before others.

    Projects hold the camera with which they began, and export the adjusted one alone.
    """
    paths = [one.path for one in found]
    alone = [one for one in cameras if paths.count(one.path) == 1]
    cameras = alone or cameras
    if len(cameras) > 1:
        raise SettingsError(
            f"{name_some(one.title for one in cameras)} hold a camera each",
            expected="the camera of the image points",
            remedy="Name that one after --from, and leave the others out",
        )
    if cameras[0].camera is None:
        raise FileError(
            "holds several cameras",
            expected="one camera",
            remedy="Write them with einschalt convert, and name one camera.toml",
            file=cameras[0].title,
        )
    return cameras[0]


def _join(flights, key, name, table, kind, own=None):
    """Put a table to the flight with which it shares most names."""
    names = table.frame[own or name]
    shares = [is_among(names, flight[key].frame[name]).mean() for flight in flights]
    if not shares or max(shares) == 0.0:
        raise FileError(
            f"shares no {name} with a flight",
            expected=f"names of the {key.replace('_', ' ')}",
            remedy="Name the flight after --from as well, or leave the file out",
            file=table.title,
        )
    best = [f for f, s in zip(flights, shares, strict=True) if s == max(shares)]
    free = [flight for flight in best if kind not in flight]
    by_name = [f for f in free if _flight_of(f) == flight_named(table.title)]
    (by_name or free or best)[0][kind] = table


def _flight_of(tables):
    for one in tables.values():
        if flight_named(one.title):
            return flight_named(one.title)
    return None


def _sizes(tables, known, pitch):
    """Unit and scale number of a flight, guesses both; a scale may be None.

    ``pitch``: size of a pixel as the user says it [µm], or None.
    """
    if "image_points" in tables:
        unit = Guess("mm", "image coordinates")
        table, key = tables["image_points"], "image_id"
        if "camera" in tables:
            return unit, _scale_of_pixels(table, tables["camera"], known, pitch)
    else:
        table, key = tables["model_points"], "model_id"
        unit = unit_of(table.frame)
        if table.unit is not None:
            unit = Guess(table.unit, f"the header of {table.title} says so")
    return unit, scale_of(table.frame, on_a_plane(known.frame), unit.value, key)


def _scale_of_pixels(table, camera, known, pitch):
    """Scale number of image points in pixels; None where their size is unknown."""
    pitch = camera.camera.get(PITCH, pitch)
    if not isinstance(pitch, (int, float)) or not pitch > 0.0:
        return None
    frame = table.frame.assign(x=table.frame["x"] * pitch, y=table.frame["y"] * pitch)
    return scale_of(frame, on_a_plane(known.frame), "um", "image_id")


def _named(flights, scales):
    """Flights by name: what their files say, then the scales."""
    if len(flights) == 1:
        return {"low_flight": flights[0]}
    by_file = [_flight_of(tables) for tables in flights]
    if sorted(map(str, by_file)) == sorted(FLIGHTS):
        return dict(sorted(zip(by_file, flights, strict=True)))
    numbers = [scales[id(tables)] for tables in flights]
    if None not in numbers and numbers[0].value != numbers[1].value:
        high = int(numbers[1].value > numbers[0].value)
        return {"high_flight": flights[high], "low_flight": flights[1 - high]}
    raise SettingsError(
        "nothing tells which of the two flights is the high one",
        expected="names of files with high and low (hoch and tief), or two scales",
        remedy="Rename one of the files",
    )


def _scale_beside(proposal):
    """Scale of the low flight by the high one, where control does not give it."""
    low, high = (proposal.tables.get((name, "model_points")) for name in FLIGHTS[::-1])
    known = proposal.values.get(("high_flight", "scale_number"))
    lacks = proposal.values.get(("low_flight", "scale_number")) is None
    if lacks and low is not None and high is not None and known is not None:
        units = [proposal.values[name, "model_unit"].value for name in FLIGHTS[::-1]]
        scale = scale_beside(low.frame, units[0], high.frame, units[1], known.value)
        proposal.values["low_flight", "scale_number"] = scale


def _questions(proposal, named):
    """What is still to be asked."""
    questions = []
    known = proposal.tables.get(("control_points", "file"))
    if proposal.values.get(("block", "crs")) is None:
        could = systems_of(known.frame) if "easting" in known.frame else []
        said = f", such as {name_some(could, 8)}" if could else ""
        system = f"Reference system of the coordinates{said}"
        text = f"{system}; {EMPTY_FOR_LOCAL}"
        without = WITHOUT_SYSTEM
        crs = Question("block", "crs", "--crs", text, None, True, without)
        questions.append(crs)
    error = "control_points", "standard_error_m"
    has_errors = known is None or {error[1], "standard_error_easting"} & {*known.frame}
    if not has_errors and error not in proposal.values:
        text = f"{CONTROL_ERROR}; {EMPTY_IF_UNKNOWN}"
        option = "--control-error-m"
        without = "no errors are propagated, and no ellipses drawn"
        questions.append(Question(*error, option, text, None, True, without))
    known_values = {place for place, said in proposal.values.items() if said}
    for name, tables in named.items():
        word = name.partition("_")[0]
        asked = {"m_g_um": (f"--{word}-m-g-um", M_G_QUESTIONS[name], M_G_UM[name])}
        if "image_points" in tables and "camera" not in tables:
            text = DISTANCE_QUESTIONS[name]
            asked["principal_distance_mm"] = ("--principal-distance-mm", text, None)
        if "camera" in tables and tables["camera"].lacks_pitch:
            asked[PITCH] = ("--pixel-size-um", PITCH_QUESTIONS[name], None)
        asked = {key: q for key, q in asked.items() if (name, key) not in known_values}
        questions += [Question(name, key, *said) for key, said in asked.items()]
        # the size of a pixel tells the scale
        if PITCH not in asked and proposal.values.get((name, "scale_number")) is None:
            questions.append(_question_of_scale(name))
    return questions


def _question_of_scale(name):
    option = f"--{name.partition('_')[0]}-scale"
    return Question(name, "scale_number", option, SCALE_QUESTIONS[name])


def answered(proposal, question, value, reason):
    """The proposal with the answer to a question; None leaves the key out."""
    guess = None if value is None else Guess(value, reason)
    values = proposal.values | {(question.section, question.key): guess}
    values |= error_of_control_itself(proposal.tables, values)
    rest = [one for one in proposal.questions if one is not question]
    if question.key == PITCH:
        scale = _scale_by_pitch(proposal, question.section, value)
        values[question.section, "scale_number"] = scale
        rest += [] if scale else [_question_of_scale(question.section)]
    return replace(proposal, values=values, questions=rest)


def _scale_by_pitch(proposal, section, pitch):
    """Scale number that the size of a pixel gives, or the user; None if none does."""
    said = proposal.values.get((section, "scale_number"))
    if said is not None:
        return said
    tables = [proposal.tables[section, key] for key in ("image_points", "camera")]
    grounds = [proposal.tables.get((name, "file")) for name in GROUND]
    return _scale_of_pixels(*tables, next(filter(None, grounds)), pitch)
