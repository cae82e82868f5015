"""Input: one row of knowledge about a parameter or a run column (a GUM input quantity).

The world is crisp (Machine), knowledge about it is a separate table. An Input says by how much the true value may
depart from the number in the machine file, by which law, and how often it is drawn anew: `redraw` is a label
column, one independent copy per value (machine: one for all; touch: one per row).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vcmm.core.laws import Law, MultivariateNormal, MultivariateSamples, Normal
from vcmm.core.run import Array

STATE, SINCE = "machine_state", "time since calibration"  # Inputs of a machine that was followed in time
SMALLEST = 1e-12  # of the largest eigenvalue of a correlation: what is below is rounding
EVERY = "*"  # where = "*": one draw shared by all effects of that name (one coefficient of all scales)


@dataclass(frozen=True, eq=False)
class Input:
    """Knowledge about `effect[where].parameter`, or about the run column `parameter` when effect = "channel".

    Where several quantities are known together, `members` names them and their own laws do not count. With a scalar law
    they have a common cause that moves each by `shares` (k,) of one draw; with a joint law they are correlated.

    law: departure from the estimate, canonical units. A scalar law is drawn independently for every element of an
    array parameter, times `scale` (k,) where given; MultivariateNormal and MultivariateSamples draw all together.
    owner: names the machine where two have a part in one task, so that each has draws of its own. cause: tells apart what
    makes one quantity uncertain for several physical reasons, each a line of the budget. bound: nothing is known but that the
    quantity is no larger: the law is the far end, and any share of it down to nothing is as possible. widths: how many numbers each member of a joint law
    has, where some are arrays; () where each is one number. nu: degrees of freedom of the stated standard uncertainty (JCGM 100, G.4), where the law
    has none of its own.
    """

    effect: str
    where: str
    parameter: str
    law: Law | MultivariateNormal | MultivariateSamples
    redraw: str = "machine"
    evidence: str = ""
    scale: Array | None = None
    owner: str = ""
    members: tuple[Input, ...] = ()
    shares: Array | None = None
    cause: str = ""
    bound: bool = False
    widths: tuple[int, ...] = ()
    nu: float = np.inf

    @property
    def id(self) -> str:
        """The name of the random stream and of the budget line: backlash[X].gap, scatter.value, channel.temp_part_C."""
        where = f"[{self.where}]" if self.where else ""
        name = f"{self.effect}{where}.{self.parameter}" if self.effect else self.parameter
        name = f"{name} by {self.cause}" if self.cause else name
        return f"{self.owner}: {name}" if self.owner else name

    @property
    def is_channel(self) -> bool:
        """Whether the Input moves columns of the run and no parameter of an effect."""
        return all(m.is_channel for m in self.members) if self.members else self.effect == "channel"

    @property
    def scalars(self) -> tuple[tuple[Input, float], ...]:
        """The quantities that one draw of a scalar law moves, each with its share."""
        if not self.members:
            return ((self, 1.0),)
        return tuple(zip(self.members, np.ones(len(self.members)) if self.shares is None else self.shares))

    @property
    def member_widths(self) -> tuple[int, ...]:
        """The number of elements of each member."""
        return self.widths or (1,) * len(self.members)

    def join_responses(self, parts: Sequence[Array]) -> Array:
        """Join responses (..., 1) to the members into the response to this Input: (..., 1) of a common cause, else (..., k)."""
        if isinstance(self.law, Law):
            return np.asarray(sum(share * part for (_, share), part in zip(self.scalars, parts)))
        return np.concatenate(parts, axis=-1)

    @property
    def size(self) -> float:
        """Standard uncertainty of a scalar Input, canonical unit; 1e-6 where its law has none that is finite and above zero."""
        _, factor = self.spread(1)
        u = float(np.ravel(self.law.u)[0]) * abs(float(factor[0, 0]))
        return u if 0 < u < np.inf else 1e-6

    def spread(self, k: int) -> tuple[Law | MultivariateSamples, Array]:
        """Return (law, factor (k, r)): the departure of the k elements is factor @ r draws of the law.

        The draws are independent, but for MultivariateSamples, whose r = k columns are drawn by rows together.
        """
        if isinstance(self.law, MultivariateNormal):
            return Normal(1.0), self.law.factor
        if isinstance(self.law, MultivariateSamples):
            return self.law, np.eye(k)
        return self.law, np.diag(np.ones(k) if self.scale is None else np.broadcast_to(self.scale, (k,)))


@dataclass(frozen=True, eq=False)
class JointCovariance:
    """Covariance of several errors. errors (k,): name of each number; position (k,): its node, nan for an error without one; matrix (k, k)."""

    errors: tuple[str, ...]
    position: Array
    matrix: Array

    @property
    def factor(self) -> Array:
        """The factor (k, r) with factor @ factor.T = matrix, by the eigenvectors of the correlation matrix."""
        u = np.sqrt(np.diag(self.matrix))
        scale = np.where(u > 0, u, 1.0)
        size, ways = np.linalg.eigh(self.matrix / np.outer(scale, scale))
        kept = size > SMALLEST * max(float(size[-1]), 0.0)
        return np.asarray(scale[:, None] * (ways[:, kept] * np.sqrt(size[kept])))
