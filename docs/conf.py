"""The site: ``make docs`` builds it, without a network."""

import os
import sys
from pathlib import Path

from pygments.lexers.special import TextLexer

import einschalt

DOCS = Path(__file__).parent
ROOT = DOCS.parent
sys.path.insert(0, str(DOCS / "_ext"))

from recipes import copy_recipes  # noqa: E402 - beside this file

# kernels of the notebooks: nothing of the user's own settings, and no warning that what
# they are told, on this computer, is not encrypted
KERNELS = ROOT / "out" / "ipython"
os.environ["IPYTHONDIR"] = str(KERNELS)
settings_of_kernels = KERNELS / "profile_default" / "ipython_kernel_config.py"
settings_of_kernels.parent.mkdir(parents=True, exist_ok=True)
settings_of_kernels.write_text("c.IPKernelApp.log_level = 'ERROR'\n", "utf-8")

RECIPES = DOCS / "recipes"
copy_recipes(
    ROOT / "pipelines", RECIPES, ROOT / "data_examples", DOCS / "images" / "recipes"
)

project = "einschalt"
author = "the einschalt developers"
project_copyright = f"{author}, BSD-3-Clause"
version = release = einschalt.__version__

extensions = [
    "myst_nb",  # pages in Markdown, tutorials that are computed
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "numpydoc",
    "sphinx_gallery.gen_gallery",
    "sphinx_design",  # cards of the home page
    "sphinx_copybutton",
    "link_texts",  # titles of pages, where sources name their files
    "mathml",  # formulas without scripts
    "generated_reference",  # commands, settings and findings from the program itself
]
exclude_patterns = [
    "_build",
    "recipes",
    "gallery/*.ipynb",
    "gallery/*.py",
    "sg_execution_times.rst",
]
templates_path = ["_templates"]
nitpicky = True  # of public docstrings too: they refer to public names
smartquotes = False  # -- is an option, not a dash
suppress_warnings = [
    "config.cache",  # functions in the configuration of the gallery
]

myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 4
nb_execution_mode = "force"  # what stands on the site is what the program says today
nb_execution_raise_on_error = True
nb_execution_timeout = 300

autosummary_generate = True
autodoc_typehints = "none"  # the docstrings say more
numpydoc_show_class_members = False
numpydoc_xref_param_type = False


sphinx_gallery_conf = {
    "examples_dirs": "recipes",
    "gallery_dirs": "gallery",
    "filename_pattern": r"\.py$",
    "within_subsection_order": "FileNameSortKey",
    "reset_modules": (),
    "image_scrapers": (),
    "capture_repr": (),
    "abort_on_example_error": True,
    "show_memory": False,
    "min_reported_time": 1e9,
    "download_all_examples": False,
    "write_computation_times": False,
    "default_thumb_file": str(DOCS / "images" / "precision_map.png"),
}

html_theme = "furo"  # its fonts are those of the reader's system, nothing is fetched
html_title = f"einschalt {release}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_show_sourcelink = False
html_theme_options = {
    "light_css_variables": {
        "color-brand-primary": "#0b5c6b",
        "color-brand-content": "#0b5c6b",
    },
    "dark_css_variables": {
        "color-brand-primary": "#6cc4d3",
        "color-brand-content": "#6cc4d3",
    },
}
linkcheck_anchors = False


def setup(app):
    """Take tables as they stand: no lexer knows them."""
    for table in ("csv", "xyz"):
        app.add_lexer(table, TextLexer)
