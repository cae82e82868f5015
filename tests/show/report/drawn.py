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
