"""Drilling, boring and tapping cycles, stroke by stroke. Heights by hand from the manual's descriptions."""

from __future__ import annotations

import math

import pytest

from tests.program.heidenhain.klartext import moves
from vcmm.core.errors import DataError
from vcmm.program.drilling import depths_of

START = "TOOL CALL 5 Z S1000\nM3\n"


def heights(
    cycle: str, values: str, start: str = "L X+10 Y+5 Z+50 FMAX M99"
) -> list[tuple[str, float, float | None]]:
    data = " ~\n ".join(f"{v}" for v in values.split())
    made = moves(f"{START}CYCL DEF {cycle} NAME ~\n {data}\n{start}")[1:]
    return [(m.kind[0], m.end[2], m.feed if m.kind != "dwell" else m.seconds) for m in made]


def test_depths_of_infeeds():
    assert depths_of(0.0, -10.0, 4.0) == [-4, -8, -10]
    assert depths_of(0.0, -10.0, 4.0, 1.0, 2.0) == [-4, -7, -9, -10]  # 4, 3, 2 (not less), the rest
    assert depths_of(5.0, 4.0, 9.0) == [4.0]


def test_reaming_and_boring():
    """201: out at Q208; 202: 0.2 mm off the wall in -X, and back over the hole."""
    got = heights("201", "Q200=2 Q201=-15 Q206=100 Q211=0.5 Q208=250 Q203=+0 Q204=20")
    assert got == [("r", 2, None), ("l", -15, 100), ("d", -15, 0.5), ("l", 2, 250), ("r", 20, None)]
    bored = moves(
        f"{START}CYCL DEF 202 BORING ~\n Q200=2 ~\n Q201=-5 ~\n Q206=100 ~\n Q208=0 ~\n Q203=+0 ~\n Q214=1\nL X+10 Z+50 FMAX M99"
    )[1:]
    assert [m.end for m in bored] == [(10, 0, 2), (10, 0, -5), (9.8, 0, -5), (9.8, 0, 2), (10, 0, 2)]


def test_universal_drilling_breaks_chips_before_it_goes_out():
    """203: infeeds 5, 4, 3 to -12; one break (back 0.2 mm) and then out to the clearance, in again to Q200 above the depth."""
    got = heights("203", "Q200=2 Q201=-12 Q206=100 Q202=5 Q203=+0 Q212=1 Q213=1 Q205=2 Q208=300 Q256=0.2")
    assert got == [
        ("r", 2, None), ("l", -5, 100), ("l", -4.8, 300), ("l", -9, 100), ("l", 2, 300), ("r", -7, None), ("l", -12, 100), ("l", 2, 300),
    ]  # fmt: skip


def test_universal_pecking():
    """205: advanced stop 0.5 mm above the depth reached; chips broken each 4 mm by 0.2 mm; rapid out."""
    got = heights("205", "Q200=2 Q201=-10 Q206=100 Q202=6 Q203=+0 Q258=0.5 Q257=4 Q256=0.2")
    assert got == [
        ("r", 2, None), ("l", -4, 100), ("r", -3.8, None), ("l", -6, 100), ("r", 2, None), ("r", -5.5, None), ("l", -10, 100), ("r", 2, None),
    ]  # fmt: skip


def test_tapping():
    """206 at Q206; 207 at pitch times speed, 1.5 mm x 1000/min; 209 in steps of 5 mm, back by 1 mm."""
    assert heights("206", "Q200=2 Q201=-10 Q206=750 Q211=0 Q203=+0") == [
        ("r", 2, None),
        ("l", -10, 750),
        ("l", 2, 750),
    ]
    assert heights("207", "Q200=2 Q201=-10 Q239=+1.5 Q203=+0") == [
        ("r", 2, None),
        ("l", -10, 1500),
        ("l", 2, 1500),
    ]
    broken = heights("209", "Q200=2 Q201=-10 Q239=-1 Q203=+0 Q257=5 Q256=1")
    assert [h for _, h, _ in broken] == [2, -5, -4, -10, 2]


def test_centring_and_single_lip_drilling():
    assert heights("240", "Q200=2 Q343=0 Q201=-3 Q206=100 Q211=0.1 Q203=+0 Q204=0") == [
        ("r", 2, None), ("l", -3, 100), ("d", -3, 0.1), ("r", 2, None),
    ]  # fmt: skip
    assert [
        h for _, h, _ in heights("241", "Q200=2 Q201=-80 Q206=100 Q203=+0 Q379=20 Q253=500 Q208=1000")
    ] == [2, -18, -80, 2]


def test_bore_milling_runs_down_a_helix():
    """208: radius 15 - 5 = 10; 2 mm a turn from +2 to -4, then a full circle, back to the middle."""
    made = moves(
        f"{START}CYCL DEF 208 ~\n Q200=2 ~\n Q201=-4 ~\n Q206=200 ~\n Q334=2 ~\n Q203=+0 ~\n Q335=30\nL X+10 Y+5 Z+50 FMAX M99"
    )
    arcs = [m for m in made if m.kind == "arc"]
    assert [(m.end[2], m.clockwise, m.turns) for m in arcs] == [
        (0, False, 1),
        (-2, False, 1),
        (-4, False, 1),
        (-4, False, 1),
    ]
    assert all(math.dist(m.end[:2], (10, 5)) == pytest.approx(10) for m in arcs)
    assert made[-1].end == (10, 5, 2)


def test_old_pecking_counts_from_where_the_tool_stands():
    """1: start 25 is DIST 24 above the surface at 1; to 1 - 10 = -9 by 4: 0.6 mm before the depth reached, dwell, out."""
    text = f"{START}CYCL DEF 1.0 PECKING\nCYCL DEF 1.1 DIST24\nCYCL DEF 1.2 DEPTH-10\nCYCL DEF 1.3 PLNGNG4\nCYCL DEF 1.4 DWELL0.5\nCYCL DEF 1.5 F80\n"
    made = moves(f"{text}L X+1 Z+25 FMAX M99")[1:]
    assert [m.end[2] for m in made] == pytest.approx([-3, 25, -2.4, -7, 25, -6.4, -9, -9, 25])
    assert [m.feed for m in made if m.kind == "line"] == [80] * 3
    other = text.replace("DIST24", "ABST-24").replace("PLNGNG4", "ZUSTLG-4").replace("DWELL0.5", "V.ZEIT 0,5")
    assert [m.end for m in moves(f"{other}L X+1 Z+25 FMAX M99")[1:]] == [m.end for m in made]
    deep = moves(f"{text.replace('DEPTH-10', 'DEPTH-50').replace('PLNGNG4', 'PLNGNG40')}L Z+25 FMAX M99")[1:]
    assert [m.end[2] for m in deep] == pytest.approx([-39, 25, -38, -49, -49, 25])  # 50 / 50 = 1 mm before


def test_old_tapping():
    made = moves(
        f"{START}CYCL DEF 17.0 RIGID\nCYCL DEF 17.1 DIST2\nCYCL DEF 17.2 DEPTH-8\nCYCL DEF 17.3 PITCH+1.25\nL Z+5 FMAX M99"
    )[1:]
    assert [(m.end[2], m.feed) for m in made] == [(-5, 1250), (5, 1250)]
    cut = moves(f"{START}CYCL DEF 18.0 THREAD\nCYCL DEF 18.1 DEPTH-8\nCYCL DEF 18.2 PITCH+1\nL Z+5 FMAX M99")[
        1:
    ]
    assert [(m.end[2], m.feed) for m in cut] == [(-3, 1000)]


def test_a_depth_above_the_surface_is_refused():
    with pytest.raises(DataError, match="cycle 207 needs a negative depth"):
        heights("207", "Q200=2 Q201=10 Q239=1 Q203=+0")
