"""Instrument: its kind of recording, and its own errors as columns over the observations.

An error of the instrument has a standard uncertainty u (its calibration certificate), which the readings of the machine
may reduce: it is one more Input of the calibration. `redraw` says for which rows it
is the same: all ("machine", one instrument), or those of one value of a label ("setup", "instrument"). Recordings that state the
same serial were made by one instrument: what of it lasts (a scale, not the places of single balls in the axes of the machine) is one
unknown of them all.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from vcmm.core.errors import UsageError, choose_from
from vcmm.core.run import Array, Run
from vcmm.core.units import dimension_of, parse_unit, quantity
from vcmm.task.response.recording import Ints, Recording

Column = Callable[[Recording, Run], Array]


@dataclass(frozen=True)
class OwnError:
    """unit: of the error, for example "um/m". column: (m, k) observation in mm or rad per unit in mm and rad.

    is_permanent: it is the same in every recording of one instrument.
    """

    name: str
    unit: str
    column: Column
    doc: str
    is_permanent: bool = True


@dataclass(frozen=True)
class Instrument:
    """kind: of its recordings. errors: its own. usual_nuisances: nuisance words that its recordings usually need.

    other_kinds: further kinds that its recordings may have.
    """

    name: str
    kind: str
    errors: tuple[OwnError, ...]
    usual_nuisances: tuple[str, ...]
    cites: str
    other_kinds: tuple[str, ...] = ()

    @property
    def kinds(self) -> tuple[str, ...]:
        return (self.kind, *self.other_kinds)

    def error(self, name: str) -> OwnError:
        """Return one of its errors. Raises UsageError with the closest name."""
        error = next((e for e in self.errors if e.name == name), None)
        if error is None:
            names = [e.name for e in self.errors]
            raise UsageError(f'the instrument "{self.name}" has no error "{name}".{choose_from(name, names)}')
        return error


@dataclass(frozen=True)
class InstrumentCertificate:
    """One instrument as it was used: u of its own errors (unit of `OwnError`, in mm and rad), redraw label, serial number or ""."""

    instrument: Instrument
    u: Mapping[str, float]
    redraw: str = "machine"
    serial: str = ""

    @staticmethod
    def of(
        instrument: Instrument, stated: Mapping[str, str], redraw: str = "machine", serial: str = ""
    ) -> InstrumentCertificate:
        """Parse texts such as {"scale": "0.3 um/m"}. Raises UsageError for names, units and signs that do not fit."""
        u = {}
        for name, text in stated.items():
            unit = instrument.error(name).unit
            u[name] = quantity(text, dimension_of(unit), name, f"0.5 {unit}")
            if u[name] < 0:
                raise UsageError(f'{name} = "{text}" is negative; a standard uncertainty is zero or positive')
        return InstrumentCertificate(instrument, u, redraw, serial)

    def unknowns(self, recording: Recording, run: Run) -> list[tuple[str, Array]]:
        """Return `columns` under names such as "EXX: laser linear scale", without the recording where all recordings of one serial number
        share it."""
        lasting = [
            f"{self.instrument.name} {e.name}"
            for e in self.instrument.errors
            if e.is_permanent and self.serial
        ]
        return [
            (f"{name} of {self.serial}" if name in lasting else f"{recording.name}: {name}", part)
            for name, part in self.columns(recording, run)
        ]

    def columns(self, recording: Recording, run: Run) -> list[tuple[str, Array]]:
        """Return (name such as "laser linear scale[setup=2]", (m, k)) scaled to unit variance; run: prepared by the machine."""
        out = []
        values, codes = _copies(recording, self.redraw)
        for name, u in self.u.items():
            if u == 0:
                continue
            whole = self.instrument.error(name).column(recording, run) * u
            for code, value in enumerate(values):
                part = whole * (codes == code)[:, None]
                part = part[:, np.abs(part).max(axis=0, initial=0.0) > 0]
                where = f"[{self.redraw}={value}]" if value else ""
                if part.shape[1]:
                    out.append((f"{self.instrument.name} {name}{where}", part))
        return out


def _copies(recording: Recording, redraw: str) -> tuple[tuple[str, ...], Ints]:
    if redraw == "machine":
        return ("",), np.zeros(recording.m, dtype=np.intp)
    if redraw not in recording.run.labels:
        raise UsageError(
            f'[instrument] redraw = "{redraw}": the data have no such label column; add it, or write redraw = "machine"'
        )
    return recording.groups(redraw)


def measured_length(recording: Recording, run: Run) -> Array:
    """Return the length of an observation (m, 1) mm: of a length itself, else how far the tip lies along the direction; 0 for an angle."""
    if recording.kind == "angle":
        return np.zeros((recording.m, 1))
    if recording.kind == "length":
        both = recording.other >= 0
        if "length_mm" in run.columns:
            return run.column("length_mm")[recording.row][:, None]
        way = run.tip[recording.row] - np.where(both[:, None], run.tip[recording.other], 0.0)
        return np.linalg.norm(way, axis=1)[:, None]
    return np.asarray((recording.direction * run.tip[recording.row]).sum(axis=1))[:, None]


def reading_column(recording: Recording, run: Run) -> Array:
    """Return the reading itself, for an error in proportion to it, as (m, 1)."""
    return recording.value[:, None]


def angle_reading(recording: Recording, run: Run) -> Array:
    """Return the reading of an angle (m, 1); 0 for a length."""
    return recording.value[:, None] * float(recording.kind == "angle")


def across_reading(recording: Recording, run: Run) -> Array:
    """Return the reading of a displacement across the travel (m, 1); 0 for one along it, or for an angle."""
    way = run.tip[recording.row] - run.tip[recording.row].mean(axis=0)
    along_travel = np.abs((recording.direction * way).sum(axis=1)).max(initial=0.0) > 1e-3
    return recording.value[:, None] * float(recording.kind == "displacement" and not along_travel)


def since_start(recording: Recording, run: Run) -> Array:
    """Return the time from the first row (m, 1), s; zero without time_s."""
    time = run.columns.get("time_s", np.zeros(run.n))
    return np.asarray(time[recording.row] - time.min(initial=np.inf))[:, None]


def constant(recording: Recording, run: Run) -> Array:
    """Return ones (m, 1), for an error that is the same in every row."""
    return np.ones((recording.m, 1))


def half_along_normal(recording: Recording, run: Run) -> Array:
    """Return half of a diameter (m, 1), outwards: its share in the reading of a touch."""
    return np.full((recording.m, 1), 0.5)


def of_features(recording: Recording, run: Run) -> Array:
    """Return the coordinate of each calibrated feature (label `feature`) along the direction, (m, 3 features). Raises UsageError."""
    if "feature" not in run.labels:
        raise UsageError("the calibration of single balls needs the label column feature; add it to the data")
    values, codes = recording.groups("feature")
    out = np.zeros((recording.m, len(values), 3))
    out[np.arange(recording.m), codes] = recording.direction
    return out.reshape(recording.m, -1)


SCALE = OwnError("scale", "um/m", measured_length, "u of its unit of length: wavelength, air, expansion")
GAIN = OwnError("gain", "%", reading_column, "u of its gain, in proportion to the reading")
assert parse_unit("%").factor == 0.01
