"""The three tests of section 4 on a lathe: straightness reversal, face reversal, half turn; what they find of the four errors.

The probes' noise is 0.6 nm rms after a Gaussian low-pass of 60 Hz (appendix A), so 1.68 nm white at 1 kHz. Their spot of 2 mm averages
the artefacts. Drawn: the wander of a set-up, how far the mirror is from its old place after a reversal, the arm L, the mirrors.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm import Array, Machine, Run, reversals

from .lathe import HALF, NM, RADIUS, TURN, DrawnLathe, surface_motion

RATE = 1000.0  # 1/s
QUIET, PASS = 0.6 * NM, 60.0  # after the low-pass, Hz
NOISE = QUIET / np.sqrt(
    PASS * np.sqrt(np.pi / np.log(2)) / 2 / (RATE / 2)
)  # white at 1 kHz: 50 % transmission at 60 Hz
SPEED = 10.0 / 60.0  # mm/s
SCANS, STEP = 3, 0.1  # scans in each set-up; mm between the means of a scan
ARM, TURNS, PER_TURN = 20.0, 20, 3000  # mm (drawn); 20 rpm at 1 kHz
ORDERS = 15
SPOT = 2.0  # mm
WANDER, PLACED = (
    0.5 * NM,
    0.05,
)  # rms of a set-up's slow wander over a scan; mm, rms of the mirror's place after a reversal
FACE = reversals.ReversalTest("face", "EZC", "EBC", {"centre": 0.0, "outer": ARM})
PLACES = np.arange(-HALF, HALF + STEP / 2, STEP)
MIRROR = np.arange(-RADIUS, RADIUS + STEP / 2, STEP)


@dataclass(frozen=True, eq=False)
class Survey:
    """What the tests found. square: by eq. 11 as printed; corrected: with E_ZX taken off the scans before their slopes are fitted.

    scans: of the half turn, for the joint identification. yaw: (E_BX at PLACES less its mean, rad; u of it) by two probes at a time in
    the straightness reversal, which the paper did not do.
    """

    straight: reversals.StraightnessReversal
    spindle: reversals.SeparationResult
    square: reversals.SquarenessReversal
    corrected: reversals.SquarenessReversal
    scans: tuple[reversals.LineScan, ...]
    yaw: tuple[Array, float]


def survey(lathe: DrawnLathe, rng: np.random.Generator) -> Survey:
    """All three tests."""
    straight = reversals.straightness_reversal(straightness_scans(lathe.machine, rng))
    spindle = reversals.separate_errors(FACE, face_groups(lathe, rng))
    tilt = half_turn_tilt(spindle)
    scans = half_turn_scans(lathe, rng)
    without = [
        reversals.LineScan(s.setup, s.place, s.value - np.interp(s.place, straight.nodes, straight.machine))
        for s in scans
    ]
    square, corrected = (
        reversals.squareness_reversal(scans, tilt=tilt),
        reversals.squareness_reversal(without, tilt=tilt),
    )
    return Survey(straight, spindle, square, corrected, tuple(scans), yaw_of(lathe.machine, rng))


def half_turn_tilt(spindle: reversals.SeparationResult) -> float:
    """E_tilt of eq. 11: mean of E_BC at 0 and 180 deg, rad."""
    return float(spindle.curve("EBC", np.array([0.0, np.pi])).mean())


def straightness_scans(machine: Machine, rng: np.random.Generator) -> list[reversals.LineScan]:
    """Eq. 7: three scans and three reversed. The probe on the slide at the height of the spindle, the mirror on Z."""
    probe = -PLACES  # the probe stays on the slide, so the place on the mirror side moves on
    moved = -machine.tip_error(_scan(PLACES, probe))[:, 2]
    edge, out = mirror_profile(rng), []
    for setup, sense in ((reversals.NORMAL, 1.0), (reversals.REVERSED, -1.0)):
        form = np.interp(PLACES + (PLACED * rng.standard_normal() if sense < 0 else 0.0), *edge)
        for _ in range(SCANS):
            out.append(reversals.LineScan(setup, PLACES, form + sense * moved + scan_noise(len(PLACES), rng)))
    return out


def yaw_of(machine: Machine, rng: np.random.Generator) -> tuple[Array, float]:
    """E_BX less its mean at PLACES, rad, and its u: two probes ARM apart on the slide, read at a time, three scans before and after.

    The mirror's slope is the same for both, so that the difference keeps the linear part of the yaw, which one probe loses; half
    the difference of the set-ups drops the mirror.
    """
    moved = [-machine.tip_error(_scan(PLACES, p - PLACES))[:, 2] for p in (0.0, ARM)]
    n = 2 * SCANS
    white = NOISE / np.sqrt(STEP / SPEED * RATE)
    noise = sum(white * rng.standard_normal(len(PLACES)) + wander(len(PLACES), rng) for _ in range(n)) / n
    yaw = -(moved[1] - moved[0] + np.sqrt(2) * noise) / ARM
    return yaw - yaw.mean(), float(np.sqrt(2 * (white**2 + WANDER**2) / n) / ARM)


def _scan(x: Array, offset: Array) -> Run:
    tip = np.zeros((len(x), 3))
    tip[:, 0] = offset
    return Run({"X": x, "C": np.zeros(len(x)), "Z": np.zeros(len(x))}, tip)


def mirror_profile(rng: np.random.Generator) -> tuple[Array, Array]:
    """(places, heights) mm of a metal mirror: 80 nm in long waves, 10 nm in waves of 0.8 mm, seen through the spot."""
    fine = np.arange(-HALF - 3, HALF + 3, 0.02)
    long = sum(
        rng.standard_normal() * np.cos(np.pi * k * fine / HALF + rng.uniform(0, TURN)) / k
        for k in range(1, 7)
    )
    short = 10 * NM * np.cos(TURN * fine / 0.8)
    return fine, through_spot(80 * NM * np.asarray(long) / float(np.ptp(long)) + short, 0.02)


def through_spot(values: Array, step: float) -> Array:
    """(n,) averaged over a disc of 2 mm: chords as weights."""
    n = int(SPOT / 2 / step)
    across = np.arange(-n, n + 1) * step / (SPOT / 2)
    weights = np.sqrt(np.maximum(1 - across**2, 0.0))
    padded = np.pad(values, n, mode="edge")
    return np.convolve(padded, weights / weights.sum(), mode="valid")


def scan_noise(n: int, rng: np.random.Generator) -> Array:
    """Noise of means over STEP, and a slow wander of the set-up."""
    white = NOISE / np.sqrt(STEP / SPEED * RATE)
    return np.asarray(white * rng.standard_normal(n) + wander(n, rng))


def wander(n: int, rng: np.random.Generator, size: float = WANDER) -> Array:
    """A random walk from end to end of rms `size` about its mean."""
    walk = np.cumsum(rng.standard_normal(n))
    walk = walk - walk.mean()
    return np.asarray(size * walk / walk.std())


def face_groups(lathe: DrawnLathe, rng: np.random.Generator) -> list[reversals.TurnGroup]:
    """Eq. 9: two probes before and after the reversal, 20 turns of 3000 readings each."""
    angle = np.arange(PER_TURN) * TURN / PER_TURN
    flat = rng.standard_normal(12) / np.repeat(np.arange(1, 7), 2)
    form = (
        40
        * NM
        * sum(flat[2 * k - 2] * np.cos(k * angle) + flat[2 * k - 1] * np.sin(k * angle) for k in range(1, 7))
    )
    whole, out = np.arange(TURNS * PER_TURN) * TURN / PER_TURN, []
    for setup in (reversals.NORMAL, reversals.REVERSED):
        lies = 2e-6 * rng.standard_normal(2)
        loose = [asynchronous(len(whole), PER_TURN, rms, rng) for rms in lathe.asynchronous]
        for probe, arm in (FACE.arms or {}).items():
            here = -arm if setup == reversals.REVERSED else arm
            seen = reversals.reading(
                FACE, lathe.machine, lambda q: np.asarray(form), setup=setup, probe=probe, angle=angle
            )
            seen = seen + here * (lies[0] * np.cos(angle) + lies[1] * np.sin(angle))
            value = (
                np.tile(seen, TURNS) + loose[0] - here * loose[1] + NOISE * rng.standard_normal(len(whole))
            )
            out.append(reversals.turn_group(setup, probe, whole, value, ORDERS))
    return out


def asynchronous(n: int, per_turn: int, rms: float, rng: np.random.Generator) -> Array:
    """(n,) motion that does not repeat from turn to turn: smooth over a twelfth of a turn."""
    width = per_turn // 12
    raw = rng.standard_normal(n // width + 3)
    at = np.arange(n) / width
    return np.asarray(rms * 1.22 * np.interp(at, np.arange(len(raw)), raw))


def half_turn_scans(lathe: DrawnLathe, rng: np.random.Generator) -> list[reversals.LineScan]:
    """Three scans of the mirror on the spindle at 0 and three at 180 deg; the spindle stands still."""
    form, lean, out = mirror_profile(rng), 5e-6 * rng.standard_normal(), []
    for setup, angle, way in ((reversals.NORMAL, 0.0, 1.0), (reversals.REVERSED, np.pi, -1.0)):
        moved = surface_motion(lathe.machine, MIRROR, np.full(len(MIRROR), angle))
        seen = np.interp(way * MIRROR, *form) + way * lean * MIRROR + moved
        out += [reversals.LineScan(setup, MIRROR, seen + scan_noise(len(MIRROR), rng)) for _ in range(SCANS)]
    return out
