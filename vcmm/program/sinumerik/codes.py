"""G functions and named functions of Sinumerik that change the state, and those that are refused by name."""

from __future__ import annotations

from collections.abc import Callable

from vcmm.program.facing import face_begins, face_ends
from vcmm.program.frames import in_plane
from vcmm.program.radius import SINUMERIK, Style
from vcmm.program.sinumerik.state import SinumerikControl

MITRE = Style("perpendicular", "lines")  # G451
IDLE = frozenset(  # they change no path here
    [
        "SOFT",
        "SOFTA",
        "BRISK",
        "BRISKA",
        "DRIVE",
        "DRIVEA",
        "FFWON",
        "FFWOF",
        "STOPRE",
        "NORM",
        "CDOF",
        "CDOF2",
        "COMPOF",
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
        "DYNPREC",
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
        "MSG",
        "WORKPIECE",
        "GROUP_BEGIN",
        "GROUP_END",
        "GROUP_ADDEND",
        "CPRECOF",
        "CPRECON",
        "FNORM",
        "FCUB",
        "FLIN",
        "FPO",
        "CUT2D",
        "CUT2DF",
        "CUT2DFD",
        "CUTCONOF",
        "TOROTOF",
        "PAROTOF",
        "OSC",
        "OSOF",
        "OST",
        "OSS",
        "OSSE",
        "OSD",
        "OTOL",
        "EXTERN",
        "DELDTG",
        "ASPOF",
        "SPOSOF",
        "BNAT",
        "CNAT",
        "BTAN",
        "CTAN",
        "BAUTO",
        "CAUTO",
        "SPCON",
        "SPCOF",
        "FGROUP",
        "FGREF",
        "WAITM",
        "WAITP",
        "WAITS",
        "RELEASE",
        "GET",
        "GETD",
        "INIT",
        "START",
        "SETM",
        "CLEARM",
        "DIACYCOFA",
        "ENS",
        "NEWCONF",
        "SETMS",
        "WRTPR",
        "STRINGIS",
        "STOLF",
        "GWPSON",
        "GWPSOF",
        "ACTBLOCNO",
        "IPTRLOCK",
        "IPTRUNLOCK",
        "LOCK",
        "UNLOCK",
        "ISD",
        "DISABLE",
        "ENABLE",
        "SETINT",
        "CLRINT",
        "WRITE",
        "READ",
        "DELETE",
        "CLEAR",
        *(
            "TANG",
            "TANGDEL",
            "TANGOF",
            "TRAILOF",
            "LEADOF",
            "CTABDEL",
            "SPOF",
            "POLFA",
            "TOFFOF",
        ),  # they define or end
        *("ORISON", "ORISOF", "DIAM90A", "DIACYCOFA", "CUTMODK", "PDELAYON", "PDELAYOF", "PUNCHACC", "OVRA"),
        *(
            "COUPDEF",
            "COUPDEL",
            "COUPRES",
            "COUPON",
            "COUPONC",
            "COUPOF",
            "COUPOFS",
            "WAITC",
            "FPR",
            "FPRAOF",
            "FPRAON",
        ),  # spindles
    ]
)
IDLE_G = frozenset(
    (
        "G601",
        "G602",
        "G603",
        "G290",
        "G460",
        "G461",
        "G462",
        "G148",
        "G8",
        "G62",
        "G621",
        "G810",
        "G811",
        "G25",
        "G26",
    )
)
LINES = "straight lines between its points"
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
        if side is not None and in_plane(i.r.world, i.r.plane) is None:
            what = "radius compensation in a tilted plane"
            i.r.assume(what, "none: the path on the programmed contour", f"{what}{LATER}", column=i.column)
            i.r.compensate(None, i.modes.style)
            return
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


def _assume(
    what: str, value: str, matters: bool = True, **values: object
) -> Callable[[SinumerikControl], None]:
    """Return the action for a function read otherwise than on the control: a remark in a survey, refused in strict reading."""

    def change(i: SinumerikControl) -> None:
        i.r.assume(what, value, f"{what}{LATER}", column=i.column, matters=matters)
        if values:
            _set(**values)(i)

    return change


def _tell(what: str, value: str) -> Callable[[SinumerikControl], None]:
    """What does not change the path over the workpiece: told on both levels."""
    return lambda i: i.r.assume(what, value, column=i.column, matters=False)


def _lead_tip(on: bool) -> Callable[[SinumerikControl], None]:
    """Return the action of TRAORI and its end: the tip is led over the workpiece, the axes follow from the machine."""

    def change(i: SinumerikControl) -> None:
        i.r.is_tcp_on = on
        tell_point_to_point(i)
        if on:
            what = "TRAORI (5-axis transformation)"
            i.r.assume(what, "the points of the tip as programmed", column=i.column, matters=False)
        else:
            i.r.aim = None

    return change


def _point_to_point(on: bool) -> Callable[[SinumerikControl], None]:
    """PTP and CP: under a transformation every axis goes its own way to the end point, and no straight line comes of it."""

    def change(i: SinumerikControl) -> None:
        i.modes.by_axes = on
        tell_point_to_point(i)

    return change


def tell_point_to_point(i: SinumerikControl) -> None:
    """What PTP does where a transformation is on; without one nothing."""
    if i.modes.by_axes and i.r.is_tcp_on:
        what = "PTP (under a transformation the axes go from point to point)"
        i.r.assume(what, LINES, f"{what}{LATER}", column=i.column)


def _face(on: bool) -> Callable[[SinumerikControl], None]:
    """Return the action of TRANSMIT and its end: X and Y over the end face, X and C lead the tip."""

    def change(i: SinumerikControl) -> None:
        if i.modes.face is not None:
            face_ends(i.r, i.modes.face)
            i.modes.face = None
        if on:
            i.modes.face = i.modes.last_face = face_begins(i.r)
        else:
            _lead_tip(False)(i)

    return change


def _cutter_in_space(name: str) -> Callable[[SinumerikControl], None]:
    """Return the radius compensation in space: it does nothing until G41 or G42."""

    def change(i: SinumerikControl) -> None:
        if i.r.compensation is not None:
            what = f"{name} (radius compensation in space)"
            i.r.assume(what, "in the plane", f"{what}{LATER}", column=i.column)

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
    "G33": _set(motion="G33"), "G34": _set(motion="G33"), "G35": _set(motion="G33"), "G331": _set(motion="G331"), "G332": _set(motion="G331"),
    "G63": _set(),
    **{
        f"G{n}": _assume(f"G{n} (smooth approach and retraction)", "straight to its point")
        for n in (147, 247, 347, 148, 248, 348)
    },
    "G291": _assume("G291 (ISO dialect)", "passed over: the words are read as Siemens words"),
    "G5": _assume("G5 (oblique plunge grinding)", "passed over"), "G7": _assume("G7 (oblique plunge grinding)", "passed over"),
}  # fmt: skip
SWITCHES: dict[str, Callable[[SinumerikControl], None]] = {
    "CIP": _set(motion="CIP"), "DIAMON": _set(diameter="always"), "DIAM90": _set(diameter="absolute"), "DIAMOF": _set(diameter=""),
    **{n: _assume(f"{n} (spline)", LINES, motion="G1") for n in ("ASPLINE", "BSPLINE", "CSPLINE")},
    "POLY": _assume("POLY (polynomial)", LINES, motion="G1"), "INVCW": _assume("INVCW (involute)", LINES, motion="G1"),
    "INVCCW": _assume("INVCCW (involute)", LINES, motion="G1"), "CT": _set(motion="CT"),
    "TRAORI": _lead_tip(True), "TRAFOOF": _face(False),
    "TRANSMIT": _face(True),
    "TRACYL": _assume("TRACYL (cylinder transformation)", "the points as programmed"), "TRAANG": _assume("TRAANG (inclined axis)", "the points as programmed"),
    "CDON": _assume("CDON (look-ahead for bottlenecks)", "passed over: only neighbouring blocks meet"),
    "KONT": _assume("KONT (approach around the contour)", "straight, as with NORM"), "KONTC": _assume("KONTC", "straight, as with NORM"),
    "KONTT": _assume("KONTT", "straight, as with NORM"), "CUTCONON": _assume("CUTCONON", "passed over"),
    **{n: _set(sweeps=True) for n in ("ORIWKS", "ORIVECT", "ORIPLANE")}, **{n: _set(sweeps=False) for n in ("ORIMKS", "ORIAXES")},
    **{n: _assume(f"{n} (what A2= B2= C2= mean)", "passed over", matters=False) for n in ("ORIEULER", "ORIRPY", "ORIRPY2", "ORIVIRT1")},
    **{n: _assume(f"{n} (frame along the tool)", "passed over") for n in ("TOFRAME", "TOFRAMEX", "TOFRAMEY", "TOFRAMEZ", "TOROTX", "TOROTY", "TOROTZ")},
    **{n: _assume(f"{n} (a tool holder that can be turned)", "passed over") for n in ("TCARR", "TCOABS", "TCOFR")},
    **{n: _assume(f"{n} (the actual values of axes are set)", "passed over") for n in ("PRESETON", "PRESETONS")},
    "DIAMCHANA": _assume("DIAMCHANA (diameters of a further axis)", "passed over"), "PUTFTOC": _assume("PUTFTOC (fine offset of the tool)", "passed over"),
    **{n: _cutter_in_space(n) for n in ("CUT3DC", "CUT3DF", "CUT3DFS", "CUT3DFF")},
    "OFFN": _assume("OFFN (oversize of the contour)", "none"), "TOROT": _assume("TOROT (frame along the tool)", "passed over"),
    "PAROT": _assume("PAROT (frame along the workpiece)", "passed over"),
    "PTP": _point_to_point(True), "CP": _point_to_point(False),
    **{n: _tell(f"{n} (rapids under a transformation go from point to point)", LINES) for n in ("PTPG0", "PTPWOC")},
    "TANGON": _assume("TANGON (a rotary axis follows the direction of the path)", "that axis stays where it is"),
    "TLIFT": _assume("TLIFT (a block between, where the axis that follows the path turns)", "no block"),
    **{n: _assume(f"{n} (an axis that goes along with another)", "it stays where it is") for n in ("TRAILON", "LEADON", "CTABDEF", "CTABEND", "MASLON")},
    "GEOAX": _assume("GEOAX (other axes become X, Y, Z)", "passed over: X, Y, Z stay"),
    **{n: _assume(f"{n} (punching at the ends of blocks)", "passed over") for n in ("PON", "PONS", "SON", "SONS")},
    **{n: _assume(f"{n} (a path divided into strokes)", "passed over") for n in ("SPN", "SPP")},
    "TOFFON": _assume("TOFFON (an offset of the tool from outside)", "none"), "CUTMOD": _assume("CUTMOD (tool data turned with the tool holder)", "as they are"),
    "WHENEVER": _assume("synchronised actions (WHENEVER, DO ...)", "passed over", matters=False),
}  # fmt: skip
