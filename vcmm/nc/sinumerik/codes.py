"""G functions and named functions of Sinumerik that change the state, and those that are refused by name."""

from __future__ import annotations

from collections.abc import Callable
from typing import NoReturn

from vcmm.nc.radius import SINUMERIK, Style
from vcmm.nc.sinumerik.state import SinumerikControl

MITRE = Style("perpendicular", "lines")  # G451
IDLE = frozenset(
    [
        "SOFT",
        "BRISK",
        "BRISKA",
        "SOFTA",
        "DRIVE",
        "FFWON",
        "FFWOF",
        "STOPRE",
        "NORM",
        "CDOF",
        "CDOF2",
        "COMPOF",
        "TRAFOOF",
        "WALIMON",
        "WALIMOF",
        "CFC",
        "CFTCP",
        "CFIN",
        "DYNNORM",
        "DYNROUGH",
        "DYNSEMIFIN",
        "DYNFINISH",
        "DYNPOS",
        "FIFOCTRL",
        "STARTFIFO",
        "STOPFIFO",
        "FENDNORM",
        "SBLOF",
        "SBLON",
        "DISPLOF",
        "DISPLON",
        "RTLION",
        "RTLIOF",
        "UPATH",
        "SPATH",
        "ORIWKS",
        "ORIMKS",
        "MSG",
        "WORKPIECE",
        "GROUP_BEGIN",
        "GROUP_END",
        "CPRECOF",
        "CPRECON",
        "FNORM",
    ]
)  # they change no path here
IDLE_G = frozenset(("G601", "G602", "G603", "G290", "G460", "G148"))
LATER = " is not understood; docs/nc_sinumerik_heidenhain.md lists what is, rewrite it with G0 to G3"


def _set(**values: object) -> Callable[[SinumerikControl], None]:
    def change(i: SinumerikControl) -> None:
        for name, value in values.items():
            setattr(i.modes if hasattr(i.modes, name) else i.r, name, value)

    return change


def _plane(name: str) -> Callable[[SinumerikControl], None]:
    def change(i: SinumerikControl) -> None:
        if name != i.r.plane:
            i.r.free("the plane changes")
            i.r.plane = name
            if i.r.tool_offset[2] and i.r.tool_data.shape != "turning":
                i.r.remark(
                    "the tool length stays along Z in every plane, as with setting data $SC_TOOL_LENGTH_CONST = 17"
                )

    return change


def _side(side: str | None) -> Callable[[SinumerikControl], None]:
    def change(i: SinumerikControl) -> None:
        i.r.compensate(side, i.modes.style)

    return change


def _spindle(feed_mode: str) -> Callable[[SinumerikControl], None]:
    """Ends constant surface speed (G94, G95 and G97 all do); the speed that it has set last is kept."""

    def change(i: SinumerikControl) -> None:
        i.r.feed_mode = feed_mode
        if i.r.surface:
            i.r.surface = False
            i.r.speed = abs(i.r.moves[-1].spindle) if i.r.moves else 0.0

    return change


def _refuse(text: str) -> Callable[[SinumerikControl], NoReturn]:
    def change(i: SinumerikControl) -> NoReturn:
        i.r.fault(f"{text}{LATER}", i.column)

    return change


CODES: dict[str, Callable[[SinumerikControl], None]] = {
    "G0": _set(motion="G0"), "G1": _set(motion="G1"), "G2": _set(motion="G2"), "G3": _set(motion="G3"),
    "G17": _plane("XY"), "G18": _plane("ZX"), "G19": _plane("YZ"),
    "G70": _set(unit=25.4, feed_unit=1.0), "G71": _set(unit=1.0, feed_unit=1.0),
    "G700": _set(unit=25.4, feed_unit=25.4), "G710": _set(unit=1.0, feed_unit=1.0),
    "G90": _set(absolute=True), "G91": _set(absolute=False),
    "G40": _side(None), "G41": _side("left"), "G42": _side("right"),
    "G450": _set(style=SINUMERIK), "G451": _set(style=MITRE),
    "G9": _set(exact_once=True), "G60": _set(exact_stop=True),
    **{f"G{n}": _set(exact_stop=False) for n in (64, 641, 642, 643, 644, 645)},
    "G93": _set(feed_mode="G93"), "G94": _spindle("G94"), "G95": _spindle("G95"),
    "G96": _set(feed_mode="G95", surface=True), "G961": _set(feed_mode="G94", surface=True),
    "G97": _spindle("G95"), "G971": _spindle("G94"),
    **{f"G{n}": _refuse(f"G{n} (thread cutting or tapping)") for n in (33, 34, 35, 63, 331, 332)},
    **{f"G{n}": _refuse(f"G{n} (smooth approach and retraction)") for n in (147, 247, 248, 347, 348)},
    **{f"G{n}": _refuse(f"G{n} (polar coordinates)") for n in (110, 111, 112)},
    "G75": _refuse("G75 (fixed point of the machine)"), "G291": _refuse("G291 (ISO dialect)"),
}  # fmt: skip
SWITCHES: dict[str, Callable[[SinumerikControl], None]] = {
    "CIP": _set(motion="CIP"), "DIAMON": _set(diameter="always"), "DIAM90": _set(diameter="absolute"), "DIAMOF": _set(diameter=""),
    **{n: _refuse(f"{n} (spline)") for n in ("ASPLINE", "BSPLINE", "CSPLINE")},
    "POLY": _refuse("POLY (polynomial)"), "CT": _refuse("CT (tangential circle)"), "TRAORI": _refuse("TRAORI (5-axis transformation)"),
    "TRANSMIT": _refuse("TRANSMIT (face machining with C)"), "TRACYL": _refuse("TRACYL (cylinder transformation)"),
    "CDON": _refuse("CDON (look-ahead for bottlenecks)"), "KONT": _refuse("KONT (approach around the contour)"),
    "KONTC": _refuse("KONTC"), "KONTT": _refuse("KONTT"), "CUTCONON": _refuse("CUTCONON"),
}  # fmt: skip
