"""Triangles as JSON of PROJ's ``tinshift``: format "triangulation_file", version 1.0.

Both ways are in one file. Coordinates are easting, northing, written with all digits:
what is read is what was computed. Source: PROJ, data/triangulation.schema.json.
"""

import json

import numpy as np

from einschalt.foundations.display_names import as_unicode
from einschalt.interfaces.files.atomic import write_text

VERTICES = ["source_x", "source_y", "target_x", "target_y"]
TRIANGLES = ["idx_vertex1", "idx_vertex2", "idx_vertex3"]


def tinshift_step(path):
    """PROJ's step for a file of triangles."""
    text = str(path)
    # spaces part the words of a PROJ string
    return (
        f'+proj=tinshift +file="{text}"'
        if " " in text
        else (f"+proj=tinshift +file={text}")
    )


def write_tinshift(path, net, *, name, description, systems):
    """Write a TriangleNet; ``systems``: what names the one it leads from, and to."""
    used = net.used
    place = np.zeros(len(net.source), dtype=np.int64)
    place[used] = np.arange(len(used))
    source, target = systems
    content = {
        "file_type": "triangulation_file",
        "format_version": "1.0",
        "name": name,
        "description": description,
        "input_crs": source,
        "output_crs": target,
        "transformed_components": ["horizontal"],
        "vertices_columns": VERTICES,
        "triangles_columns": TRIANGLES,
    }
    head = json.dumps(content, indent=1, ensure_ascii=False)[:-2]
    vertices = np.column_stack([net.source[used], net.target[used]]).tolist()
    triangles = place[net.corners].tolist()
    # a line for each, so that two publications can be compared
    rows = ",\n".join(map(json.dumps, vertices)), ",\n".join(map(json.dumps, triangles))
    text = (
        f'{head},\n "vertices": [\n{rows[0]}\n ],\n "triangles": [\n{rows[1]}\n ]\n}}\n'
    )
    write_text(path, as_unicode(text))
