"""Answers (the contract's JSON of `vcmm diagnose`) against the truth of a case, and figures of many cases."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from benchmarks.exam.blocks import Truth
from benchmarks.exam.case import Concealed

UNITS = {"nm": 1e-9, "um": 1e-6, "mm": 1e-3, "m": 1.0, "nrad": 1e-9, "urad": 1e-6, "mrad": 1e-3, "rad": 1.0, "arcsec": 4.84813681e-6,
         "us": 1e-6, "ms": 1e-3, "s": 1.0, "min": 60.0, "h": 3600.0, "Hz": 1.0, "K": 1.0, "N": 1.0, "kg": 1.0, "1": 1.0,
         "ppm": 1e-6, "mm/mm": 1.0}  # fmt: skip
STALE = {
    "geometric_change",
    "scale_factor",
    "squareness",
    "abbe_offset",
    "cross_axis_flexure",
    "map_interpolation",
}
ALIAS = {  # one stylus and one speed; one line of one instrument: what nothing in the recording can tell apart
    ("probe poor", "tip_radius"): "trigger_delay", ("probe poor", "trigger_delay"): "tip_radius",
    ("laser poor", "cosine_error"): "scale_factor",
}  # fmt: skip
DISTURBED = ("unexplained", "partly explained")


def unit_value(text: str) -> float | None:
    """'um/(m K)' -> SI factor, None when the unit is not known here."""
    text = text.split(" at ")[0].strip()
    top, _, bottom = text.partition("/")
    total = 1.0
    for word in top.split():
        if word not in UNITS:
            return None
        total *= UNITS[word]
    for word in bottom.strip("() ").replace("(", " ").replace(")", " ").replace("/", " ").split():
        name, _, power = word.partition("^")
        if name not in UNITS:
            return None
        total /= UNITS[name] ** int(power or 1)
    return total


def rivals(answer: Mapping[str, Any]) -> list[str]:
    """Names of an answer and all that it cannot be told from, without places."""
    words = [answer["effect"], *answer.get("cannot_be_told_from", [])]
    return [str(w.get("effect") if isinstance(w, dict) else w).split("[")[0].split(" ")[0] for w in words]


def accepted(item: Concealed, simpler: Sequence[str]) -> set[str]:
    return {item.effect, *simpler}


def name_right(item: Concealed, simpler: Sequence[str], found: Mapping[str, Any]) -> bool:
    """The first answer, or a stored mistake in the contract's own key."""
    if item.effect == "map_mistake":
        return mistake_right(item, found)
    answers = found["answer"]
    return bool(answers) and answers[0]["effect"] in accepted(item, simpler)


def mistake_right(item: Concealed, found: Mapping[str, Any]) -> bool:
    """Exact: component and what, either of the two for a swap."""
    said = found.get("mistake")
    if not said or item.effect != "map_mistake":
        return False
    due = {f"{item.where['component']}:{item.where['what']}", *item.also}
    return f"{said['component']}:{str(said['what']).split(' (')[0]}" in due


def place_right(item: Concealed, found: Mapping[str, Any]) -> bool | None:
    """Every key of the truth's place that the answer names agrees (axis, pair, component ...); None where none is shared."""
    if item.effect == "map_mistake":
        return None  # see mistake_right
    if not found["answer"]:
        return False
    where = {k: str(v) for k, v in (found["answer"][0].get("where") or {}).items()}
    shared = [k for k in item.where if k in where]
    return all(where[k] == item.where[k] for k in shared) if shared else None


def intervals(item: Concealed, amplitude: float, found: Mapping[str, Any]) -> list[dict[str, Any]]:
    """For every parameter that the truth fixes: is it inside the stated 95 % interval?"""
    out = []
    for answer in found["answer"]:
        if answer["effect"] != item.effect:
            continue
        for name, (value, unit) in item.parameters(amplitude).items():
            row: dict[str, Any] = {"effect": item.effect, "parameter": name, "true": value, "unit": unit}
            said = answer.get("parameters", {}).get(name)
            row["said"] = said
            factor = unit_value(str(said.get("unit", ""))) if said else None
            if said and factor and unit_value(unit) and said.get("interval95"):
                low, high = (float(v) * factor for v in np.ravel(said["interval95"])[:2])
                low, high = (
                    sorted((abs(low), abs(high))) if item.sign_free and low * high > 0 else (low, high)
                )
                due = value * float(unit_value(unit) or 1.0)
                row |= {
                    "inside": bool(low <= due <= high),
                    "ratio": float(np.ravel(said["value"])[0]) * factor / due,
                }
            out.append(row)
        break
    return out


def energy_left(found: Mapping[str, Any]) -> list[float]:
    """effect_energy_left of the folds that gained from, or lost by, the answer."""
    folds = (found.get("fit") or {}).get("held_out") or []
    return [float(f["effect_energy_left"]) for f in folds if f.get("effect_energy_left") is not None]


def score(truth: Truth, found: Mapping[str, Any], seconds: float) -> dict[str, Any]:
    """All that is known of one case, as plain values."""
    answers = found["answer"]
    names = [a["effect"] for a in answers]
    sets = [rivals(a) for a in answers]
    everything = {n for s in sets for n in s} | ({"map_mistake"} if found.get("mistake") else set())
    row: dict[str, Any] = {
        **truth.summary(), "verdict": found["verdict"], "answered": names, "where": [a.get("where") for a in answers],
        "sets": sets, "probabilities": [a.get("probability") for a in answers], "mistake": found.get("mistake"),
        "unknown": found.get("unknown"), "noise": (found.get("noise") or {}).get("findings"), "seconds": seconds,
        "energy_left": energy_left(found), "set_size": len(sets[0]) if sets else 0,
        "anything": bool(answers or found.get("unknown") or found.get("mistake")),
    }  # fmt: skip
    if truth.items and truth.block != "E":
        item, simple = truth.items[0], truth.simple[0]
        row["right"] = any(name_right(i, c, found) for i, c in zip(truth.items, truth.simple))
        row["place_right"] = place_right(item, found)
        row["in_set"] = mistake_right(item, found) or bool(accepted(item, simple) & everything)
        good = [accepted(i, s) for i, s in zip(truth.items, truth.simple)]
        row["all_found"] = all(any(n in g for n in names) for g in good)
        row["all_in_sets"] = all(g & everything for g in good)
        row["extra"] = sum(not any(n in g for g in good) for n in names)
        row["exact"] = row["all_found"] and row["extra"] == 0
        row["intervals"] = [r for i, a in zip(truth.items, truth.amplitudes) for r in intervals(i, a, found)]
        row["wrong_confident"] = bool(
            answers and (answers[0].get("probability") or 0) >= 0.95 and not any(g & everything for g in good)
        )
        alias = ALIAS.get((truth.design, item.effect))
        row["alias_kept"] = ({alias, item.effect} <= everything) if alias and answers else None
    if truth.block == "E":
        row["flagged"] = found.get("unknown") is not None or found["verdict"] in DISTURBED
        row["silently_wrong"] = bool(answers) and not row["flagged"]
    if truth.block == "C":
        row["right"] = (bool(names) and names[0] in STALE) if truth.stale_delta >= 7 else None
        row["other_physics"] = [n for n in names if n not in STALE]
        row["other_named"] = bool(row["other_physics"])
        row["nothing"] = not row["anything"]
    if truth.invisible:
        said = {
            str(w).split("[")[0].split(" ")[0]
            for w in [*found.get("invisible", []), *found.get("not_testable", [])]
        }
        row["declared_invisible"] = truth.items[0].effect in said
    return row


def bound(hits: int, n: int, lower: bool) -> float:
    """One-sided 95 % Clopper-Pearson bound of a rate."""
    from scipy.stats import beta

    if n == 0:
        return 0.0 if lower else 1.0
    if lower:
        return 0.0 if hits == 0 else float(beta.ppf(0.05, hits, n - hits + 1))
    return 1.0 if hits == n else float(beta.ppf(0.95, hits + 1, n - hits))


def rate(rows: Sequence[Mapping[str, Any]], key: str, high_is_good: bool = True) -> dict[str, Any]:
    known = [bool(r[key]) for r in rows if r.get(key) is not None]
    hits, n = sum(known), len(known)
    return {
        "hits": hits,
        "n": n,
        "rate": hits / n if n else None,
        "bound95": bound(hits, n, high_is_good),
    }


def confusion(rows: Sequence[Mapping[str, Any]]) -> dict[str, dict[str, int]]:
    """concealed -> first answer -> count. Without an answer: mistake, unknown or nothing."""
    table: dict[str, dict[str, int]] = {}
    for r in rows:
        first = (
            r["answered"][0]
            if r.get("answered")
            else "mistake"
            if r.get("mistake")
            else "unknown"
            if r.get("unknown")
            else "nothing"
        )
        for item in (r["concealed"] or [{"effect": "(nothing)"}])[:1]:
            inner = table.setdefault(str(item["effect"]), {})
            inner[first] = inner.get(first, 0) + 1
    return table


def confusion_text(table: Mapping[str, Mapping[str, int]]) -> str:
    lines = [f"{'concealed':24} answered first"]
    for name in sorted(table):
        inner = sorted(table[name].items(), key=lambda kv: (-kv[1], kv[0]))
        lines.append(f"{name:24} " + ", ".join(f"{k} {v}" for k, v in inner))
    return "\n".join(lines)


def summarise(rows: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Figures of a block."""
    done = [r for r in rows if not r.get("error")]
    seen = [r for r in done if not r.get("invisible")]
    out: dict[str, Any] = {"cases": len(rows), "failed_to_run": len(rows) - len(done)}
    for key, good in (("right", True), ("place_right", True), ("in_set", True), ("exact", True), ("all_in_sets", True), ("flagged", True),
                      ("silently_wrong", False), ("wrong_confident", False), ("other_named", False), ("nothing", False), ("alias_kept", True)):  # fmt: skip
        if any(r.get(key) is not None for r in seen):
            out[key] = rate(seen, key, good)
    nulls = [r for r in done if not r["concealed"] and r["block"] == "B"]
    if nulls:
        out["false_alarm"] = rate(nulls, "anything", False)
        worlds = sorted({str(r["world"]) for r in nulls})
        out["false_alarm_by_world"] = {
            w: rate([r for r in nulls if r["world"] == w], "anything", False) for w in worlds
        }
    sizes = [r["set_size"] for r in seen if r.get("set_size")]
    out["mean_set"] = float(np.mean(sizes)) if sizes else None
    extra = [r["extra"] for r in seen if r.get("extra") is not None]
    out["mean_extra"] = float(np.mean(extra)) if extra else None
    hidden = [r for r in done if r.get("invisible")]
    if hidden:
        out["declared_invisible"] = rate(hidden, "declared_invisible")
    told = [i for r in seen for i in r.get("intervals", []) if "inside" in i]
    out["coverage"] = rate(told, "inside")
    left = [v for r in seen if r.get("right") for v in r.get("energy_left", [])]
    out["energy_left"] = _energies(left)
    new = [r["new_recording_energy_left"] for r in seen if r.get("new_recording_energy_left") is not None]
    out["new_recording_energy_left"] = _energies(new)
    seconds = [r["seconds"] for r in done]
    out["seconds"] = {"median": float(np.median(seconds)), "max": float(np.max(seconds))} if seconds else None
    out["baselines"] = _baselines(done)
    out["confusion"] = confusion(done)
    return out


def _energies(left: Sequence[float]) -> dict[str, float] | None:
    if not left:
        return None
    values = np.array(left)
    return {"median": float(np.median(values)), "share_below_0.1": float(np.mean(values <= 0.1)),
            "worse": int(np.sum(values > 1)), "n": len(values)}  # fmt: skip


def _baselines(rows: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    names = sorted({n for r in rows for n in r.get("baselines", {})})
    out = {}
    for name in names:
        mine = [r for r in rows if name in r.get("baselines", {})]
        known = [{"hit": r["baselines"][name] in {r["concealed"][0]["effect"], *r["concealed"][0]["counts_too"]}}
                 for r in mine if r["concealed"]]  # fmt: skip
        alarms = [{"hit": r["baselines"][name] is not None} for r in mine if not r["concealed"]]
        out[name] = {"right": rate(known, "hit"), "false_alarm": rate(alarms, "hit", False)}
    return out
