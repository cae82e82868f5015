"""Units and signs that contradict one another, and the factors of units that are taken for those of a heading.

Positions in inches and times in minutes: units that no header contradicts, from quantities that belong together. A small artefact on a large machine also covers a small part of the travels.
So positions are suspected only where a second thing disagrees by 25.4: the points of the part, or digits that are round in mm and not as they stand.

Signs: speeds against normals, senses against speeds, speeds against the motion itself.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.task.response.recording import Recording

# the speed in mm/s (or rad/s) over the number that is written in another unit
PER_MINUTE, METRES_PER_MINUTE, METRES_PER_SECOND = 1.0 / 60.0, 1000.0 / 60.0, 1000.0


def unit_forms() -> dict[str, tuple[tuple[float, float, str], ...]]:
    """Return, by the beginning of a column, (factor, zero, words) of every unit that may be meant: the quantity is factor (value - zero)."""
    from scipy.constants import convert_temperature, degree_Fahrenheit, g, zero_Celsius

    freezing = float(convert_temperature(0.0, "Celsius", "Fahrenheit"))
    return {
        "temp_": (
            (degree_Fahrenheit, freezing, "the values are degF"),
            (1.0, zero_Celsius, "the values are K"),
        ),
        "speed_": (
            (PER_MINUTE, 0.0, "the values are 60 times too large, as per minute"),
            (60.0, 0.0, "the values are 60 times too small"),
            (METRES_PER_MINUTE, 0.0, "the values are 1000/60 times too small, as m/min"),
            (METRES_PER_SECOND, 0.0, "the values are 1000 times too small, as m/s"),
        ),
        "load_": ((1.0 / g, 0.0, "the values are N"), (g, 0.0, "the values are 9.81 times too small")),
    }


INCH = 25.4
NEAR_FACTOR_SHARE = (
    0.05  # of the factor that the points of the part give; the tip is its radius away from them
)
DIGITS = 5  # after the point, mm: what coordinate lists hold
FASTEST = 1000.0  # mm/s, 60 m/min in every second row: beyond what feed axes do on a measured path


def unit_remarks(recording: Recording, machine: Machine) -> list[str]:
    """Return one sentence where positions look like inches, one where the times look like minutes."""
    return [*_positions(recording, machine), *_times(recording)]


def _positions(recording: Recording, machine: Machine) -> list[str]:
    run = recording.run
    lines = {a: run.position[a] for a in "XYZ" if a in run.position and np.ptp(run.position[a]) > 0}
    if not lines or any(INCH * np.ptp(q) > np.ptp(machine.axes[a].travel) for a, q in lines.items()):
        return []
    because = _of_part(recording) or _of_digits(lines)
    if not because:
        return []
    shown = ", ".join(
        f"{a} {float(np.ptp(q)):.3g} of {float(np.ptp(machine.axes[a].travel)):.4g} mm"
        for a, q in lines.items()
    )
    return [
        f"the positions cover only {shown}, and {because}: they look like inches; expected mm (1 inch is {INCH} mm)"
    ]


def _of_part(recording: Recording) -> str:
    """Return the distances between the points of the part against those between the positions, per placement and stylus."""
    run = recording.run
    names = [f"part_{c}_mm" for c in "xyz"]
    if not set(names) <= set(run.columns) or not set("XYZ") <= set(run.position):
        return ""
    part, tip = run.vector(*names), np.stack([run.q(a) for a in "XYZ"], axis=1)
    none = np.zeros(run.n, dtype=np.str_)
    both = np.stack([run.labels.get(label, none) for label in ("pose", "stylus")], axis=1)
    of_part, of_tip = 0.0, 0.0
    for value in np.unique(both, axis=0):
        rows = (both == value).all(axis=1)
        of_part += float(((part[rows] - part[rows].mean(axis=0)) ** 2).sum())
        of_tip += float(((tip[rows] - tip[rows].mean(axis=0)) ** 2).sum())
    if of_tip <= 0 or abs(np.sqrt(of_part / of_tip) / INCH - 1.0) > NEAR_FACTOR_SHARE:
        return ""
    return f"the points of the part (part_x_mm ...) lie {np.sqrt(of_part / of_tip):.4g} times as far apart"


def _of_digits(lines: dict[str, Array]) -> str:
    """Return the numbers with a few digits in mm, which were divided by 25.4."""

    def round_share(values: Array) -> float:
        return float(np.mean(np.abs(values - np.round(values, DIGITS)) < 1e-8))

    values = np.concatenate(list(lines.values()))
    if round_share(values) > 0.2 or round_share(INCH * values) < 0.95:
        return ""
    return "times 25.4 they become numbers of a few digits"


def _times(recording: Recording) -> list[str]:
    """Return a sentence about a path that is faster than any axis."""
    names = [f"speed_{a}_mm_s" for a in "XYZ" if f"speed_{a}_mm_s" in recording.run.columns]
    if recording.kind not in ("path", "displacement") or not names:
        return []
    each = np.stack([recording.run.columns[c] for c in names], axis=1)
    usual = float(np.median(np.linalg.norm(each, axis=1)))
    if usual <= FASTEST:
        return []
    return [
        f"the motion runs at {usual:.4g} mm/s ({usual * 0.06:.3g} m/min), faster than feed axes do: is time_s in seconds? "
        f"Were it in minutes, it would run at {usual / 60:.3g} mm/s"
    ]


SPEED_UNITS = (  # true speed over the number that is written, where the heading says mm/s (or rad/s)
    (PER_MINUTE, "units per minute"),
    (METRES_PER_MINUTE, "m/min"),
    (METRES_PER_SECOND, "m/s"),
    (INCH, "inches per second"),
)
REVERSED_ROWS_SHARE = 0.9  # share of the rows from which a sign is called reversed
ENOUGH_ROWS = 20  # rows that can tell


def sign_remarks(recording: Recording) -> list[str]:
    """Return one sentence per contradiction."""
    return [*_approach(recording), *_senses(recording), *_speeds(recording)]


def _approach(recording: Recording) -> list[str]:
    """Check that a touch moves against the outward normal: v . n is negative."""
    run = recording.run
    names = [f"speed_{a}_mm_s" for a in "XYZ"]
    if recording.kind != "probe" or not set(names) <= set(run.columns):
        return []
    v = run.vector(*names)[recording.row]
    along, size = (v * recording.direction).sum(axis=1), np.linalg.norm(v, axis=1)
    use = (np.abs(along) > 0.5 * size) & (size > 0) & ~_is_scan(recording)
    away = use & (along > 0)
    if use.sum() < ENOUGH_ROWS or not away.any():
        return []
    if away.sum() > REVERSED_ROWS_SHARE * use.sum():
        return [
            f"in {int(away.sum())} of {int(use.sum())} touches the tip moves away from the surface (speed . normal > 0):"
            " either nx ny nz point into the material or the speeds have the wrong sign; a trigger delay and a tip"
            " radius would come out with the wrong sign"
        ]
    if away.sum() < 0.2 * use.sum():
        return [
            f"{recording.places(away)}: the tip moves away from the surface (speed . normal > 0), against the other rows"
        ]
    return []


def _is_scan(recording: Recording) -> npt.NDArray[np.bool_]:
    mode = recording.run.labels.get("mode")
    return np.zeros(recording.m, dtype=bool) if mode is None else (mode == "scan")[recording.row]


def _senses(recording: Recording) -> list[str]:
    """Check that the sense of an axis is the sign of its speed."""
    out = []
    for axis in recording.run.position:
        sense, speed = _column(recording, f"sense_{axis}"), _speed(recording, axis)
        if sense is None or speed is None:
            continue
        use = (sense != 0) & (np.abs(speed) > 1e-9)
        against = use & (np.sign(speed) != np.sign(sense))
        if use.sum() >= ENOUGH_ROWS and against.sum() > REVERSED_ROWS_SHARE * use.sum():
            out.append(
                f"sense_{axis} and speed_{axis} have opposite signs in {int(against.sum())} of {int(use.sum())} rows; one"
                " of them is reversed, and backlash and lag would come out with opposite signs"
            )
    return out


def _speeds(recording: Recording) -> list[str]:
    """Check that along a trace the speed is the change of the position with time."""
    time, out = _column(recording, "time_s"), []
    if time is None:
        return []
    for axis in recording.run.position:
        speed, q = _speed(recording, axis), recording.run.position[axis][recording.row]
        step = np.diff(time)
        use = step > 0
        if speed is None or use.sum() < ENOUGH_ROWS or np.ptp(q) == 0:
            continue
        moved = np.diff(q)[use] / step[use]
        stated = ((speed[1:] + speed[:-1]) / 2)[use]
        if not (np.std(moved) > 0 and np.std(stated) > 0):
            continue
        is_trace = recording.kind in ("path", "angle")
        if is_trace and np.corrcoef(moved, stated)[0, 1] < -0.5:
            out.append(f"speed_{axis} has the opposite sign of the motion along {axis} between the rows")
        if is_trace or _varies(stated):  # rows of one feed may be stops, with a wait of any length between
            out += _of_another_unit(axis, moved, stated)
    return out


def _varies(speed: Array) -> bool:
    """Return whether a speed has more than one size, where it is large."""
    size = np.abs(speed)
    large = size[size > 0.5 * size.max()]
    return float(np.std(large)) > NEAR_FACTOR_SHARE * float(np.mean(large))


def _of_another_unit(axis: str, motion: Array, speed: Array) -> list[str]:
    """Return speeds that go with the motion in most rows, at one ratio, which is that of two units. A pause between two runs is no motion of that speed."""
    large = np.abs(speed) > 0.5 * np.abs(speed).max()
    ratio = motion[large] / speed[large]
    usual = float(np.median(ratio))
    if (
        large.sum() < ENOUGH_ROWS
        or usual == 0
        or np.mean(np.abs(ratio / usual - 1.0) < NEAR_FACTOR_SHARE) < REVERSED_ROWS_SHARE
    ):
        return []
    return [
        f"speed_{axis} is {1.0 / abs(usual):.3g} times the motion along {axis} between the rows, as if it were written in {unit}: a lag or a delay"
        f" would come out {abs(usual):.4g} times its size"
        for factor, unit in SPEED_UNITS
        if abs(abs(usual) / factor - 1.0) < NEAR_FACTOR_SHARE
    ]


def _column(recording: Recording, name: str) -> Array | None:
    values = recording.run.columns.get(name)
    return None if values is None else values[recording.row]


def _speed(recording: Recording, axis: str) -> Array | None:
    unit = "mm" if axis in "XYZ" else "rad"
    return _column(recording, f"speed_{axis}_{unit}_s")
