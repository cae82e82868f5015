"""The loop from a measured part to the next one, as a document and in words: the answer first."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from vcmm.learn.diagnosis.result import Diagnosis, diagnosis_json
from vcmm.learn.diagnosis.written_machine import answers_to_write
from vcmm.show.tables.compensation import proof_json

if TYPE_CHECKING:
    from vcmm.answer.evaluation.virtual_measurement import Measurement
    from vcmm.core.run import Array
    from vcmm.shop.machining.held_out import HeldOutProof
    from vcmm.shop.machining.measured_part import MeasuredCut
    from vcmm.shop.machining.proof import CutProof


class LoopRecord(Protocol):
    """Result of the command."""

    @property
    def cut(self) -> MeasuredCut: ...
    @property
    def diagnosis(self) -> Diagnosis: ...
    @property
    def machine(self) -> Any: ...
    @property
    def program(self) -> Any: ...
    @property
    def proof(self) -> CutProof: ...
    @property
    def after(self) -> Measurement | None: ...
    @property
    def refusal(self) -> str: ...
    @property
    def open_words(self) -> str: ...
    @property
    def setting(self) -> str: ...
    @property
    def rest(self) -> Array: ...
    @property
    def held_out(self) -> HeldOutProof | None: ...
    @property
    def is_met(self) -> bool: ...


def loop_json(loop: LoopRecord) -> dict[str, Any]:
    """Return the body of vcmm.loop/1."""
    d, proof = loop.diagnosis, loop.proof
    crisp = {id(a) for a in answers_to_write(d.answer)}
    answers = [
        answer | {"written": id(a) in crisp} for answer, a in zip(diagnosis_json(d)["answer"], d.answer)
    ]
    now = {"by": "measured", **_figures(loop.cut.off), "characteristics": _measured_values(loop.cut)}
    after = None
    if proof.after is not None and not loop.refusal:
        after = {
            "by": "cut",
            **_figures(proof.after.off),
            "met": loop.is_met,
            "allowed_um": proof.limit * 1e3,
        }
        after["not_explained"] = _figures(loop.rest)
        after["characteristics"] = _values(loop.after)
    return {
        "verdict": d.verdict, "found": answers, "machine": _name(loop.machine), "program": _name(loop.program),
        "rms_um": {"before": _um(d.fit.before), "after": _um(d.fit.after), "noise": _um(d.fit.noise)},
        "held_out": _held_out(loop.held_out), "scatter_um": _scatter(loop.cut),
        "open": loop.open_words or loop.setting or None, "part_now": now, "part_next": after, "refused": loop.refusal or None, **proof_json(proof),
    }  # fmt: skip


def loop_text(loop: LoopRecord, notes: Sequence[str]) -> Iterator[str]:
    """Yield lines for the terminal: the next part first, then the findings (notes), then the characteristics."""
    now, proof = loop.cut.off * 1e3, loop.proof
    was = f"this part departs by {np.abs(now).max():.2f} µm at most and {np.abs(now).mean():.2f} µm in the mean ({len(now)} measured points)"
    if loop.refusal:
        yield f"No program for the next part: it would be worse. {loop.refusal}. {was[0].upper()}{was[1:]}."
    elif proof.after is not None:
        yield (
            f"The next part, cut by {loop.program}, departs by {proof.after.largest * 1e3:.2f} µm at most ({proof.after.worst}) and "
            f"{proof.after.mean * 1e3:.2f} µm in the mean; {was}."
        )
        more = "" if loop.is_met == proof.is_met else "; the real part is not assured of it, see below"
        yield (
            f"Allowed are {proof.limit * 1e3:.2f} µm: {'met' if proof.is_met else 'NOT met'} by the cut on the machine with what was found{more}."
        )
    if loop.open_words:
        yield f"Open: {loop.open_words}."
    elif loop.setting:
        yield f"Not in that figure: {loop.setting}."
    yield from notes
    if loop.after is not None:
        yield ""
        yield "characteristic, from nominal: measured now, next part"
        for row, after in zip(_measured_values(loop.cut), _values(loop.after)):
            unit, small, factor = ("mm", "um", 1e3) if "deviation_mm" in row else ("rad", "urad", 1e6)
            a, b = (float(r[f"deviation_{unit}"]) * factor for r in (row, after))
            yield f"  {row['name']}: {a:+.2f}, {b:+.2f} {small}"


def _figures(off: Array) -> dict[str, Any]:
    size = np.abs(off) * 1e3
    return {"largest_um": float(size.max()), "mean_um": float(size.mean()), "points": len(off)}


def _measured_values(cut: MeasuredCut) -> list[dict[str, Any]]:
    return [
        {
            "name": c.name,
            f"measured_{c.unit}": c.measured,
            f"deviation_{c.unit}": c.measured - c.nominal,
            f"predicted_{c.unit}": c.prediction,
        }
        for c in cut.comparisons
    ]


def _values(measurement: Measurement | None) -> list[dict[str, Any]]:
    return [
        {"name": c.name, f"value_{c.unit}": c.value, f"deviation_{c.unit}": c.value - c.nominal}
        for c in (measurement.values if measurement else ())
    ]


def _held_out(proof: HeldOutProof | None) -> dict[str, Any] | None:
    """Return how the findings predict passes that they were not fitted to; null where nothing was to be written."""
    if proof is None:
        return None
    return {
        "holds": proof.holds, "evidence_nats": proof.evidence, "threshold_nats": proof.threshold, "held_out_nats": proof.gain, "seen_um2": proof.visible_square * 1e6, "unseen_um2": proof.rigid_square * 1e6,
        "largest_unseen_um": proof.largest * 1e3,
    }  # fmt: skip


def _scatter(cut: MeasuredCut) -> dict[str, Any]:
    """Return standard deviations along one direction as the part shows them, and those of the machine file."""
    size = cut.sizes
    if size is None:
        return {"point": cut.scatter * 1e3}
    return {
        "point": cut.scatter * 1e3, "per_move": size.per_move * 1e3, "per_pass": size.per_pass * 1e3, "along_pass": size.along * size.stated * 1e3,
        "stated": size.stated * 1e3,
    }  # fmt: skip


def _um(value: float | None) -> float | None:
    return None if value is None else value * 1e3


def _name(path: Any) -> str | None:
    return None if path is None else str(path)
