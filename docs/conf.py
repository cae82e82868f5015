"""Sphinx settings; `make docs` builds docs/_build/html. generate.py writes what comes from code anew: effects, reference, lessons.

The lessons are run by MyST-NB; what they printed and drew is kept in docs/_build/.jupyter_cache until a lesson changes.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

import generate  # noqa: E402  - lies beside this file

import vcmm  # noqa: E402

generate.write_all(HERE)
os.environ["PYTHONPATH"] = os.pathsep.join(
    filter(None, [str(HERE.parent), os.environ.get("PYTHONPATH")])
)  # of the kernels

project = "vcmm"
author = "the vcmm authors"
release = version = vcmm.__version__
extensions = ["myst_nb"]
myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3
suppress_warnings = [
    "myst.xref_missing"
]  # links that leave docs/ (to tests, README) are checked by tests/test_docs.py
exclude_patterns = ["_build"]  # gallery.md is made by make_gallery.py and kept
nb_execution_mode = "cache"
nb_execution_in_temp = True  # lessons write files
nb_execution_timeout = 600
nb_execution_raise_on_error = True
nb_merge_streams = True
html_theme = "furo"
html_title = "vcmm"
