"""The gallery: every picture taken out of the report that its command writes. One picture, one command, one notebook each.

python docs/make_gallery.py [NAME ...]     writes docs/gallery.md and docs/gallery/NAME.svg with the numbers of each in NAME.json

The pictures are those of the reports, unchanged; the numbers are what the picture carries as data.
"""

from __future__ import annotations

import html
import json
import re
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import chdir
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vcmm.face.cli import run
from vcmm.show.report.palette import css_variables

HERE = Path(__file__).resolve().parent
FIGURE = re.compile(
    r'<figure class="figure" data-chart="([^"]*)"><figcaption>(.*?)</figcaption><div class="picture">(<svg.*?</svg>)',
    re.S,
)
HEAD = """# Gallery

Pictures of the trade, as the reports hold them: in a page each carries its numbers as data (`data-chart`), and tests compare these with the
table beside it. `python docs/make_gallery.py` takes each out of the report that its command writes. `vcmm new plate`, `ballbar`, `traced_cmm` and `worn_cmm`
write the files that the commands name; `axis.toml` is in `docs/gallery/`.
"""


@dataclass(frozen=True)
class Picture:
    """name of the file; command without "vcmm"; the report it writes; which of its charts: kind, and number among those; a notebook."""

    name: str
    title: str
    command: str
    report: str
    chart: str
    number: int
    notebook: str
    words: str


PLATE = "uncertainty plate.toml --trials 20000 --out plate"
BALLBAR = "diagnose ballbar.toml --out ballbar-report"
PLACE = "place plate.toml --evaluations 300 --scan 256 --trials 5000 --out placed"
THERMAL = "calibrate thermal traced_cmm/warm_up.toml --machine traced_cmm/machine.toml --report thermal.html"
CALIBRATE = "calibrate traced_cmm.toml --machine traced_cmm/machine.toml --report calibrated.html"
SCENES = (  # drawn by pyvista, no charts of a page: file, command, title, words, notebook
    ("scene.png", "view plate.toml --close --png scene.png", "Touches in space", "The part with every touch and its standard uncertainty, magnified as the picture says.", "01_first_uncertainty"),
    ("slices.png", "view worn_cmm/machine.toml --look slices --png slices.png", "Slices through a volume", "The size of the tip error on three planes through the middle of the travels.", "06_calibrating"),
    ("hull.png", "view worn_cmm/machine.toml --look hull --png hull.png", "A volume as it is bent", "The sides of the travels with their tip errors, magnified as the picture says.", "06_calibrating"),
)  # fmt: skip
PICTURES = (
    Picture("decision", "Decision of ISO 14253-1", PLATE, "plate/report.html", "decision", 0, "01_first_uncertainty", "The result with its interval among conformance, uncertainty and non-conformance zone."),
    Picture("waterfall", "How u grows", PLATE, "plate/report.html", "waterfall", 0, "02_reading_a_budget", "Contributions added in quadrature, the largest first; the last bar is u of the table."),
    Picture("distribution", "What the trials gave", PLATE, "plate/report.html", "distribution", 0, "02_reading_a_budget", "Histogram with the coverage interval of GUM Supplement 1."),
    Picture("labels", "Results on the part", PLATE, "plate/report.html", "callouts", 0, "01_first_uncertainty", "Deviation from nominal with U and decision, a leader line to the feature; a distance is joined as by a dimension."),
    Picture("placed", "Where the part may lie", PLACE, "placed/report.html", "map", 0, "04_placing_a_part", "The objective over two freedoms of the pose, with the pose found."),
    Picture("calibrated", "An error as it was found", CALIBRATE, "calibrated.html", "curve", 0, "06_calibrating", "A component error over its axis, with its band."),
    Picture("warm", "Temperatures of a warm-up", THERMAL, "thermal.html", "curve", 0, "06_calibrating", "What the sensors of a machine read while it warms up."),
    Picture("drift", "Drift over time, before and after", THERMAL, "thermal.html", "curve", 1, "06_calibrating", "Readings over the time of a warm-up, and what the thermal terms leave of them."),
    Picture("positioning", "ISO 230-2 band chart", "test axis.toml --iso 230-2 --report axis/report.html", "axis/report.html", "positioning", 0, "06_calibrating", "Means of both directions, mean ± 2 s, and what A and E span."),
    Picture("ballbar", "Trace of a ball bar", "test ballbar.toml --iso 230-4 --report circle/report.html", "circle/report.html", "trace", 0, "07_diagnosing_a_real_log", "Both senses of rotation about the centre of their common least-squares circle."),
    Picture("before", "A diagnosis, before", BALLBAR, "ballbar-report/report.html", "trace", 0, "07_diagnosing_a_real_log", "What the machine file leaves of the trace."),
    Picture("after", "The same, after", BALLBAR, "ballbar-report/report.html", "trace", 1, "07_diagnosing_a_real_log", "What the machine file leaves that the diagnosis wrote, on the same scale."),
    Picture("boxes", "The covariate that named it", BALLBAR, "ballbar-report/report.html", "boxes", 0, "07_diagnosing_a_real_log", "Half the gap on either side of zero before, nothing after."),
)  # fmt: skip


def figures(page: str) -> Iterator[tuple[dict[str, Any], str, str]]:
    """(numbers, title, svg) of every chart of a report that carries its numbers."""
    for data, caption, svg in FIGURE.findall(page):
        yield json.loads(html.unescape(data)), caption, svg


def standing_alone(svg: str) -> str:
    """The chart of a page as a file: its colours, light or dark as the reader's screen, and a ground."""
    style = css_variables() + "svg{background:var(--surface);font-family:system-ui,sans-serif}"
    return svg.replace("<svg ", '<svg xmlns="http://www.w3.org/2000/svg" ', 1).replace("><title>", f"><style>{style}</style><title>", 1) + "\n"  # fmt: skip


def take(picture: Picture, folder: Path, done: set[str]) -> tuple[dict[str, Any], str]:
    """(numbers, svg) of a picture, its command run in a folder unless it is among those done."""
    if picture.command not in done:
        with chdir(folder):
            code = run(picture.command.split())
        if code not in (0, 1):
            raise SystemExit(f"vcmm {picture.command} ended with {code}")
        done.add(picture.command)
    page = (folder / picture.report).read_text(encoding="utf-8")
    mine = [(numbers, svg) for numbers, _, svg in figures(page) if numbers["chart"] == picture.chart]
    return mine[picture.number]


def lay_out(folder: Path) -> None:
    """The files that the commands name."""
    with chdir(folder):
        for name in ("plate", "ballbar", "traced_cmm", "worn_cmm"):
            if run(["new", name]) != 0:
                raise SystemExit(f"vcmm new {name} failed")
    for name in ("axis.toml", "axis.csv", "machine.toml"):
        (folder / name).write_bytes((HERE / "gallery" / name).read_bytes())


def page() -> str:
    """docs/gallery.md"""
    parts = [HEAD]
    for p in PICTURES:
        parts.append(
            f"## {p.title}\n\n{p.words}\n\n![{p.title}](gallery/{p.name}.svg)\n\n```text\nvcmm {p.command}\n```\n\n"
            f"Notebook: `notebooks/{p.notebook}.py` · numbers: `docs/gallery/{p.name}.json`\n"
        )
    for name, command, title, words, notebook in SCENES:
        parts.append(
            f"## {title}\n\n{words}\n\n![{title}](gallery/{name})\n\n```text\nvcmm {command}\n```\n\nNotebook: `notebooks/{notebook}.py`\n"
        )
    return "\n".join(parts)


def main(names: Sequence[str]) -> None:
    chosen = [p for p in PICTURES if not names or p.name in names]
    done: set[str] = set()
    with tempfile.TemporaryDirectory(prefix="gallery-") as folder:
        lay_out(Path(folder))
        for name, command, *_ in SCENES:
            if not names or name.removesuffix(".png") in names:
                with chdir(folder):
                    run(command.split())
                (HERE / "gallery" / name).write_bytes((Path(folder) / name).read_bytes())
        for picture in chosen:
            numbers, svg = take(picture, Path(folder), done)
            (HERE / "gallery" / f"{picture.name}.svg").write_text(standing_alone(svg), encoding="utf-8")
            text = json.dumps(numbers, indent=1, ensure_ascii=False, sort_keys=True)
            (HERE / "gallery" / f"{picture.name}.json").write_text(text + "\n", encoding="utf-8")
    (HERE / "gallery.md").write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
