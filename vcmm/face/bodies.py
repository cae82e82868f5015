"""Bodies of JSON documents whose tables are in several places: of a calibration, a rewritten program, a placed cut part."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from vcmm.compensation.result import CompensatedProgram
    from vcmm.learn.calibration.result import Calibration
    from vcmm.shop.machining.placement import PlacedCut
    from vcmm.shop.machining.proof import CutProof


def calibration_json(calibration: Calibration, out: Path | None) -> dict[str, Any]:
    """Return the JSON document without its frame; its figures are those of the written file, read back."""
    from vcmm.files.own.machine import load_machine
    from vcmm.learn.calibration.acceptance import volume_figures
    from vcmm.learn.calibration.result import rms
    from vcmm.show.tables.calibration import FIGURES, RESIDUALS, residuals
    from vcmm.show.tables.table import records

    pulls = zip(calibration.posterior.own_names, calibration.posterior.own)
    return {
        "machine": None if out is None else str(out),
        "identified": calibration.figures(),
        "not_identified": calibration.identified.document(),
        "interpolation": calibration.interpolation,
        "condition": calibration.identified.condition,
        "residual_um": rms(calibration.residual) * 1e3,
        "residuals": records(RESIDUALS, residuals(calibration).rows),
        "instruments": [{"input": name, "pull": float(v)} for name, v in pulls],
        "probe_radius": calibration.probe_radii(),
        "nodes": {c.axis: len(c.nodes) for c in calibration.kept.curves},
        "figures": records(FIGURES, volume_figures(load_machine(out))) if out is not None else [],
    }


def compensation_json(result: CompensatedProgram, target: Path | None, proof: CutProof) -> dict[str, Any]:
    """Return the body of the JSON document; lengths in um, as people state them. met: of the cut, where one was made, else of the path."""
    from vcmm.show.tables.compensation import departure_json, pointing_json, proof_json, shifts_json

    r, b = result.rounding, result.blocks
    return {
        "program": result.name, "dialect": result.dialect, "machine": result.machine, "file": None if target is None else str(target),
        "tolerance_um": result.tolerance * 1e3, "tolerance_used_um": result.tolerance_used * 1e3,
        "met": result.is_met if proof.after is None else proof.is_met, **proof_json(proof),
        "path_met": result.is_met,
        "deviation": {
            "before": departure_json(result.before), "offset_only": departure_json(result.offset_only), "after": departure_json(result.after),
            "before_with_dynamic": departure_json(result.whole[0]) if result.whole else None,
            "after_with_dynamic": departure_json(result.whole[1]) if result.whole else None,
        },
        "orientation": None if result.orientation is None else {
            "before": pointing_json(result.orientation.before), "after": pointing_json(result.orientation.after),
        },
        "offset_shift_mm": shifts_json(result),
        "rounding": {"step_mm": r.step, "max_um": r.largest * 1e3, "rms_um": r.rms * 1e3, "share": r.share},
        "blocks": {
            "before": b.before, "after": b.after, "growth": b.growth, "changed": b.changes, "added": b.additions,
            "rate_before_1_s": b.rate_before, "rate_after_1_s": b.rate_after, "rate_line": b.rate_line,
        },
        "hash": result.digest,
    }  # fmt: skip


def placed_cut_json(placed: PlacedCut) -> dict[str, Any]:
    from vcmm.answer.placing.result import freedom_key, map_json, pose_json
    from vcmm.part.gps.characteristics import unit
    from vcmm.show.tables.placement import GAINS, gains
    from vcmm.show.tables.table import records

    def at(place: Any) -> dict[str, Any]:
        rows = [
            {"name": c.name, f"deviation_{unit(c)}": float(d)}
            for c, d in zip(placed.characteristics, place.deviations)
        ]
        return {"pose": pose_json(place.pose), "value": place.value, "characteristics": rows}

    certificate, flat = placed.certificate, placed.region
    return {
        "pose": pose_json(placed.best.pose),
        "objective": {"kind": {"deviation": 1.0}, "weights": placed.weights, **{k: at(placed.best)[k] for k in ("value", "characteristics")}},
        "present": at(placed.present) | {"gain": placed.gain},
        "median": at(placed.median),
        "worst": at(placed.worst),
        "certificate": {
            "method": certificate.method, "text": certificate.text, "scanned": certificate.scan_count,
            "better": certificate.better, "earlier": certificate.earlier, "hidden": certificate.hidden_gain,
            "spacing": certificate.spacing,
        },
        "flat": {"within": flat.within, "share": flat.share, "box": {freedom_key(n): list(r) for n, r in flat.box.items()}},
        "conforming": records(GAINS, gains(placed).rows),
        "map": map_json(placed.map),
    }  # fmt: skip
