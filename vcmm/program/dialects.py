"""Dialects as data: what a control understands, and how it reads numbers. The registry is open to other front-ends.

A dialect of the G-code family is a `Dialect` value and is read by vcmm.program.iso. Any other language registers a
function text -> Program with `register`. Readers are named, and imported when the first program of theirs is read.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from vcmm.core.errors import UsageError, choose_from

if TYPE_CHECKING:
    from vcmm.program.moves import Program
    from vcmm.program.setup import Setup

FrontEnd = Callable[[str, str, "Setup"], "Program"]  # text, name of the file for messages, set-up


@dataclass(frozen=True)
class Dialect:
    """One member of the G-code family.

    decimal_point: "calculator" (X10 is 10 mm) or "increment" (X10 without a point is 10 increments).
    dwell: seconds per unit of P in G4 and cycles. words: "o" O-words and named parameters, "macro" Fanuc macro B.
    unused_words: treatment of a word that no code of its block uses: "refuse" or "remark".
    codes: name of the table of G codes (vcmm.program.iso.groups). survey: the level (vcmm.program.levels), from the set-up.
    cycles_apart: drilling cycles are a modal group of their own: G0 G80 in one block, and G80 leaves G0 or G1 in force.
    system: of the G codes of a lathe, A, B or C. everything_home: G28 without axes sends all of them.
    length_follows: a block with G43 and an axis word counts increments from the programmed point (Fanuc), not from the
    position of the new tool (LinuxCNC).
    """

    name: str
    words: str
    unit_codes: Mapping[str, float]
    decimal_point: str = "calculator"
    increment: tuple[float, float] = (0.001, 0.0001)  # mm, inch
    dwell: float = 1.0
    nested_comments: bool = False
    semicolon_comment: bool = True
    sharing: bool = False  # G28 and a motion code in one block
    arc_centre: str = "incremental"
    absolute: bool = True  # G90 is in force when the control wakes up
    unused_words: str = "refuse"
    needs_end: bool = True
    default_motion: str | None = None
    length_follows: bool = False
    lathe: bool = False
    codes: str = ""
    survey: bool = False
    cycles_apart: bool = False
    system: str = "A"
    everything_home: bool = False
    peck_clearance: float = 0.254  # mm; G73 retract and G83 re-entry distance
    fix_is_floor: bool = True
    part_spindles: Mapping[str, int] = field(
        default_factory=dict
    )  # codes after which another spindle holds the part
    pockets: tuple[
        Callable[[Any, Any], None], ...
    ] = ()  # milling cycles of a text by Q of G287, with the control and the hole

    @property
    def haas(self) -> bool:
        """Whether it is one of Haas."""
        return self.name.startswith("haas")


_INCH = {"G20": 25.4, "G21": 1.0}
LINUXCNC = Dialect("linuxcnc", "o", _INCH, everything_home=True)
GRBL = replace(
    LINUXCNC, name="grbl", nested_comments=True, unused_words="remark", needs_end=False, default_motion="G0", cycles_apart=True
)  # fmt: skip
MACH3 = replace(GRBL, name="mach3", codes="mach3", unit_codes=_INCH | {"G70": 25.4, "G71": 1.0})
FANUC = Dialect(
    "fanuc", "macro", _INCH | {"G70": 25.4, "G71": 1.0}, dwell=0.001, nested_comments=True,
    semicolon_comment=False, sharing=True, unused_words="remark", needs_end=False, default_motion="G0",
    length_follows=True, peck_clearance=0.5, fix_is_floor=False, cycles_apart=True,
)  # fmt: skip
HAAS = replace(FANUC, name="haas", codes="haas", unit_codes=_INCH, everything_home=True)
MAZAK = replace(FANUC, name="mazak", unit_codes=_INCH)
FANUC_LATHE = replace(FANUC, name="fanuc-lathe", codes="lathe", unit_codes=_INCH, lathe=True)
FANUC_LATHE_B = replace(FANUC_LATHE, name="fanuc-lathe-b", codes="lathe-b", system="B")
HAAS_LATHE = replace(FANUC_LATHE, name="haas-lathe", everything_home=True, part_spindles={"G14": 2, "G15": 1})
_FAMILY = (FANUC, LINUXCNC, FANUC_LATHE, FANUC_LATHE_B, HAAS, HAAS_LATHE, MAZAK, MACH3, GRBL)
G_CODE: dict[str, Dialect] = {d.name: d for d in _FAMILY}
FRONT_ENDS: dict[str, FrontEnd] = {}
TRACE_READERS: dict[str, FrontEnd] = {}  # the same with Program.traces and Program.steps
EXTENSIONS: dict[str, str] = {"ngc": "linuxcnc"}
G_CODE_READER = "vcmm.program.iso.program"


def register(
    name: str, front_end: FrontEnd, extensions: tuple[str, ...] = (), traced: FrontEnd | None = None
) -> None:
    """Add a language that is no member of the G-code family: a function (text, file name, set-up) -> Program.

    traced: the same with traces, for languages whose programs can be rewritten.
    """
    FRONT_ENDS[name] = front_end
    if traced is not None:
        TRACE_READERS[name] = traced
    EXTENSIONS.update(dict.fromkeys(extensions, name))


def late(module: str, function: str) -> Callable[..., Any]:
    """Return a function of a module that is imported now, and not before."""
    return getattr(importlib.import_module(module), function)


def _reader(module: str, trace: bool) -> FrontEnd:
    """Return `read` of a module, which is imported when the first program is read."""
    return lambda text, name, setup: late(module, "read")(text, name, setup, trace)


for _name, _module, _extensions in (
    ("sinumerik", "vcmm.program.sinumerik.reader", ("mpf", "spf")),
    ("heidenhain", "vcmm.program.heidenhain.reader", ("h",)),
):
    register(_name, _reader(_module, False), _extensions, _reader(_module, True))
register("okuma", _reader("vcmm.program.okuma.reader", False), ("min", "ssb"))
register("fagor", _reader("vcmm.program.fagor.reader", False), ("pim",))


def names() -> list[str]:
    """Return all dialects that can be read."""
    return [*G_CODE, *FRONT_ENDS]


def check_name(name: str) -> str:
    """Return the name. Raises UsageError with the closest one."""
    if name not in G_CODE and name not in FRONT_ENDS:
        raise UsageError(f'unknown dialect "{name}".{choose_from(name, names())}')
    return name
