"""Typical amplitudes: how large each linear parameter is when it matters, with where the figure comes from.

One table for all effects. Diagnosis takes them as the widths of its priors, spread over a wide range, so a figure need
only be right within a factor of a few. Canonical units: mm, rad, s, N, kg and what is made of them.

A note with arithmetic is an estimate from mechanics or optics. "usual" is an order of magnitude quoted for CMMs and
machining centres in the literature (Slocum, Precision Machine Design, 1992; Schwenke et al., CIRP Annals 57 (2008) 660;
Weckenmann et al., CIRP Annals 53 (2004) 657; Bryan, CIRP Annals 39 (1990) 645); it is no limit of any standard.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from vcmm.core.effect import Effect, parameter
from vcmm.core.units import parse_unit

UM, URAD, HOUR = 1e-3, 1e-6, 3600.0


@dataclass(frozen=True)
class Typical:
    """amount: per element of the parameter, canonical unit; turn: the same for a rotation (component EA., EB., EC.)."""

    amount: float
    why: str
    turn: float = 0.0


TYPICAL: Mapping[str, Mapping[str, Typical]] = {
    # stored geometry
    "component_table": {"values": Typical(2 * UM, "usual: 1-5 um, 2-20 urad per component", 5 * URAD)},
    "component_spline": {"values": Typical(2 * UM, "usual: 1-5 um, 2-20 urad per component", 5 * URAD)},
    "component_polynomial": {
        "coefficients": Typical(2 * UM, "the same over a travel of the order of 1 m", 5 * URAD)
    },
    "lost_motion_table": {"values": Typical(1 * UM, "as lost_motion")},
    "calibration_modes": {"modes": Typical(1.0, "standardised by its own loadings")},
    "squareness": {"angle": Typical(10 * URAD, "usual: stale squareness 1-50 urad")},
    "scale_factor": {"k": Typical(5e-6, "usual: scale or gain error 1-10 ppm")},
    "geometric_change": {
        "coefficients": Typical(1 * UM, "a fraction of the component itself: 1 um, 3 urad", 3 * URAD)
    },
    "map_interpolation": {
        "coefficients": Typical(0.5 * UM, "up to a few um between nodes 25-100 mm apart", 1 * URAD)
    },
    "abbe_counted_twice": {"share": Typical(1.0, "a mistake: the coefficient is 1 or -1")},
    "abbe_offset": {"arm": Typical(50.0, "a reflector or stylus taken for another: 10-200 mm")},
    # elastic
    "cross_axis_flexure": {"c": Typical(20 * UM / 1e6, "usual: 1-20 um over 0.5 m x 0.5 m")},
    "part_load": {"c": Typical(0.05 * UM / 1e3, "usual: 0-5 um per 100 kg over 0.5 m")},
    "gravity_flexure": {
        "angle": Typical(20 * URAD, "a head of 0.3 m that sags 5 um; steel tubes of 1 m 20-300 urad")
    },
    # thermal
    "scale_expansion": {"alpha": Typical(8e-6, "steel 11.5, glass 8, Zerodur 0 um/(m K)")},
    "part_expansion": {"alpha": Typical(8e-6, "steel 11.5, aluminium 23; known to 10 % after correction")},
    "thermal_drift": {"k": Typical(2 * UM, "usual: CMM 1-5, machining centre 10-50 um/K")},
    "thermal_drift_two_lags": {
        "k": Typical(2 * UM, "as thermal_drift"),
        "k_slow": Typical(2 * UM, "as thermal_drift"),
    },
    "linear_drift": {"c": Typical(2 * UM / HOUR, "usual: 1-5 um in an hour after switching on")},
    "settling_drift": {"c": Typical(10 * UM / HOUR, "usual: 5-30 um/h in the first minutes after a start")},
    "step_change": {"a": Typical(2 * UM, "a slipped clamp or a bump: 1-10 um")},
    "gradient_bending": {
        "k": Typical(10 * UM / 1e6, "alpha / (2 h): granite 6 um/(m K) / (2 x 0.3 m) = 10 um/(m^2 K)")
    },
    "spindle_growth": {"amplitude": Typical(20 * UM, "usual: 10-60 um")},
    "screw_heating": {
        "k": Typical(50e-6, "usual: 50-100 um/m for a screw without a scale"),
        "shift": Typical(20 * UM, "50 um/m with the fixed bearing 0.4 m from the zero"),
    },
    # setting up
    "work_offset": {"shift": Typical(5 * UM, "usual: edge finder or touch probe on the machine 2-10 um")},
    "tool_length": {"dl": Typical(5 * UM, "usual: tool setter 2-10 um")},
    "tool_offset": {"shift": Typical(3 * UM, "usual: trial cut measured with a micrometer 2-5 um")},
    "tool_radius": {"dr": Typical(5 * UM, "usual: tool setter or presetter 2-10 um")},
    "workpiece_heating": {"k": Typical(20e-6 / HOUR, "steel 11.5 um/(m K) at 1-3 K in an hour of cutting")},
    # drives and scales
    "backlash": {"gap": Typical(1 * UM, "usual: CMM 0.1-0.5, machine tool 1-10 um")},
    "lost_motion": {
        "g0": Typical(1 * UM, "as backlash"),
        "g1": Typical(4e-6, "usual: wind-up 1-10 um over 1 m"),
    },
    "lost_motion_curve": {
        "g0": Typical(1 * UM, "as backlash"),
        "g1": Typical(4e-6, "as lost_motion"),
        "curve": Typical(1 * UM, "as backlash: what wear makes of it along the travel"),
    },
    "hysteresis": {"amplitude": Typical(1 * UM, "usual: 0.2-3 um")},
    "reversal_spike": {"height": Typical(3 * UM, "ball bar: 1-15 um over 0.1-1 mm")},
    "screw_pitch": {
        "sine": Typical(1 * UM, "usual: 0.5-5 um once per turn"),
        "cosine": Typical(1 * UM, "usual: 0.5-5 um once per turn"),
    },
    "encoder_interpolation": {
        "sine": Typical(0.1 * UM, "0.2-1 % of the signal period: 40-200 nm at 20 um"),
        "cosine": Typical(0.1 * UM, "0.2-1 % of the signal period: 40-200 nm at 20 um"),
    },
    # dynamics
    "servo_lag": {"lag": Typical(1e-4, "gains 1/Kv = 15-60 ms matched to 1 %: 5 um at 50 mm/s")},
    "readout_delay": {"delay": Typical(1e-4, "one cycle of a control or interface: 0.05-1 ms")},
    "readout_delay_rotary": {
        "delay": Typical(1e-4, "one cycle of a converter or bus: 0.05-1 ms; faults reach 30 ms")
    },
    "dynamic_pitch": {
        "k": Typical(
            5 * URAD / 1e3, "CMM 0.1-1 um at 0.1 m/s^2, machine tool 5-20 um at 10 m/s^2, arm 0.5 m"
        ),
        "yaw": Typical(5 * URAD / 1e3, "as pitch"),
    },
    "structural_vibration": {
        "sine": Typical(0.5 * UM, "usual: 0.1-2 um at 10-60 Hz"),
        "cosine": Typical(0.5 * UM, "usual: 0.1-2 um at 10-60 Hz"),
    },
    # probe, stylus, part
    "probe_lobing": {
        "cosine": Typical(0.5 * UM, "+-0.3-1 um with 10-20 mm styli, to 5 um with long ones"),
        "sine": Typical(0.5 * UM, "+-0.3-1 um with 10-20 mm styli, to 5 um with long ones"),
    },
    "tip_radius": {"dr": Typical(0.5 * UM, "qualification: 0.1-2 um")},
    "tip_offset": {"d": Typical(1 * UM, "qualification: 0.2-3 um")},
    "stylus_qualification": {"d": Typical(1 * UM, "qualification: 0.2-3 um")},
    "stylus_bending": {
        "c": Typical(1 * UM, "0.1 N on 50 mm of carbide, d 3 mm: 0.1 x 50^3 / (3 x 6e5 x 4.0) mm = 1.7 um")
    },
    "trigger_delay": {"delay": Typical(2e-4, "1 ms at 5 mm/s is 5 um, mostly removed by qualification")},
    "tip_form": {
        "coefficients": Typical(0.1 * UM, "ball grade 5: 0.13 um out of round; worn or dirty: more")
    },
    "clamping": {"coefficients": Typical(5 * UM, "usual: 1-20 um on parts that yield")},
    "reindexing": {"d": Typical(0.5 * UM, "indexing heads and racks: 0.3-1 um")},
    "scatter": {"value": Typical(0.7 * UM, "repeatability of a CMM touch: 0.3-1 um")},
    "residual_field": {"values": Typical(1 * UM, "what compensation leaves: 0.5-3 um")},
    "correlated_field": {"values": Typical(1.0, "standardised by its own deviations")},
    # instruments
    "cosine_error": {"share": Typical(1.0, "theta = 1 mrad is 0.5 um/m")},
    "air_index": {"scale": Typical(1.0, "no correction at all: 1-10 ppm")},
    "dead_path": {"length": Typical(100.0, "optics set up 50-500 mm from the first point")},
    # cutting
    "tool_deflection": {
        "compliance": Typical(0.1 * UM, "carbide d 10 mm, 50 mm out: 50^3 / (3 x 6e5 x 491) mm/N = 0.14 um/N")
    },
    "tool_wear": {"rate": Typical(0.2 * UM / 1e3, "flank wear 0.3 mm x tan 7 deg = 37 um in about 200 m")},
    "tool_runout": {
        "cosine": Typical(5 * UM, "collets and holders: 2-20 um"),
        "sine": Typical(5 * UM, "collets and holders: 2-20 um"),
    },
    # rotary axes
    "rotary_location": {
        "offset": Typical(10 * UM, "five-axis machines: 5-50 um"),
        "tilt": Typical(20 * URAD, "five-axis machines: 10-100 urad"),
    },
    "rotary_cyclic": {"coefficients": Typical(5 * UM, "five-axis machines: 1-20 um, 5-50 urad", 10 * URAD)},
}


def typical(effect: Effect, name: str) -> float:
    """Typical size of each element of a linear parameter, canonical unit; 1 of its own unit where the table has none.

    For "mm or rad" that is 1 um, or 1 urad for the rotations EA., EB., EC. Raises UsageError for an unknown parameter.
    """
    spec = parameter(effect, name)
    turns = str(getattr(effect, "component", ""))[1:2] in tuple("ABC")
    known = TYPICAL.get(effect.name, {}).get(spec.name)
    if known is not None:
        return known.turn if turns and known.turn else known.amount
    if spec.metadata["unit"] == "mm or rad":
        return URAD if turns else UM
    return parse_unit(spec.metadata["unit"]).factor
