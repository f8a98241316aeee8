"""What is still to be asked where no file tells it, and what answers tell."""

from dataclasses import dataclass, replace

from einschalt.foundations.errors import name_some
from einschalt.foundations.language import mark_each
from einschalt.interfaces.new_block.guesses import Guess, scale_of_pixels, systems_of
from einschalt.interfaces.new_block.looked_at import PITCH
from einschalt.interfaces.new_block.photographs import error_of_control_itself
from einschalt.pipeline.block.facts import RANGES

GROUND = ("control_points", "approximate_points")
# of sensors the smallest have half a micrometre; of photographs that were reduced in
# size the largest some tenths of a millimetre
PITCHES_UM = (0.2, 1000.0)
LARGEST_CONTROL_ERROR = 10.0  # metres
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


def questions_of(proposal, named):
    """What is still to be asked."""
    questions = []
    known = proposal.tables.get(("control_points", "file"))
    if proposal.values.get(("block", "crs")) is None:
        ground = known or proposal.tables["approximate_points", "file"]
        questions.append(_question_of_system(ground.frame))
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


def expected_instead(key, value) -> str:
    """What is expected in place of the number of a key; empty where it is possible.

    ``value`` None is no number.
    """
    if key in RANGES:
        return "" if value in RANGES[key] else str(RANGES[key])
    if key == PITCH:
        least, most = PITCHES_UM
        is_possible = value is not None and least <= value <= most
        return "" if is_possible else f"{least:g} to {most:g} (micrometres)"
    is_possible = value is not None and 0.0 < value <= LARGEST_CONTROL_ERROR
    return "" if is_possible else "a number above 0, at most 10 metres"


def _question_of_system(frame):
    """Ask for the system of points in metres, or into which degrees are transformed."""
    could = systems_of(frame)
    said = f", such as {name_some(could, 8)}" if could else ""
    if "easting" not in frame:
        text = f"Plane reference system of the block, since these are degrees{said}"
        return Question("block", "crs", "--crs", text)
    system = f"Reference system of the coordinates{said}"
    text = f"{system}; {EMPTY_FOR_LOCAL}"
    return Question("block", "crs", "--crs", text, None, True, WITHOUT_SYSTEM)


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
    return scale_of_pixels(*tables, next(filter(None, grounds)), pitch)
