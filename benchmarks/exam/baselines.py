"""Plain methods on the same cases, over a generic library of columns: they have to lose.

    stepwise    forward choice by BIC, noise from the residual, stored table trusted
    lasso       path of the lasso, model by BIC                      (Tibshirani 1996; coordinate descent)
    refit       free cubic baseline of every component first, then stepwise
    stlsq       sequentially thresholded least squares               (Brunton, Proctor, Kutz 2016)
    gp          Gaussian-process discrepancy over positions and time (Kennedy and O'Hagan 2001): names nothing

Each gives the name of the largest term, or None for "nothing missing".
"""

from __future__ import annotations

import numpy as np

from benchmarks.exam.design import Design
from benchmarks.exam.kinema import Array, Errors
from benchmarks.exam.observe import Hidden, nuisance_columns, observed, tip_motion

Library = list[tuple[str, Array]]


def _along(d: Design, field: Array) -> Array:
    """Projection of a tip field (n, 3) on the observations, with the sign of the recording."""
    if d.normal is None:
        return d.sign * field.ravel()
    return np.asarray(d.sign * (field * d.normal).sum(axis=1))


def library(d: Design) -> Library:
    """Simple formulas of the contract, over the columns that the recording has."""
    out: Library = []
    eye = np.eye(3)
    q = {a: d.q[a] for a in "XYZ"}
    u = {a: (q[a] - q[a].mean()) / max(np.ptp(q[a]), 1.0) for a in q}
    has = {*d.columns, *d.series}
    for i, a in enumerate("XYZ"):
        out.append(("scale_factor", _along(d, q[a][:, None] * eye[i])))
        for e in eye:
            out += [("geometric_change", _along(d, (u[a] ** p)[:, None] * e)) for p in (2, 3)]
            out += [("linear_drift", _along(d, d.columns["time_s"][:, None] * e))] if i == 0 else []
            for b in "XYZ"[i + 1 :]:
                out.append(("cross_axis_flexure", _along(d, (u[a] * u[b])[:, None] * e)))
            if "load_kg" in has:
                out.append(("part_load", _along(d, (d.get("load_kg") * u[a])[:, None] * e)))
        for period in (2.0, 5.0, 8.0, 10.0, 16.0, 20.0):
            for wave in (np.sin, np.cos):
                out.append(("screw_pitch", _along(d, wave(2 * np.pi * q[a] / period)[:, None] * eye[i])))
        for column, name in (("sense_", "backlash"), ("speed_", "servo_lag")):
            key = next((k for k in has if k.startswith(column + a)), "")
            if key:
                out.append((name, _along(d, d.get(key)[:, None] * eye[i])))
        if f"sense_{a}" in has:
            out.append(("lost_motion", _along(d, (d.get(f"sense_{a}") * u[a])[:, None] * eye[i])))
            if f"since_reversal_{a}_mm" in has:
                pulse = d.get(f"sense_{a}") * np.exp(-d.get(f"since_reversal_{a}_mm"))
                out.append(("reversal_spike", _along(d, pulse[:, None] * eye[i])))
        if f"accel_{a}_mm_s2" in has:
            six = np.zeros((d.rows, 6))
            six[:, 3 + (i + 1) % 3] = 1e-8 * d.get(f"accel_{a}_mm_s2")
            out.append(("dynamic_pitch", observed(d, tip_motion(d, Errors({a: six})), Hidden())))
        if f"temp_scale_{a.lower()}_C" in has:
            out.append(
                (
                    "scale_expansion",
                    _along(d, ((d.get(f"temp_scale_{a.lower()}_C") - 20) * q[a])[:, None] * eye[i]),
                )
            )
    for pair in ("A0Z", "B0Z", "C0Y"):
        out.append(("squareness", observed(d, tip_motion(d, Errors(square={pair: 1e-5})), Hidden())))
    for e in eye:
        if "temp_air_C" in has:
            out.append(("thermal_drift", _along(d, (d.get("temp_air_C") - 20)[:, None] * e)))
        if "temp_gradient_C" in has:
            out += [
                ("gradient_bending", _along(d, (d.get("temp_gradient_C") * u[a] ** 2)[:, None] * e))
                for a in "XY"
            ]
        if "force_x_N" in has:
            out.append(
                ("tool_deflection", _along(d, d.get(f"force_{'xyz'[int(e @ [0, 1, 2])]}_N")[:, None] * e))
            )
    return out + (_readings(d, has) if d.normal is not None else [])


def _readings(d: Design, has: set[str]) -> Library:
    out: Library = []
    n = d.normal
    place = d.nominal_tip() - d.nominal_tip().mean(axis=0)
    if "probe_angle_deg" in has:
        out += [("probe_lobing", w(3 * np.radians(d.get("probe_angle_deg")))) for w in (np.sin, np.cos)]
        out.append(("stylus_bending", d.get("stylus_length_mm") ** 3))
        out += [("tip_radius", (d.codes("stylus") == c).astype(float)) for c in np.unique(d.codes("stylus"))]
        out += [("tip_form", n[:, i] * n[:, j]) for i in range(3) for j in range(i, 3)][:5]
        v = np.column_stack([d.columns[f"speed_{a}_mm_s"] for a in "XYZ"])
        out.append(("trigger_delay", (v * n).sum(axis=1)))
    if "temp_part_C" in has:
        out.append(("part_expansion", (d.get("temp_part_C") - 20) * (place * n).sum(axis=1)))
    if "cut_length_mm" in has:
        out += [
            ("tool_wear", d.get("cut_length_mm") * (d.codes("tool") == c)) for c in np.unique(d.codes("tool"))
        ]
        out += [("tool_runout", w(np.radians(d.get("spindle_angle_deg")))) for w in (np.sin, np.cos)]
        out.append(("workpiece_heating", d.get("time_s") * (place * n).sum(axis=1)))
    if "pressure_hPa" in has:
        out.append(("air_index", (d.get("pressure_hPa") - 1013.25) * d.hidden["way"]))
        out.append(("dead_path", d.get("pressure_hPa") - d.get("pressure_hPa").mean()))
    return out


def _freed(columns: Array, basis: Array) -> Array:
    return columns - basis @ (basis.T @ columns)


def _ready(d: Design, values: Array, more: Array | None = None) -> tuple[list[str], Array, Array]:
    """Names, unit columns and residual, free of the nuisance (and of `more`)."""
    free = nuisance_columns(d) if more is None else np.column_stack([nuisance_columns(d), more])
    w, s, _ = np.linalg.svd(free, full_matrices=False)
    basis = w[:, s > 1e-9 * s.max(initial=1.0)]
    names, columns = zip(*library(d))
    raw = np.column_stack(columns)
    raw = raw / np.maximum(np.linalg.norm(raw, axis=0), 1e-300)
    kept = _freed(raw, basis)
    size = np.linalg.norm(kept, axis=0)
    good = size > 1e-3
    return [n for n, g in zip(names, good) if g], kept[:, good] / size[good], _freed(values, basis)


def _bic(r: Array, k: int) -> float:
    return float(len(r) * np.log(r @ r / len(r)) + k * np.log(len(r)))


def _fit(x: Array, y: Array) -> tuple[Array, Array]:
    c = np.linalg.lstsq(x, y, rcond=None)[0] if x.shape[1] else np.zeros(0)
    return c, y - x @ c


def _largest(names: list[str], x: Array, y: Array, chosen: list[int]) -> str | None:
    if not chosen:
        return None
    c, _ = _fit(x[:, chosen], y)
    return names[chosen[int(np.abs(c).argmax())]]


def stepwise(names: list[str], x: Array, y: Array, most: int = 8) -> str | None:
    chosen: list[int] = []
    best, r = _bic(y, 0), y
    while len(chosen) < most:
        j = int(np.abs(x.T @ r).argmax())
        _, left = _fit(x[:, [*chosen, j]], y)
        if _bic(left, len(chosen) + 1) >= best:
            break
        chosen, r, best = [*chosen, j], left, _bic(left, len(chosen) + 1)
    return _largest(names, x, y, chosen)


def lasso(names: list[str], x: Array, y: Array) -> str | None:
    gram, corr = x.T @ x, x.T @ y
    c = np.zeros(x.shape[1])
    best: tuple[float, list[int]] = (_bic(y, 0), [])
    for level in np.abs(corr).max() * np.geomspace(1.0, 0.1, 20):
        for _ in range(40):
            old = c.copy()
            for j in range(len(c)):
                z = corr[j] - gram[j] @ c + gram[j, j] * c[j]
                c[j] = np.sign(z) * max(abs(z) - level, 0.0) / gram[j, j]
            if np.abs(c - old).max() < 1e-3 * level:
                break
        chosen = [int(j) for j in np.flatnonzero(c)]
        _, left = _fit(x[:, chosen], y)
        best = min(best, (_bic(left, len(chosen)), chosen))
    return _largest(names, x, y, best[1])


def stlsq(names: list[str], x: Array, y: Array, limit: float = 3.0) -> str | None:
    chosen = list(range(x.shape[1]))
    for _ in range(10):
        c, left = _fit(x[:, chosen], y)
        sigma = np.sqrt(left @ left / max(len(y) - len(chosen), 1))
        kept = [j for j, v in zip(chosen, c) if abs(v) > limit * sigma]
        if kept == chosen:
            break
        chosen = kept
    return _largest(names, x, y, chosen)


def gaussian_process(d: Design, y: Array) -> str | None:
    """Evidence of a smooth field of position and time against none; it can say that, and no name."""
    per = len(y) // d.rows
    t = d.columns["time_s"]
    u = np.column_stack([d.q[a] / 150.0 for a in d.q] + [t / max(np.ptp(t), 1.0) * 4])
    u = np.repeat(u, per, axis=0)
    k = np.exp(-0.5 * ((u[:, None] - u[None]) ** 2).sum(axis=2))
    m = len(y)
    none = -0.5 * m * np.log(y @ y / m)
    best = -np.inf
    for share in (0.05, 0.2, 0.8):
        lower = np.linalg.cholesky(np.eye(m) + share * k)
        z = np.linalg.solve(lower, y)
        best = max(best, float(-0.5 * m * np.log(z @ z / m) - np.log(np.diag(lower)).sum()))
    return "unknown" if best - none > 3.0 else None


def free_baseline(d: Design) -> Array:
    """Cubic polynomials in every component error and the squareness: the machine calibrated anew on this recording."""
    columns = []
    for a in d.machine.linear:
        u = (d.q[a] - d.q[a].mean()) / max(np.ptp(d.q[a]), 1.0)
        for i in range(6):
            for p in (1, 2, 3):
                six = np.zeros((d.rows, 6))
                six[:, i] = 1e-6 * u**p
                columns.append(observed(d, tip_motion(d, Errors({a: six})), Hidden()))
    raw = np.column_stack(columns)
    return raw / np.maximum(np.linalg.norm(raw, axis=0), 1e-300)


def all_names(d: Design, residual: Array) -> dict[str, str | None]:
    """Every baseline's first name; residual = observed - predicted from the stored table, mm."""
    names, x, y = _ready(d, residual)
    again = _ready(d, residual, free_baseline(d))
    return {"stepwise": stepwise(names, x, y), "lasso": lasso(names, x, y), "refit": stepwise(*again),
            "stlsq": stlsq(names, x, y), "gp": gaussian_process(d, y)}  # fmt: skip
