"""Find the periods that a recording can show, and their aliases.

Rows on a lattice of step h hold a wave of period p and one of 1 / |k/h - 1/p| with the same numbers (Shannon): no
period below 2 h can be distinguished from a longer one. Rows at irregular places have no such twin. A period longer than two thirds
of the range is a bend, and fewer than FEWEST places carry no period at all.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from vcmm.core.axes import is_rotary
from vcmm.core.effect import Effect
from vcmm.core.run import Array, Run

FEWEST = 12  # different places
TURNS = 1.5  # periods within the range
IN_STEP = 0.9  # of the spectral window, from which rows are on a lattice
DIGITS = 6  # of mm or rad: closer readings are one place
NEAR_PERIODS = 0.125  # of a period: places closer than this are one place
MOST_BINS = 2**20
MOST_PEAKS = 60
SAME_FREQUENCY_SHARE = 0.05  # of a frequency: closer ones are one
SUM_TOLERANCE = 1e-9  # relative, of sums
FURTHER = 40.0  # an alias is looked for at periods down to this part
LEAD = 4.0  # mm: shorter leads are rare
MOST_SHOWN = 12
ROUND = 2 * np.pi
A_TURN = 0.95  # of a turn: the last step that would close it may be missing


def coordinate(effect: Effect, run: Run) -> Array | None:
    """Return the coordinate (n,) over which an effect is periodic: its raw scale where it has one, else the position of its axis."""
    axis = str(getattr(effect, "axis", ""))
    raw = run.columns.get(f"raw_{axis}_{'mm' if axis in 'XYZ' else 'rad'}")
    if effect.diagnosis.follows_raw_scale and raw is not None:
        return raw
    return run.position.get(axis)


def lattice_frequency(q: Array, highest: float) -> float:
    """Return the lattice frequency, see `_lattice_frequency`; cached, since every harmonic and shape needs the same places.

    Each place counts once: an axis at rest while others move is in step with any frequency, and carries no information.
    """
    return _cached_frequency(np.unique(np.round(q, DIGITS)).tobytes(), float(highest))


@lru_cache(maxsize=64)
def _cached_frequency(places: bytes, highest: float) -> float:
    return _lattice_frequency(np.frombuffer(places), highest)


def _lattice_frequency(q: Array, highest: float) -> float:
    """Return the lowest frequency g up to `highest` at which all places q (n,) are in step; infinite where there is none.

    The spectral window |mean exp(2 pi i g q)| is 1 at 0 and again at 1 / h for rows on a lattice of step h (Deeming,
    Astrophysics and Space Science 36 (1975) 137); a wave of frequency f has a twin at |g - f|. Found by one FFT of the
    histogram of places, in bins an eighth of the shortest wavelength.
    """
    length = float(np.ptp(q))
    if length <= 0 or highest * length <= TURNS:
        return float("inf")
    width = 0.25 / highest
    count = min(int(length / width) + 2, MOST_BINS)
    width = max(width, length / (count - 1))
    whole = 1 << int(np.ceil(np.log2(2 * count)))
    filled = np.bincount(np.round((q - q.min()) / width).astype(np.intp), minlength=whole)
    window = np.abs(np.fft.rfft(filled)) / len(q)
    g = np.arange(len(window)) / (len(filled) * width)
    window[g < TURNS / length] = 0.0
    window[g > min(highest * (1 + 1e-3), 0.3 / width)] = 0.0  # beyond, the bins themselves are a lattice
    high = np.flatnonzero(window >= 0.8 * IN_STEP)  # binning blurs the window
    return next(
        (
            frequency
            for start in _starts(g[high], length)
            if (frequency := _peak(q, start, length)) is not None
        ),
        np.inf,
    )


def _starts(high: Array, length: float) -> list[float]:
    """Return the frequencies from which to search, 3 / length apart."""
    _, first = np.unique(np.floor(high * length / 3.0), return_index=True)
    return [float(g) for g in high[first][:MOST_PEAKS]]


def _peak(q: Array, start: float, length: float) -> float | None:
    """Return the exact window about a bin: its maximum's frequency where that is IN_STEP."""
    near = np.maximum(start + np.linspace(-1.0, 4.0, 101) / length, TURNS / length)
    window = np.abs(np.exp(2j * np.pi * np.outer(near, q - q.min())).mean(axis=1))
    best = int(np.argmax(window))
    return float(near[best]) if window[best] >= IN_STEP else None


def shortest_period(q: Array | None, finest: float) -> float:
    """Return the shortest period, down to `finest`, that rows at q (n,) can tell from every longer one."""
    if q is None:
        return float("inf")
    g = lattice_frequency(q, 2.0 / finest)
    return finest if np.isinf(g) else 2.0 / g


def can_show_period(q: Array | None, period: float, least: float | None = None) -> bool:
    """Return whether rows at q (n,) can show this period, and no longer one in its place. least: `shortest_period`, where it is known."""
    if q is None:
        return False
    length = float(np.ptp(q))
    if (
        period * TURNS > length * (1 + SUM_TOLERANCE)
        or len(np.unique(np.round(q / (NEAR_PERIODS * period)))) < FEWEST
    ):
        return False
    return period >= (shortest_period(q, period) if least is None else least) * (1 - 1e-2)


def whole_fractions(periods: Sequence[float], q: Array) -> list[float]:
    """Return, for an axis that turns, the whole fractions of a turn next to periods (rad), and the
    turn itself, as far as rows at q (n,) show them.
    """
    whole = sorted({1, *(max(round(ROUND / p), 1) for p in periods)})
    return [ROUND / k for k in whole if np.ptp(q) >= A_TURN * ROUND / k and can_show_harmonic(k, q)]


def can_show_harmonic(harmonic: int, angle: Array) -> bool:
    """Return whether rows at these angles (n,) rad can show a wave with `harmonic` periods per turn. It takes more than two places each."""
    around = np.mod(angle, ROUND)
    cells = 16 * harmonic
    cells_met = np.unique(np.round(around / ROUND * cells).astype(int) % cells)
    return len(cells_met) > 2 * harmonic


def nearest_alias(q: Array | None, period: float) -> float | None:
    """Return the longest other period with the same numbers at q, or None where there is none.

    On a lattice of step h: frequencies 1/h - f, then 1/h + f. A screw of 5 mm looked at every 4 mm shows 20 mm.
    """
    g = np.inf if q is None else lattice_frequency(q, FURTHER / period)
    if np.isinf(g):
        return None
    step = 1.0 / g
    near, far = abs(1.0 / step - 1.0 / period), 1.0 / step + 1.0 / period
    other = (
        near
        if near > SAME_FREQUENCY_SHARE / period and abs(near * period - 1.0) > SAME_FREQUENCY_SHARE
        else far
    )
    return 1.0 / other


def alias_words(effect: Effect | None, run: Run) -> str:
    """Return 'period 20 mm or its alias 5 mm: ...' for an effect with a period, "" where the rows decide."""
    if effect is None or not hasattr(effect, "period"):
        return ""
    harmonic = int(getattr(effect, "harmonic", 1))
    period, q = float(effect.period) / harmonic, coordinate(effect, run)
    others = () if q is None else aliases(q, period)
    if q is None or not others:
        return ""
    unit = "rad" if is_rotary(str(getattr(effect, "axis", "X"))) else "mm"
    step = 1.0 / lattice_frequency(q, FURTHER / period)
    rest = ", ".join(f"{p:.3g}" for p in others[1 : MOST_SHOWN + 1])
    further = f" (or {rest} {unit}, and shorter)" if rest else ""
    return (
        f"period {period:.4g} {unit} or its alias {others[0]:.4g} {unit}{further}: the places are {step:.4g} {unit} apart,"
        f" and cannot tell; compare with the lead, and measure at unequal steps{_only_half(period, step, unit)}"
    )


def alias_names(effect: Effect | None, run: Run) -> tuple[str, ...]:
    """Return the same wave with the periods that the rows cannot tell from its own, by name, the longest first: screw_pitch of 10 mm."""
    if effect is None or not hasattr(effect, "period"):
        return ()
    q = coordinate(effect, run)
    others = () if q is None else aliases(q, float(effect.period) / int(getattr(effect, "harmonic", 1)))
    unit = "rad" if is_rotary(str(getattr(effect, "axis", "X"))) else "mm"
    return tuple(f"{effect.name} of {p:.3g} {unit}" for p in others[:MOST_SHOWN])


def _only_half(period: float, step: float, unit: str) -> str:
    """Return the remark that twice the step shows one phase of a wave only: its cosine is +1 and -1 in turn, its sine is zero."""
    if abs(period / (2 * step) - 1.0) > 0.02:
        return ""
    return f". At two steps ({2 * step:.4g} {unit}) sine and cosine cannot be separated, so the amplitude is a least one"


def aliases(q: Array, period: float) -> tuple[float, ...]:
    """Return all other periods with the same numbers at q, longest first, down to usual leads of 4 mm, or a fifth of
    the period.

    On a lattice of step h: 1 / |n/h - 1/p| and 1 / (n/h + 1/p). A lead of 10 mm looked at every 23.7 mm shows
    1 / (1/10 - 2/23.7) = 64.05 mm.
    """
    g = lattice_frequency(q, FURTHER / period)
    if not np.isfinite(g):
        return ()
    highest = max(
        1.0 / LEAD if period > LEAD else 0.0,
        5.0 / period,
        1.0 / (nearest_alias(q, period) or np.inf) * (1 + SUM_TOLERANCE),
    )
    n = np.arange(1, max(int(highest / g), 1) + 2)
    f = np.concatenate([np.abs(n * g - 1.0 / period), n * g + 1.0 / period])
    f = f[
        (f > SAME_FREQUENCY_SHARE / period)
        & (np.abs(f * period - 1.0) > SAME_FREQUENCY_SHARE)
        & (f <= highest)
    ]
    kept: list[float] = []
    for frequency in np.sort(f):
        if not kept or frequency > kept[-1] * 1.001:
            kept.append(float(frequency))
    return tuple(1.0 / frequency for frequency in kept)
