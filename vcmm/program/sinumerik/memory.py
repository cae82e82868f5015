"""State of a Sinumerik program: R parameters, variables of all types, arrays, system variables.

Source: Siemens, SINUMERIK 840D sl / 828D, Programming Manual Job Planning, "Flexible NC programming"; List Manual System Variables.
What only the machine or the caller knows (machine data, inputs, global user data) is taken as zero, with a remark.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from vcmm.core.errors import did_you_mean
from vcmm.program.expressions import evaluate
from vcmm.program.faults import BlockFault
from vcmm.program.frames import AffineMap, plane_of_axes, rotation, stretch, translation
from vcmm.program.moves import ORIGIN, PLANES
from vcmm.program.recorder import Recorder

AXES = "XYZ"
FRAME_FUNCTIONS = ("CTRANS", "CROT", "CROTS", "CSCALE", "CMIRROR")
TEXTS = ("STRING", "AXIS", "CHAR")
OUTSIDE = "an array or one of the system variables, which are not understood; use R parameters, or take the line out where it sets data of the machine"
ARITHMETIC: Mapping[str, Callable[[Any], float]] = {
    "STRLEN": lambda s: float(len(str(s))), "NUMBER": lambda s: float(str(s)), "ISNUMBER": lambda s: float(_is_number(str(s))),
    "ISAXIS": lambda n: float(1 <= (n or 0) <= 3),
}  # fmt: skip
TEXT_FUNCTIONS: Mapping[str, Callable[[Any], str]] = {
    "AXNAME": lambda s: str(s).upper(), "AXSTRING": str, "TOUPPER": lambda s: str(s).upper(), "TOLOWER": lambda s: str(s).lower(),
}  # fmt: skip
MEASURING = frozenset(  # global user data of the measuring cycles, which a program sets before a call
    [
        "_MVAR",
        "_SETVAL",
        "_SETV",
        "_MA",
        "_MD",
        "_FA",
        "_TSA",
        "_KNUM",
        "_PRNUM",
        "_NMSP",
        "_VMS",
        "_STA1",
        "_INCA",
        "_ID",
        "_SZA",
        "_SZO",
        "_CPA",
        "_CPO",
        "_RA",
        "_RF",
        "_CORA",
        "_TZL",
        "_TMV",
        "_TUL",
        "_TLL",
        "_TDIF",
        "_K",
        "_EVNUM",
        "_TNUM",
        "_TNAME",
        "_DLNUM",
        "_TENV",
        "_CALNUM",
        "_NUM",
        "_CHBIT",
        "_TP",
        "_WP",
        "_OVR",
        "_OVI",
    ]
)
MODES = {"_OFF": 0.0, "_FINISH": 1.0, "_SEMIFIN": 2.0, "_ROUGH": 3.0}  # of CYCLE832


@dataclass(slots=True)
class Variable:
    """A variable of the program, or an array; kind: REAL, INT, BOOL, CHAR, STRING, AXIS, FRAME. first: what its elements begin with."""

    kind: str
    elements: dict[tuple[Any, ...], Any] = field(default_factory=dict)
    first: Any = None
    many: bool = False

    def store(self, index: tuple[Any, ...], value: Any) -> None:
        """Store a value of that kind."""
        kinds: dict[str, Callable[[float], float]] = {"INT": round, "BOOL": bool}
        if isinstance(value, str | AffineMap):
            self.elements[index] = value
            return
        if value is None:
            value = "" if self.kind in TEXTS else 0.0
        self.elements[index] = value if isinstance(value, str) else float(kinds.get(self.kind, float)(value))

    def value(self, index: tuple[Any, ...]) -> Any:
        """Return the stored value."""
        return self.elements.get(
            index, self.first if self.first is not None else "" if self.kind in TEXTS else 0.0
        )


@dataclass(eq=False)
class SinumerikMemory:
    """scopes: of the program, and of each subprogram under way. sure: no value has been taken that only caller or machine know."""

    recorder: Recorder
    parameters: dict[int, float] = field(default_factory=dict)
    scopes: list[dict[str, Variable]] = field(default_factory=lambda: [{}])
    sure: bool = True
    has_contact: bool = False  # whether the last measuring move met anything

    def guess(self, what: str, value: str, otherwise: str, column: int = 0) -> None:
        """Return a value that only the machine or the caller knows."""
        self.recorder.assume(what, value, otherwise, column=column or None)
        self.sure = False
        self.recorder.states.machine_value = what

    # -- reading --
    def parameter(self, index: int) -> float:
        if index not in self.parameters:
            if self.recorder.setup.strict:
                self.recorder.remark(f"R{index} is used before it is set; 0 is taken")
            else:
                self.guess(f"the value of R{index}", "0", "")
        return self.parameters.get(index, 0.0)

    def variable(self, name: str, column: int) -> Any:
        entry = self._variable(name)
        if entry is not None:
            return entry.value(())
        if name.startswith("$"):
            return self.system(name, (), column)
        if name in MODES:
            return MODES[name]
        names = [*self.scopes[-1], *self.scopes[0]]
        self.guess(
            f"the variable {name}, which is not the program's own", "0",
            f"the variable {name} is not defined; add DEF REAL {name} at the start of the program.{did_you_mean(name, names)}", column,
        )  # fmt: skip
        return 0.0

    def element(self, name: str, index: tuple[Any, ...], column: int) -> Any:
        """Return an element: FIELD[2], $AA_IM[X]."""
        entry = self._variable(name)
        if entry is not None:
            return entry.value(index)
        if name.startswith("$"):
            return self.system(name, index, column)
        self.guess(
            f"the variable {name}[...], which is not the program's own",
            "0",
            f"{name}[...] is {OUTSIDE}",
            column,
        )
        return 0.0

    def _variable(self, name: str) -> Variable | None:
        return self.scopes[-1].get(name) or self.scopes[0].get(name)

    def is_defined(self, name: str) -> bool:
        return name in self.scopes[-1] or name in self.scopes[0]

    def function(self, name: str, arguments: list[Any], column: int, message: str) -> Any:
        """Evaluate functions of texts and axes; others are the machine's."""
        if arguments and name in ARITHMETIC:
            try:
                return ARITHMETIC[name](arguments[0])
            except ValueError:
                raise BlockFault(column, f'"{arguments[0]}" is no number') from None
        if arguments and name in TEXT_FUNCTIONS:
            return TEXT_FUNCTIONS[name](arguments[0])
        if name in FRAME_FUNCTIONS:
            return self.frame(name, arguments, column)
        if self.recorder.setup.strict:
            raise BlockFault(column, message)
        self.guess(f"the function {name}", "0", "", column)
        return 0.0

    def frame(self, name: str, arguments: list[Any], column: int) -> AffineMap:
        """Return the frame of CTRANS(X,10,Y,5), CROT(Z,30), CROTS(X,20,Y,10), CSCALE(X,2), CMIRROR(X): a frame as a value."""
        unit, made = self.recorder.unit, AffineMap()
        values = {
            str(a).upper(): 0.0 if b is None or isinstance(b, str) else float(b)
            for a, b in zip(arguments, [*arguments[1:], 0.0])
        }
        x, y, z = (values.get(a) for a in AXES)
        if name == "CTRANS":
            return translation(((x or 0.0) * unit, (y or 0.0) * unit, (z or 0.0) * unit))
        named = [k for k, axis in enumerate(AXES) if axis in values]
        if name == "CROTS" and len(named) > 1:
            tilted = plane_of_axes(named, (x, y, z))
            if tilted is None:
                raise BlockFault(
                    column, "CROTS takes two solid angles that make a plane, as in CROTS(X,20,Y,10)"
                )
            return tilted
        if name in ("CROT", "CROTS"):
            for axis, angle in ((2, z), (1, y), (0, x)):
                made = made.then(rotation(axis, math.radians(angle or 0.0)))
            return made
        still = -1.0 if name == "CMIRROR" else None
        return stretch(tuple(1.0 if v is None else still or v or 1.0 for v in (x, y, z)))  # type: ignore[arg-type]

    # -- system variables --
    def system(self, name: str, index: tuple[Any, ...], column: int) -> Any:
        """Return a system variable: a value that follows from the program, else zero."""
        r = self.recorder
        plane = PLANES[r.plane]
        if name in ("$P_AXN1", "$P_AXN2", "$P_AXN3"):
            return AXES[plane[int(name[-1]) - 1]]
        axis = AXES.find(str(index[-1]).upper()) if index else -1
        if axis >= 0 and name in ("$P_EP", "$AA_IW", "$AA_IM", "$P_EPM"):
            return (r.q if name == "$AA_IM" else r.p)[axis] / r.unit
        if name == "$P_UIFR" and len(index) == 3 and index[2] in ("TR", "FI", "RT"):
            return self.offset_read(round(index[0]), str(index[1]).upper(), str(index[2]))
        if r.skip is not None and axis >= 0 and name in ("$AA_MW", "$AA_MM"):
            return (r.skip if name == "$AA_MW" else r.skip_axes)[axis] / r.unit
        if r.skip is not None and name == "$AC_MEA":
            return float(self.has_contact)
        simple: Mapping[str, float | None] = {
            "$P_TOOLNO": float(r.tool), "$P_TOOL": float(bool(r.tool)), "$P_F": r.feed, "$P_TOOLR": r.tool_data.radius,
            "$P_SEARCH": 0.0, "$P_SIM": 0.0, "$P_DRYRUN": 0.0, "$P_SUBPAR": 1.0,
        }  # fmt: skip
        value = simple.get(name, self._group(index) if name in ("$P_GG",) else None)
        if value is not None and not r.setup.strict:
            return value
        label = f"{name}[{','.join(_plain(i) for i in index)}]" if index else name
        self.guess(f"the system variable {label}", "0", f"{label} is {OUTSIDE}", column)
        return 0.0

    def _group(self, index: tuple[Any, ...]) -> float | None:
        """Return $P_GG: the active function of a G group: 1 motion, 6 plane, 13 unit, 14 absolute."""
        r, group = self.recorder, round(index[0]) if index else 0
        values: Mapping[int, float | None] = {
            1: {"G0": 1.0, "G1": 2.0, "G2": 3.0, "G3": 4.0}.get(r.motion or "G1"), 6: {"XY": 1.0, "ZX": 2.0, "YZ": 3.0}[r.plane],
            13: 1.0 if r.unit > 1.0 else 2.0, 14: 1.0 if r.absolute else 2.0,
        }  # fmt: skip
        return values.get(group)

    # -- writing --
    def define(self, kind: str, names: Any, variables: Any) -> None:
        """Read DEF."""
        for name, value, sizes in names:
            variable = Variable(kind, many=bool(sizes))
            first = None if value is None else evaluate(value, variables)
            if sizes:
                variable.first = first
            elif first is not None:
                variable.store((), first)
            self.scopes[-1][name] = variable

    def store(self, name: str, index: tuple[Any, ...], value: Any, column: int) -> None:
        """Store a value in a variable of the program, or of the machine."""
        entry = self._variable(name)
        if entry is not None:
            entry.store(index, value)
        elif name in MEASURING:
            self.scopes[0][name] = Variable("STRING" if isinstance(value, str) else "REAL", many=bool(index))
            self.scopes[0][name].store(index, value)
        elif name.startswith("$P_UIFR") and self.work_offset(index, value):
            return
        elif name.startswith("$") or index:
            label = f"{name}[{','.join(_plain(i) for i in index)}]" if index else name
            self.guess(f"the setting of {label}", "passed over", f"{label} is {OUTSIDE}", column)
        else:
            names = [*self.scopes[-1], *self.scopes[0]]
            self.guess(
                f"the variable {name}, which is not the program's own", "0",
                f"the variable {name} is not defined; add DEF REAL {name} at the start of the program.{did_you_mean(name, names)}", column,
            )  # fmt: skip
            self.scopes[0][name] = Variable("REAL", {(): value})

    def work_offset(self, index: tuple[Any, ...], value: Any) -> bool:
        """Set a work offset: $P_UIFR[1,X,TR]=5 or $P_UIFR[1]=CTRANS(X,5) sets G54, 2 G55 ... 5 G505; RT turns about Z. False for unmodelled parts."""
        if len(index) == 1 and isinstance(value, AffineMap):
            return self._whole_offset(
                f"G{53 + round(index[0])}" if 1 <= index[0] <= 4 else f"G{500 + round(index[0])}", value
            )
        axis = AXES.find(str(index[1]).upper()) if len(index) == 3 else -1
        part = index[2] if len(index) == 3 else ""
        if (
            axis < 0
            or not isinstance(value, float | int)
            or part not in ("TR", "FI", "RT")
            or (part == "RT" and axis != 2)
        ):
            return False
        r, number = self.recorder, round(index[0])
        name = f"G{53 + number}" if 1 <= number <= 4 else f"G{500 + number}"
        if part == "RT":
            r.rotations[name] = math.radians(value)
        else:
            point = list(r.offsets.get(name, ORIGIN))
            point[axis] = float(value) * r.unit
            r.offsets[name] = (point[0], point[1], point[2])
        r.refresh()
        return True

    def offset_read(self, number: int, axis: str, part: str) -> float:
        """Return $P_UIFR[1,X,TR]: G54 and so on of the set-up, as the program has left it; in the unit of the program, turns in degrees."""
        r, name = self.recorder, f"G{53 + number}" if 1 <= number <= 4 else f"G{500 + number}"
        if part == "RT":
            return math.degrees(r.rotations.get(name, 0.0)) if axis == "Z" else 0.0
        if part == "FI" or axis not in AXES:
            return 0.0
        return r.offsets.get(name, ORIGIN)[AXES.index(axis)] / r.unit

    def _whole_offset(self, name: str, value: AffineMap) -> bool:
        """Return a work offset as a frame: shift, and turn about Z; others are not modelled."""
        r, m = self.recorder, value.matrix
        flat = abs(m[2][2] - 1.0) < 1e-9 and abs(m[0][0] * m[1][1] - m[0][1] * m[1][0] - 1.0) < 1e-9
        if flat:
            r.offsets[name], r.rotations[name] = value.shift, math.atan2(m[1][0], m[0][0])
            r.refresh()
        return flat


def _plain(value: Any) -> str:
    return value if isinstance(value, str) else f"{value or 0:g}"


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
