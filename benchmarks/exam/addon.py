"""The recommended next measurement, taken: block F with `next_measurement` followed as an operator would read it.

The machine, its missed calibration, the concealed effect and the placements stay what they were; the readings of the first
recording stay to the last digit; behind them come the rows of the add-on with their own scatter. Both together are put to
the command again: is the right name first now, is the set smaller, is the rival gone that was to be told apart?
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.exam import blocks, files
from benchmarks.exam.addon_rows import (
    NotPossible,
    Part,
    after_reversal,
    faster,
    longer_stylus,
    other_side,
    taken,
    turned,
    walked,
)
from benchmarks.exam.blocks import Case, Setting
from benchmarks.exam.design import Design
from benchmarks.exam.kinema import Array
from benchmarks.exam.noise import scatter
from benchmarks.exam.observe import Hidden, join, nuisance_columns, observed, real_errors, tip_motion

SAME = 0.05  # of the effect: how far it may differ on the first recording when it is made again on both
OF_THE_TIP = ("tip_radius", "tip_form")  # another stylus has another ball
WORDS: tuple[tuple[tuple[str, ...], str], ...] = (
    (("speed",), "faster"), (("other side",), "other side"), (("right after a reversal",), "after a reversal"),
    (("stylus",), "longer stylus"), (("turn the artefact",), "turned"), (("warmer",), "warmer"), (("log",), "longer log"),
)  # fmt: skip
CHANGES: Mapping[str, Callable[[Part], Part]] = {
    "faster": faster, "other side": other_side, "after a reversal": after_reversal, "longer stylus": longer_stylus,
    "turned": turned, "warmer": lambda p: p, "longer log": lambda p: p,
}  # fmt: skip


def change_of(do: str) -> str | None:
    """Which change the operator's sentence asks for; None for a sentence that is not known here."""
    return next((name for words, name in WORDS if all(w in do for w in words)), None)


def recommended(found: Mapping[str, Any]) -> Mapping[str, Any] | None:
    """The first proposal for the first answer, where that has rivals."""
    if not found["answer"] or not found["answer"][0].get("cannot_be_told_from"):
        return None
    first = found["answer"][0]["effect"]
    return next((n for n in found.get("next_measurement") or [] if first in n["separates"]), None)


def longer(old: Design, change: str, rng: np.random.Generator) -> Design:
    """Both recordings as one design. Raises NotPossible."""
    part = CHANGES[change](taken(old))
    new, path, row_node = walked(old, part)
    t = old.columns["time_s"]
    ran = new.columns["time_s"] - new.columns["time_s"][0]
    if change == "longer log":
        later = t.max() + np.linspace(0.02, 2.0, new.rows) * np.ptp(t)
    else:
        later = (
            t.max()
            + (4 * 3600.0 if change == "warmer" else 600.0)
            + ran / (2.5 if change == "faster" else 1.0)
        )
    columns = {**new.columns, "time_s": later}
    if "cut_length_mm" in columns:  # the tools go on from where they were
        columns["cut_length_mm"] = columns["cut_length_mm"] + old.columns["cut_length_mm"].max()
    series = continued(old, float(later.max()), 2.0 if change == "warmer" else 0.0, rng)
    return _joined(old, replace(new, columns=columns), series, path, row_node)


def continued(d: Design, until: float, rise: float, rng: np.random.Generator) -> dict[str, Array]:
    """The logs go on from their last values with slow waves of a third of their scatter; temperatures rise by `rise`."""
    if not d.series or until <= d.series["time_s"][-1]:
        return dict(d.series)
    end = d.series["time_s"][-1]
    more = np.arange(60.0, until - end + 121.0, 60.0)
    out = {"time_s": np.concatenate([d.series["time_s"], end + more])}
    for name, log in d.series.items():
        if name == "time_s":
            continue
        phase = rng.uniform(0, 2 * np.pi)
        wave = np.sin(2 * np.pi * more / rng.uniform(4e3, 2e4) + phase) - np.sin(phase)
        warm = rise if name.startswith("temp_") and "gradient" not in name else 0.0
        out[name] = np.concatenate(
            [log, log[-1] + 0.3 * np.std(log) * wave + warm * (1 - np.exp(-more / 1800.0))]
        )
    return out


def _joined(
    a: Design, b: Design, series: dict[str, Array], path: Array | None, row_node: Array | None
) -> Design:
    def both(x: Mapping[str, Array], y: Mapping[str, Array]) -> dict[str, Array]:
        return {k: np.concatenate([v, y[k]]) for k, v in x.items()}

    return replace(
        a, q=both(a.q, b.q), offset=np.concatenate([a.offset, b.offset]),
        normal=None if a.normal is None or b.normal is None else np.concatenate([a.normal, b.normal]),
        columns=both(a.columns, b.columns), labels={k: [*v, *b.labels[k]] for k, v in a.labels.items()}, series=series,
        hidden=both(a.hidden, b.hidden), nodes=path if path is not None else None,
        row_node=None if a.row_node is None or row_node is None else np.concatenate([a.row_node, row_node]),
    )  # fmt: skip


def hidden_on(case: Case, both: Design) -> Hidden:
    """The concealed effects on both recordings, made from the same draws. Raises NotPossible where they come out otherwise."""
    truth = case.truth
    key = (truth.seed, ord(truth.block), truth.number)
    # the maker must draw the same stylus again, so it sees the first recording's name; another ball has no such error
    seen = replace(
        both, labels={k: [v.removesuffix(" long") for v in column] for k, column in both.labels.items()}
    )
    mine = np.array(
        [not v.endswith(" long") for v in both.labels.get("stylus", [""] * both.rows)], dtype=float
    )
    parts = []
    for i, (item, amplitude) in enumerate(zip(truth.items, truth.amplitudes)):
        again = blocks.FAMILIES[item.effect](seen, case.machine, np.random.default_rng((*key, i)))
        part = again.build(amplitude)
        parts.append(replace(part, reading=part.reading * mine) if item.effect in OF_THE_TIP else part)
    return join(parts)


def measured(case: Case, both: Design, rng: np.random.Generator) -> Array:
    """Readings of both: those of the first as they were. Raises NotPossible where the effect cannot be made again."""
    hidden = hidden_on(case, both)
    m = len(case.values)
    machine = case.machine
    errors = real_errors(both, machine, hidden, case.truth.stale)
    without = real_errors(both, machine, Hidden(), case.truth.stale)
    true = observed(both, tip_motion(both, errors, hidden.shift), hidden)
    effect = (true - observed(both, tip_motion(both, without), Hidden()))[:m]
    truth = case.truth
    old = blocks.effect_of(
        Setting(case.design, machine, case.white),
        join([i.build(a) for i, a in zip(truth.items, truth.amplitudes)]),
    )
    if np.linalg.norm(effect - old) > SAME * np.linalg.norm(old):
        raise NotPossible("the effect is drawn from the rows of one recording")
    noise = scatter("t6", both, len(true) - m, rng)
    return np.concatenate([case.values, true[m:] + _placed(case, both, len(true), rng)[m:] + noise])


def _placed(case: Case, both: Design, size: int, rng: np.random.Generator) -> Array:
    """Placements, offsets and zeros on both: those of the first recording go on (they are linear in the nuisance columns);
    what is new (a turned artefact, another stylus) is drawn as the generator draws it."""
    rng_first = np.random.default_rng((case.truth.seed, ord(case.truth.block), case.truth.number))
    drawn = _first_draw(case, rng_first)
    columns = nuisance_columns(both)
    known = columns[: len(case.values)]
    c = np.linalg.lstsq(known, drawn, rcond=1e-10)[0]
    fresh = np.abs(known).max(axis=0) < 1e-12
    c[fresh] = (rng.normal(0, 1.0, len(c)) * _sizes(both))[fresh]
    out = np.asarray(columns @ c)
    assert len(out) == size
    return out


def _sizes(d: Design) -> Array:
    """Standard deviation of each nuisance column's coefficient, mm: shifts 3 um, turns 8 urad (columns are per 100 mm), zeros."""
    out: list[float] = []
    for word, label in d.nuisance.items():
        if word in ("zero", "dead_path", "radius"):
            one = [2e-3]
        else:
            one = [3e-3] * 3 + ([8e-4] * 3 if word in ("rigid", "alignment") else [])
        out += one * len(np.unique(d.codes(label)))
    return np.array(out)


def _first_draw(case: Case, rng: np.random.Generator) -> Array:
    """The nuisance of the first recording, drawn again as `blocks.build` drew it."""
    from benchmarks.exam import machines
    from benchmarks.exam.observe import nuisance_draw

    name, _, _ = blocks.plan(case.truth.block, case.truth.number)
    more = {"rich": False} if case.truth.block == "F" else {}
    design = blocks.DESIGNS[name](rng, **more)
    machines.draw(design.machine, rng)
    if design.rows != case.design.rows:
        raise NotPossible("add-ons are made for designs of their own number of rows")
    return nuisance_draw(design, rng)


def write(case: Case, change: str, folder: Path) -> Path:
    """The recording of both. Raises NotPossible."""
    key = (case.truth.seed, ord(case.truth.block), case.truth.number, 7)
    rng = np.random.default_rng(key)
    both = longer(case.design, change, rng)
    return files.write(folder, both, case.machine, measured(case, both, rng))
