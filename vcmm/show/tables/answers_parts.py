"""The answers of several parts, of a part beside its prediction, of the loop to the next part, of a certificate, of machines compared."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from vcmm.show.report.answers import (
    FINE_UNITS,
    STATE,
    AnswerLine,
    K,
    Kind,
    answer_of,
    percent,
    signed_value,
    value_and_U,
)

if TYPE_CHECKING:
    from vcmm.answer.evaluation.result import CharacteristicResult
    from vcmm.answer.evaluation.virtual_measurement import MeasuredValue, Measurement
    from vcmm.answer.inference.job import EvaluatedPart
    from vcmm.files.learned.certificate_comparison import CertificateWorth
    from vcmm.shop.machining.measured_part import BesidePrediction, MeasuredCut

ORDER = ("does not conform", "undecided", "conforms")  # the worst first
PLURAL = {"does not conform": "do not conform", "undecided": "undecided", "conforms": "conform"}
MOST_E_N = 1.0  # ISO/IEC 17043: |E_n| above it is a departure beyond both uncertainties


def parts_answers(parts: Sequence[EvaluatedPart]) -> list[AnswerLine]:
    """Return a line per characteristic for one part. Several: per characteristic how many conform, and the worst part."""
    if len(parts) == 1:
        return [answer_of(e.result) for e in parts[0].characteristics]
    names = dict.fromkeys(e.name for p in parts for e in p.characteristics)
    return [_of_all([(p.part, e.result) for p in parts for e in p.characteristics if e.name == n]) for n in names]  # fmt: skip


def _of_all(results: Sequence[tuple[str, CharacteristicResult]]) -> AnswerLine:
    part, worst = min(results, key=lambda pair: _badness(pair[1]))
    counts = {
        text: sum(c.decision is not None and c.decision.text == text for _, c in results) for text in ORDER
    }
    counts_text = [f"{n} {PLURAL[text]}" for text, n in counts.items() if n]
    line = answer_of(worst)
    kind: Kind = next((STATE[text] for text in ORDER if counts[text]), "muted")
    return replace(
        line,
        name=f"{line.name}, {len(results)} parts",
        coverage=f"{line.coverage}; the worst: part {part}",
        verdict=", ".join(counts_text),
        kind=kind,
        link="",
        numbers={**line.numbers, "part": part, "parts": len(results), **{k.replace(" ", "_"): v for k, v in counts.items()}},
    )  # fmt: skip


def _badness(c: CharacteristicResult) -> tuple[int, float, float]:
    """Return a key that is least for the worst part: by decision, the probability of conformity, and how far it lies within its limits;
    without them from nominal."""
    if c.decision is None or c.tolerance is None:
        return len(ORDER), 0.0, -abs(c.value - c.nominal)
    low, high = c.tolerance
    p = c.decision.p_conform
    return ORDER.index(c.decision.text), 0.0 if p is None else p, min(high - c.value, c.value - low)


def measured_answers(m: Measurement) -> list[AnswerLine]:
    """Return one virtual measurement: values without U, and how to get it."""
    return [_measured_line(v) for v in m.values]


def _measured_line(v: MeasuredValue) -> AnswerLine:
    unit = "mm" if v.unit == "mm" else "rad"
    word, scale = FINE_UNITS[unit]
    value, _ = value_and_U(v.value, float("inf"), unit, small=v.nominal == 0)
    return AnswerLine(
        v.name,
        value,
        coverage="measured once: no U",
        limits=""
        if v.nominal == 0
        else f"{signed_value((v.value - v.nominal) * scale, 0.0, word, '+')} from nominal",
        numbers={"name": v.name, f"value_{unit}": v.value},
        labels=("", "", ""),
    )


def cut_answers(cut: MeasuredCut) -> list[AnswerLine]:
    """Return, for a measured part, the departure from the prediction, and its covariate."""
    worst = sorted(cut.comparisons, key=lambda r: -abs(r.e_n) if np.isfinite(r.e_n) else 0.0)
    first = cut.mismatch[0] if cut.mismatch else None
    points = AnswerLine(
        "Measured points",
        f"at most {np.abs(cut.off).max() * 1e3:.2f} µm from nominal",
        coverage=f"{len(cut.off)} points, scatter {cut.scatter * 1e3:.2f} µm",
        verdict="departs from its prediction" if first else "as predicted",
        kind="warning" if first else "good",
        because=first.text if first else "",
        change="vcmm diagnose of the recording that was written" if first else "",
        numbers={"largest_um": float(np.abs(cut.off).max() * 1e3), "mismatches": len(cut.mismatch)},
        labels=("", "", "to find the cause:"),
    )
    return [points, *map(_beside, worst)]


def _beside(r: BesidePrediction) -> AnswerLine:
    word, scale = FINE_UNITS[r.unit]
    far = abs(r.e_n) > MOST_E_N
    return AnswerLine(
        r.name,
        f"measured {signed_value((r.measured - r.nominal) * scale, 0.0, word, '+')}, predicted "
        f"{signed_value((r.prediction - r.nominal) * scale, K * r.u * scale, word, '+')}",
        coverage=f"from nominal; ± of the difference, k = {K:.0f}",
        verdict=f"E_n = {r.e_n:.2f}".replace("-", "−"),
        kind="warning" if far else "good",
        numbers={"name": r.name, "E_n": r.e_n},
    )


def certificate_answers(w: CertificateWorth, least: float) -> list[AnswerLine]:
    """Return U by the certificate as stated, U with a further fact, and whether machines at the limit are covered."""
    out = []
    for name in dict.fromkeys(u.characteristic for u in w.by_fact):
        of_characteristic = [u for u in w.by_fact if u.characteristic == name]
        counted = [c for c in w.coverage if c.characteristic == name]
        share = min((c.share for c in counted), default=None)
        word, scale = FINE_UNITS[of_characteristic[0].unit]
        best = min(of_characteristic, key=lambda u: u.expanded)
        out.append(
            AnswerLine(
                name,
                f"U = {of_characteristic[0].expanded * scale:.2f} {word}",
                coverage=f"half the 95 % interval, by {of_characteristic[0].facts}",
                verdict="" if share is None else f"holds {percent(share)} of machines at the limit",
                kind="muted" if share is None else "good" if share >= least else "bad",
                because=f"U = {best.expanded * scale:.2f} {word}" if best is not of_characteristic[0] else "",
                link="U with every further fact",
                numbers={
                    "name": name,
                    f"U_{of_characteristic[0].unit}": of_characteristic[0].expanded,
                    "share": share,
                },
                labels=("", f"with {best.facts.lstrip('+ ')} too:", ""),
            )
        )
    return out


def machine_answers(order: Sequence[str], rows: Mapping[str, Mapping[str, Any]]) -> list[AnswerLine]:
    """Return which machine suits the part, and by how much it is ahead of the next."""
    best = rows[order[0]]
    pose, amount = best["words"]
    ahead = ""
    if len(order) > 1:
        other = rows[order[1]]
        ahead = f"{order[1]}: {other['words'][1]}"
    refused = sum(bool(row["refused"]) for row in rows.values())
    return [
        AnswerLine(
            f"Machine {order[0]}",
            amount,
            coverage=pose,
            verdict=f"best of {len(rows)} machines",
            kind="good",
            because=ahead,
            change="" if not refused else f"{refused} cannot take the part",
            numbers={"machine": order[0], "value": best["value"], "machines": len(rows)},
            labels=("", "next:", ""),
        )
    ]
