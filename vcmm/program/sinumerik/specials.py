"""Blocks of Sinumerik that are no motion of a contour: dwells, frames, poles, reference points."""

from __future__ import annotations

import math

from vcmm.program.frames import UNITY, AffineMap, plane_of_axes, rotation, stretch, translation
from vcmm.program.leading import name_axes
from vcmm.program.levels import SetupEntry
from vcmm.program.moves import ORIGIN, PLANES, point_of
from vcmm.program.sinumerik.codes import LATER
from vcmm.program.sinumerik.paths import SinumerikPaths
from vcmm.program.sinumerik.state import AXES, ROTARY, SinumerikWords

FRAMES = ("TRANS", "ATRANS", "ROT", "AROT", "ROTS", "AROTS", "SCALE", "ASCALE", "MIRROR", "AMIRROR")


class SinumerikSpecials(SinumerikPaths):
    """Executes them."""

    # -- blocks that are no motion --
    def special(self, words: SinumerikWords) -> bool:
        if "G4" in words.g:
            self.dwell(words)
            return True
        frames = [c for c in words.commands if c.name in FRAMES]
        if frames:
            words.commands.remove(frames[0])
            self.frame(words, frames[0].name)
            return True
        if "G74" in words.g or "G75" in words.g:
            self.reference(words, "G75" in words.g)
            return True
        if words.g.keys() & {"G110", "G111", "G112"}:
            self.set_pole(words)
            return True
        if words.g.keys() & {"G58", "G59"}:
            self.shift(words, "G59" in words.g)
            return True
        if words.g.keys() & {"G25", "G26"}:
            words.items.clear()  # limits of spindle and working area
        return False

    def shift(self, words: SinumerikWords, is_fine: bool) -> None:
        """Shift by G58, G59: the shift of the programmed frame in the axes that are named. G58 sets the part of TRANS and leaves that of G59 and
        ATRANS, G59 the other way round (Siemens, Programming Manual Fundamentals, "Programmable work offset (G58, G59)")."""
        m, fine = self.modes.frame, list(self.modes.fine)
        shift = list(m.shift)
        for k, name in enumerate(AXES):
            value = words.take(name)
            if value is not None:
                coarse = shift[k] - fine[k] if is_fine else value * self.r.unit
                fine[k] = value * self.r.unit if is_fine else fine[k]
                shift[k] = coarse + fine[k]
        self.modes.fine = point_of(fine)
        self.frames(AffineMap(m.matrix, point_of(shift)))

    def dwell(self, words: SinumerikWords) -> None:
        if words.has("F"):
            self.r.dwell(words.take("F") or 0.0)
        elif words.has("S"):
            turns = words.take("S") or 0.0
            if not self.r.speed:
                self.r.fault("G4 S counts turns of the spindle, which has no speed; give G4 F in seconds")
            self.r.dwell(turns * 60.0 / self.r.speed)
        else:
            self.r.fault("G4 takes F (seconds) or S (turns of the spindle), as in G4 F1.5")

    def reference(self, words: SinumerikWords, fixed: bool) -> None:
        """Execute G74 X1=0: the named axes go to their reference point; G75: to a fixed point of the machine, which is taken to be there."""
        axes = [
            k for k in range(3) if words.take(AXES[k]) is not None or words.take(f"{AXES[k]}1") is not None
        ]
        for name in (*ROTARY, "FP", *(f"{a}1" for a in ROTARY)):
            words.items.pop(name, None)
        if fixed:
            self.r.assume(
                "the fixed point of the machine (G75)", "the reference point",
                f"G75 (fixed point of the machine){LATER}", column=self.column, blank=SetupEntry("", "reference", '["0 mm", "0 mm", "0 mm"]'),
            )  # fmt: skip
        if not axes:
            return
        name_axes(self.r, "".join(AXES[k] for k in axes))
        o, home, tip = self.r.tool_offset, self.r.setup.reference, self.r.tip()
        target = [home[k] - o[k] if k in axes else tip[k] for k in range(3)]
        self.r.to_machine((target[0], target[1], target[2]), rapid=True)

    def frame(self, words: SinumerikWords, name: str) -> None:
        base = self.modes.frame if name.startswith("A") else AffineMap()
        kind = name.removeprefix("A") if name.startswith("A") else name
        values = [words.take(a) for a in AXES]
        if kind == "TRANS":
            self.turn_shift(words, name)
            made = translation(point_of([(v or 0.0) * self.r.unit for v in values]))
        elif kind == "ROT":
            made = self.rotation(words, values)
        elif kind == "ROTS":
            made = self.solid_rotation(words, values, name)
        elif kind == "SCALE":
            if any(v is not None and v <= 0 for v in values):
                self.r.fault(f"{name} takes factors above zero; MIRROR mirrors")
            made = stretch(point_of([1.0 if v is None else v for v in values]))
        else:
            made = stretch(point_of([1.0 if v is None else -1.0 for v in values]))
        if not name.startswith("A"):
            self.modes.fine = ORIGIN
        elif kind == "TRANS" and base.matrix == UNITY:
            self.modes.fine = point_of([a + b for a, b in zip(self.modes.fine, made.shift)])
        self.frames(base.then(made))

    def turn_shift(self, words: SinumerikWords, name: str) -> None:
        """Shift by TRANS B=10: rotary axes are shifted too."""
        before = self.modes.turns if name == "ATRANS" else ORIGIN
        values = [words.take(a) for a in ROTARY]
        self.modes.turns = point_of([b + math.radians(v or 0.0) for b, v in zip(before, values)])

    def solid_rotation(self, words: SinumerikWords, values: list[float | None], name: str) -> AffineMap:
        """Return the rotation of ROTS, AROTS: two solid angles; one alone, or RPL=, turns as ROT does."""
        named = [k for k in range(3) if values[k] is not None]
        if len(named) < 2:
            return self.rotation(words, values)
        made = plane_of_axes(named, values)
        if made is None:
            self.r.fault(
                f"{name} takes two solid angles that make a plane, as in {name} X20 Y10; a third one is one too many"
            )
        return made

    def rotation(self, words: SinumerikWords, values: list[float | None]) -> AffineMap:
        """Return the rotation of RPL= in the plane, or X Y Z in the order of RPY angles: about Z, the new Y, the new X."""
        angle = words.take("RPL")
        if angle is not None:
            return rotation(PLANES[self.r.plane][2], math.radians(angle))
        made = AffineMap()
        for axis in (2, 1, 0):
            made = made.then(rotation(axis, math.radians(values[axis] or 0.0)))
        return made
