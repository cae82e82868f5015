"""plotly.js as text for a page: packed by gzip and base64, read from the installed package, so that a page works offline."""

from __future__ import annotations

import base64
import gzip
from functools import cache
from importlib import resources

from vcmm.core.errors import Environment


@cache
def packed_plotly() -> str:
    """About 2.0 MB. Environment: plotly is not installed as it should be."""
    try:
        source = resources.files("plotly").joinpath("package_data", "plotly.min.js").read_bytes()
    except (ModuleNotFoundError, FileNotFoundError):
        raise Environment("plotly.js is not found: install plotly again (pip install plotly)") from None
    return base64.b64encode(gzip.compress(source, 9, mtime=0)).decode("ascii")
