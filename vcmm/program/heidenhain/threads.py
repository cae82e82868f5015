"""Thread milling of Klartext: cycle 262.

Source: HEIDENHAIN, TNC 640 User's Manual Cycle Programming, "Thread milling (cycle 262)": pre-positioning at Q253 to the starting plane, a
tangential way to the nominal diameter, one helix (Q355 = 0), one along the whole thread (1) or several (Q355 pitches apart), and
back to the middle. A remark states that the way in and out is half a circle at one height.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from vcmm.program.cycle_tables import Cycle, Values, cycle
from vcmm.program.drilling import whole_count
from vcmm.program.heidenhain.machining import KlartextPrimitive, MachiningCycle


def thread_milling(c: MachiningCycle, v: Values) -> None:
    """Run cycle 262: diameter Q335, pitch Q239 (negative: left-hand), depth Q201. Climb (Q351 = 1) inside is counter-clockwise: a right-hand
    thread rises then, and goes down in up-cut."""
    r, pitch = c.recorder, v["pitch"]
    if not pitch:
        r.fault(f"cycle {c.number} has no pitch Q239; add it")
    radius = max(v["diameter"] / 2.0 - c.radius(), 0.0)
    floor, counter = c.surface + v["depth"], round(v.without("climb", 1.0)) != -1
    rises = counter == (pitch > 0)
    r.assume(
        f"how cycle {c.number} leads in and out", "in half a circle at one height",
        f"how cycle {c.number} leads in is the control's own affair and not known; write its helix with CP", matters=True,
    )  # fmt: skip
    levels, turns = _levels(c, v, floor, abs(pitch))
    middle = c.here()
    c.to(None, None, c.clearance, True)
    for low in levels:
        first, last = (low, low + turns * abs(pitch)) if rises else (low + turns * abs(pitch), low)
        with c.feed_at(v["approach"], v["feed"]) as rapid:
            c.to(*middle, first, rapid)
        with c.feed_at(v["feed"]):
            c.cutter.thread(middle, radius, (first, last), abs(pitch), not counter)
    c.to(None, None, c.second, True)


def _levels(c: MachiningCycle, v: Values, floor: float, pitch: float) -> tuple[list[float], int]:
    """Return the lower ends of the helices, and their turns."""
    steps = v.number("turns")
    if steps == 0:
        return [floor], 1
    length = c.surface - floor
    if steps == 1:
        return [floor], max(1, whole_count(math.ceil(length / pitch - 1e-9)))
    count = max(1, whole_count(math.ceil(length / (steps * pitch) - 1e-9)))
    return [floor + k * steps * pitch for k in range(count)], 1


THREADS: Mapping[str, Cycle[KlartextPrimitive]] = {
    "262": cycle("Q335=diameter mm!, Q239=pitch mm!, Q201=depth mm!, Q355=turns count, Q253=approach feed, Q351=climb count?, Q200=clear mm!, Q203=surface mm!, Q204=second mm, Q207=feed feed!", thread_milling),
}  # fmt: skip
