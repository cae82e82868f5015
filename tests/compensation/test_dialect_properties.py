"""Sinumerik and Klartext programs at random: within tolerance and rounding, and every block means what it meant.

Also: writing a program out does not change what the machine cuts.
"""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.compensation.mill import SETUP, rough, run
from vcmm.program.interpret import interpret

quick = settings(
    max_examples=20, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow]
)
number = st.integers(-1400, 1400).map(lambda n: n / 10)
radius = st.integers(5, 400).map(lambda n: n / 10)
FRAMES = ["", "TRANS X10 Y-5 Z3", "ROT Z30", "MIRROR X0", "ATRANS X5"]
CYCLES = [
    "", "CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X+10\n", "CYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 ROT+30\n",
    "CYCL DEF 8.0 MIRROR\nCYCL DEF 8.1 X\n",
]  # fmt: skip


@st.composite
def siemens(draw: st.DrawFn) -> str:
    """Lines in both measures, arcs in their forms, frames."""
    lines = ["G54 G90 G17", draw(st.sampled_from(FRAMES)), "G0 X0 Y0 Z20", "G1 Z0 F500"]
    for k in range(draw(st.integers(1, 7))):
        x, y, r, sense = draw(number), draw(number), draw(radius), draw(st.sampled_from(["G2", "G3"]))
        lines += draw(
            st.sampled_from(
                [
                    [f"N{k} G1 X{x} Y={y} ; line {k}"],
                    [f"G1 X=IC({x / 20:.3f}) Y=AC({y})"],
                    ["G1 X0 Y0", f"{sense} X{r} Y{-r} CR={1.2 * r:.3f}"],
                    ["G1 X0 Y0", f"{sense} X{r} Y{-r} CR={-1.2 * r:.3f}"],
                    [f"{sense} I{r} J0"],
                    ["G1 X5 Y5", f"{sense} I=AC({r + 6}) J=AC(5) AR=100"],
                    ["G1 X0 Y0", f"{sense} X{r} Y{r} AR=70"],
                    ["G91", f"G1 X{x / 50:.3f} Y{y / 50:.3f}", "G90"],
                    ["G1 X0 Y0", f"X{r + 3} RND=1", f"Y{r + 3}"],
                ]
            )
        )
    return "\n".join([*lines, "M30", ""])


@st.composite
def klartext(draw: st.DrawFn) -> str:
    """Lines in both measures, circles, helices, polar and tangential blocks, frames."""
    text = "BEGIN PGM A MM\nTOOL CALL 1 Z S1000\n" + draw(st.sampled_from(CYCLES))
    text += "L X+0 Y+0 Z+20 R0 FMAX\nL Z+0 F500\n"
    for k in range(draw(st.integers(1, 7))):
        x, y, r, sense = draw(number), draw(number), draw(radius), draw(st.sampled_from("+-"))
        text += draw(
            st.sampled_from(
                [
                    f"{k} L X{x:+} Y{y:+} ; line {k}\n",
                    f"L IX{x / 20:+.3f} Y{y:+}\n",
                    f"L X+0 Y+0\nCR X+{r} Y-{r} R{sense}{1.2 * r:.3f} DR{sense}\n",
                    f"L X+0 Y+0\nCC X+{r} Y+0\nC X+0 Y+0 DR{sense}\n",
                    f"L X+0 Y+0\nCC X+{r} Y+0\nCP IPA{sense}400 IZ-2 DR{sense}\n",
                    f"CC X{x:+} Y{y:+}\nLP PR+{r} PA+{abs(x)}\nLP IPA+30\n",
                    f"L X+0 Y+0\nL X+{r}\nCT X+{2 * r} Y+{r}\n",
                    f"L X+0 Y+0\nL X+{r + 3}\nRND R1\nL Y+{r + 3}\n",
                ]
            )
        )
    return text + "L Z+50 FMAX M30\nEND PGM A MM\n"


def check(text: str, dialect: str) -> None:
    with tempfile.TemporaryDirectory() as folder:
        found = run(Path(folder), text, rough(), replace(SETUP, dialect=dialect))
    assert found.after.largest <= 1e-3 + found.rounding.largest + 1e-6
    assert found.is_met
    comments = [line.split(";")[1] for line in text.splitlines() if ";" in line]
    assert [line.split(";")[1] for line in found.text.splitlines() if ";" in line][4:] == comments


@pytest.mark.thorough
@quick
@given(siemens())
def test_sinumerik(text: str):
    check(text, "sinumerik")


@pytest.mark.thorough
@quick
@given(klartext())
def test_klartext(text: str):
    check(text, "heidenhain")


@pytest.mark.thorough
@quick
@given(st.integers(1, 4), st.integers(1, 4), number, radius)
def test_written_out_programs_cut_the_same(calls: int, turns: int, x: float, r: float):
    """A loop of calls against the same blocks written by hand: the same rewritten moves."""
    inner = f"G91\nG1 X{x / 20:.3f}\nG3 X{-r / 4:.3f} Y{r / 4:.3f} CR={r:.3f}\nG90\n"
    loops = f"G54 G90\nG1 X0 Y0 F500\nFOR R1=1 TO {calls}\nPART\nENDFOR\nM30\nPROC PART\nFOR R2=1 TO {turns}\n{inner}ENDFOR\nRET\n"
    plain = "G54 G90\nG1 X0 Y0 F500\n" + inner * (calls * turns) + "M30\n"
    setup = replace(SETUP, dialect="sinumerik")
    with tempfile.TemporaryDirectory() as folder:
        one, two = (run(Path(folder), t, rough(), setup) for t in (loops, plain))
    a, b = (interpret(f.text, "sinumerik", setup).moves for f in (one, two))
    assert [(m.kind, m.end, m.centre, m.feed) for m in a] == [(m.kind, m.end, m.centre, m.feed) for m in b]
