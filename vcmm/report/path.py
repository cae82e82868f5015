"""The path of a program as a picture that can be followed: by tool, with line and feed under the pointer and a slider along it."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from vcmm.report.page import asset
from vcmm.report.text import escape

VIEWS = {"top": "XY", "front": "XZ", "side": "YZ", "lathe": "ZX", "space": "in space"}


@dataclass(frozen=True)
class PathPicture:
    """n pieces between n + 1 points, mm. line, tool, feed (mm/min, None: not known), rapid: of each piece; text: of the lines."""

    points: Sequence[tuple[float, float, float]]
    line: Sequence[int]
    tool: Sequence[int]
    feed: Sequence[float | None]
    rapid: Sequence[bool]
    text: Mapping[int, str]
    view: str = "space"


def path_picture(path: PathPicture) -> str:
    """One block of HTML with its data and its script."""
    columns = zip(*((round(p[0], 4), round(p[1], 4), round(p[2], 4)) for p in path.points))
    x, y, z = ([*c] for c in columns)
    data = {
        "x": x, "y": y, "z": z, "line": [*path.line], "tool": [*path.tool], "feed": [*path.feed],
        "rapid": [int(r) for r in path.rapid], "text": path.text, "view": path.view,
    }  # fmt: skip
    inside = json.dumps(data, separators=(",", ":")).replace("<", "\\u003c")
    buttons = " ".join(
        f'<button type="button" value="{k}">{escape(name)}</button>' for k, name in VIEWS.items()
    )
    n = len(path.line)
    return (
        f'<figure data-path><p>{buttons}</p><canvas style="width:100%;height:60vh;border:1px solid #8886"></canvas>'
        f'<input type="range" aria-label="along the program" min="0" max="{n}" value="{n}" style="width:100%">'
        '<output style="display:block;min-height:2.5em;font-family:monospace"></output>'
        f'<script type="application/json">{inside}</script><script>\n{asset("path.js")}</script></figure>'
    )
