"""CYCLE81 to CYCLE83 and CYCLE832, move by move."""

from __future__ import annotations

from tests.nc.sinumerik.programs import check, moves


def test_drilling_cycles():
    check("G0 Z50\nF100\nCYCLE81(10,0,2,-15)", (0, 0, 50), (0, 0, 2), (0, 0, -15), (0, 0, 10))
    modal = moves("G0 Z10 F100\nMCALL CYCLE82(10,0,2,,8,0.5)\nX5\nX7\nMCALL\nX9")
    assert [m.kind for m in modal] == ["rapid", *["rapid", "rapid", "line", "dwell", "rapid"] * 2, "rapid"]
    assert [m.end[2] for m in modal[2:4]] == [2, -8]
    # CYCLE83 to -20: first 8, then 8 - 3 = 5 (to -13), then 3 (DAM is the least; to -16), the last 4 halved: -18, -20
    deep = moves("G0 Z10 F100\nCYCLE83(10,0,2,-20,,-8,,3,0,0,0.5,1)")
    assert [m.end[2] for m in deep if m.kind == "line"] == [-8, -13, -16, -18, -20]
    assert [m.feed for m in deep if m.kind == "line"] == [50, 100, 100, 100, 100]
