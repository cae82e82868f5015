"""Cycle times that programs state in their comments beside those of vcmm, as Markdown for docs/timing.md.

python tools/cycle_times.py FOLDER

Machine: X, Y, Z with the typical figures that vcmm takes where a file states none; control: its defaults, tool changes not counted.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from vcmm.core.errors import VcmmError
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.face.cli.nc_folder import programs_in
from vcmm.program.interpret import read_program
from vcmm.program.limits import Control
from vcmm.program.setup import Setup
from vcmm.shop.motion.timing import plan_motion
from vcmm.shop.motion.toolpath import clock, naive_seconds

WORDS = r"(?:machin(?:e|ing)|cycle|run(?:ning)?|cutting|total)?[ \t_]*time"
UNITS = {"h": 3600.0, "m": 60.0, "s": 1.0}
CLOCK = re.compile(rf"(total[^\n]*)?{WORDS}[^\n\d]{{0,12}}(\d+):(\d\d):(\d\d)", re.IGNORECASE)
NUMBER = re.compile(rf"(total[^\n]*)?{WORDS}[^\n\d]{{0,6}}(\d+(?:\.\d+)?)[ \t]*(h(?:ou)?rs?|min(?:ute)?s?|s(?:ec(?:ond)?s?)?)\b", re.IGNORECASE)  # fmt: skip


def stated_seconds(text: str) -> float | None:
    """The time that a program states of itself: its total where it says so, else the first; None without one."""
    found = [(m[1], int(m[2]) * 3600.0 + int(m[3]) * 60.0 + int(m[4])) for m in CLOCK.finditer(text)]
    found += [(m[1], float(m[2]) * UNITS[m[3][0].lower()]) for m in NUMBER.finditer(text)]
    totals = [seconds for total, seconds in found if total]
    return next(iter(totals or [seconds for _, seconds in found]), None)


def row(path: Path, folder: Path) -> str | None:
    """One line of the table; None where the program states no time."""
    text = path.read_text(encoding="utf-8", errors="replace")
    stated = stated_seconds("\n".join(line for line in text.splitlines() if set(line) & set("(;")))
    if stated is None:
        return None
    name = path.relative_to(folder).as_posix()
    try:
        moves = [m for m in read_program(path, None, Setup(strict=False)).moves if m.kind != "dwell"]
        letters = [*"XYZ", *(a for i, a in enumerate("ABC") if any(m.rotary_start[i] or m.rotary_end[i] for m in moves))]  # fmt: skip
        axes = {a: Axis(a, (-1e4, 1e4)) for a in letters}
        chain = " ".join(f"{a}'" for a in letters if a != "Z")
        machine = Machine("mill", "machine-tool", parse_structure(f"w {chain} b Z t"), axes)
        planned = plan_motion(moves, machine, Control(tool_change=0.0))
    except VcmmError as error:
        return f"| {name} | {clock(stated)} | | | {str(error).splitlines()[0][:110]} |"
    cells = f"{clock(naive_seconds(planned))} | {clock(planned.seconds)}"
    return f"| {name} | {clock(stated)} | {cells} | {planned.seconds / stated:.2f} |"


def main(folder: Path) -> None:
    print("| program | it states | length over feed | time law | ratio |\n|---|---|---|---|---|")
    for path in programs_in(folder):
        line = row(path, folder)
        if line is not None:
            print(line, flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
