"""Fagor programs of mills: moves worked out by pencil from the manual of the CNC 8055 (M and EN models)."""

from __future__ import annotations

import re

import pytest

from vcmm.core.errors import DataError
from vcmm.face.cli import run as vcmm
from vcmm.program.interpret import interpret
from vcmm.program.moves import Program
from vcmm.program.reading import guess
from vcmm.program.setup import Setup, Tool

SETUP = Setup(strict=True, tools={1: Tool(1, 50.0, 10.0)})
HEAD = "%PART,MX--,\nN10 G90 G17 G71\nN20 T1 D1 M6\nN30 G0 G43 X0 Y0 Z20\n"


def read(text: str, setup: Setup = SETUP) -> Program:
    return interpret(HEAD + text, "fagor", setup)


def path(text: str, setup: Setup = SETUP) -> list[tuple[str, tuple[float, ...]]]:
    return [(m.kind, m.end) for m in read(text, setup).moves][1:]


def test_g81_goes_to_the_reference_plane_z_and_down_to_i():
    """8055, 9.7: G98 back to the initial plane 20, G99 to Z; K is a dwell in hundredths of a second; modal, each X or Y is a hole."""
    assert path("G99 G81 X10 Y5 Z2 I-10 F100\nG98 X20\nG80\nM30\n") == [
        ("rapid", (10, 5, 20)), ("rapid", (10, 5, 2)), ("line", (10, 5, -10)), ("rapid", (10, 5, 2)),
        ("rapid", (20, 5, 2)), ("line", (20, 5, -10)), ("rapid", (20, 5, 20)),
    ]  # fmt: skip
    assert not any(
        "decimal point" in r.text for r in read("G0 X10\nM30\n").warnings
    )  # X10 is 10 mm on a Fagor
    dwells = [m.seconds for m in read("G81 X10 Z2 I-10 K150 F100\nG80\nM30\n").moves if m.kind == "dwell"]
    assert dwells == [1.5]


def test_g91_counts_z_from_the_initial_plane_and_i_from_the_reference_plane():
    """20 - 18 = 2; 2 - 12 = -10."""
    assert path("G91 G99 G81 X10 Y5 Z-18 I-12 F100\nG80\nM30\n")[1:3] == [
        ("rapid", (10, 5, 2)),
        ("line", (10, 5, -10)),
    ]


def test_g83_pecks_j_times_i():
    """Three pecks of 4 mm below Z2: -2, -6, -10; back out to Z2 and down to 1 mm above the depth reached."""
    assert path("G98 G83 X10 Y5 Z2 I-4 J3 F100\nG80\nM30\n")[1:] == [
        ("rapid", (10, 5, 2)), ("line", (10, 5, -2)), ("rapid", (10, 5, 2)), ("rapid", (10, 5, -1)), ("line", (10, 5, -6)), ("rapid", (10, 5, 2)),
        ("rapid", (10, 5, -5)), ("line", (10, 5, -10)), ("rapid", (10, 5, 20)),
    ]  # fmt: skip


def test_corners_mirrors_turns_and_dwells():
    """G36 R5 rounds the corner at the end of its block, G39 R5 chamfers it; G11 mirrors X, G73 turns by Q about I, J."""
    rounded = read("G1 G36 R5 X30 F100\nY40\nM30\n").moves[1:]
    assert [(m.kind, m.end[:2]) for m in rounded] == [("line", (25, 0)), ("arc", (30, 5)), ("line", (30, 40))]
    assert [e[:2] for _, e in path("G1 G39 R5 X30 F100\nY40\nM30\n")] == [(25, 0), (30, 5), (30, 40)]
    assert path("G11\nG0 X10 Y5\nG10\nX10\nM30\n") == [("rapid", (-10, 5, 20)), ("rapid", (10, 5, 20))]
    turned = path("G73 Q90 I10 J0\nG0 X20 Y0\nG73\nX20 Y0\nM30\n")
    assert turned[0][1] == pytest.approx((10, 10, 20))
    assert turned[1][1] == (20, 0, 20)
    assert [m.seconds for m in read("G4 K50\nG0 X1\nG4\nM30\n").moves if m.kind == "dwell"] == [0.5]


def test_the_tool_gives_length_and_radius():
    """T1 D1 with 50 mm and 10 mm: the contour 5 mm to the left; the axes stand 50 mm higher."""
    program = read("G1 G41 X10 Y10 F100\nY40\nG40 Y60\nM30\n")
    assert [m.end[:2] for m in program.moves[1:]] == [(5, 10), (5, 40), (10, 60)]
    assert program.moves[-1].tool_offset[2] == 50
    assert read("N50 T1.1 (FRESA)\nN M6\nG0 X3\nM30\n").moves[-1].end[0] == 3


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("G87 Z2 J30 K20 B3\n", "G87 of Fagor without Z and I"), ("(RPT N10,N20)N3\n", r"\(RPT ...\)"), ("(P1=3)\n", r"\(P ...\)"),
        ("G8 X3 Y4\n", "an arc that goes on in tangent"), ("G1 R10 Q45 F100\n", "polar coordinates"), ("G69 Z2 I-10 B3 F100\n", "G69 of Fagor, deep drilling"),
        ("G81 X1 Z2 I-5 F100 N3\n", "repeats"), ("G81 X1 Z2 I-5 F100\nZ10\n", "before G80"), ("G25 N30\n", "G25 of Fagor"),
        ("G83 Z2 I-4 F100\n", "G83 of Fagor without"), ("G1 X[3]\n", "the block G1"),
    ],
)  # fmt: skip
def test_what_is_not_read_is_a_hole_with_its_line_or_refused(text: str, what: str):
    line = HEAD.count("\n") + text.count("\n")
    if text.count("\n") == 1:
        with pytest.raises(DataError, match=f":{line}:1: .*{what}"):
            read(text + "M30\n")
    told = read(text + "M30\n", Setup(strict=False)).assumed
    assert any(
        a.value.startswith("a hole in the path") and a.line == line and re.search(what, a.what) for a in told
    )


def test_a_program_of_a_lathe_is_refused():
    with pytest.raises(DataError, match="a Fagor program of a lathe"):
        interpret("%TURN,MX--,\nG90 G95\nG0 X40 Z2\nG1 Z-20 F0.2\nM30\n", "fagor", SETUP)


def test_fagor_is_recognised_and_read_from_the_command_line(tmp_path, capsys):
    (tmp_path / "a.pim").write_text(HEAD + "G81 X10 Y5 Z2 I-10 F100\nG80\nM30\n")
    assert guess(HEAD + "M30\n", None)[0] == "fagor"
    assert vcmm(["nc", str(tmp_path / "a.pim")]) == 0
    assert "dialect fagor" in capsys.readouterr().err


@pytest.mark.parametrize("text", ["G83 Z2 I J3 F100\n", "G1 X0 Y F100\n"])
def test_a_word_without_its_number_is_refused_on_both_levels(text: str):
    for setup in (SETUP, Setup(strict=False)):
        with pytest.raises(DataError, match=r":5:.*has no number"):
            read(text + "M30\n", setup)


def tips(text: str, setup: Setup) -> list[tuple[int, float, float]]:
    """Tool, X and Z of the ends."""
    return [(m.tool, m.end[0], m.end[2]) for m in interpret(text, "fagor", setup).moves]


def test_the_number_behind_the_point_of_t_is_the_tool_offset():
    """8025 M, "T2.2": the tool, and its place in the table of offsets; without M6 in the program T itself changes. Axes at 50 + 80 = 130 with
    T1.1; with the length 60 of offset 12 the tip is at 130 - 60 = 70 and the radius 2: X10 - 2 = 8 on the left."""
    tools = {1: Tool(1, 80.0, 10.0), 2: Tool(2, 70.0, 6.0), 12: Tool(12, 60.0, 4.0)}
    setup = Setup(strict=True, tools=tools)
    text = "%00229\nN10 G90 G71 G17\nN20 T1.1\nN30 G43\nN40 G0 X0 Y0 Z50\nN50 T2.12\nN60 G0 Y-5\nN70 G1 G41 X10 Y0 F100\nN80 Y30\nN90 G0 G40 X0\nN100 M30\n"
    made = tips(text, setup)
    assert made[0] == (1, 0, 50)
    assert made[1] == (2, 0, 70)
    assert made[3] == (2, 8, 70)
    without = interpret(text, "fagor", Setup(strict=False, tools={1: tools[1], 2: tools[2]}))
    assert any("12" in a.what for a in without.assumed) or any("12" in w.text for w in without.warnings)


def test_d_beside_t_is_the_tool_offset():
    """8055, "T1 D2 M6": offset 2; length 70, and 60 from D12 on: the axes at 20 + 70 = 90, the tip at 30."""
    tools = {1: Tool(1, 80.0, 10.0), 2: Tool(2, 70.0, 6.0), 12: Tool(12, 60.0, 4.0)}
    text = "%P,MX--,\nG90 G17 G71\nT1 D2 M6\nG0 G43 X0 Y0 Z20\nD12\nX1\nM30\n"
    assert tips(text, Setup(strict=True, tools=tools)) == [(1, 0, 20), (1, 1, 30)]
