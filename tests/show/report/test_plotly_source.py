"""The script of scenes is the published one, unchanged, and knows every kind of trace that scenes are made of."""

from __future__ import annotations

import base64
import gzip
import hashlib
import re
from importlib import resources
from pathlib import Path

from vcmm.show.report.page import SHA256, VERSION, packed_plotly, page

ROOT = Path(__file__).resolve().parents[3]


def script() -> str:
    return gzip.decompress(base64.b64decode(packed_plotly())).decode("utf-8")


def test_it_is_the_published_script():
    assert hashlib.sha256(script().encode()).hexdigest() == SHA256
    assert f"plotly.js (gl3d - minified) v{VERSION}" in script()[:200]


def test_its_licence_lies_beside_it():
    text = resources.files("vcmm.show.report").joinpath("plotly-gl3d.LICENSE").read_text(encoding="utf-8")
    assert text.startswith("MIT License")


def test_it_knows_every_kind_of_trace_that_scenes_hold():
    source = (ROOT / "vcmm/show/report/scene_traces.py").read_text(encoding="utf-8")
    kinds = set(re.findall(r'"type": "(\w+)"', source))
    assert kinds >= {"mesh3d", "scatter3d", "cone"}
    known = script()
    assert not [kind for kind in kinds if f'name: "{kind}"' not in known and f'name:"{kind}"' not in known]


def test_only_pages_with_a_scene_carry_it():
    assert len(page("t", ["<p>no scene</p>"])) < 100_000
    assert packed_plotly() in page("t", ['<figure data-scene="x"></figure>'])
    assert len(packed_plotly()) < 800_000
