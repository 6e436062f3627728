"""Sphinx: how the documentation is built. `make docs` builds it; a warning is an error."""

import gc
import sys
from importlib.metadata import version as installed_version
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "_ext"))

gc.set_threshold(100_000, 20, 20)  # nearly all that is made is in use: the usual search took a tenth of the build

project = "subskin"
author = "The subskin developers"
copyright = "2026, the subskin developers"
version = release = installed_version("subskin")

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
    "sphinx_gallery.gen_gallery",
    "cli_help",
    "mathfont",
    "mathml",
    "names",
    "offline",
    "sidebar",
]
html_math_renderer = "mathml"
default_role = "name"

exclude_patterns = [
    "_build",
    "_templates",
    "gallery/*.ipynb",
    "gallery/*.py",
    "**/*.md5",
    "**/sg_execution_times.rst",  # loads scripts from elsewhere
    "sg_execution_times.rst",
]
templates_path = ["_templates"]
myst_enable_extensions = ["dollarmath", "amsmath", "deflist", "colon_fence", "fieldlist"]
myst_heading_anchors = 3
nitpicky = False

autosummary_generate = True
autodoc_default_options = {"members": True, "show-inheritance": True, "member-order": "bysource"}
autodoc_typehints = "none"  # the numpydoc sections say types, shapes and units
napoleon_google_docstring = False
napoleon_numpy_docstring = True
napoleon_use_param = False  # types such as "array_like, shape (n,)" are prose, not names to link
napoleon_use_rtype = False

html_theme = "furo"
html_title = "subskin"
html_static_path = ["_static"]
html_css_files = ["subskin.css"]
html_copy_source = False
html_show_sourcelink = False
pygments_style = "friendly"
pygments_dark_style = "native"

sphinx_gallery_conf = {
    "examples_dirs": "../examples",
    "gallery_dirs": "gallery",
    "filename_pattern": r"/plot_",
    "ignore_pattern": r"/(demo|_)|(^|/)ppo_",
    "within_subsection_order": "FileNameSortKey",
    "download_all_examples": False,
    "remove_config_comments": True,
    "thumbnail_size": (480, 336),
    "show_memory": False,
    "show_signature": False,
    "min_reported_time": 3600,
    "abort_on_example_error": True,
    "image_scrapers": ("figures.scrape",),
    "reset_modules": ("matplotlib",),
}
