"""Transformations of coordinates in Klartext: cycles 7, 8, 10, 11, 19, 26, 247, TRANS, PLANE.

Source: HEIDENHAIN, TNC 640 User's Manual Klartext Programming, "Coordinate transformations" and "PLANE functions". What builds up
on one another depends on the order in which it is programmed; a transformation programmed again keeps its place.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from vcmm.program.frames import AffineMap, rotation, stretch, translation
from vcmm.program.heidenhain.text import KlartextReader
from vcmm.program.moves import PLANES, Point, Posture
from vcmm.program.recorder import Recorder

AXES = "XYZ"
SHIFT, MIRROR, TURN, SCALE, PLANE, INNER = (
    "shift",
    "mirror",
    "rotation",
    "scale",
    "plane",
    "shift in the plane",
)
_AFTER = "a datum shift after rotation, mirror or scaling is not understood; shift first, then rotate"


@dataclass(eq=False)
class KlartextFrames:
    """maps: what is in force, from the outermost to the innermost."""

    recorder: Recorder
    shifts: dict[str, list[float]] = field(default_factory=lambda: {SHIFT: [0.0] * 3, INNER: [0.0] * 3})
    mirror_axes: frozenset[int] = frozenset()
    turn: float = 0.0  # deg
    scales: list[float] = field(default_factory=lambda: [1.0] * 3)
    maps: dict[str, AffineMap] = field(default_factory=dict)
    tip_led: bool = False  # M128, TCPM
    waits: bool = False  # the plane is there, and the rotary axes wait for a block that turns them (STAY)
    posture: Posture | None = None  # of the plane in force

    def put(self, name: str, made: AffineMap, again: bool = False) -> None:
        """Insert a transformation at its place; behind all others where it is new, or is to be built on them `again`."""
        if made == AffineMap():
            self.maps.pop(name, None)
        else:
            if again:
                self.maps.pop(name, None)
            self.maps[name] = made
        whole = AffineMap()
        for part in self.maps.values():
            whole = whole.then(part)
        self.recorder.set_frame(whole)

    # -- shifts --
    def datum(self, reader: KlartextReader) -> None:
        """Execute cycle 7: X Y Z, absolute from the preset or incremental; # takes a row of a datum table."""
        if reader.accept("#"):
            row = f"row {reader.value('#'):g} of the datum table"
            self.recorder.assume(
                row, "no shift", "a datum shift from a datum table (#) is not understood; write its X Y Z"
            )
            return
        name = INNER if PLANE in self.maps else SHIFT
        shift = self.shifts[name]
        while not reader.is_done:
            axis, incremental, value = self.coordinate(reader, "a datum shift")
            if axis is None:
                continue
            new = shift[axis] + value if incremental else value
            self.after_others(name, new != shift[axis] and new != 0.0)
            shift[axis] = new
        self.put(name, translation(_three(shift)), again=name == SHIFT and self.above(name))

    def coordinate(self, reader: KlartextReader, what: str) -> tuple[int | None, bool, float]:
        """Read X+10 or IX+10: axis (None for one that is passed over), incremental, mm."""
        name = reader.upper()
        letter = name[-1:]
        if name not in (letter, f"I{letter}") or letter not in "XYZABCUVW" or not letter:
            raise reader.fault(f'{what} takes X, Y, Z, found "{name}"')
        reader.at += 1
        value = reader.value(name)
        if letter in AXES:
            return AXES.index(letter), name[0] == "I", value * self.recorder.unit
        if value:
            self.recorder.assume(
                f"the datum of the axis {letter}", "no shift", f'{what} takes X, Y, Z, found "{name}"'
            )
        return None, False, 0.0

    def above(self, name: str) -> bool:
        """Return whether others have been programmed after a transformation."""
        return name in self.maps and list(self.maps)[-1] != name

    def after_others(self, name: str, moved: bool) -> None:
        """Apply a shift along axes that are turned, mirrored or scaled already."""
        if moved and any(k in self.maps for k in (MIRROR, TURN, SCALE)):
            self.recorder.assume(
                "a datum shift after rotation, mirror or scaling",
                "along the axes as they are then", _AFTER,
            )  # fmt: skip

    # -- rotation, mirror, scale --
    def mirror(self, reader: KlartextReader) -> None:
        """Execute cycle 8: the axes that are mirrored; none ends it."""
        axes = reader.rest().upper().replace(",", "")
        if any(a not in AXES for a in axes):
            raise reader.fault(f"a mirror image takes X, Y, Z, got {axes}")
        self.together(bool(axes), TURN)
        self.mirror_axes = frozenset(AXES.index(a) for a in axes)
        self.put(MIRROR, stretch(_three([-1.0 if k in self.mirror_axes else 1.0 for k in range(3)])))

    def together(self, wanted: bool, other: str) -> None:
        """Mirror and rotation: the one programmed later lies inside the other."""
        if wanted and other in self.maps:
            what = "mirror and rotation together"
            self.recorder.assume(
                what, "the later one inside the other", f"{what} are not understood; use one of them"
            )

    def rotate(self, reader: KlartextReader) -> None:
        """Execute cycle 10: ROT, absolute or incremental, deg."""
        incremental = reader.accept("IROT")
        if not incremental:
            reader.expect("ROT", "of the rotation, as in CYCL DEF 10.1 ROT+35")
        value = reader.value("ROT")
        self.turn_by(self.turn + value if incremental else value)

    def turn_by(self, angle: float) -> None:
        """Turn by an angle, deg, in the plane in force."""
        self.together(angle != 0.0, MIRROR)
        self.turn = angle
        self.put(TURN, rotation(PLANES[self.recorder.plane][2], math.radians(angle)))

    def enlarge(self, reader: KlartextReader) -> None:
        """Execute cycle 11: SCL."""
        reader.expect("SCL", "of the scaling, as in CYCL DEF 11.1 SCL 0.99")
        value = reader.value("SCL")
        self.scale(reader, [value] * 3)

    def scale(self, reader: KlartextReader, factors: Sequence[float]) -> None:
        if any(f <= 0 for f in factors):
            raise reader.fault("SCL must be above zero")
        self.scales = list(factors)
        self.put(SCALE, stretch(_three(self.scales)))

    def stretch(self, reader: KlartextReader) -> None:
        """Execute cycle 26: factors of single axes, X0.99; CCX, CCY: the point that stays."""
        factors, centre = [1.0] * 3, [0.0] * 3
        while not reader.is_done:
            name = reader.upper()
            reader.at += 1
            value = reader.value(name)
            if name in tuple(AXES):
                factors[AXES.index(name)] = value
            elif name[:2] == "CC" and name[2:] in tuple(AXES):
                centre[AXES.index(name[2:])] = value * self.recorder.unit
            else:
                raise reader.fault(f'cycle 26 takes X, Y, Z and CCX, CCY, found "{name}"')
        self.scale(reader, factors)
        stays = _three([c * (1.0 - f) for c, f in zip(centre, factors)])
        self.put(SCALE, translation(stays).then(stretch(_three(factors))))

    # -- presets --
    def preset(self, number: int) -> None:
        """Execute cycle 247: preset 1 is G54 of the set-up, 2 is G55 ...; shift, mirror, rotation and scale end with it."""
        if not 1 <= number <= 6:
            self.recorder.assume(
                f"preset {number}", "machine zero",
                f"preset {number} has no work offset in the set-up; presets 1 to 6 are G54 to G59 there",
            )  # fmt: skip
        for name in (SHIFT, MIRROR, TURN, SCALE):
            self.maps.pop(name, None)
        self.shifts[SHIFT], self.mirror_axes, self.turn, self.scales = [0.0] * 3, frozenset(), 0.0, [1.0] * 3
        self.put(SHIFT, AffineMap())
        if 1 <= number <= 6:
            self.recorder.set_offset(f"G{53 + number}")
            return
        self.recorder.free("the work offset changes")
        self.recorder.select(f"preset {number}")
        self.recorder.refresh()

    # -- tilted planes --
    def tilt(self, made: AffineMap, posture: Posture | None = None, *, stays: bool = False) -> None:
        """Tilt by PLANE or cycle 19: the plane in which X and Y now lie; none ends it, and the shift inside it. stays: the rotary axes keep
        their angles until a block turns them; the tip is led over the plane all the same, the control knows where they stand."""
        is_plane = made != AffineMap()
        if not is_plane:
            self.maps.pop(INNER, None)
            self.shifts[INNER] = [0.0] * 3
        self.waits, self.posture = is_plane and stays, posture
        self.recorder.is_plane_tilted = is_plane and not stays
        self.recorder.is_tcp_on = self.tip_led or self.waits
        self.put(PLANE, made)
        self.recorder.posture = posture if is_plane else None

    def settle(self) -> None:
        """Execute the block behind PLANE ... STAY that turns the rotary axes to the angles of the plane (Q120 to Q122)."""
        self.waits, self.recorder.is_plane_tilted, self.recorder.is_tcp_on = False, True, self.tip_led

    def lead(self, on: bool) -> None:
        """Begin or end M128, TCPM."""
        self.tip_led = on
        self.recorder.is_tcp_on = on or self.waits


def turned_about(a: float, b: float, c: float) -> AffineMap:
    """Return the spatial angles, deg: about the X, then Y, then Z axis, which are fixed; R = Rz(c) Ry(b) Rx(a)."""
    made = AffineMap()
    for axis, angle in ((2, c), (1, b), (0, a)):
        made = made.then(rotation(axis, math.radians(angle)))
    return made


def _three(values: Sequence[float]) -> Point:
    return values[0], values[1], values[2]
