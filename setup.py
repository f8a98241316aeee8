"""Beside pyproject.toml: example blocks and glossary go into the wheel."""

import shutil
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py

GLOSSARY = Path("docs", "glossary.md")
EXAMPLES = ("neukirchen", "sxb_strasbourg")


class BuildWithExamples(build_py):
    """Copies them beside the modules; a checkout uses them where they are."""

    def run(self):
        """Build, then copy."""
        super().run()
        if self.editable_mode:
            return
        for name in EXAMPLES:
            place = Path(self.build_lib, "einschalt", "data_examples", name)
            shutil.copytree(Path("data_examples", name), place, dirs_exist_ok=True)
        shutil.copy(GLOSSARY, Path(self.build_lib, "einschalt", GLOSSARY.name))


setup(cmdclass={"build_py": BuildWithExamples})
