"""A hole, move by move, by hand."""

from __future__ import annotations

from vcmm.program.drilling import Hole
from vcmm.program.recorder import Recorder


def recorder() -> Recorder:
    r = Recorder(file="p.nc")
    r.feed = 100.0
    r.straight((10.0, 20.0, 50.0), True)
    r.moves.clear()
    return r


def seen(r: Recorder) -> list[tuple[str, float]]:
    return [(m.kind, m.seconds if m.kind == "dwell" else m.end[2]) for m in r.moves]


def test_pecks_with_full_retract():
    # clearance 2, depths -5 and -8: down, out to 2, pause 0.5 s, back to 1 above -5, down, dwell 1 s each, out to 30
    r = recorder()
    hole = Hole(r, clearance=2.0, bottom=-8.0, retract=30.0)
    hole.to(2.0, True)
    hole.pecks([-5.0, -8.0], lambda depth: depth + 1.0, wait=1.0, pause=0.5)
    hole.leave()
    assert seen(r) == [
        ("rapid", 2.0), ("line", -5.0), ("dwell", 1.0), ("rapid", 2.0), ("dwell", 0.5), ("rapid", -4.0), ("line", -8.0),
        ("dwell", 1.0), ("rapid", 30.0),
    ]  # fmt: skip
    assert {m.end[:2] for m in r.moves} == {(10.0, 20.0)}


def test_chip_breaking_at_feed_and_a_slower_first_stroke():
    r = recorder()

    def slower(k: int) -> None:
        r.feed = 50.0 if k == 0 else 100.0

    Hole(r, 2.0, -8.0, 30.0).pecks(
        [-5.0, -8.0], lambda depth: depth + 1.0, out=False, back_at_feed=True, before=slower
    )
    assert [(m.kind, m.end[2], m.feed) for m in r.moves] == [
        ("line", -5.0, 50.0), ("line", -4.0, 50.0), ("line", -8.0, 100.0),
    ]  # fmt: skip


def test_moves_that_go_nowhere_are_made_where_the_cycle_says_so():
    for idle, count in ((False, 0), (True, 2)):
        r = recorder()
        hole = Hole(r, 2.0, -8.0, 50.0, idle=idle)
        hole.leave()
        hole.across(10.0, 20.0)
        assert len(r.moves) == count


def test_feed_in_waits_at_the_bottom_and_across_stays_at_its_height():
    r = recorder()
    hole = Hole(r, 2.0, -8.0, 30.0)
    hole.feed_in(0.25)
    hole.across(11.0, 20.0)
    assert seen(r) == [("line", -8.0), ("dwell", 0.25), ("rapid", -8.0)]
    assert r.moves[-1].end == (11.0, 20.0, -8.0)
