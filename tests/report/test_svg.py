"""A drawing that stands alone."""

from __future__ import annotations

import xml.etree.ElementTree as ET

from vcmm import report


def test_standalone_svg_has_a_namespace() -> None:
    text = report.standalone(report.bars([("a", 1.0)], unit="µm", title="B"))
    assert ET.fromstring(text).tag == "{http://www.w3.org/2000/svg}svg"
