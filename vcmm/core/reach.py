"""Find the positions of the linear axes that bring the tip to a place."""

from __future__ import annotations

import numpy as np

from vcmm.core.axes import is_rotary
from vcmm.core.errors import ModelLimit
from vcmm.core.kinematics import nominal_tip
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run


def linear_positions(machine: Machine, run: Run, tip: Array) -> dict[str, Array]:
    """Return axis positions that bring the tip to `tip` (n, 3) mm, workpiece axes; rotary axes and offsets as in the run.

    The tip is linear in the positions of the linear axes. Raises ModelLimit where they cannot reach a place.
    """
    letters = [a for a in machine.chain.letters if a in "XYZ"]
    rest = {a: q if is_rotary(a) else np.zeros(run.n) for a, q in run.position.items()}

    def at(position: dict[str, Array]) -> Array:
        return nominal_tip(machine.chain, machine.axes, Run(position, run.offset))

    base = at(rest)
    moves = np.stack([at(rest | {a: np.ones(run.n)}) - base for a in letters], axis=2)
    q = np.einsum("nai,ni->na", np.linalg.pinv(moves), tip - base)
    gap = np.linalg.norm(base + np.einsum("nia,na->ni", moves, q) - tip, axis=1)
    if gap.max(initial=0.0) > 1e-6:
        raise ModelLimit(
            f"row {int(gap.argmax()) + 1}: the axes {' '.join(letters)} cannot bring the tip there "
            f"(they miss it by {gap.max():.3g} mm)"
        )
    return rest | {a: q[:, i] for i, a in enumerate(letters)}
