"""Check coefficients of thermal expansion against those of solids, for remarks on a slip of sign, decimal point or unit."""

from __future__ import annotations

SHRINKS = -2e-6  # 1/K: carbon fibre along its fibres has -1e-6; nothing that is measured has less
USUAL = (4e-6, 30e-6)  # 1/K: from granite and glass to zinc
USUAL_WORDS = "usual are 4 to 30 um/(m K): granite 6, glass 8, steel 11.5, aluminium 23.2"


def unusual_expansion(what: str, alpha: float) -> str:
    """Return a remark on an expansion (1/K) out of the usual range, "" for a usual one and for None."""
    if alpha == 0.0 or USUAL[0] <= alpha <= USUAL[1]:
        return ""
    return (
        f"{what} = {alpha * 1e6:g} um/(m K): {USUAL_WORDS}; glass ceramics and Invar have 0 to 2, plastics up to 200: check sign, decimal "
        "point and unit"
    )
