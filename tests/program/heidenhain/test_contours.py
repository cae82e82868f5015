"""Contour cycles 14, 20, 24 and 25: paths worked out by pencil from the manual ("SL cycles"). The tool has 10 mm."""

from __future__ import annotations

import pytest

from vcmm.core.errors import DataError
from vcmm.program.interpret import interpret
from vcmm.program.setup import Setup, Tool

TOOLS = {1: Tool(1, 50.0, 10.0)}
HEAD = "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S1000\n2 L X+90 Y+90 Z+100 R0 FMAX\n3 CYCL DEF 14.0 CONTOUR\n4 CYCL DEF 14.1 CONTOUR LABEL1\n"
OPEN = "LBL 1\nL X+0 Y+0 RL\nL X+40\nL Y+40\nLBL 0\nEND PGM A MM\n"
SQUARE = "LBL 1\nL X+0 Y+0 {side}\nL X+40\nL Y+40\nL X+0\nL Y+0\nLBL 0\nEND PGM A MM\n"
TRAIN = "CYCL DEF 25 CONTOUR TRAIN Q1=-20 Q3={allowance} Q5=+0 Q7=+50 Q10=-10 Q11=100 Q12=200 Q15={sense}\nCYCL CALL\nL X-50 FMAX M30\n"
SIDE = (
    "CYCL DEF 20 CONTOUR DATA ~\nQ1=-20 Q2=+1 Q3=+0.5 Q4=+0 Q5=+0 Q6=+2 Q7=+50 Q8=+0.5 Q9=+1\n"
    "CYCL DEF 24 SIDE FINISHING Q9={sense} Q10=-20 Q11=100 Q12=200 Q14=+0\nCYCL CALL\nL X-50 FMAX M30\n"
)
ROUGH = (
    "CYCL DEF 20 CONTOUR DATA ~\nQ1=-8 Q2=+1 Q3=+0.5 Q4=+0.2 Q5={surface} Q6=+2 Q7=+50 Q8=+0.5 Q9=+1\n"
    "CYCL DEF {number} {name} Q10=-5 Q11=100 Q12=200 Q13=1 {more}\nCYCL CALL\nL X-50 FMAX M30\n"
)


def path(text: str, strict: bool = False) -> list[tuple[str, tuple[float, ...]]]:
    program = interpret(HEAD + text, "heidenhain", Setup(strict=strict, tools=TOOLS))
    return [(m.kind, tuple(round(v, 6) for v in m.end)) for m in program.moves][1:]


def test_a_contour_train_climbs_as_it_is_programmed():
    """RL with Q15 = +1: 5 mm to the left, the inside corner at (35, 5); -10 and -20, out to Q7 between; then on from where it stood."""
    ring = [("line", (35, 5)), ("line", (35, 40))]
    expected = [("rapid", (90, 90, 50))]
    for level in (-10, -20):
        expected += [
            ("rapid", (0, 5, 50)),
            ("line", (0, 5, level)),
            *((k, (*p, level)) for k, p in ring),
            ("rapid", (35, 40, 50)),
        ]
    assert path(TRAIN.format(allowance="+0", sense="+1") + OPEN) == [*expected, ("rapid", (-50, 40, 50))]


def test_up_cut_goes_back_and_an_allowance_moves_it_aside():
    """Q15 = -1: the same path the other way; Q3 = 1: 6 mm beside it."""
    made = path(TRAIN.format(allowance="+1", sense="-1") + OPEN)
    assert made[1:6] == [
        ("rapid", (34, 40, 50)),
        ("line", (34, 40, -10)),
        ("line", (34, 6, -10)),
        ("line", (0, 6, -10)),
        ("rapid", (0, 6, 50)),
    ]


def test_to_and_fro_stays_down():
    """Q15 = 0: the second infeed is where the first has ended."""
    made = path(TRAIN.format(allowance="+0", sense="+0") + OPEN)
    assert made[4:8] == [
        ("line", (35, 40, -10)),
        ("line", (35, 40, -20)),
        ("line", (35, 5, -20)),
        ("line", (0, 5, -20)),
    ]


def test_side_finishing_closes_its_ring():
    """A pocket of 40 x 40, counter-clockwise with RL: the tool 5 mm inside, from corner to corner, without a way into the wall."""
    made = path(SIDE.format(sense="+1") + SQUARE.format(side="RL"))
    assert made[1:] == [
        ("rapid", (5, 5, 50)), ("rapid", (5, 5, 2)), ("line", (5, 5, -20)), ("line", (35, 5, -20)), ("line", (35, 35, -20)), ("line", (5, 35, -20)), ("line", (5, 5, -20)),
        ("rapid", (5, 5, 50)), ("rapid", (-50, 5, 50)),
    ]  # fmt: skip


def test_an_island_is_gone_round_in_arcs():
    """RR: outside; climb is clockwise then, so the programmed way is reversed; corners as arcs about them."""
    made = path(SIDE.format(sense="+1") + SQUARE.format(side="RR"))
    assert made[1:5] == [
        ("rapid", (-5, 0, 50)),
        ("rapid", (-5, 0, 2)),
        ("line", (-5, 0, -20)),
        ("line", (-5, 40, -20)),
    ]
    assert [p for k, p in made if k == "arc"] == [(0, 45, -20), (45, 40, -20), (40, -5, -20), (-5, 0, -20)]


@pytest.mark.parametrize(
    ("text", "what"),
    [
        (TRAIN.format(allowance="+0", sense="+1") + OPEN, "7:1: where cycle 25 goes in is the control's own"),
        (
            ROUGH.format(number=22, name="ROUGH-OUT", more="Q18=0", surface=0) + SQUARE.format(side="RL"),
            "9:1: how cycle 22 clears and where it goes in is the control's own affair",
        ),
    ],
)
def test_strict_reading_refuses_what_is_not_known(text: str, what: str):
    with pytest.raises(DataError, match=what):
        path(text, strict=True)


def test_what_is_missing_is_refused():
    with pytest.raises(DataError, match="there is no LBL 1 for the contour"):
        path(TRAIN.format(allowance="+0", sense="+1") + "END PGM A MM\n")
    with pytest.raises(DataError, match="cycle 20 has no Q1"):
        path("CYCL DEF 24 SIDE FINISHING Q9=+1 Q10=-20 Q11=100 Q12=200\n" + OPEN)
    with pytest.raises(DataError, match="has no RL or RR"):
        path(SIDE.format(sense="+1") + SQUARE.format(side="R0"))


@pytest.mark.parametrize("surface", [0, 30])
def test_rough_out_leaves_its_allowances(surface: int):
    """A pocket of 40 x 40: centre of the tool 5.5 mm inside, rows 29 / 6 = 4.833 mm apart (5 at most); depths -5 and -8 + 0.2 below Q5, along the wall last."""
    made = path(
        ROUGH.format(number=22, name="ROUGH-OUT", more="Q18=0", surface=surface) + SQUARE.format(side="RL")
    )
    cut = [p for k, p in made if k == "line"]
    assert {round(p[2] - surface, 6) for p in cut} == {-5, -7.8}
    first = [p[:2] for p in cut if p[2] == surface - 5]
    assert first[1] == (34.5, round(5.5 + 29 / 6, 6))
    assert first[-5:] == [(5.5, 5.5), (34.5, 5.5), (34.5, 34.5), (5.5, 34.5), (5.5, 5.5)]
    assert {round(p[1], 3) for p in first} == {5.5, 10.333, 15.167, 20.0, 24.833, 29.667, 34.5}
    assert made[:4] == [
        ("rapid", (90, 90, 50)), ("rapid", (5.5, round(5.5 + 29 / 6, 6), 50)), ("rapid", (5.5, round(5.5 + 29 / 6, 6), surface + 2)),
        ("line", (5.5, round(5.5 + 29 / 6, 6), surface - 5)),
    ]  # fmt: skip


def test_the_floor_is_finished_at_full_depth():
    made = path(ROUGH.format(number=23, name="FLOOR", more="", surface=30) + SQUARE.format(side="RL"))
    assert {p[2] for k, p in made if k == "line"} == {22}


def test_pilot_holes_stand_where_the_rough_out_goes_in():
    """Pecks of 5 down to 7.8, 0.6 mm before the depth reached; the tool of Q13 has 5 mm radius."""
    made = path(ROUGH.format(number=21, name="PILOT DRILLING", more="", surface=0) + SQUARE.format(side="RL"))
    spot = (5.5, round(5.5 + 29 / 6, 6))
    heights = [
        ("rapid", 50),
        ("rapid", 2),
        ("line", -5),
        ("rapid", 2),
        ("rapid", -4.4),
        ("line", -7.8),
        ("rapid", 50),
    ]
    assert made[:-1] == [
        ("rapid", (90, 90, 50)),
        *(("rapid" if k == "rapid" else "line", (*spot, z)) for k, z in heights),
    ]


def test_the_depth_counts_from_the_surface():
    """Cycles 24 and 25: Q1 is an increment from Q5 (manual: Q1=-20, Q5=+30, Q7=+80)."""
    made = path(
        SIDE.format(sense="+1").replace("Q5=+0", "Q5=+30").replace("Q7=+50", "Q7=+80")
        + SQUARE.format(side="RL")
    )
    assert made[2:4] == [("rapid", (5, 5, 32)), ("line", (5, 5, 10))]


def test_side_finishing_comes_down_at_rapid_to_its_set_up_clearance():
    """Q5 0 + Q6 2 = 2: from there at Q11 = 100, where it fed 52 mm from Q7 = 50 before; cycle 25 has no Q6 and goes at Q11 from Q7."""

    def down(text: str) -> list[tuple[str, float, float, float | None]]:
        made = interpret(HEAD + text, "heidenhain", Setup(strict=False, tools=TOOLS)).moves
        return [(m.kind, m.start[2], m.end[2], m.feed) for m in made if m.end[2] < m.start[2] <= 50]

    assert down(SIDE.format(sense="+1") + SQUARE.format(side="RL")) == [
        ("rapid", 50, 2, None),
        ("line", 2, -20, 100),
    ]
    assert down(TRAIN.format(allowance="+0", sense="+0") + OPEN)[0] == ("line", 50, -10, 100)
