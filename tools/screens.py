"""The first screen of every kind of page, as a picture: docs/images/screens/NAME.png, 1280 x 800 pixels, looked at by people.

    python tools/screens.py [NAME ...]      needs chromium (or CHROMIUM=path) and vcmm[browser]

Each page is written by the command beside it, in a folder of its own; narrow ones are also taken at 390 pixels (NAME-390.png).
"""

from __future__ import annotations

import io
import os
import shutil
import sys
import tempfile
from contextlib import chdir
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vcmm.face.cli import run

FOLDER = Path(__file__).resolve().parents[1] / "docs" / "images" / "screens"
GALLERY = FOLDER.parents[1] / "gallery"
PROGRAMS = ("chromium", "chromium-browser", "google-chrome")
FLAGS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"]
COLOURS = 96  # of a picture: screens are mostly flat


@dataclass(frozen=True)
class Screen:
    """name of the file; command without "vcmm" and the page it writes; at: a part of the page instead of its first screen; narrow: at 390 too."""

    name: str
    command: str
    page: str
    at: str = ""
    narrow: bool = False


PLATE = "uncertainty plate.toml --trials 20000 --out plate"
CUT = "cut measured_block.toml --trials 1000 --out cut"
SCREENS = (
    Screen("uncertainty", PLATE, "plate/report.html", narrow=True),
    Screen("labels", PLATE, "plate/report.html", at="figure[data-chart*=callouts]"),
    Screen("evaluate", "evaluate plate.toml --values values.csv --trials 20000 --out evaluated", "evaluated/report.html", narrow=True),
    Screen("sheet", "evaluate plate.toml --values values.csv --trials 20000 --out evaluated", "evaluated/sheet.html"),
    Screen("place", "place plate.toml --evaluations 300 --scan 256 --trials 5000 --out placed", "placed/report.html", narrow=True),
    Screen("diagnose", "diagnose ballbar.toml --out diagnosed", "diagnosed/report.html", narrow=True),
    Screen("acceptance", "test axis.toml --iso 230-2 --report axis/report.html", "axis/report.html"),
    Screen("calibrate", "calibrate traced_cmm.toml --machine traced_cmm/machine.toml --report calibrated.html", "calibrated.html", narrow=True),
    Screen("thermal", "calibrate thermal traced_cmm/warm_up.toml --machine traced_cmm/machine.toml --report thermal.html", "thermal.html"),
    Screen("field", "field plate.toml --out field", "field/field.html"),
    Screen("compare", "compare ballbar.toml --machine diagnosed/machine.toml --out compared", "compared/report.html"),
    Screen("cut", CUT, "cut/report.html", narrow=True),
    Screen("path", CUT, "cut/report.html", at="[data-path]"),
    Screen("nc", "nc measured_block/part.nc --setup measured_block/setup.toml --plot --out nc", "nc/part.html"),
    Screen("compensate", "compensate measured_block.toml --plot --out new.nc", "new.html"),
)  # fmt: skip


def lay_out(folder: Path) -> None:
    """The files that the commands name."""
    with chdir(folder):
        for name in ("plate", "ballbar", "measured_block", "traced_cmm"):
            run(["new", name])
    for name in ("axis.toml", "axis.csv", "machine.toml"):
        (folder / name).write_bytes((GALLERY / name).read_bytes())
    (folder / "values.csv").write_text(
        "characteristic,value_mm\nbore diameter,30.0042\nbore to front,40.0011\nbore square to top,0.0016\n"
    )


def words_of(command: str) -> list[str]:
    import shlex

    return shlex.split(command)


def take(browser: Any, page: Path, at: str, width: int) -> bytes:
    """A picture of the first screen, or of one part of the page."""
    opened = browser.new_page(viewport={"width": width, "height": 800})
    opened.goto(page.as_uri())
    opened.wait_for_timeout(700)
    if at:
        part = opened.locator(at).first
        part.scroll_into_view_if_needed()
        opened.wait_for_timeout(1500)
        shot = part.screenshot()
    else:
        shot = opened.screenshot()
    opened.close()
    return bytes(shot)


def save(shot: bytes, name: str) -> None:
    """With few colours, so that it is small."""
    from PIL import Image

    picture = Image.open(io.BytesIO(shot)).convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
    picture.save(FOLDER / f"{name}.png", optimize=True)
    print(f"{name}.png {(FOLDER / f'{name}.png').stat().st_size // 1000} kB", file=sys.stderr)


def main(names: list[str]) -> None:
    from playwright.sync_api import sync_playwright

    FOLDER.mkdir(parents=True, exist_ok=True)
    program = os.environ.get("CHROMIUM") or next(filter(None, map(shutil.which, PROGRAMS)))
    done: set[str] = set()
    with tempfile.TemporaryDirectory(prefix="screens-") as where, sync_playwright() as playing:
        folder = Path(where)
        lay_out(folder)
        browser = playing.chromium.launch(executable_path=program, args=FLAGS)
        for screen in [s for s in SCREENS if not names or s.name in names]:
            if screen.command not in done:
                with chdir(folder):
                    code = run(words_of(screen.command))
                if code not in (0, 1):
                    raise SystemExit(f"vcmm {screen.command} ended with {code}")
                done.add(screen.command)
            save(take(browser, folder / screen.page, screen.at, 1280), screen.name)
            if screen.narrow:
                save(take(browser, folder / screen.page, screen.at, 390), f"{screen.name}-390")
        browser.close()


if __name__ == "__main__":
    main(sys.argv[1:])
