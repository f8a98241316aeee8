"""One start of ``einschalt serve``: its key, what it may see, and what it leaves.

It leaves the results that were asked for, and nothing else: what was dropped lies in a
folder of its own that goes with it.
"""

import os
import re
import secrets
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import urlencode

from einschalt.foundations.display_names import printable
from einschalt.interfaces.batch.block_task import inputs_of
from einschalt.interfaces.files.atomic import SESSION, hidden_name, remove_leftovers
from einschalt.interfaces.files.block_toml import BLOCK_FILE
from einschalt.interfaces.local_page.dropped_files import BYTES_PER_MB, Drops
from einschalt.interfaces.local_page.rooted_paths import Root, kind_of
from einschalt.interfaces.local_page.runs import Runs

MOST_UPLOAD_MB = 1000.0
RESULTS = "results"


class Session:
    """What all pages share."""

    def __init__(self, folder, *, most_upload_mb=MOST_UPLOAD_MB):
        self.root = Root(folder)
        self.key = secrets.token_urlsafe(24)
        temporary = Path(tempfile.gettempdir())
        remove_leftovers(temporary)  # of sessions that were killed
        self.folder = temporary / hidden_name(SESSION)
        self.folder.mkdir(mode=0o700)
        self.drops = Drops(self.folder, most_upload_mb * BYTES_PER_MB)
        self.runs = Runs()

    def place(self, asked):
        """Folder that a page names: ``path`` in the root, or in ``drop``."""
        drop, path = asked.get("drop", ""), asked.get("path", "")
        root = self.drops.get(drop).root if drop else self.root
        return Place(root, root.folder(path), drop)

    def close(self):
        """End the runs, and remove what was dropped."""
        self.runs.end()
        shutil.rmtree(self.folder, ignore_errors=True)


@dataclass(frozen=True)
class Place:
    """A folder, and how pages name it."""

    root: Root
    folder: Path
    drop: str = ""

    @property
    def query(self):
        """What stands after the ? of an address."""
        asked = {"drop": self.drop, "path": self.root.name(self.folder)}
        return urlencode({name: value for name, value in asked.items() if value})

    @property
    def fields(self):
        """The same, as hidden fields of a form."""
        return {"drop": self.drop, "path": self.root.name(self.folder)}

    @property
    def title(self):
        """Name of the folder."""
        return printable(self.folder.name)

    @property
    def kind(self):
        """Whether it holds a block, a result or neither."""
        return kind_of(self.folder)

    def require_own_files(self):
        """Refuse a block that names files out of the root, by path or by a link."""
        self.root.require_inside(self.folder / BLOCK_FILE)
        for path in inputs_of(self.folder, {})[0].values():
            if os.path.lexists(path):
                self.root.require_inside(path)

    def usual_output(self, title=""):
        """Where results are put unless another folder is named, from the root.

        Those of dropped files are named after the block, ``title``.
        """
        if self.drop:
            plain = re.sub(r"\W+", "_", title).strip("_")
            return f"{plain}_{RESULTS}" if plain else RESULTS
        name = self.root.name(self.folder)
        return f"{name}_{RESULTS}" if name else RESULTS
