"""Reading of drawn reports, for the tests of this room."""

from __future__ import annotations

import json
import math
import re
import xml.etree.ElementTree as ET
from typing import Any

NAN = math.nan


def svgs(markup: str) -> list[ET.Element]:
    """Every SVG of the markup as a parsed tree: fails where one is not well-formed."""
    return [ET.fromstring(text) for text in re.findall(r"<svg .*?</svg>", markup, re.S)]


def the_svg(markup: str) -> ET.Element:
    (only,) = svgs(markup)
    return only


def figure_in(markup: str) -> dict[str, Any]:
    """The figure of a scene, as plotly gets it."""
    found = re.search(r"data-scene>(.*?)</script>", markup, re.S)
    assert found
    return dict(json.loads(found.group(1)))


def coordinates(path: ET.Element) -> list[tuple[float, float]]:
    flat = [float(v) for v in re.findall(r"-?\d+\.?\d*", path.get("d") or "")]
    return list(zip(flat[::2], flat[1::2]))


def rects(svg: ET.Element, role: str) -> list[ET.Element]:
    return [r for r in svg.iter("rect") if f"f-{role}" in (r.get("class") or "").split()]


def value(element: ET.Element, name: str) -> float:
    text = element.get(name)
    assert text is not None
    return float(text)
