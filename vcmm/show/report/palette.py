"""The colours of a report, by role, for a light and a dark screen. One home: Python charts and CSS both read it.

Charts and scenes name a role, which the page paints (`css_variables`): one picture serves both screens, and print.
"""

from __future__ import annotations

from vcmm.core.errors import UsageError, choose_from

LIGHT: dict[str, str] = {
    "page": "#f7f8fa",
    "surface": "#ffffff",
    "ink": "#1c2530",
    "muted": "#566272",
    "faint": "#8b96a5",
    "rule": "#c9d0d9",
    "grid": "#e8ebf0",
    "accent": "#2a63a5",
    "accent-soft": "#c3d6ea",
    "good": "#256b41",
    "good-soft": "#cfe8d8",
    "warning": "#80530a",
    "warning-soft": "#fae3b0",
    "bad": "#ab3227",
    "bad-soft": "#f4cdc7",
    "c1": "#2a63a5",
    "c2": "#c76a1d",
    "c3": "#1d8577",
    "c4": "#81509c",
    "c5": "#8c7a15",
    "c6": "#66707d",
}

DARK: dict[str, str] = {
    "page": "#12161c",
    "surface": "#191e26",
    "ink": "#e6eaf0",
    "muted": "#a3aebc",
    "faint": "#76828f",
    "rule": "#3d4754",
    "grid": "#272e38",
    "accent": "#6fa8e6",
    "accent-soft": "#2c4663",
    "good": "#6cc892",
    "good-soft": "#23503a",
    "warning": "#e3b04b",
    "warning-soft": "#5c4a1c",
    "bad": "#ee8579",
    "bad-soft": "#642f2b",
    "c1": "#6fa8e6",
    "c2": "#eb9a55",
    "c3": "#55bfae",
    "c4": "#bd90d8",
    "c5": "#cdb94c",
    "c6": "#9aa5b3",
}

SERIES = ("c1", "c2", "c3", "c4", "c5", "c6")


def hex_of(colour: str) -> str:
    """Return #rrggbb of a role name or of a literal #rrggbb; raises UsageError for anything else."""
    if colour in LIGHT:
        return LIGHT[colour]
    digits = colour[1:]
    if len(colour) == 7 and colour[0] == "#" and all(c in "0123456789abcdefABCDEF" for c in digits):
        return colour
    raise UsageError(f'Colour "{colour}" is neither #rrggbb nor a role.{choose_from(colour, LIGHT)}')


def rgb_of(colour: str) -> tuple[int, int, int]:
    """Return (red, green, blue), 0 to 255, of a role name or of #rrggbb."""
    text = hex_of(colour)
    return int(text[1:3], 16), int(text[3:5], 16), int(text[5:7], 16)


def css_variables() -> str:
    """Return `:root` rules: light by default and in print, dark where the reader's system asks for it."""
    light = "".join(f"--{role}:{colour};" for role, colour in LIGHT.items())
    dark = "".join(f"--{role}:{colour};" for role, colour in DARK.items())
    return f":root{{{light}}}\n@media screen and (prefers-color-scheme:dark){{:root{{{dark}}}}}\n"
