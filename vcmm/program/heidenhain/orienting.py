"""Blocks of Klartext that move along the tool or turn it by other words than angles of axes: M140, A+Q120, TCPM AXIS SPAT.

Source: HEIDENHAIN, TNC 640 User's Manual Klartext Programming, "Retraction from the contour in the tool-axis direction: M140",
"Positioning the rotary axes (PLANE ... STAY)", "FUNCTION TCPM".
"""

from __future__ import annotations

import math

from vcmm.program.heidenhain.planes import asks_for_plane_angles
from vcmm.program.heidenhain.technology import KlartextTechnology
from vcmm.program.heidenhain.text import KlartextReader
from vcmm.program.heidenhain.transforms import turned_about
from vcmm.program.heidenhain.words import AXES, ROTARY, KlartextWords, read_words
from vcmm.program.leading import column, name_axes
from vcmm.program.levels import SetupEntry


def retracting(p: KlartextTechnology, words: KlartextWords) -> bool:
    """Read a block with M140: its F, at rapid without one, is that of this block alone. True at the end of the program."""
    before = p.r.feed, p.r.feed_mode
    rapid = p.technology(words) or words.feed is None
    retract(p, words.away or 0.0, rapid)
    p.r.feed, p.r.feed_mode = before
    return p.after(words)


def retract(p: KlartextTechnology, away: float, rapid: bool) -> None:
    """Retract, as M140 MB: back along the axis of the tool; MB MAX to the end of travel, which is taken at the reference point."""
    r = p.r
    axis = r.tool_axis
    leans = r.is_tcp_on and not r.is_plane_tilted and (r.aim is not None or any(r.rotary))
    if leans or (r.is_plane_tilted and not math.isfinite(away)):
        r.fault(
            "M140 along a tool that leans: its way is not known here; end the tilted plane or M128 before, or program the point with L"
        )
    name_axes(r, AXES[axis])
    p.last_rapid = rapid
    if math.isfinite(away):
        point = list(r.p)
        point[axis] += away * r.unit
        r.straight((point[0], point[1], point[2]), rapid)
        return
    r.assume(
        "M140 MB MAX (out to the end of travel)", f"to the reference point, {r.setup.reference[axis]:g} mm",
        blank=SetupEntry("", "reference", '["0 mm", "0 mm", "0 mm"]'), matters=False,
    )  # fmt: skip
    tip = list(r.tip())
    tip[axis] = r.setup.reference[axis] - r.tool_offset[axis]
    r.to_machine((tip[0], tip[1], tip[2]), rapid)


def settling(p: KlartextTechnology, reader: KlartextReader) -> KlartextWords:
    """Return the words of a block; A+Q120 C+Q122 behind PLANE ... STAY turn the tool square to the plane, before the next motion."""
    frames = p.cycles.frames
    if not asks_for_plane_angles(frames, reader):
        return read_words(reader, ())
    reader.parameters = {**reader.parameters, "Q120": 0.0, "Q121": 0.0, "Q122": 0.0}
    words = read_words(reader, ())
    for name in ROTARY:
        words.take(name)
    frames.settle()
    return words


def by_spatial_angles(p: KlartextTechnology, words: KlartextWords, angles: list[float]) -> None:
    """Turn the tool, TCPM AXIS SPAT: A B C, deg, are its direction. The first block states all three, as the manual asks for."""
    for k, name in enumerate(ROTARY):
        absolute, relative = words.take(name), words.take(f"I{name}")
        angles[k] = angles[k] + relative if relative is not None else angles[k]
        angles[k] = absolute if absolute is not None else angles[k]
    if any(map(math.isnan, angles)):
        p.r.fault("the first block with AXIS SPAT states A, B and C, those that are 0 too")
    p.r.point_to(column(p.r.world.then(turned_about(angles[0], angles[1], angles[2])), 2))
