"""One surface read by a probe: towards it, until ball and surface meet, and back. What the cycles of all controls are made of."""

from __future__ import annotations

from vcmm.nc.moves import ORIGIN, Point
from vcmm.nc.recorder import Recorder
from vcmm.nc.setup import Tool
from vcmm.nc.touching import ProbeContact, first_contact, stopped_at

OVERTRAVEL = 10.0  # mm beyond the expected surface, as in Renishaw's Inspection Plus (Q) and usual as set-up of a probe elsewhere


def ball_radius(tool: Tool) -> float:
    """mm; 0 where the set-up does not state it."""
    return (tool.diameter or 0.0) / 2.0


def touch(r: Recorder, end: Point, tool: Tool, expected: Point | None = None) -> bool:
    """Straight towards a programmed point until the probe answers; whether it does. Rotary axes stand.

    expected: the programmed point at which it answers where no surface is stated on this way; None: it goes on to the end.
    """
    r.free("a probing move is programmed")
    if tool.number and tool.shape not in ("probe", "ball"):
        what = f"of {tool.diameter:g} mm" if tool.diameter else "without a diameter"
        r.remark(
            f'tool {tool.number} probes, which is no probe (shape = "probe") but {tool.shape} {what}: it touches like a ball of that diameter',
            kind=f"probes {tool.number}",
        )
    tip, radius, target = r.tip(), ball_radius(tool), r.world.apply(end)
    centre = (0.0, 0.0, radius)  # over the tip, which is the lowest point
    met = first_contact(r.setup.surfaces, tip, target, radius, centre)
    if met is None and expected is not None:
        met = stopped_at(tip, r.world.apply(expected), target)
        if met is not None:
            r.assume(
                "where the surfaces lie that are probed", "where the program expects them", matters=False
            )
    if met is not None:
        number, read = len(r.touches), r.setup.read_out
        r.touches.append(
            ProbeContact(
                line=r.line,
                tip=met[0],
                along=met[1],
                normal=met[2],
                tool=r.tool,
                tool_offset=r.tool_offset,
                offset=r.offset,
                rotary=r.rotary,
            )
        )
        further = read[number] if number < len(read) else 0.0
        x, y, z = (p + further * a for p, a in zip(met[0], met[1]))
        end = r.world.undo((x, y, z))
    r.straight(end, False)
    r.skip, r.skip_axes = end, r.q
    return met is not None


def read_surface(
    r: Recorder, axis: int, expected: float, sense: float, tool: Tool, *, overtravel: float = OVERTRAVEL
) -> float:
    """Coordinate of a surface along an axis (0, 1, 2), mm as programmed: the probe goes there from where it stands, and back.

    expected: where the program takes the surface to be; sense: +1 or -1, the way to it. Where the set-up states no surface on that
    way it is taken to lie where expected. From the side the ball touches its radius before; from above with its lowest point.
    """
    radius = 0.0 if axis == 2 else ball_radius(tool)
    start = r.p
    met = touch(
        r,
        at(start, axis, expected + sense * overtravel),
        tool,
        expected=at(start, axis, expected - sense * radius),
    )
    if not met:
        r.fault(
            f"the probe stands behind the surface that it is to touch, or its ball of {2.0 * ball_radius(tool):g} mm does not fit: check where it starts and "
            "the expected position or size"
        )
    measured = r.p[axis] + sense * radius
    r.straight(start, False)
    return measured


def corrected_zero(r: Recorder, axis: int, reads: float, should: float) -> Point:
    """The work offset in force, shifted along an axis so that what now reads `reads` (mm) will read `should`; machine axes, mm."""
    here, there = r.world.apply(at(r.p, axis, should)), r.world.apply(at(r.p, axis, reads))
    old = r.offsets.get(r.offset, ORIGIN)
    return old[0] + there[0] - here[0], old[1] + there[1] - here[1], old[2] + there[2] - here[2]


def at(point: Point, axis: int, value: float) -> Point:
    """The point with another coordinate along an axis."""
    out = list(point)
    out[axis] = value
    return out[0], out[1], out[2]
