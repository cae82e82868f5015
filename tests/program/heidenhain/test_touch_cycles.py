"""TCH PROBE 400 to 427, by hand: what the preset becomes, and what stands in the Q parameters."""

from __future__ import annotations

import math

import pytest

from vcmm.core.errors import DataError
from vcmm.program.interpret import interpret
from vcmm.program.moves import Program
from vcmm.program.setup import Setup, Tool
from vcmm.program.touching import Face, Round, Surface, box_faces

BOX = box_faces((50.0, 20.0, -230.0), (100.0, 60.0, 30.0))  # X -50 to 50, Y -30 to 30, Z -30 to 0 of the work
TOOLS = {9: Tool(9, length=120.0, diameter=6.0, shape="probe")}
ZERO = {"G54": (100.0, 50.0, -200.0), "G55": (1.0, 2.0, 3.0)}
BORE = Round((101.0, 51.0, 0.0), 15.02, inside=True)  # 1 mm beside the middle in X and Y, 0.04 mm too wide
TURN = 0.01  # rad


def run(cycle: str, *lines: str, surfaces: tuple[Surface, ...] = BOX) -> Program:
    number, *words = cycle.split()
    called = " ~\n".join([f"TCH PROBE {number} NAME", *words])
    text = "\n".join(["BEGIN PGM P MM", "TOOL CALL 9 Z S10", "L Z+50 FMAX", called, *lines, "END PGM P MM"])
    return interpret(text, "heidenhain", Setup(offsets=ZERO, tools=TOOLS, surfaces=surfaces))


def turned_corner() -> tuple[Face, Face]:
    """Faces that meet at X -50, Y -30 of the work, turned by TURN counter-clockwise; the part lies towards +X and +Y."""
    c, s, point = math.cos(TURN), math.sin(TURN), (50.0, 20.0, -200.0)
    return Face(point, (-c, -s, 0.0)), Face(point, (s, -c, 0.0))


@pytest.mark.parametrize("extra", ["", " Q325=+15 Q247=+80", " Q423=+3"])
def test_the_middle_of_a_bore_becomes_the_datum(extra):
    # found at (1, 1): it is to read (10, 0), so the zero goes from (100, 50) to (91, 51)
    found = run(
        "412 Q321=+0 Q322=+0 Q262=+30 Q261=-5 Q320=+0 Q260=+20 Q305=+0 Q331=+10 Q332=+0 Q303=+1" + extra,
        "L X+0 Y+0 FMAX",
        "L X+Q153 Y+Q151 FMAX",
        surfaces=(BORE,),
    )
    assert found.moves[-2].end[:2] == pytest.approx((91.0, 51.0), abs=1e-9)
    assert found.moves[-1].end[:2] == pytest.approx((91.0 + 30.04, 51.0 + 1.0), abs=1e-9)


def test_a_boss_is_touched_from_outside_and_its_height_too():
    boss = (
        Round((101.0, 51.0, -195.0), 15.0, inside=False, low=-230.0, high=-195.0),
        Face((0.0, 0.0, -195.0), (0.0, 0.0, 1.0)),
    )
    found = run(
        "413 Q321=+0 Q322=+0 Q262=+30 Q261=-5 Q320=+5 Q260=+20 Q305=+2 Q331=+0 Q332=+0 Q381=+1 Q382=+0 Q383=+0 Q384=+4 Q333=+0", "CYCL DEF 247 DATUM ~\n Q339=2",
        "L X+0 Y+0 Z+0 FMAX", surfaces=boss,
    )  # fmt: skip
    assert len(found.touches) == 5
    assert found.moves[-1].end == pytest.approx((101.0, 51.0, -195.0), abs=1e-9)


def test_a_rectangle_from_outside():
    # the stock is 100 by 60 about 0; expected about (1, 2)
    found = run(
        "411 Q321=+1 Q322=+2 Q323=+99 Q324=+61 Q261=-5 Q320=+2 Q260=+20 Q305=+0 Q331=+1 Q332=+2",
        "L X+1 Y+2 FMAX",
        "L X+Q154 Y+Q155 FMAX",
    )
    assert [round(t.tip[k], 9) for t, k in zip(found.touches, (0, 0, 1, 1))] == [153.0, 47.0, 83.0, 17.0]
    assert found.moves[-2].end[:2] == pytest.approx((100.0, 50.0))
    assert found.moves[-1].end[:2] == pytest.approx((199.0, 108.0))


def test_a_ridge_and_a_slot():
    found = run(
        "409 Q321=+1 Q322=+0 Q311=+99 Q272=+1 Q261=-5 Q320=+2 Q260=+20 Q305=+0 Q405=+3",
        "L X+3 Y+0 FMAX",
        "L X+Q166 FMAX",
    )
    assert found.moves[-2].end[:2] == pytest.approx((100.0, 50.0))
    assert found.moves[-1].end[0] == pytest.approx(97.0 + 100.0)
    walls = (Face((90.0, 0.0, 0.0), (1.0, 0.0, 0.0)), Face((111.0, 0.0, 0.0), (-1.0, 0.0, 0.0)))
    found = run(
        "408 Q321=+0 Q322=+0 Q311=+20 Q272=+1 Q261=-5 Q260=+20 Q405=+0", "L X+Q166 Y+0 FMAX", surfaces=walls
    )
    assert found.moves[-1].end[0] == pytest.approx(100.5 + 21.0)


def test_in_a_narrow_slot_it_probes_from_the_middle():
    """8 mm wide at X0, ball of 6 mm: its middle has 1 mm to either side, less than the 2 + 2 + 3 = 7 mm from which it would begin."""
    walls = (Face((96.0, 50.0, -200.0), (1.0, 0.0, 0.0)), Face((104.0, 50.0, -200.0), (-1.0, 0.0, 0.0)))
    found = run(
        "408 Q321=+0 Q322=+0 Q311=+8 Q272=+1 Q261=-5 Q320=+2 Q260=+20 Q405=+0",
        "L X+Q166 Y+0 FMAX",
        surfaces=walls,
    )
    assert [t.tip[0] for t in found.touches] == [101.0, 99.0]
    assert {m.start[0] for m in found.moves if m.kind == "line" and m.end[0] in (101.0, 99.0)} == {100.0}
    assert found.moves[-1].end[0] == pytest.approx(108.0)


def test_an_outer_corner_with_its_turn():
    # the corner at (-50, -30) is to read (0, 0), and the part lies turned by 0.01 rad: X+100 goes along its edge
    cycle = "414 Q263=-40 Q264=-30 Q326=+30 Q296=-50 Q297=-20 Q327=+30 Q261=-5 Q320=+2 Q260=+20 Q304=+1 Q305=+0 Q331=+0 Q332=+0"
    found = run(cycle, "L X+100 Y+0 FMAX", "L X+Q151 Y+Q152 FMAX", surfaces=turned_corner())
    c, s = math.cos(TURN), math.sin(TURN)
    assert found.moves[-2].end[:2] == pytest.approx((50.0 + 100.0 * c, 20.0 + 100.0 * s), abs=1e-9)
    x, y = -50.0, -30.0  # Q151, Q152: as programmed when it was measured
    assert found.moves[-1].end[:2] == pytest.approx((50.0 + x * c - y * s, 20.0 + x * s + y * c), abs=1e-9)


def test_a_basic_rotation_by_two_points_and_by_two_holes():
    c, s = math.cos(TURN), math.sin(TURN)
    line = "400 Q263=-40 Q264=-30 Q265=+20 Q266=-30 Q272=+2 Q267=+1 Q261=-5 Q320=+2 Q260=+20 Q307=+0 Q305=+0"
    holes = "401 Q268=+0 Q269=+0 Q270=+60 Q271=+0 Q261=-5 Q260=+20 Q307=+0 Q305=+0"
    bores = tuple(Round((100.0 + r * c, 50.0 + r * s, 0.0), 5.0, inside=True) for r in (0.0, 60.0))
    for cycle, surfaces in ((line, turned_corner()), (holes, bores)):
        found = run(cycle, "L X+100 Y+0 FMAX", "L Z+Q150 FMAX", surfaces=surfaces)
        assert found.moves[-2].end[:2] == pytest.approx((100.0 + 100.0 * c, 50.0 + 100.0 * s), abs=1e-9)
        assert found.moves[-1].end[2] == pytest.approx(-200.0 + math.degrees(TURN), abs=1e-9)


def test_circles_of_holes_and_lines_between_them():
    middles = [
        (100.5 + 40.0 * math.cos(a), 50.25 + 40.0 * math.sin(a))
        for a in (0.0, math.pi / 2, math.pi, -math.pi / 2)
    ]
    holes = tuple(Round((x, y, 0.0), 5.0, inside=True) for x, y in middles)
    found = run(
        "416 Q273=+0 Q274=+0 Q262=+80 Q291=+0 Q292=+90 Q293=+180 Q261=-5 Q260=+20 Q305=+0 Q331=+0 Q332=+0",
        "L X+0 Y+0 FMAX",
        "L X+Q153 FMAX",
        surfaces=holes,
    )
    assert found.moves[-2].end[:2] == pytest.approx((100.5, 50.25), abs=1e-9)
    assert found.moves[-1].end[0] == pytest.approx(180.5, abs=1e-9)
    places = "Q268=+40 Q269=+0 Q270=+0 Q271=+40 Q316=-40 Q317=+0 Q318=+0 Q319=-40"
    found = run(f"418 {places} Q261=-5 Q260=+20 Q305=+0 Q331=+0 Q332=+0", "L X+0 Y+0 FMAX", surfaces=holes)
    assert found.moves[-1].end[:2] == pytest.approx((100.5, 50.25), abs=1e-9)


def test_a_height_becomes_the_datum():
    # the top at Z0 is to read +2
    found = run("417 Q263=+0 Q264=+0 Q294=+1 Q320=+2 Q260=+20 Q305=+0 Q333=+2", "L Z+2 FMAX", "L X+Q160 FMAX")
    assert found.moves[-2].end[2] == pytest.approx(-200.0)
    assert found.moves[-1].end[0] == pytest.approx(100.0)


@pytest.mark.parametrize(
    ("cycle", "results"),
    [
        ("420 Q263=-40 Q264=-30 Q265=+20 Q266=-30 Q272=+2 Q267=+1 Q261=-5 Q260=+20", {"Q150": math.degrees(TURN)}),
        ("420 Q263=-50 Q264=-20 Q265=-50 Q266=+20 Q272=+1 Q267=+1 Q261=-5 Q260=+20", {"Q150": 90.0 + math.degrees(TURN)}),
        ("421 Q273=+0 Q274=+0 Q262=+30 Q261=-5 Q260=+20", {"Q151": 1.0, "Q152": 1.0, "Q153": 30.04, "Q161": 1.0, "Q163": 0.04}),
        ("424 Q273=+0 Q274=+0 Q282=+99 Q283=+60 Q261=-5 Q260=+20", {"Q154": 100.0, "Q155": 60.0, "Q164": 1.0, "Q165": 0.0}),
        ("426 Q263=-50 Q264=+0 Q265=+50 Q266=+0 Q272=+1 Q311=+99 Q261=-5 Q260=+20", {"Q156": 100.0, "Q157": 0.0, "Q166": 1.0}),
        ("427 Q263=-49 Q264=+0 Q261=-5 Q272=+1 Q267=+1 Q260=+20", {"Q160": -50.0}),
        ("427 Q263=+0 Q264=+0 Q261=+1 Q272=+3 Q267=-1 Q260=+20", {"Q160": 0.0}),
    ],
)  # fmt: skip
def test_what_is_measured_goes_into_parameters(cycle, results):
    surfaces = turned_corner() if cycle.startswith("420") else (BORE,) if cycle.startswith("421") else BOX
    found = run(cycle, *(f"L X+{name} FMAX" for name in results), surfaces=surfaces)
    ends = [m.end[0] - 100.0 for m in found.moves[-len(results) :]]
    assert ends == pytest.approx(list(results.values()), abs=1e-9)


def test_a_slot_is_measured_at_two_places():
    walls = (Face((90.0, 0.0, 0.0), (1.0, 0.0, 0.0)), Face((111.0, 0.0, 0.0), (-1.0, 0.0, 0.0)))
    found = run(
        "425 Q328=+0 Q329=+0 Q310=+7 Q272=+1 Q311=+20 Q261=-5 Q260=+20",
        "L X+Q156 Y+Q157 Z+Q166 FMAX",
        surfaces=walls,
    )
    assert [t.tip[:2] for t in found.touches] == [(108.0, 50.0), (93.0, 57.0)]
    assert found.moves[-1].end == pytest.approx((121.0, 50.5, -199.0))


def test_what_a_cycle_lacks_is_said_by_line():
    for cycle, message in (
        ("412 Q321=+0 Q322=+0 Q262=+30 Q261=-5 Q423=+5", "4:11: .*Q423 = 5 must be 3 or 4 points"),
        ("410 Q321=+0 Q322=+0 Q323=+30 Q261=-5", "TCH PROBE 410 needs Q324"),
        ("409 Q321=+0 Q322=+0 Q311=+30 Q261=-5 Q272=+3", "Q272 = 3 must be 1 or 2"),
        ("400 Q263=-40 Q264=-30 Q265=-40 Q266=-30 Q272=+2 Q267=+1 Q261=-5", "both points lie at one place"),
        ("401 Q268=+0 Q269=+0 Q270=+60 Q271=+0 Q261=+20 Q402=+1", "Q402 = 1 turns the rotary table"),
        (
            "401 Q268=+0 Q269=+0 Q270=+60 Q271=+0 Q261=+20",
            r"finds no hole at X 0, Y 0 \(mm\).*as \[\[surfaces\]\]",
        ),
        ("415 Q263=+0", "in one version of the control"),
        ("431 Q263=+0", "TCH PROBE 431 .a plane. is not understood"),
    ):
        with pytest.raises(DataError, match=message):
            run(cycle)


def test_a_survey_goes_on_where_a_cycle_cannot():
    text = "BEGIN PGM P MM\nTOOL CALL 9 Z S10\nTCH PROBE 410 DATUM ~\nQ321=+0\nL X+7 FMAX\nEND PGM P MM"
    found = interpret(text, "heidenhain", Setup(offsets=ZERO, tools=TOOLS, strict=False))
    assert found.moves[-1].end[0] == 107.0
    assert [(a.line, a.what) for a in found.assumed] == [(3, "TCH PROBE 410")]
    assert "needs Q322" in found.assumed[0].value


def test_the_way_between_touches_is_told():
    """Q301 = 0: the machine goes from touch to touch at the measuring height; here it goes over Q260, as with Q301 = 1."""
    cycle = "421 Q273=+0 Q274=+0 Q262=+30 Q261=-5 Q260=+20 Q301={}"
    said = [[w.text for w in run(cycle.format(k)).warnings if "Q301" in w.text] for k in "01"]
    assert [len(texts) for texts in said] == [1, 0]
    assert "goes over Q260 here" in said[0][0]
