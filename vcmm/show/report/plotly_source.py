"""plotly.js as text for a page: the bundle for three dimensions, which comes with vcmm, so that a page works offline.

`plotly-gl3d.min.js.xz` is `plotly-gl3d.min.js` of plotly.js 4.1.1, unchanged, packed by xz (npm package plotly.js-gl3d-dist-min; MIT
licence, beside it). It draws meshes, lines, points and cones, which is all that scenes hold, at a third of the whole library.
To renew it: npm pack plotly.js-gl3d-dist-min, xz -9e, then VERSION and SHA256 here.
"""

from __future__ import annotations

import base64
import gzip
import lzma
from functools import cache
from importlib import resources

VERSION = "4.1.1"
SHA256 = "aab04dcd9c103a92b18723f8c837712fe820f325d0bcd2421e415e8124a75b9f"  # of the script, unpacked
FILE = "plotly-gl3d.min.js.xz"


@cache
def packed_plotly() -> str:
    """The script, packed by gzip, which browsers unpack, and in base64: 0.74 MB."""
    script = lzma.decompress(resources.files("vcmm.show.report").joinpath(FILE).read_bytes())
    return base64.b64encode(gzip.compress(script, 9, mtime=0)).decode("ascii")
