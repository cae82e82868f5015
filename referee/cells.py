"""The cells: kind/task/family of parts/machine."""

from referee.machines import FAMILIES as MACHINES
from referee.parts import FAMILIES as PARTS

QUICK = ("circle8", "circle36", "arc30", "plane25", "plane100", "line15", "bore48")
MORE = ("square", "wall", "ledge", "holes", "place")
SLOW = ("zone36", "planezone")


def all_cells() -> list[str]:
    """Every cell, in the order in which they are run."""
    cells = [f"evaluate/{t}/{f}/exact" for t in QUICK + MORE for f in PARTS]
    cells += [f"evaluate/{t}/{f}/exact" for t in SLOW for f in ("lobes", "waves", "dent")]
    cells += ["evaluate/three/known_lobes/exact", "evaluate/circle8/known_lobes/exact"]
    noises = ("t3", "ar", "dust", "digits", "fine_digits")
    cells += [f"evaluate/{t}/waves/{n}" for t in ("circle36", "bore48", "plane100") for n in noises]
    certified = ("circle36", "bore48", "plane100", "square", "ledge", "holes", "place")
    cells += [f"evaluate/{t}/waves/cert_{m}" for t in certified for m in MACHINES]
    cells += [
        f"decide/{t}/{f}/exact"
        for t in ("circle36", "holes", "ledge", "square")
        for f in ("perfect", "waves")
    ]
    cells += [f"decide/{t}/waves/cert_smooth" for t in ("circle36", "ledge")]
    cells += [
        f"uncertainty/{t}/perfect/exact" for t in ("circle8", "circle36", "arc30", "bore48", "ledge", "holes")
    ]
    cells += ["uncertainty/three/known_lobes/exact", "uncertainty/circle36/perfect/t3"]
    cells += [f"uncertainty/{t}/perfect/cert_{m}" for t in ("circle36", "holes") for m in MACHINES]
    cells += [f"monotone/{t}/waves/cert_smooth" for t in ("arc30", "circle36", "bore48", "ledge", "square")]
    cells += [f"place/{t}/perfect/exact" for t in ("circle36", "arc30", "holes")]
    return cells
