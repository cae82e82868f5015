"""Small pieces of SVG as strings. Coordinates are pixels, y downwards, rounded to 0.01 px.

No namespace is written: inside HTML none is needed, and the page then holds no address at all.
`standalone` adds it for a file of its own.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from vcmm.report.palette import LIGHT, hex_of
from vcmm.report.text import escape, text_width

FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif"
SIZE = 12.5  # font size of chart text, px
HALF, FULL = 500, 1010  # chart widths, px: two beside each other in `page.columns`, one across the page


def px(value: float, decimals: int = 2) -> str:
    """A coordinate without idle zeros. A number that is not finite is a bug of the caller."""
    if not math.isfinite(value):
        raise ValueError("a coordinate of a chart is not finite")
    text = f"{value:.{decimals}f}".rstrip("0").rstrip(".") if decimals else f"{value:.0f}"
    return "0" if text == "-0" else text


def points(xy: Iterable[Sequence[float]], close: bool = False, decimals: int = 2) -> str:
    """Path data of a polyline through points (x, y)."""
    return "M" + "L".join(f"{px(x, decimals)} {px(y, decimals)}" for x, y in xy) + ("Z" if close else "")


def paint(fill: str = "", stroke: str = "", width: float = 0.0, dash: str = "", opacity: float = 1.0) -> str:
    """Attributes that paint by role (or by #rrggbb): light colour as attribute, role as class."""
    classes = [f"{k}-{role}" for k, role in (("f", fill), ("s", stroke)) if role in LIGHT]
    out = [f'class="{" ".join(classes)}"'] if classes else []
    out.append(f'fill="{hex_of(fill) if fill else "none"}"')
    if stroke:
        out.append(f'stroke="{hex_of(stroke)}" stroke-width="{px(width or 1)}"')
    if dash:
        out.append(f'stroke-dasharray="{dash}"')
    if opacity != 1.0:
        out.append(f'opacity="{px(opacity)}"')
    return " ".join(out)


def tooltip(text: str) -> str:
    """Inner <title>: shown on hover, read aloud."""
    return f"<title>{escape(text)}</title>" if text else ""


def line(x1: float, y1: float, x2: float, y2: float, how: str) -> str:
    """A straight line."""
    return f'<line x1="{px(x1)}" y1="{px(y1)}" x2="{px(x2)}" y2="{px(y2)}" {how}/>'


def rect(x: float, y: float, width: float, height: float, how: str, hint: str = "", radius: float = 0) -> str:
    """A rectangle; `hint` is shown on hover."""
    corner = f' rx="{px(radius)}"' if radius else ""
    return (
        f'<rect x="{px(x)}" y="{px(y)}" width="{px(width)}" height="{px(height)}"{corner} {how}>'
        f"{tooltip(hint)}</rect>"
    )


def circle(x: float, y: float, radius: float, how: str, hint: str = "") -> str:
    """A circle; `hint` is shown on hover."""
    return f'<circle cx="{px(x)}" cy="{px(y)}" r="{px(radius)}" {how}>{tooltip(hint)}</circle>'


def path(data: str, how: str, hint: str = "") -> str:
    """A path; `hint` is shown on hover."""
    return f'<path d="{data}" {how}>{tooltip(hint)}</path>'


def text(
    x: float,
    y: float,
    words: str,
    role: str = "ink",
    anchor: str = "start",
    size: float = SIZE,
    bold: bool = False,
    halo: bool = False,
) -> str:
    """One line of text on the baseline y; anchor start, middle or end. A halo keeps it readable over lines."""
    weight = ' font-weight="600"' if bold else ""
    look = (
        paint(role, "surface", 4.0) + ' paint-order="stroke" stroke-linejoin="round"' if halo else paint(role)
    )
    return (
        f'<text x="{px(x)}" y="{px(y)}" text-anchor="{anchor}" font-size="{px(size)}"{weight} {look}>'
        f"{escape(words)}</text>"
    )


def legend(entries: Sequence[tuple[str, str]], left: float, top: float, width: float) -> tuple[str, float]:
    """Keys (svg of a 16 x 10 px swatch, name) flowing into rows; returns the SVG and the height used."""
    out, x, y, row = [], left, top, 20.0
    for swatch, name in entries:
        need = 22 + text_width(name, SIZE) + 16
        if x > left and x + need > left + width:
            x, y = left, y + row
        out.append(
            f'<g transform="translate({px(x)} {px(y)})">{swatch}</g>{text(x + 22, y + 10, name, "muted")}'
        )
        x += need
    return "".join(out), (y - top + row if entries else 0.0)


def document(width: float, height: float, body: str, title: str) -> str:
    """A whole <svg>, scaled to the column but never enlarged beyond 1.1 times."""
    return (
        f'<svg viewBox="0 0 {px(width)} {px(height)}" width="{px(width)}" height="{px(height)}" role="img" '
        f'aria-label="{escape(title)}" font-family="{FONT}" style="max-width:{px(1.1 * width)}px">'
        f"<title>{escape(title)}</title>{body}</svg>"
    )


def figure(svg: str, title: str, caption: str = "", extra: str = "") -> str:
    """<figure> with the title above the picture and a muted line below the title."""
    small = f'<span class="caption">{escape(caption)}</span>' if caption else ""
    head = f"<figcaption>{escape(title)}{small}</figcaption>" if title or caption else ""
    return f'<figure class="figure">{head}<div class="picture">{svg}</div>{extra}</figure>'


def standalone(markup: str) -> str:
    """The first <svg> of `markup` as the text of an .svg file (adds the namespace)."""
    start, end = markup.index("<svg "), markup.index("</svg>") + len("</svg>")
    return f'<svg xmlns="http://www.w3.org/2000/svg" {markup[start + 5 : end]}'
