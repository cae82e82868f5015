"""An interactive picture of the path of a program: by tool, feed or error, with the line under the pointer and a slider along it."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from vcmm.show.report.colormap import bands, legend
from vcmm.show.report.page import asset
from vcmm.show.report.text import escape

VIEWS = {"top": "XY", "front": "XZ", "side": "YZ", "lathe": "ZX", "space": "in space"}


@dataclass(frozen=True)
class PathPicture:
    """n pieces between n + 1 points, mm. line, tool, feed (mm/min, None: not known), rapid: of each piece; text: of the lines, those that
    do not move too.

    error: of each piece, um (None: not known), or nothing. name: of this path where there are several.
    """

    points: Sequence[tuple[float, float, float]]
    line: Sequence[int]
    tool: Sequence[int]
    feed: Sequence[float | None]
    rapid: Sequence[bool]
    text: Mapping[int, str]
    view: str = "space"
    error: Sequence[float | None] = ()
    name: str = ""


LISTING = (
    '<div data-scale="tool" class="tools" hidden></div><div class="listing"><input type="search" aria-label="search the program" '
    'placeholder="search the program"><ol tabindex="0" aria-label="program; arrow keys go from move to move"></ol></div>'
)


def path_picture(*paths: PathPicture, caption: str = "") -> str:
    """Return one block of HTML with its data and its script. Several paths, such as before and after compensation, share view, slider and colours."""
    feeds = [f for p in paths for f in p.feed if f is not None]
    errors = [e for p in paths for e in p.error if e is not None]
    scales = {"error": ("µm", errors), "feed": ("mm/min", feeds)}
    data = {"view": paths[0].view, "text": {k: v for p in paths for k, v in p.text.items()}}
    shown, legends = [], []
    for kind, (unit, values) in scales.items():
        if values:
            scale = bands(np.array([0.0, *values] if kind == "error" else values))
            data[kind] = {"levels": scale.levels.tolist(), "colours": list(scale.colours)}
            shown.append(kind)
            legends.append(f'<div data-scale="{kind}" hidden>{legend(scale, unit, 260)}</div>')
    data["paths"] = [_columns(p) for p in paths]
    inside = json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    buttons = " ".join(
        f'<button type="button" value="{k}">{escape(name)}</button>' for k, name in VIEWS.items()
    )
    n = max(len(p.line) for p in paths)
    small = f"<figcaption>{escape(caption)}</figcaption>" if caption else ""
    return (
        f'<figure class="figure" data-path>{small}<p>{_choice("colour", [*shown, "tool"])}{_choice("program", [p.name for p in paths])}{buttons}</p>'
        f'<div class="row path"><canvas role="img" aria-label="path of the program"></canvas>{"".join(legends)}{LISTING}</div>'
        f'<input type="range" aria-label="along the program" min="0" max="{n}" value="{n}">'
        f'<output></output><script type="application/json">{inside}</script><script>\n{asset("path.js")}</script></figure>'
    )


def _choice(name: str, options: Sequence[str]) -> str:
    """Return a field to choose from; nothing where there is no choice."""
    if len(options) < 2:
        return ""
    inside = "".join(
        f'<option value="{k if name == "program" else escape(o)}">{escape(o)}</option>'
        for k, o in enumerate(options)
    )
    return f'<label>{name} <select name="{name}">{inside}</select></label> '


def _columns(path: PathPicture) -> dict[str, object]:
    x, y, z = ([round(p[i], 4) for p in path.points] for i in range(3))
    return {
        "x": x, "y": y, "z": z, "line": [*path.line], "tool": [*path.tool], "feed": [*path.feed],
        "rapid": [int(r) for r in path.rapid], "error": [None if e is None else round(e, 3) for e in path.error],
    }  # fmt: skip
