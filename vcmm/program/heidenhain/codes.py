"""M functions of Klartext beyond spindle, coolant and program run: their effect on the path.

Source: HEIDENHAIN, TNC 640 User's Manual Klartext Programming, "Miscellaneous functions"; iTNC 530 for M90, M92, M104 to M114.
"""

from __future__ import annotations

from collections.abc import Mapping

from vcmm.program.recorder import Recorder

READ = (2, 30, 89, 91, 99)  # where they stand
SHORTEST, LONGEST, TURN_FEED, MINUTE_FEED, TIP, TIP_OFF, RETRACT, NO_ROTATION = (
    126,
    127,
    136,
    137,
    128,
    129,
    140,
    143,
)
IDLE_M = frozenset(
    (0, 1, 6, 7, 8, 9, 10, 11, 19, 25, 26, 27, 40, 41, 42, 43)  # stops, coolant, tool change, clamps, gears
    + (101, 102, 107, 108, 141, 148, 149, 150)  # displays, messages, supervision
)
REST: Mapping[int, tuple[str, str]] = {  # what they do, and how they are read
    90: ("M90 (constant speed at corners)", "passed over: the corners are those of the tolerance"),
    92: ("M92 (coordinates from a datum of the machine builder)", "the machine datum itself, as with M91"),
    94: ("M94 (whole turns taken off a rotary axis)", "passed over: the axis counts on"),
    97: ("M97 (small contour steps)", "passed over: only neighbouring blocks meet"),
    98: ("M98 (open contour corners)", "passed over"),
    103: ("M103 (feed factor for plunging)", "passed over: the feed as programmed"),
    109: ("M109 (feed at the cutting edge in arcs)", "passed over: the feed of the centre of the tool"),
    110: (
        "M110 (feed at the cutting edge in inside arcs)",
        "passed over: the feed of the centre of the tool",
    ),
    111: ("M111 (end of M109)", "passed over"),
    112: ("M112 (transitions of contours)", "passed over: the corners are those of the tolerance"),
    113: ("M113 (end of M112)", "passed over"),
    114: ("M114 (compensation of the machine geometry)", "passed over: points as programmed"),
    115: ("M115 (end of M114)", "passed over"),
    116: ("M116 (feed of rotary axes in mm/min)", "passed over: degrees per minute"),
    117: ("M117 (end of M116)", "passed over"),
    118: ("M118 (handwheel superimposed)", "passed over: no handwheel motion is assumed"),
    120: ("M120 (contour looked ahead)", "passed over: only neighbouring blocks meet"),
    124: ("M124 (points left out)", "passed over: all points are kept"),
    130: ("M130 (points of the plane that is not tilted)", "passed over: points of the plane in force"),
    138: ("M138 (choice of tilting axes)", "passed over"),
    144: ("M144 (kinematics counted at the end of a block)", "passed over"),
    145: ("M145 (end of M144)", "passed over"),
    197: ("M197 (rounded corners)", "passed over"),
}
PARAMETERS: Mapping[int, tuple[str, ...]] = {  # words that belong to the M function before them
    103: ("F",), 112: ("T", "A", "E"), 118: ("X", "Y", "Z", "A", "B", "C"), 120: ("LA",), 124: ("T",), 128: ("F",), 140: ("MB", "F"),
    144: (), 197: ("DL",),
}  # fmt: skip


def strange(r: Recorder, m: int, column: int) -> None:
    """Note an M function that is read without its effect, once. Raises ProgramFault in strict reading."""
    if m in REST:
        what, value = REST[m]
        r.assume(
            what, value,
            f"M{m} is not understood; it may change the path or the feed, remove it or program what it does", column=column,
            matters=m in (92, 94, 97, 98, 112, 114, 118, 120, 130, 197),
        )  # fmt: skip
    else:
        r.remark(f"M{m} belongs to the machine builder; it is taken to move nothing", column)
