"""The three pictures of README, drawn from results; what they show stands in the files, so that a test can compute it again.

    python tools/readme_pictures.py            draws docs/images/measured.png, machined.png and diagnosed.png

tests/delivery/test_readme.py computes the numbers again and holds them against those in the files.
"""

from __future__ import annotations

import json
import struct
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import vcmm

FOLDER = Path(__file__).resolve().parents[1] / "docs" / "images"
KEY = "vcmm"  # of the text chunk that holds the numbers
TRIALS = 20_000
CUT_TRIALS = 2000


def _main_lines(budget: Any) -> Any:
    """Lines of more than one percent."""
    return type(budget)(line for line in budget if line.share >= 0.01)


def measured() -> tuple[Any, dict[str, Any]]:
    """The plate: where its bore will be found, and where U comes from."""
    result = vcmm.uncertainty(vcmm.example("plate"), trials=TRIALS)
    c = result["bore to front"]
    numbers = {
        "name": c.name, "value_mm": c.value, "U_mm": c.expanded, "interval_mm": list(c.interval),
        "budget": {line.input: line.share for line in c.budget if line.share >= 0.01},
    }  # fmt: skip

    def draw(left: Any, right: Any) -> None:
        c.plot(left)
        _main_lines(c.budget).plot(right, f"{c.name}: shares of u²")

    return draw, numbers


def machined() -> tuple[Any, dict[str, Any]]:
    """The turned shaft: what is expected of every size, with U, before it is turned."""
    result = vcmm.cut(vcmm.example("turned_shaft"), trials=CUT_TRIALS)
    sizes = [c for c in result.characteristics if c.tolerance is not None and c.type == "size"]
    numbers = {
        "sizes": {
            c.name: {"deviation_um": 1e3 * (c.value - c.nominal), "U_um": 1e3 * c.expanded, "decision": c.decision.text}
            for c in sizes
            if c.decision
        }
    }  # fmt: skip

    def draw(left: Any, right: Any) -> None:
        at = range(len(sizes))
        for i, c in zip(at, sizes):
            assert c.tolerance is not None
            low, high = (1e3 * (end - c.nominal) for end in c.tolerance)
            left.barh(i, high - low, left=low, height=0.55, color="0.88")
        left.errorbar(
            [1e3 * (c.value - c.nominal) for c in sizes],
            list(at),
            xerr=[1e3 * c.expanded for c in sizes],
            fmt="o",
            capsize=4,
        )
        left.set_yticks(list(at), [c.name for c in sizes])
        left.invert_yaxis()
        left.use_sticky_edges = False
        left.margins(x=0.05)
        left.spines[["top", "right"]].set_visible(False)
        left.set_xlabel("deviation from nominal / µm (grey: tolerance)")
        left.set_title("before it is cut: value ± U")
        c = sizes[0]
        _main_lines(c.budget).plot(right, f"{c.name}: shares of u²")

    return draw, numbers


def diagnosed() -> tuple[Any, dict[str, Any]]:
    """The ball bar log that comes with vcmm: residuals, and what explains them."""
    file = vcmm.example("ballbar")
    recording = vcmm.load_recording(file)[0]
    found = vcmm.diagnose(file)
    numbers = {
        "verdict": found.verdict,
        "probability": {f"{a.effect} {' '.join(map(str, a.where.values()))}".strip(): a.probability for a in found.answer},
        "rms_before_um": 1e3 * found.fit.before, "rms_after_um": 1e3 * found.fit.after,
    }  # fmt: skip

    def draw(left: Any, right: Any) -> None:
        recording.plot(left)
        found.plot(right)

    return draw, numbers


PICTURES: dict[str, Callable[[], tuple[Any, dict[str, Any]]]] = {
    "measured": measured,
    "machined": machined,
    "diagnosed": diagnosed,
}


def write_picture(name: str, folder: Path = FOLDER) -> Path:
    """Draw one picture with its numbers beside the pixels. Returns the file."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    draw, numbers = PICTURES[name]()
    figure, axes = plt.subplots(1, 2, figsize=(11.0, 3.6), layout="constrained")
    draw(*axes)
    target = folder / f"{name}.png"
    figure.savefig(target, dpi=110, metadata={"Software": None, KEY: json.dumps(numbers)})
    plt.close(figure)
    return target


def numbers_in(file: Path) -> dict[str, Any]:
    """The numbers of a picture, from its text chunk (PNG specification, 11.3.4). ValueError: it holds none."""
    data = file.read_bytes()
    at = 8
    while at < len(data):
        (length,) = struct.unpack(">I", data[at : at + 4])
        kind, body = data[at + 4 : at + 8], data[at + 8 : at + 8 + length]
        word, _, text = body.partition(b"\0")
        if kind in (b"tEXt", b"iTXt") and word == KEY.encode():
            found: dict[str, Any] = json.loads(text.lstrip(b"\0").decode("utf-8"))
            return found
        at += 12 + length
    raise ValueError(f"{file} holds no numbers; draw it by tools/readme_pictures.py")


if __name__ == "__main__":
    for picture in sys.argv[1:] or PICTURES:
        print(f"wrote {write_picture(picture)}", file=sys.stderr)
