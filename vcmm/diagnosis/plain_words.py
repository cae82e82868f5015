"""What an answer means at the machine: what is seen, what usually causes it, what confirms it. One entry per family."""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np

from vcmm.core.effect import Effect
from vcmm.core.kinematics import ROTARY
from vcmm.core.run import Run
from vcmm.core.units import plain
from vcmm.diagnosis.estimates import Estimate
from vcmm.diagnosis.periods import alias_words

FULL_TURN = np.radians(345.0)

# family: (what is seen, usual causes, what confirms it); {axis} is the place, {name} a parameter with its unit
WORDS: Mapping[str, tuple[str, str, str]] = {
    "scale_factor": ("{where} travels too far in proportion to the distance ({k})", "a scale, a gain or a temperature that is not compensated", "a step gauge or laser along {where}, at two temperatures"),
    "squareness": ("{where} is out of square by {angle}", "the machine was moved or levelled anew, or a guide was adjusted", "a square or two diagonals, the artefact turned by 90 degrees"),
    "geometric_change": ("{where} is no longer what the table says ({rms})", "wear, foundation, transport or a stale calibration", "measure {where} again and replace its table"),
    "map_mistake": ("the stored table of {where} is not what the machine does", "a wrong sign, unit or column when the table was entered", "compare the table with the calibration sheet; a corrected table is written"),
    "abbe_counted_twice": ("the Abbe arm of {where} is wrong in the table by its full length", "a table taken at the reference line and corrected once more, or not at all", "measure the position of {where} on two lines"),
    "abbe_offset": ("{where} was measured on another line than stated ({arm})", "reflector or tool offset entered wrongly", "measure {where} on a second, parallel line"),
    "map_interpolation": ("between the nodes of its table {where} is off ({rms})", "the nodes are too far apart", "measure between the nodes and refine the table"),
    "cross_axis_flexure": ("the structure bends with the position of the other axis ({where}, {c})", "weight of a slide or ram on its guide", "measure one axis at three places of the other"),
    "gravity_flexure": ("the head sags by {angle} when it lies level", "weight of head, tool or tube on its bearing", "the same place or target with the head turned over"),
    "part_load": ("a load bends {where} ({c})", "weight of part or pallet", "the same artefact with and without ballast"),
    "scale_expansion": ("the scale of {where} follows the temperature ({alpha})", "expansion coefficient or scale temperature not compensated", "the same length at temperatures 2 K apart"),
    "part_expansion": ("the part is larger when warmer ({alpha})", "wrong expansion coefficient or part temperature", "measure the part again after soaking"),
    "thermal_drift": ("the tip moves towards +{direction} as the temperature {sensor} rises ({k}, after {tau})", "a part of the frame warms with it", "log a reference point for three time constants over a temperature step"),
    "linear_drift": ("the tip drifts towards +{direction} by {c}", "warming up, settling or a foundation", "touch a reference point every ten minutes"),
    "step_change": ("something moved towards +{direction} by {a} at {t1}", "a slipped clamp, a bump or a changed probe", "look what happened at that time; touch the datum again"),
    "reindexing": ("every re-seating shifts the tip ({sd})", "probe head, rack or pallet does not repeat", "re-seat ten times and touch one sphere each time"),
    "gradient_bending": ("a temperature difference bends {where} ({k})", "top warmer than bottom: lights, sun, coolant", "repeat with lights or air conditioning off"),
    "spindle_growth": ("the spindle grows by {A} with a time constant {tau}", "warming of bearings and motor", "touch a reference while the spindle runs and stops"),
    "screw_heating": ("{where} stretches with the distance travelled ({k})", "the ball screw warms with use", "move to and fro for half an hour and measure again"),
    "backlash": ("{where} stops {gap} short after reversing", "wear of the {where} nut or belt, or a low preload", "approach one place from both sides, at equal speed"),
    "lost_motion": ("{where} stops short after reversing, by a gap that changes along the axis ({g0} at zero, {g1})", "wind-up of the screw, or a nut worn unevenly", "approach five places of {where} from both sides"),
    "hysteresis": ("{where} settles only after some way past a reversal ({amplitude})", "friction of guides or seals, elastic drive", "reverse with several path lengths and compare"),
    "reversal_spike": ("{where} sticks and jumps at reversals ({height})", "friction that the control does not compensate", "a circular test at two feeds and two radii"),
    "screw_pitch": ("{where} errs with a period of {period} ({amplitude})", "the screw, its bearing or a gear; compare with the lead", "measure in steps of an eighth of the period over two periods"),
    "encoder_interpolation": ("the scale of {where} errs within its signal period of {period} ({amplitude})", "offset or unequal gain of the encoder signals; dirt", "a slow scan over 0.1 mm, raw counts logged"),
    "servo_lag": ("{where} runs further behind its command than its nominal gain says (1/Kv longer by {1/Kv})", "position gain not matched to the other axes", "a circular test in both directions at two feeds"),
    "readout_delay": ("position and probe are read at different times ({delay})", "delay in the electronics or in a filter", "repeat at three speeds; at rest the error must vanish"),
    "dynamic_pitch": ("acceleration tilts {where} ({k})", "the slide is driven off its centre of mass", "the same path with half the acceleration"),
    "structural_vibration": ("{where} rings after accelerating ({amplitude}, {frequency})", "a resonance of the structure", "wait before touching; vary the waiting time"),
    "trigger_delay": ("the probe answers late ({delay})", "probe electronics; qualified at another speed", "touch a ring and a plug at three speeds"),
    "tip_radius": ("the tip is {dr} larger than qualified", "worn or dirty tip, or a bad qualification", "clean and qualify again; touch a ring and a plug"),
    "probe_lobing": ("the probe errs with the direction of touch ({amplitude})", "the three seats of a touch trigger probe", "25 touches around a sphere; then another probe orientation"),
    "stylus_bending": ("the stylus bends sideways ({c})", "a long or thin stylus, or a high force", "repeat with half the stylus length or half the force"),
    "tip_form": ("the tip is not round ({rms})", "wear, a flat or dirt", "turn the stylus by 90 degrees and touch a sphere again"),
    "clamping": ("the part is bent by its clamping ({rms})", "clamps or supports force it", "measure the part free and clamped"),
    "cosine_error": ("the instrument stands askew ({theta})", "beam not parallel to the travel", "align the beam again over the whole travel"),
    "air_index": ("the wavelength follows the air ({scale} times the full correction)", "air temperature, pressure or humidity not compensated", "log the air and switch the compensation on"),
    "dead_path": ("the dead path of the laser is not compensated ({length})", "optics set up far from the first point", "move the optics close to the first point"),
    "tool_deflection": ("the cutting force bends the tool ({compliance})", "slender tool, high chip load", "a spring pass, or half the feed"),
    "tool_wear": ("the tool loses radius while it cuts ({rate})", "wear", "the same program with a new tool"),
    "tool_runout": ("the tool runs out ({amplitude})", "collet or holder", "turn the tool in its holder by 180 degrees"),
    "workpiece_heating": ("the part grows while it is cut ({k})", "heat of cutting", "measure again after cooling; cut with a pause"),
    "rotary_location": ("the centre line of {where} is not where it should be ({offset}{tilt})", "the table was set anew or hit", "touch a sphere on the table at four angles"),
    "rotary_cyclic": ("{where} errs once or a few times per turn ({amplitude})", "eccentric encoder, bearing or gear", "compare at angles 180 degrees apart"),
}  # fmt: skip


# family: parameter whose negative value turns the sentence round, and then what is seen and usual causes; "" keeps a part
REVERSED: Mapping[str, tuple[str, str, str, str]] = {
    "backlash": ("gap", "{where} stops {gap} too far after reversing", "a reversal compensation that is set too large, or a sign", "approach one place from both sides with the compensation switched off"),
    "lost_motion": ("g0", "{where} stops too far after reversing, by an amount that changes along the axis ({g0} at zero, {g1})", "a reversal compensation that is set too large, or a sign", "approach five places of {where} from both sides with the compensation switched off"),
    "scale_factor": ("k", "{where} travels too short in proportion to the distance ({k})", "", ""),
    "thermal_drift": ("k", "the tip moves towards -{direction} as the temperature {sensor} rises ({k}, after {tau})", "", ""),
    "linear_drift": ("c", "the tip drifts towards -{direction} by {c}", "", ""),
    "step_change": ("a", "something moved towards -{direction} by {a} at {t1}", "", ""),
    "spindle_growth": ("A", "the spindle draws back by {A} with a time constant {tau}", "", ""),
    "screw_heating": ("k", "{where} shrinks with the distance travelled ({k})", "", ""),
    "servo_lag": ("1/Kv", "{where} runs less far behind its command than its nominal gain says (1/Kv shorter by {1/Kv})", "", ""),
    "readout_delay": ("delay", "the position is read before the probe, or corrected for too long a delay ({delay})", "", ""),
    "trigger_delay": ("delay", "the probe answers earlier than its correction says ({delay})", "", ""),
    "tip_radius": ("dr", "the tip is {dr} smaller than qualified", "", ""),
}  # fmt: skip
SIGNED = {"lost_motion": ("g0", "g1"), "squareness": ("angle",), "scale_expansion": ("alpha",), "part_expansion": ("alpha",), "cross_axis_flexure": ("c",), "thermal_drift": ("k",), "scale_factor": ("k",), "air_index": ("scale",), "dead_path": ("length",), "abbe_offset": ("arm",)}  # fmt: skip


def plain_words(effect: str, where: Mapping[str, str], parameters: Mapping[str, Estimate]) -> str:
    """One sentence for the operator: what is seen; what usually causes it; what confirms it. "" for unknown families."""
    if effect not in WORDS:
        return ""
    place = ", ".join(str(v) for v in where.values() if v) or "the machine"
    signed = SIGNED.get(effect, ())
    shown = {k: _value(e, k in signed) for k, e in parameters.items()}
    known = _Values({**{k: str(v) for k, v in where.items()}, "where": place, **shown})
    turned = _turned(effect, parameters)
    seen, cause, confirm = (
        (other or usual).format_map(known) for usual, other in zip(WORDS[effect], turned, strict=True)
    )
    seen = re.sub(r", after (?=\))", "", seen)  # what an answer does not have leaves no trace
    seen = re.sub(r" ?\([, ]*\)", "", re.sub(r"[, ]+\)", ")", seen.replace("(, ", "("))).strip()
    return f"{seen[:1].upper()}{seen[1:]}; usually {cause}; confirm by: {confirm}."


def _turned(effect: str, parameters: Mapping[str, Estimate]) -> tuple[str, str, str]:
    """Words for the negative sense of an effect; empty where its usual words hold."""
    name, *words = REVERSED.get(effect, ("", "", "", ""))
    negative = name in parameters and parameters[name].value < 0
    return (words[0], words[1], words[2]) if negative else ("", "", "")


class _Values(dict[str, str]):
    """Parameters that an answer does not have leave no trace."""

    def __missing__(self, key: str) -> str:
        return ""


def _value(e: Estimate, signed: bool = False) -> str:
    return plain(e.value if signed else abs(e.value)) + (f" {e.unit}" if e.unit != "1" else "")


def remark(effect: Effect | None, run: Run, kind: str = "probe") -> str:
    """What must be said beside an answer: the alias of a period, that a turn cannot be out of scale, or that the
    instrument (kind displacement or angle) may be to blame.
    """
    if effect is None:
        return ""
    component = str(getattr(effect, "component", ""))
    along = (component[:1] == "E" and component[1:2] == component[2:]) or component in ("EAA", "EBB", "ECC")
    if (
        kind in ("displacement", "angle")
        and along
        and effect.name in ("geometric_change", "map_interpolation")
    ):
        return (
            "or the instrument itself: a departure that depends on the position alone, the same in both directions, looks"
            " the same when the scale or sensor that measured is at fault; repeat it with another instrument"
        )
    axis = str(getattr(effect, "axis", ""))
    if effect.name == "scale_factor" and axis in ROTARY and float(np.ptp(run.q(axis))) > FULL_TURN:
        return (
            f"a saw over a full turn of {axis}: after 360 degrees the axis is where it was, so this is no geometry but the"
            " gain or the wrap-around of the readout"
        )
    said = (_of_wave(effect), alias_words(effect, run))
    return "; ".join(s for s in said if s)


def _of_wave(effect: Effect) -> str:
    """The second wave of one period is the first of half of it: a recording knows the wave only."""
    if effect.name != "encoder_interpolation" or getattr(effect, "harmonic") < 2:  # noqa: B009 - the encoder's
        return ""
    period = float(getattr(effect, "period"))  # noqa: B009
    wave = period / int(getattr(effect, "harmonic"))  # noqa: B009
    return (
        f"a wave of {wave:.4g} mm: unequal gains of signals of {period:.4g} mm, or offsets of signals of {wave:.4g} mm;"
        " the data sheet of the scale decides"
    )
