"""Which table of a block each file is, and what is still to be asked."""

from dataclasses import dataclass, field

import numpy as np

from einschalt.foundations.errors import (
    FileError,
    SettingsError,
    TableError,
    name_some,
)
from einschalt.foundations.header_units import METRES_PER_LENGTH
from einschalt.foundations.names import is_among
from einschalt.foundations.near_words import pair_meant, told_apart
from einschalt.interfaces.new_block.guesses import (
    Guess,
    flight_named,
    on_a_plane,
    scale_beside,
    scale_of,
    scale_of_pixels,
    unit_of,
)
from einschalt.interfaces.new_block.looked_at import PITCH
from einschalt.interfaces.new_block.photographs import (
    error_of_control_itself,
    transformation_of,
)
from einschalt.interfaces.new_block.questions import questions_of
from einschalt.pipeline.block.facts import FLIGHTS, RANGES

USUAL_SCALE_NUMBER = 10_000.0
CONTROL_WORDS = ("control", "pass", "paß", "fest", "gcp", "appui", "appoggio")
APPROXIMATE_WORDS = ("approx", "näher", "naeher", "appro")


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
    proposal = Proposal({(name, "file"): one for name, one in ground.items()})
    proposal.left_out = left_out
    _require_shared_names(ground, flights)
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
    proposal.questions = questions_of(proposal, named)
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


def _require_shared_names(ground, flights):
    """Refuse flights of whose points nothing is known, before anything is asked.

    A question for the scale number would have an answer, and the block no point. The
    low flight may have points of the high one alone.
    """
    known, rest = list(ground.values()), [_points_of(tables) for tables in flights]
    rest = [table for table in rest if table is not None]
    while rest:
        joined = [t for t in rest if any(_share_a_name(one, t) for one in known)]
        if not joined:
            raise _nothing_shared(known, rest[0])
        known += joined
        rest = [table for table in rest if table not in joined]


def _require_same_names(proposal, known, named):
    """Refuse names that are written otherwise in two tables, where no scale is found.

    Of three tables one pair may share names, and the third be lost.
    """
    before = [known]
    for name, tables in named.items():
        table = _points_of(tables)
        if table is None:
            continue
        if proposal.values.get((name, "scale_number")) is None:
            for other in before:
                _require_alike(other, table)
        before.append(table)


def _points_of(tables):
    return tables.get("model_points", tables.get("image_points"))


def _share_a_name(one, other):
    return bool(is_among(*map(_point_names, (one, other))).any())


def _point_names(table):
    return table.frame["point_id"].astype(str)


def _nothing_shared(others, table):
    """What is wrong where a table has none of the names of the others."""
    for other in others:
        pair = pair_meant(_point_names(other), _point_names(table).unique())
        if pair is not None:
            return _written_otherwise(other, table, pair)
    one = others[0]
    names, own = (name_some(_point_names(o).unique(), 3) for o in (one, table))
    return TableError(
        f"{table.title} holds none of the points of {one.title}: its points are "
        f"called {own}, those of {one.title} {names}",
        expected="the same point under the same name in both",
        remedy="Rename the points in one of them, or name the files that belong "
        "together after --from",
    )


def _require_alike(one, other):
    if _share_a_name(one, other):
        return
    pair = pair_meant(_point_names(one), _point_names(other).unique())
    if pair is not None:
        raise _written_otherwise(one, other, pair)


def _written_otherwise(one, other, pair):
    written = told_apart(*pair)
    return TableError(
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
            return unit, scale_of_pixels(table, tables["camera"], known, pitch)
    else:
        table, key = tables["model_points"], "model_id"
        unit = unit_of(table.frame)
        if table.unit is not None:
            unit = Guess(table.unit, f"the header of {table.title} says so")
    return unit, scale_of(table.frame, on_a_plane(known.frame), unit.value, key)


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
