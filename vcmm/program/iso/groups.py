"""G and M codes of the G-code family by modal group, for every table that a dialect names. Data, no behaviour.

Sources: FANUC Series 30i operator's manuals (machining centre B-64304EN, lathe B-64304EN-1), "G code list"; Haas mill and lathe
operator's manuals, "G-codes"; LinuxCNC and Mach3 G code references.
"""

from __future__ import annotations

_DRILLING = "G73 G74 G76 G80 G81 G82 G83 G84 G85 G86 G87 G88 G89"
_LINUXCNC = {
    "motion": f"G0 G1 G2 G3 G5 G5.1 G33 G33.1 {_DRILLING}",
    "plane": "G17 G18 G19",
    "distance": "G90 G91",
    "arc": "G90.1 G91.1",
    "feed": "G93 G94 G95",
    "compensation": "G40 G41 G42 G41.1 G42.1",
    "length": "G43 G43.1 G43.2 G49",
    "retract": "G98 G99",
    "offset": "G54 G55 G56 G57 G58 G59 G59.1 G59.2 G59.3",
    "path": "G61 G61.1 G64",
    "spindle": "G96 G97",
    "diameter": "G7 G8",
    "dwell": "G4",
    "other": "G10 G28 G28.1 G30 G30.1 G52 G92 G92.1 G92.2 G92.3",
    "machine": "G53",
}
_MACH3 = {
    **{k: v for k, v in _LINUXCNC.items() if k not in ("diameter", "motion")},
    "motion": f"G0 G1 G2 G3 G33 G33.1 {_DRILLING}",
    "rotation": "G68 G69",
    "scaling": "G50 G51",
    "polar": "G15 G16",
    "pocket": "G12 G13",
    "harmless": "G40.1 G48 G49.1 G61.1 G100 G101",
}
_FANUC = {
    **{k: v for k, v in _LINUXCNC.items() if k not in ("diameter", "arc")},
    "motion": "G0 G1 G2 G3 G33 G32",
    "cycle": _DRILLING,
    "length": "G43 G44 G49 G43.4 G43.5",
    "other": f"{_LINUXCNC['other']} G29",
    "dynamic": "G54.2 G54.4",
    "offset": "G54 G55 G56 G57 G58 G59 G54.1",
    "path": "G61 G61.1 G62 G63 G64",
    "rotation": "G68 G69",
    "scaling": "G50 G51",
    "mirror": "G50.1 G51.1",
    "polar": "G15 G16",
    "exact": "G9",
    "macro": "G65 G66 G66.1 G67",
    "tilt": "G68.2 G68.3 G68.4 G53.1 G53.6",
    "single": "G60",
    "winding": "G12.1 G13.1 G112 G113 G7.1 G107",
    "harmless": "G5 G5.1 G8 G11 G22 G23 G25 G26 G40.1 G49.1 G50.2 G69.1 G150.1 G290 G291",
}
_HAAS = {
    **{k: v for k, v in _FANUC.items() if k not in ("tilt", "dynamic")},
    "offset": " ".join([_FANUC["offset"], "G154", *(f"G{n}" for n in range(110, 130))]),
    "length": "G43 G44 G49 G143 G234",
    "pocket": "G12 G13",
    "pattern": "G70 G71 G72",
    "irregular": "G150",
    "mirror": "G100 G101",
    "tilt": "G254 G255 G253 G268 G269",
    "cycle": f"{_DRILLING} G77",
    "harmless": "G5 G8 G93.1 G102 G103 G160 G161 G187 G188 G266",
}
_LATHE = {
    **{
        k: v
        for k, v in _FANUC.items()
        if k not in ("retract", "distance", "spindle", "feed", "tilt", "dynamic")
    },
    "motion": "G0 G1 G2 G3 G32 G33 G34 G90 G92 G94",
    "cycle": "G80 G83 G84 G85 G87 G88 G89 G81 G82 G86",
    "feed": "G98 G99",
    "spindle": "G96 G97",
    "length": "G43 G44 G49",
    "offset": "G54 G55 G56 G57 G58 G59 G54.1 G154",
    "turning": "G70 G71 G72 G73 G74 G75 G76",
    "other": "G10 G28 G29 G30 G50 G52 G92.1",
    "scaling": "G51",
    "harmless": "G5 G8 G11 G14 G15 G18.1 G22 G23 G25 G26 G40.1 G50.1 G50.2 G51.2 G61.1 G69.1 G103 G111 G187 G199",
}
_LATHE_B = {
    **_LATHE,
    "motion": "G0 G1 G2 G3 G32 G33 G34 G77 G78 G79",
    "cycle": "G80 G83 G84 G85 G87 G88 G89 G81 G82 G86",
    "distance": "G90 G91",
    "feed": "G93 G94 G95",
    "retract": "G98 G99",
    "other": "G10 G28 G29 G30 G52 G92 G92.1",
    "harmless": "G5 G8 G11 G14 G15 G22 G23 G25 G26 G40.1 G50 G50.1 G50.2 G51.2 G69.1",
}


def _table(groups: dict[str, str]) -> dict[str, str]:
    return {code: group for group, codes in groups.items() for code in codes.split()}


TABLES = {
    "fagor": _table(_FANUC | {"cycle": f"{_DRILLING} G287"}),
    "linuxcnc": _table(_LINUXCNC), "mach3": _table(_MACH3), "fanuc": _table(_FANUC), "haas": _table(_HAAS),
    "lathe": _table(_LATHE), "lathe-b": _table(_LATHE_B),
}  # fmt: skip
REFUSED_CODES = {
    "G5": "splines", "G5.1": "quadratic splines", "G5.2": "NURBS", "G5.3": "NURBS", "G6.2": "NURBS interpolation", "G6.1": "splines",
    "G31": "the skip function: where it stops is decided by a probe", "G38.2": "probing", "G38.3": "probing",
    "G38.4": "probing", "G38.5": "probing", "G51": "scaling", "G51.1": "mirroring", "G16": "polar coordinates",
    "G12.1": "polar coordinate interpolation", "G112": "polar coordinate interpolation", "G7.1": "cylindrical interpolation",
    "G107": "cylindrical interpolation", "G43.4": "tool centre point control", "G43.5": "tool centre point control",
    "G68.2": "tilted working planes", "G68.3": "tilted working planes", "G53.1": "tilted working planes",
    "G54.2": "dynamic work offsets", "G254": "dynamic work offsets", "G255": "dynamic work offsets", "G253": "tilted working planes",
    "G234": "tool centre point control", "G143": "tool length along a tilted axis", "G268": "tilted working planes",
    "G60": "single direction positioning", "G34": "threads of variable lead", "G35": "circular threads", "G36": "circular threads",
    "G186": "tapping with a driven tool", "G95": "tapping with a driven tool", "G37": "measuring the tool", "G45": "tool offset increments", "G46": "tool offset increments", "G47": "tool offset increments",
    "G48": "tool offset increments", "G41.2": "radius compensation in space", "G42.2": "radius compensation in space",
    "G150": "pockets of any shape", "G141": "radius compensation in space", "G136": "measuring a work offset",
    "G68.4": "tilted working planes", "G53.3": "tilted working planes", "G53.6": "tilted working planes", "G69": "tilted working planes",
    "G70": "turning cycles", "G71": "turning cycles", "G72": "turning cycles", "G75": "turning cycles", "G77": "turning cycles",
    "G84.2": "rigid tapping", "G84.3": "rigid tapping, left-hand", "G184": "reverse tapping", "G105": "a bar feeder",
    "G241": "radial drilling with a driven tool", "G243": "radial drilling with a driven tool", "G195": "radial tapping with a driven tool",
    "G196": "radial tapping with a driven tool", "G78": "threading cycles", "G79": "facing cycles", "G12": "circular pockets", "G13": "circular pockets",
}  # fmt: skip
REFUSED_OF: dict[str, dict[str, str]] = {  # what a code means in a table where it means something else
    "haas": {
        "G47": "engraving of a text", "G35": "measuring the diameter of a tool", "G36": "measuring work offsets",
        "G37": "measuring the length of a tool", "G174": "tapping along another axis, left-hand", "G184": "tapping along another axis",
    }
}  # fmt: skip
PROBING = (
    "G31",
    "G38.2",
    "G38.3",
    "G38.4",
    "G38.5",
)  # where the set-up states surfaces, the touch is worked out
STAND_INS = {  # a survey goes straight to the end point of what it does not model
    "G5": "G1", "G5.1": "G1", "G5.2": "G1", "G5.3": "G1", "G6.1": "G1", "G6.2": "G1", "G31": "G1", "G38.2": "G1", "G38.3": "G1",
    "G38.4": "G1", "G38.5": "G1", "G41.2": "G41", "G42.2": "G42", "G84.2": "G84", "G84.3": "G74",
}  # fmt: skip
M_GROUPS = {
    "stop": (0, 1, 2, 30, 60), "call": (97, 98, 99, 198), "tool": (6, 61), "spindle": (3, 4, 5, 19, 13, 14), "override": (48, 49),
    "state": (70, 71, 72, 73), "repeat": (47,),
}  # fmt: skip
NOT_OF = {  # M codes that mean something else in a family
    "o": (13, 14, 97, 198), "macro": (61, 70, 71, 72, 73, 47, 48, 49),
}  # fmt: skip
HARMLESS_M = {
    "o": {7, 8, 9, 10, 11, 50, 51, 52, 53, 62, 63, 64, 65, 66, 67, 68},
    "macro": {7, 8, 9, 10, 11, 12, 15, 16, 17, 18, *range(20, 30), *range(31, 47), 48, 49, 50, 51, 52, 53, 54, 59, 63, 68, 69, 75, 76, 77, 78,
              82, 83, 84, 85, 86, 87, 88, 89, 95},
}  # fmt: skip
