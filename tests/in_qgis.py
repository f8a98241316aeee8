"""Scripts in the Python of QGIS, which is none of ours: Debian's python3-qgis."""

import json
import shutil
import subprocess

import pytest

START = """
import json, os, sys
from qgis.core import *
QgsApplication.setPrefixPath("/usr", True)
application = QgsApplication([], False)
application.initQgis()
"""
# QGIS takes its libraries down in an order of its own
END = """
print(json.dumps(said), flush=True)
os._exit(0)
"""


def said_by_qgis(script, folder, *arguments):
    """What a script leaves in ``said``; the test is skipped where there is no QGIS."""
    python = shutil.which("python3", path="/usr/bin")
    found = python and subprocess.run(
        [python, "-c", "import qgis.core"], capture_output=True, check=False
    )
    if not found or found.returncode:
        pytest.skip("no QGIS for /usr/bin/python3 (Debian: python3-qgis)")
    own = {"PATH": "/usr/bin:/bin", "HOME": str(folder), "LANG": "C.UTF-8"}
    own |= {"QT_QPA_PLATFORM": "offscreen", "XDG_RUNTIME_DIR": str(folder)}
    shown = subprocess.run(
        [python, "-c", f"{START}{script}{END}", *arguments],
        env=own,
        capture_output=True,
        text=True,
        check=False,
    )
    assert shown.returncode == 0, shown.stderr
    return json.loads(shown.stdout.splitlines()[-1])
