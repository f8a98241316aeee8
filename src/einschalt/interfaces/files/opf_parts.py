"""Which files a project of the Open Photogrammetry Format (``.opf``) consists of.

The project is a list of items, whose files it names by relative URIs. Files that lie
outside of its folder are none of its own: a block must not open what a file from
elsewhere points at.
"""

from pathlib import Path
from urllib.parse import unquote, urlsplit

from einschalt.interfaces.files.json_text import parsed_json

SUFFIX = ".opf"
PROJECT = "application/opf-project+json"
CAMERA_LIST = "application/opf-camera-list+json"
INPUT_CAMERAS = "application/opf-input-cameras+json"
CALIBRATED_CAMERAS = "application/opf-calibrated-cameras+json"
CONTROL = "application/opf-input-control-points+json"
FRAME = "application/opf-scene-reference-frame+json"
READ = (CAMERA_LIST, INPUT_CAMERAS, CALIBRATED_CAMERAS, CONTROL, FRAME)


def parts_of(project, folder):
    """Files of a project that are read here: paths by format, in their order.

    ``project``: its JSON as it was parsed. A ValueError with the reason where a file is
    none of its own; KeyError, TypeError or AttributeError where it is no project.
    """
    found = {kind: [] for kind in READ}
    for item in project["items"]:
        for resource in item["resources"]:
            if resource["format"] in found:
                found[resource["format"]].append(_own(resource["uri"], Path(folder)))
    return found


def files_beside(path):
    """Files of a project that are there; what is wrong with it, its reader says."""
    path = Path(path)
    try:
        given = parsed_json(path.read_bytes()) if path.is_file() else {}
        found = [one for ones in parts_of(given, path.parent).values() for one in ones]
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return []
    return [one for one in dict.fromkeys(found) if one.is_file()]


def _own(uri, folder):
    """Path of a file in the folder of its project, which a URI names."""
    where = urlsplit(uri)
    parts = Path(unquote(where.path))
    path = folder / parts
    is_named = bool(where.path) and "\0" not in str(parts)
    if where.scheme or where.netloc or not is_named or parts.is_absolute():
        raise ValueError(f"{uri!r} is no file of its folder")
    if not path.resolve().is_relative_to(folder.resolve()):
        raise ValueError(f"{uri!r} lies outside of its folder")
    return path
