"""Dialects by scored evidence."""

from __future__ import annotations

from pathlib import Path

import pytest

from vcmm.core.errors import DataError
from vcmm.program.interpret import interpret
from vcmm.program.reading import guess
from vcmm.program.recognition import candidates, ranking_text, unsure
from vcmm.program.setup import Setup

HEADS = {
    "fanuc": "%\nO1234(PLATE)\nG21\nG28 G91 Z0\nG90 G54\nT1 M6\nG0 X1. Y2.\nG43 Z5. H1\nM30\n%",
    "haas": "%\nO01234 (PLATE)\nG20 G90\nT1 M06\nG00 G154 P3 X1. Y2.\nG187 P3\nG43 H01 Z1.\nG53 G00 Z0\nM30\n%",
    "fanuc-lathe": "%\nO0001\nG50 S2000\nT0101\nG96 S200 M3\nG0 X50. Z2.\nG71 U2. R1.\nG71 P10 Q20 U.4 W.1 F.3\nM30\n%",
    "haas-lathe": "%\nO0001\nG50 S2000\nT101\nG96 S200 M3\nG00 X50. Z2.\nG71 P10 Q20 U.4 W.1 D2. F.3\nM30\n%",
    "fanuc-lathe-b": "%\nO0001\nG92 S2000\nG90 G0 X50. Z2.\nG95 G96 S130 M3\nG1 Z-5. F.2\nM30\n%",
    "linuxcnc": "o<ring> sub\nG1 X#<r>\no<ring> endsub\no<ring> call [1]\nM2",
    "mach3": "(Mach3)\nG90 G94 G91.1 G40\nG21\nM6 T1\nG0 X1 Y2\nM30",
    "grbl": "(Shapeoko)\n$H\nG21 ; mm\nG0 X1 Y1\n",
    "mazak": "%\n(MAZAK VTC-300)\nO1234\nG21 G90\nT01 T02 M06\nG0 X1. Y1.\nG43 H1 Z5.\nM30\n%",
    "sinumerik": "; part\nN10 DEF REAL DEPTH=5\nN20 G54 G17 T=\"MILL\"\nN30 CYCLE81(5,0,1,-10)\nN40 M30",
    "heidenhain": "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S2000\n2 L X+0 Y+0 R0 FMAX\n3 END PGM A MM",
}  # fmt: skip


@pytest.mark.parametrize("dialect", HEADS)
def test_each_is_told_from_the_others(dialect: str):
    ranking = candidates(HEADS[dialect], Path("part.txt"))
    assert ranking[0].dialect == dialect
    assert f"score {ranking[0].score:g}" in ranking_text(ranking)


def test_the_ending_is_one_sign_among_others():
    assert guess(HEADS["heidenhain"], Path("part.nc"))[0] == "heidenhain"
    assert guess(HEADS["fanuc"], Path("part.h"))[0] == "fanuc"
    assert guess("G0 X1\nM2", Path("part.ngc"))[0] == "linuxcnc"


def test_the_runner_up_is_named():
    ranking = candidates(HEADS["haas"], None)
    assert ranking[1].dialect in ("fanuc", "mazak")
    assert f"runner-up {ranking[1]}" in ranking_text(ranking)


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("%\nN1 (UAO,1)\n(UCG,2,X-120X124)\nN2 G0 X1\n", "NC-110"),
        (': (PGM, NAME="1001")\n: G90 G40\nG0 X1\n', "Acramatic"),
        ("#r=50\nG0 X#r\n", "BeagleG"),
    ],
)
def test_a_control_that_is_not_here_is_named_and_refused(text: str, name: str):
    with pytest.raises(DataError, match=rf"part\.nc:1:1: .*{name}.*not here"):
        guess(text, Path("part.nc"))


def test_where_it_is_not_sure_the_second_is_tried():
    # signs of Fanuc prevail by a hair, but G154 is a work offset of Haas alone
    text = "%\nO1234\nG21\nG65 P9 A1.\nG0 G154 P1 X1.\nM30\n%\nO9\nM99\n"
    assert unsure(candidates(text, None))
    program = interpret(text, None, Setup(strict=False))
    assert program.moves[-1].offset == "G54.1 P1"


@pytest.mark.parametrize(
    ("whose", "text"),
    [
        ("Brother", "%\nO1\nG21 G90\nG100 T1 X10. Y5. Z50. G43 H1 S8000 M3\nG1 Z-1. F100\nG53 G0 Z0\nM97 P10\nM30\n%"),
        ("a control with ACC words", "%NPG\nN10 G55 G08 ACC30\nN20 G01 X1 Y2\nM30\n"),
    ],
)  # fmt: skip
def test_controls_that_are_not_here_are_named(whose: str, text: str):
    with pytest.raises(DataError, match=f"seems to be written for {whose} .*name one with --dialect"):
        interpret(text, None, Setup(strict=False))


@pytest.mark.parametrize("name", ["PART 1.MIN%", "A.B+C.MIN%", "A(1)[2].SSB%", "PART-2.MIN", " PART.SUB%"])
def test_names_of_okuma_files(name: str):
    assert guess(f"${name}\nG0 X50 Z2\nG1 Z-5 F.2\nM2\n", None)[0] == "okuma"


def test_a_tie_between_lathes_is_told():
    # a bare G28 sends all axes of a Haas home, and none of a Fanuc
    text = "%\nO1\nG50 S2000\nT0101\nG96 S200 M3\nG0 X50. Z2.\nG1 Z-5. F.2\nG28\nM30\n%"
    chosen, why = guess(text, None)
    assert chosen == "fanuc-lathe"
    assert "runner-up haas-lathe" in why
    assert "differs in words such as a bare G28" in why
    found = interpret(text, None, Setup(strict=False))
    assert [a.line for a in found.assumed if "G28 without axes" in a.what] == [8]


@pytest.mark.parametrize(
    "text",
    [
        "%00229\nN10 T1.1\nN20 M6\nN30 G0 X0 Y0\n", "%NAME,MX--,\nN10 G90 G21\nN20 G81 X10 Y5 Z2 I-10 F100\nM30\n",
        "%PLATE 1 ,MX-,\nG0 X1 Y2\nM30\n",
    ],
)  # fmt: skip
def test_fagor_is_recognised(text: str):
    assert guess(text, None)[0] == "fagor"
