"""Lay out and simulate recordings: rows of a run, directions, and the readings of an instrument on a given machine."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from vcmm.core.laws import Normal
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.task.instruments.instrument import InstrumentCertificate
from vcmm.task.instruments.probe_frame import with_probe_frame
from vcmm.task.response.nuisance import nuisance_columns
from vcmm.task.response.observe import Observer
from vcmm.task.response.recording import Recording

SHIFT, TURN = 0.05, 1e-4  # mm, rad: how far the set-up of a simulated recording lies from what was meant


def rows(
    positions: Mapping[str, Array], offset: Array, labels: Mapping[str, Sequence[str]] | None = None
) -> Run:
    """Return a run of n rows; offset (3,) or (n, 3) mm."""
    n = len(next(iter(positions.values())))
    offset = np.broadcast_to(np.asarray(offset, dtype=float), (n, 3)).copy()
    texts = {k: np.array(list(v), dtype=np.str_) for k, v in (labels or {}).items()}
    return Run({a: np.asarray(q, dtype=float) for a, q in positions.items()}, offset, {}, texts)


def layout(
    name: str,
    kind: str,
    run: Run,
    direction: Array,
    nuisance: Mapping[str, str],
    u: float,
    measuring: bool = True,
) -> Recording:
    """Lay out one observation per row along direction (3,) or (n, 3), without readings yet; u: noise, mm or rad."""
    direction = np.broadcast_to(np.asarray(direction, dtype=float), (run.n, 3)).copy()
    none = np.full(run.n, -1, dtype=np.intp)
    columns = {f"n{c}": direction[:, i] for i, c in enumerate("xyz")} if kind != "length" else {}
    return Recording(
        name=name,
        kind=kind,
        run=run.with_columns(columns),
        value=np.zeros(run.n),
        measuring=measuring,
        row=np.arange(run.n),
        direction=direction,
        other=none,
        nuisance=dict(nuisance),
        noise=Normal(u),
    )


def join_layouts(name: str, parts: Sequence[Recording]) -> Recording:
    """Join several recordings of one kind and layout into one, row after row."""
    first = parts[0]
    ends = np.cumsum([0, *(p.run.n for p in parts)])
    position = {a: np.concatenate([p.run.q(a) for p in parts]) for a in first.run.position}
    columns = {c: np.concatenate([p.run.column(c) for p in parts]) for c in first.run.columns}
    labels = {c: np.concatenate([p.run.labels[c] for p in parts]) for c in first.run.labels}
    run = Run(position, np.concatenate([p.run.offset for p in parts]), columns, labels)
    other = np.concatenate([np.where(p.other >= 0, p.other + k, -1) for p, k in zip(parts, ends)])
    return replace(
        first,
        name=name,
        run=run,
        value=np.concatenate([p.value for p in parts]),
        row=np.concatenate([p.row + k for p, k in zip(parts, ends)]),
        direction=np.concatenate([p.direction for p in parts]),
        other=other,
    )


def simulate_reading(
    recording: Recording,
    machine: Machine,
    rng: np.random.Generator,
    certificate: InstrumentCertificate | None = None,
    drawn: dict[str, Array] | None = None,
) -> Recording:
    """Return the recording with simulated readings: the machine's errors, the set-up, the instrument, and noise.

    drawn: own errors of instruments sampled so far, by name, in units of their u; errors sampled here are added.
    """
    drawn = {} if drawn is None else drawn
    observer = Observer(recording, machine)
    value = observer.baseline()
    columns, names = nuisance_columns(recording, machine)
    size = np.array([TURN if "turn" in n or n.startswith("slope") else SHIFT for n in names])
    if recording.kind == "angle":
        size = np.full(len(names), TURN)
    value = value + columns @ (size * rng.standard_normal(len(names)))
    read = replace(recording, value=value)
    for name, unit_columns in (
        certificate.unknowns(read, with_probe_frame(observer.run, machine)) if certificate else ()
    ):
        if name not in drawn:
            drawn[name] = np.asarray(rng.standard_normal(unit_columns.shape[1]))
        value = value + unit_columns @ drawn[name]
    assert recording.noise is not None
    return replace(recording, value=value + recording.noise.u * rng.standard_normal(recording.m))
