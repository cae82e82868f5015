"""Errors that touches of a probe in the spindle can determine: location errors and angular position errors of rotary axes, scale and squareness.

Touches at a few rotary positions determine the places and angles of the rotary axes; 18 curves of the linear axes they do not. So
where nothing but touch probes read the machine, and no errors are named, the following are looked for:

    rotary axes that turned    the location errors of ISO 230-1 (X0C Y0C A0C B0C ...), and the angular position error (ECC ...)
    none turned                scale (EXX as a line over the travel) and squareness of the linear axes

All others are taken as zero, or as the machine file has them. Source: ISO 230-1:2012, 3.4.2 and annex A; Ibaraki et al.,
Int. J. Mach. Tools Manuf. 58 (2012) 48.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from vcmm.core.axes import in_order, is_rotary
from vcmm.core.run import Array, Run
from vcmm.learn.calibration.model import LINEAR, LOCATIONS, PAIR_AXES, Curve
from vcmm.task.instruments.artefact import DIAMETER
from vcmm.task.instruments.instrument import InstrumentCertificate
from vcmm.task.instruments.touch_probe import TOUCH_PROBE
from vcmm.task.response.recording import Recording

TURNED = 1e-6  # rad: an axis that turned less stood still


def is_touched(recordings: Sequence[Recording], certificates: Mapping[str, InstrumentCertificate]) -> bool:
    """Return whether nothing but touch probes read the machine."""
    used = [certificates.get(r.name) for r in recordings]
    return bool(used) and all(
        certificate is not None and certificate.instrument.name == TOUCH_PROBE.name for certificate in used
    )


def touched_errors(ranges: Mapping[str, tuple[float, float]]) -> tuple[str, ...]:
    """Return the names of the errors to look for, by the axes that moved (axis -> lowest, highest)."""
    turned = in_order(a for a, (low, high) in ranges.items() if is_rotary(a) and high - low > TURNED)
    if turned:
        located = [f"{where}{axis}" for axis in turned for where in LOCATIONS[axis[0]]]
        return (*(f"E{axis[0]}{axis}" for axis in turned), *located)
    linear = [a for a in "XYZ" if a in ranges]
    pairs = [p for p, needed in PAIR_AXES.items() if set(needed) <= set(linear)]
    return (*(f"E{a}{a}" for a in linear), *pairs)


def as_line(curve: Curve) -> Curve:
    """Return an error of a linear axis as a straight line over the travel that was read: a scale. Those of rotary axes stay."""
    if curve.rotary or curve.has_file_nodes:
        return curve
    return replace(curve, nodes=curve.nodes[[0, -1]], kind=LINEAR, has_file_nodes=True)


def free_probe_errors(
    recording: Recording, run: Run, certificate: InstrumentCertificate | None
) -> tuple[Array, tuple[str, ...]]:
    """Return columns (m, k) of errors that a touch probe may have and its certificate does not state, and their names: they are free.

    run: with the normals in the frame of the probe. Its size is the nuisance `radius`, so no `diameter` is added here.
    """
    nothing = np.zeros((recording.m, 0))
    if certificate is None or certificate.instrument.name != TOUCH_PROBE.name:
        return nothing, ()
    names = [e.name for e in TOUCH_PROBE.errors if e.name not in certificate.u and e.name != DIAMETER.name]
    if not names:
        return nothing, ()
    columns = [TOUCH_PROBE.error(name).column(recording, run) for name in names]
    text = (
        f"{recording.name}: {', '.join(names)} of the touch probe: not stated in [instrument] u, so taken as unknown. An offset that is unknown is one "
        "with the place of the first rotary axis: state its u, or touch with the spindle at 0 and at 180 degrees (spindle_angle_deg)"
    )
    return np.concatenate(columns, axis=1), (text,)
