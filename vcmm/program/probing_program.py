"""Probing programs for four controls: touches of spheres along X, Y and Z at several rotary positions, each printed to a log.

    fanuc, haas   G65 P9810 (protected move), G65 P9811 (one surface); DPRNT of #135 to #137, on Haas #185 to #187
                  (Renishaw Inspection Plus, programming manuals for Fanuc H-2000-6061 and for Haas)
    sinumerik     CYCLE978 (one surface along an axis), _OVR[4] the actual value; WRITE into a file of the control
                  (Siemens, SINUMERIK 840D sl / 828D, Programming Manual Measuring Cycles 09/2011)
    heidenhain    TCH PROBE 427 (one coordinate), Q160 the measured value; FN 16: F-PRINT with a mask
                  (HEIDENHAIN, TNC 640 User's Manual, Measuring Cycles)

X Y Z of a program are those of its work offset. The length of the probe counts to the lowest point of its ball, as macros calibrate it, so
the middle of the ball is one radius higher than Z. Every touch prints the line of vcmm.files.foreign.touch_log, format "touches"; values
that the control does not measure are printed as commanded, of the middle of the ball.
Where a head turns, X Y Z are those of the axes, as if it were at zero: modes that follow the tip (G43.4, TRAORI, M128) are ended first.
Between two touches the probe goes over `clear`; rotary axes turn only up there. Collisions are not looked for.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from vcmm.core.errors import UsageError, choose_from

CONTROLS = ("fanuc", "haas", "sinumerik", "heidenhain")
RESULTS = {"fanuc": 135, "haas": 185}  # macro variable of the measured X; Y and Z follow
ENDINGS = {"fanuc": "nc", "haas": "nc", "sinumerik": "mpf", "heidenhain": "h"}
LOG = "TOUCH.LOG"
FEED = 2000  # mm/min between touches


@dataclass(frozen=True)
class PlannedTouch:
    """feature: its number. surface (3,): where it is met, mm, work offset, along one axis. way (3,): -1, 0, 1. rotary: letter -> deg.

    spindle: its orientation, deg.
    """

    feature: int
    surface: tuple[float, float, float]
    way: tuple[int, int, int]
    rotary: Mapping[str, float]
    spindle: float = 0.0

    @property
    def axis(self) -> int:
        """0, 1, 2."""
        return next(i for i, w in enumerate(self.way) if w)

    @property
    def sense(self) -> int:
        return self.way[self.axis]


@dataclass(frozen=True)
class ProbingJob:
    """clear: Z of the work offset at which rotary axes may turn; standoff: mm before the surface from where a touch begins; ball: its radius, mm.

    tool: number of the probe; leads_tip: a head turns, so that the control could follow the tip of the tool, which the program ends first; orients: whether the
    spindle is turned for the touches.
    """

    touches: tuple[PlannedTouch, ...]
    clear: float
    standoff: float
    ball: float
    tool: int = 20
    offset: str = "G54"
    name: str = "TOUCH"
    leads_tip: bool = False

    @property
    def orients(self) -> bool:
        return len({t.spindle for t in self.touches}) > 1 or any(t.spindle for t in self.touches)

    def start(self, touch: PlannedTouch) -> tuple[float, float, float]:
        """Return X Y Z of the program, of the lowest point of the ball, at the start of the touch."""
        away = [s - w * (self.standoff + self.ball) for s, w in zip(touch.surface, touch.way)]
        return away[0], away[1], away[2] - self.ball


def probing_texts(job: ProbingJob, control: str) -> dict[str, str]:
    """Return the file name -> text of the program, of HEIDENHAIN with the mask of its print. Raises UsageError for a control that is not written."""
    writers = {"fanuc": _iso, "haas": _iso, "sinumerik": _sinumerik, "heidenhain": _heidenhain}
    if control not in writers:
        raise UsageError(f'--control "{control}" is not written.{choose_from(control, CONTROLS)}')
    body = writers[control](job, control)
    texts = {f"{job.name}.{ENDINGS[control]}": "\n".join(body) + "\n"}
    if control == "heidenhain":
        texts[f"{job.name}.a"] = _mask(job)
    return texts


def _number(value: float, digits: int = 4) -> str:
    """Return a number with a decimal point, in the form for controls: 37.5, -5., 0."""
    text = f"{value:.{digits}f}".rstrip("0")
    return "0." if text in ("-0.", "0.") else text


def _visits(job: ProbingJob) -> list[tuple[PlannedTouch, bool, bool]]:
    """Return every touch, with whether the rotary axes turn and whether the spindle turns before it."""
    out, rotary, spindle = [], None, None
    for touch in job.touches:
        turns, orients = dict(touch.rotary) != rotary, job.orients and touch.spindle != spindle
        out.append((touch, turns, orients))
        rotary, spindle = dict(touch.rotary), touch.spindle
    return out


def _words_to_print(job: ProbingJob, touch: PlannedTouch, measured: str, blank: str) -> list[str]:
    """Return the words of the line that a touch prints; measured: the form in which the control prints the value along the axis."""
    words = ["TOUCH", f"F{touch.feature}"]
    words += [f"{letter}{w}" for letter, w in zip("IJK", touch.way)]
    for i, letter in enumerate("XYZ"):
        words.append(measured if i == touch.axis else f"{letter}{_number(touch.surface[i])}")
    words += [f"{a}{_number(q)}" for a, q in touch.rotary.items()]
    return words + ([f"S{_number(touch.spindle)}"] if job.orients else [])


def _iso(job: ProbingJob, control: str) -> list[str]:
    """Return the lines for Fanuc and Haas."""
    first = RESULTS[control]
    lines = ["%", "O9500 (TOUCHES OF SPHERES)", f"G21 G17 G90 G94 {job.offset}", f"T{job.tool} M6"]
    lines += ["G49"] if job.leads_tip else []  # ends G43.4 and G43.5
    lines += [f"G43 H{job.tool} Z{_number(job.clear)}", "G65 P9832", "POPEN"]
    for touch, turns, orients in _visits(job):
        if turns:
            lines += [f"G65 P9810 Z{_number(job.clear)} F{FEED}.", f"G0 {_rotary(touch)}"]
        if orients:
            lines.append(f"M19 {'P' if control == 'haas' else 'R'}{_number(touch.spindle)}")
        x, y, z = (_number(v) for v in job.start(touch))
        letter, expected = "XYZ"[touch.axis], _number(touch.surface[touch.axis])
        reads = f"{letter}#{first + touch.axis}[44]"
        lines += [f"G65 P9810 X{x} Y{y} F{FEED}.", f"G65 P9810 Z{z}", f"G65 P9811 {letter}{expected}"]
        lines += [
            f"DPRNT[{'*'.join(_words_to_print(job, touch, reads, '*'))}]",
            f"G65 P9810 Z{_number(job.clear)}",
        ]
    return [*lines, "PCLOS", "G65 P9833", "M30", "%"]


def _rotary(touch: PlannedTouch) -> str:
    return " ".join(f"{a}{_number(q)}" for a, q in touch.rotary.items())


def _sinumerik(job: ProbingJob, control: str) -> list[str]:
    """Return the lines for Sinumerik: CYCLE978 goes along its axis from the position of the probe; X, Y and Z of the printed line as for
    the others."""
    lines = [
        "; touches of spheres",
        "DEF INT _ERR",
        f"G71 G17 G90 G94 {job.offset}",
        f"T{job.tool}",
        "M6",
        "D1",
    ]
    lines += ["TRAFOOF"] if job.leads_tip else []
    lines.append(f"G0 Z{_number(job.clear)}")
    for touch, turns, orients in _visits(job):
        if turns:
            lines.append(f"G0 {_rotary(touch)}")
        if orients:
            lines.append(f"SPOS={_number(touch.spindle)}")
        x, y, z = (_number(v) for v in job.start(touch))
        expected = _number(touch.surface[touch.axis])
        side = 1 if touch.sense > 0 else 2
        lines += [f"G1 X{x} Y{y} F{FEED}", f"G1 Z{z}"]
        reach, trust = _number(2 * job.standoff), _number(job.standoff)
        lines.append(
            f'CYCLE978(0,0,,1,{expected},{reach},{trust},{touch.axis + 1},{side},1,"",,0,1.01,1.01,-1.01,0.34,1,0,,1,1)'
        )
        words = " ".join(_words_to_print(job, touch, "\0", " ")).split("\0")
        head, tail = words[0] + "XYZ"[touch.axis], words[1]
        lines += [f'WRITE(_ERR,"{LOG}","{head}"<<_OVR[4]<<"{tail}")', f"G1 Z{_number(job.clear)}"]
    return [*lines, "M30"]


def _heidenhain(job: ProbingJob, control: str) -> list[str]:
    """Return the lines for HEIDENHAIN. TCH PROBE 427 goes over the clearance height by itself; Q261 is the height of the middle of the
    ball, of a touch along Z that of the surface."""
    lines = [
        f"BEGIN PGM {job.name} MM",
        f"TOOL CALL {job.tool} Z S0",
        *(["M129"] if job.leads_tip else []),
        f"L Z{job.clear:+.4f} R0 FMAX",
    ]
    if job.offset != "G54":
        raise UsageError("a HEIDENHAIN program works in the preset in force; leave the work offset at G54")
    for touch, turns, orients in _visits(job):
        if turns:
            words = " ".join(f"{a}{q:+.4f}" for a, q in touch.rotary.items())
            lines.append(f"L {words} R0 FMAX")
        if orients:
            lines += ["CYCL DEF 13.0 ORIENTATION", f"CYCL DEF 13.1 ANGLE {touch.spindle:g}", "M19"]
        x, y, z = touch.surface
        lines += [
            "TCH PROBE 427 MEASURE COORDINATE ~", f"  Q263={x:+.4f} ;1ST POINT 1ST AXIS ~", f"  Q264={y:+.4f} ;1ST POINT 2ND AXIS ~",
            f"  Q261={z:+.4f} ;MEASURING HEIGHT ~", f"  Q320={job.standoff:+.4f} ;SET-UP CLEARANCE ~",
            f"  Q272={touch.axis + 1:+d} ;MEASURING AXIS ~", f"  Q267={touch.sense:+d} ;TRAVERSE DIRECTION ~",
            f"  Q260={job.clear:+.4f} ;CLEARANCE HEIGHT ~", "  Q281=+0 ;MEASURING LOG ~", "  Q288=+0 ;MAXIMUM LIMIT ~",
            "  Q289=+0 ;MINIMUM LIMIT ~", "  Q309=+0 ;PGM STOP IF ERROR ~", "  Q330=+0 ;TOOL",
        ]  # fmt: skip
        values = [touch.feature, *touch.way, *touch.surface, *touch.rotary.values()]
        values += [touch.spindle] if job.orients else []
        lines += [f"FN 0: Q{k} = {v:+.4f}" for k, v in enumerate(values, 1) if k != 5 + touch.axis]
        lines += [f"FN 0: Q{5 + touch.axis} = +Q160", f"FN 16: F-PRINT TNC:\\{job.name}.A / TNC:\\{LOG}"]
    return [*lines, f"L Z{job.clear:+.4f} R0 FMAX M30", f"END PGM {job.name} MM"]


def _mask(job: ProbingJob) -> str:
    """Return the mask of FN 16: one line for each touch, appended to the log."""
    letters = [*"FIJKXYZ", *job.touches[0].rotary, *(["S"] if job.orients else [])]
    digits = {"F": "%1.0F", "I": "%2.0F", "J": "%2.0F", "K": "%2.0F"}
    words = " ".join(f"{letter}{digits.get(letter, '%11.4F')}" for letter in letters)
    names = ",".join(f"Q{k}" for k in range(1, len(letters) + 1))
    return f'M_APPEND;\n"TOUCH {words}",{names};\nM_CLOSE;\n'


def turning_height(reach: Sequence[float], above: float) -> float:
    """Return Z (mm) above everything that turns: the farthest reach of it from the centre of the rotary axes, plus `above`."""
    return math.ceil(max(reach) + above)
