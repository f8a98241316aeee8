"""Which table of a block each file is, and what is still to be asked."""

from dataclasses import dataclass, field

from einschalt.foundations.errors import (
    FileError,
    SettingsError,
    name_some,
)
from einschalt.foundations.names import is_among
from einschalt.interfaces.new_block.fitting_tables import (
    require_cameras_of_pixels,
    require_possible_scales,
    require_same_names,
    require_shared_names,
)
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
from einschalt.interfaces.programs.metashape_cameras import no_camera
from einschalt.pipeline.block.facts import FLIGHTS

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
    require_shared_names(ground, flights)
    require_cameras_of_pixels(flights)
    units, scales = {}, {}
    pitch = next((said for (_, key), said in given.items() if key == PITCH), None)
    for tables in flights:
        units[id(tables)], scales[id(tables)] = _sizes(tables, known, pitch)
    require_possible_scales(
        known,
        scales.values(),
        lambda points: [_sizes(tables, points, pitch)[1] for tables in flights],
        has_pixels=any("camera" in tables for tables in flights),
    )
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
    require_same_names(proposal.values, known, named)
    proposal.questions = questions_of(proposal, named)
    return proposal


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
    cameras = [one for one in cameras if not one.unusable] or cameras
    paths = [one.path for one in found]
    alone = [one for one in cameras if paths.count(one.path) == 1]
    cameras = alone or cameras
    if len(cameras) > 1:
        raise SettingsError(
            f"{name_some(one.title for one in cameras)} hold a camera each",
            expected="the camera of the image points",
            remedy="Name that one after --from, and leave the others out",
        )
    if cameras[0].unusable:
        raise no_camera(cameras[0].unusable, cameras[0].title)
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
    return unit, scale_of(table.frame, on_a_plane(known), unit.value, key)


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
