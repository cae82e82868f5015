"""Sphinx settings; `make docs` builds docs/_build/html. docs/effects.md is written anew by generate.py."""

from __future__ import annotations

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

import generate  # noqa: E402  - lies beside this file

import vcmm  # noqa: E402

generate.write(HERE / "effects.md")

project = "vcmm"
author = "the vcmm authors"
release = version = vcmm.__version__
extensions = ["myst_parser"]
myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3
suppress_warnings = [
    "myst.xref_missing"
]  # links that leave docs/ (to tests, README) are checked by tests/test_docs.py
exclude_patterns = ["_build"]
html_theme = "furo"
html_title = "vcmm"
