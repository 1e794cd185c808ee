"""Settings of the site: `sphinx-build -W docs site` builds it, offline.

It is built from the pages here; `public_names` writes a page for each public name from its
docstring, `write_pages` the pages that come from data. Notebooks and the scripts of the gallery are
executed; `check_links` looks at every link of what was built, and `for_index` makes those of the
README addresses for the package index. Tests run what pages show, and check what notebooks name.
"""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))  # For the extensions that lie beside this file.

import cardan_dyn as cd  # noqa: E402

project = "cardan_dyn"
author = "the cardan_dyn authors"
copyright = author  # noqa: A001
version = release = cd.__version__

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "sphinx_gallery.gen_gallery",
    "gallery_figures",
    "public_names",
    "mathml",
]
# The list of names for readers of the repository; the site has one with links.
exclude_patterns = [
    "_build",
    "interface.md",
    "gallery",
    "examples/**/*.ipynb",
    # It shows results of one's own benchmarks.
    "notebooks/run_time_against_error.ipynb",
    "**.ipynb_checkpoints",
]
myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

# The notebooks stand at the top of the repository, and Sphinx reads what is beside this file.
shutil.rmtree(HERE / "notebooks", ignore_errors=True)
shutil.copytree(HERE.parent / "notebooks", HERE / "notebooks")
nb_execution_mode = "auto"  # The notebooks are kept without outputs.
nb_execution_raise_on_error = True
nb_execution_timeout = 120
nb_execution_show_tb = True
nb_output_stderr = "warn"  # Nothing may complain.
os.environ["CARDAN_DYN_PROGRESS"] = "0"
# Nor do kernels obey the profile of whoever builds the site, or warn of listeners on this machine.
_ipython = tempfile.TemporaryDirectory()
_profile = Path(_ipython.name) / "profile_default"
_profile.mkdir()
(_profile / "ipython_kernel_config.py").write_text("c.IPKernelApp.log_level = 40\n", "utf-8")
os.environ["IPYTHONDIR"] = _ipython.name

autodoc_member_order = "bysource"
autodoc_typehints = "none"  # Docstrings say shapes, units and frames; signatures stay readable.
napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_use_ivar = True
napoleon_custom_sections = ["Source"]

sphinx_gallery_conf = {
    "examples_dirs": "gallery",
    "gallery_dirs": "examples",
    "filename_pattern": r"\.py$",
    "image_scrapers": ("gallery_figures",),
    "capture_repr": (),
    "abort_on_example_error": True,
    "write_computation_times": False,
    "min_reported_time": 3600,
    "show_memory": False,
    "download_all_examples": False,
    "show_signature": False,
    "remove_config_comments": True,
}

html_math_renderer = "mathml"
html_theme = "pydata_sphinx_theme"
html_title = "cardan_dyn"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_context = {"default_mode": "auto"}  # Light or dark as the reader's system is.
# Pages that stand alone have no section to navigate in.
html_sidebars = {name: [] for name in ("first_mechanism", "questions", "changelog", "roadmap")}
html_theme_options = {
    "show_toc_level": 2,
    "navigation_with_keys": True,
    "show_prev_next": True,
    "footer_start": ["copyright"],
    "footer_end": [],
}
html_show_sourcelink = False
# One-letter attributes of the literature, which several classes have.
suppress_warnings = ["ref.python"]
