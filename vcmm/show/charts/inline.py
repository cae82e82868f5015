"""A picture as SVG inside a page: without scripts and addresses, repainted by the page for a dark screen, small."""

from __future__ import annotations

import io
import json
import math
import re
import zlib
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from vcmm.show.charts.canvas import INCH, ChartSheet
from vcmm.show.report.palette import LIGHT
from vcmm.show.report.text import escape

if TYPE_CHECKING:
    from matplotlib.axes import Axes

HINT = "hint: "  # begins the id of what says something under the pointer
LARGEST = 1.1  # of its own size: a chart is not blown up beyond
DOTS = 144  # per inch, of maps
_ROLE = {colour: role for role, colour in reversed(LIGHT.items())} | {"#000000": "ink"}
_NUMBERS = re.compile(r' (?:d|x|y|width|height|transform|points)="[^"]*"')
_FRACTION = re.compile(r"-?\d*\.\d{3,}(?:e-?\d+)?")


def on_page(chart: Callable[..., Axes], *args: Any, **options: Any) -> str:
    """Return the <figure> of a chart: `on_page(curve, series, x_label=...)`; `ax` is a ChartSheet, or the default of the chart.

    Its title goes above it as text, the lines after the first small.
    """
    ax: Any = chart(*args, **({"ax": ChartSheet()} | options))
    title, _, more = ax.get_title(loc="left").replace(r"\$", "$").partition("\n")
    ax.set_title("", loc="left")
    below = f'<span class="caption">{escape(more)}</span>' if more else ""
    head = f"<figcaption>{escape(title)}{below}</figcaption>"
    data = _data(getattr(ax, "vcmm_numbers", None))
    return f'<figure class="figure"{data}>{head}<div class="picture">{svg(ax.figure, title)}</div></figure>'


def _data(numbers: dict[str, Any] | None) -> str:
    """Return the numbers of the chart as the attribute `data-chart`: JSON; null in place of numbers that are not finite."""
    if numbers is None:
        return ""
    return f' data-chart="{escape(json.dumps(_plain(numbers), separators=(",", ":"), ensure_ascii=False))}"'


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, str) or value is None:
        return value
    if hasattr(value, "__iter__"):
        return [_plain(v) for v in value]
    return float(value) if math.isfinite(value) else None


def svg(figure: Any, title: str) -> str:
    """Return the whole figure as one <svg>: letters as text in the font of the page, colours by role (`--ink` and so on)."""
    from matplotlib import rc_context
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    out = io.StringIO()
    for drawn in figure.axes:
        drawn.patch.set_facecolor("none")
    canvas = FigureCanvasSVG(figure)
    _lay_out(figure, canvas.fixed_dpi)
    with rc_context({"svg.fonttype": "none", "svg.hashsalt": "vcmm"}):
        canvas.print_figure(out, format="svg", facecolor="none", dpi=DOTS, metadata={"Date": None})
    return _within_a_page(out.getvalue(), title, INCH * figure.get_figwidth(), INCH * figure.get_figheight())


def _lay_out(figure: Any, dpi: int) -> None:
    """Lay out a figure as print_figure does by drawing it once without output, at the dots per inch of an SVG."""
    engine = figure.get_layout_engine()
    if engine is None:
        return
    screen_dpi = figure.dpi
    figure.dpi = dpi
    engine.execute(figure)
    figure.set_layout_engine("none")
    figure.dpi = screen_dpi


def _within_a_page(text: str, title: str, width: float, height: float) -> str:
    mark = f"c{zlib.crc32(text.encode() + title.encode()):08x}"
    box = re.search(r'viewBox="[^"]*"', text)
    body = text[text.index("</metadata>") + len("</metadata>") : text.rindex("</svg>")]
    body = re.sub(r"<style.*?</style>", "", body, count=1, flags=re.S)  # would rule the whole page
    body = re.sub(rf"<g id=([\"']){HINT}(.*?)\1>", lambda m: f"<g><title>{m[2]}</title>", body)
    body = re.sub(r'<g id="[^"]*"', "<g", body)
    body = re.sub(r'(id="|href="#|url\(#)([mph][0-9a-f]{8,})', rf"\g<1>{mark}\2", body).replace(
        "xlink:href", "href"
    )
    body = _NUMBERS.sub(lambda m: _FRACTION.sub(_short, m[0]).replace("\n", ""), body)
    body = re.sub(r' transform="rotate\(-?0 [^"]*\)"', "", body)
    body = re.sub(r"font-family: [^;\"]*;? ?", "", body)
    body = re.sub(
        r"(#[0-9a-f]{6})\b(?=[^<>]*>)", lambda m: f"var(--{_ROLE[m[1]]})" if m[1] in _ROLE else m[1], body
    )
    body = re.sub(r">\s+<", "><", body).strip()
    head = (
        f'<svg class="chart" {box[0] if box else ""} width="{width:.0f}" height="{height:.0f}" role="img" '
        f'aria-label="{escape(title)}" style="max-width:{LARGEST * width:.0f}px"><title>{escape(title)}</title>'
    )
    return f"{head}{body}</svg>"


def _short(match: re.Match[str]) -> str:
    return f"{float(match[0]):.2f}".rstrip("0").rstrip(".")
