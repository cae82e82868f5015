"""The proof of a program by a cut, as a document and in words."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from vcmm.shop.machining.proof import CutProof, InspectedCut


def proof_json(proof: CutProof) -> dict[str, Any]:
    """Return the key `proof`, and `reason` where it is null."""
    if proof.after is None:
        return {"proof": None, "reason": proof.reason}
    body = {"by": "cut", **_figures(proof.after), "met": proof.is_met, "allowed_um": proof.limit * 1e3}
    return {"proof": body | {"before": None if proof.before is None else _figures(proof.before)}}


def _figures(cut: InspectedCut) -> dict[str, Any]:
    features = {
        str(name): {"lowest_um": float(off.min()) * 1e3, "highest_um": float(off.max()) * 1e3}
        for name in dict.fromkeys(cut.feature.tolist())
        if len(off := cut.off[cut.feature == name])
    }
    return {
        "largest_um": cut.largest * 1e3, "mean_um": cut.mean * 1e3, "points": len(cut.off), "uncut": cut.uncut,
        "worst_feature": cut.worst, "features": features,
    }  # fmt: skip


def proof_text(proof: CutProof) -> str:
    """Return the answer in two lines."""
    if proof.after is None:
        return f"proof by a cut: nothing was inspected; {proof.reason}"
    after, before = proof.after, proof.before
    was = (
        ""
        if before is None
        else f"; before {before.largest * 1e3:.2f} µm ({before.worst}), {before.mean * 1e3:.2f} µm"
    )
    return (
        f"proof by a cut: {'met' if proof.is_met else 'NOT met'}: the new program, cut and inspected at {len(after.off)} points, departs by {after.largest * 1e3:.2f} µm at most "
        f"({after.worst}), {after.mean * 1e3:.2f} µm in the mean{was}; allowed are {proof.limit * 1e3:.2f} µm"
        + (f"; {after.uncut} points are left uncut" if after.uncut else "")
    )
