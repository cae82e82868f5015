"""Whole paths against the interpreter of LinuxCNC itself, where it is installed."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.program.oracle import SETUP, differences, ours
from tests.program.rs274 import path_of
from vcmm.program.interpret import interpret

HEAD = "G21 G90 G17 G40 G49 G54 G94\nT1 M6\nS1000 M3\nF200\nG0 X0 Y0 Z5\n"
PROGRAMS = {
    "arcs by centre and by radius": "G1 Z-1\nG1 X10\nG3 X0 Y10 I-10 J0\nG2 X10 Y0 R10\nG2 X12 Y3 R-10.1\n",
    "helix with two turns": "G1 X10\nG2 X10 Y0 Z-4 I-10 J0 P2\n",
    "incremental": "G91\nG1 X3 Y-2\nG2 X4 Y0 I2 J0\nG90\nG0 Z20\n",
    "arcs in three planes": "G18\nG2 X4 Z3 I2 K-1\nG19\nG3 Y2 Z5 R3\nG17\n",
    "drilling, both levels of retract": "G98 G81 X5 Y5 Z-3 R2\nX10\nG99 X15\nX20 L1\nG80\nG0 X0\n",
    "pecks and dwells": "G99 G83 X5 Y5 Z-9 R2 Q4\nG82 X8 Z-3 R1 P0.5\nG73 X11 Z-7 R1 Q3\nG80\n",
    "repeats in increments": "G0 X1 Y1\nG91 G81 X3 Y1 Z-4 R-2 L3\nG90 G80\n",
    "inch": "G20\nG1 X1 Y.5 F10\nG3 X1.5 Y1 I0 J.5\nG21\nG1 X0\n",
    "work offsets": "G10 L2 P2 X10 Y20 Z-5\nG55\nG1 X1 Y1 Z1\nG53 G0 Z0\nG54\nG1 X0\n",
    "a turned offset": "G10 L2 P3 X5 Y5 R30\nG56\nG1 X10 Y0\nG2 X20 Y0 I5 J0\nG54\nG1 X0 Y0\n",
    "a shift": "G92 X100 Y50\nG1 X110 Y60\nG92.1\nG1 X0 Y0\n",
    "tool length": "T2 M6\nG43 H2\nG1 Z-2\nX5\nG49\nG0 Z50\n",
    "cutter radius, outside and inside corners": "G1 X-20 Y-20 Z-1\nG41 D1 G1 X-10 Y0\nX0\nY20\nX30\nY-10\nX50\nG40 G1 X60 Y-30\n",
    "cutter radius along arcs": "G1 X-40 Y0 Z-1\nG42.1 D6 G1 X-20\nX0\nG3 X20 Y20 I0 J20\nG2 X30 Y30 I10 J0\nG1 X50\nG40 G1 X70\n",
    "o-words": "o100 sub\nG1 X#1 Y[#1 * 2]\no100 endsub\n#5=1\no101 while [#5 LT 4]\no100 call [#5]\n#5=[#5+1]\no101 endwhile\n",
    "polar words": "G0 @10 ^30\nG1 @20\n^90\nG91 @5 ^45\nG90 G1 X0\n",
    "absolute centres": "G90.1\nG1 X10\nG3 X0 Y10 I0 J0\nG91.1\nG1 X0 Y0\n",
    "G80 beside another motion code": "G81 X5 Y5 Z-3 R2\nG0 G80 X9\nX12\nG80 G1 X3\nX4\n",
    "functions": "#1=[ATAN[1]/[1]+SQRT[16]]\nG1 X#1 Y[ROUND[2.5]+FIX[-1.5]+FUP[0.2]] Z[5 MOD 3]\n",
}


@pytest.mark.parametrize("name", PROGRAMS)
def test_the_path_is_that_of_the_interpreter(name: str, tmp_path: Path):
    """Four decimals of a millimetre or of an inch: 2.6 um at most apart, in a turned frame a little more."""
    text = HEAD + PROGRAMS[name] + "M2\n"
    found = interpret(text, "linuxcnc", SETUP)
    expected = path_of(text, tmp_path)
    assert len(expected) > 1
    assert not differences(ours(found.moves), expected, 0.004)
