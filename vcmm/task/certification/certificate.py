"""Statements of a certificate: limits of ISO 10360-2, 10360-5 and ISO 230-2, and the prior over machines that keep them.

Maximum permissible errors as certificates and data sheets write them: ISO 10360-2 has A + L/K, makers also write a slope.

1.9 um + L/300     1.9 + L/300      L in mm gives um
1.9 um + 3.3L/1000 1.9 + 3.3 L/1000 3.3 um per 1000 mm
1.9 um + 3.3 um/m  1.9 um           a slope with its unit; a limit that does not grow
1.9 um + L/300 <= 4 um              ISO 10360-2's third form: grows as far as its cap; also <, a comma, min(1.9 um + L/300, 4 um)
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from vcmm.core.errors import UsageError, choose_from
from vcmm.core.run import Array
from vcmm.core.units import quantity
from vcmm.task.certification.findings import Findings, over_the_limit

NUMBER = r"\d+(?:\.\d+)?"
_GROWS = re.compile(rf"(?:(?P<slope>{NUMBER})\s*[*x×·]?\s*)?L\s*/\s*(?P<per>{NUMBER})\s*(?P<unit>[uµμ]m)?")
_SLOPE = re.compile(rf"(?P<slope>{NUMBER})\s*(?P<unit>[uµμ]m/m|ppm|[uµμ]m\s*/\s*1000\s*mm)")
STEEPEST = 10.0  # mm per um: 100 um per metre, more than any machine that is certified by lengths
WAYS = '"1.9 um + L/300", "1.9 + 3.3L/1000" or "1.9 um + 3.3 um/m" (L in mm gives um)'


def parts_of(text: str, name: str, example: str) -> tuple[float, float]:
    """Parse a limit: return (fixed mm, length in mm per um of growth, infinite where it does not grow). UsageError: a text that is not understood."""
    plain = text.strip().lstrip("±").strip()
    bracket = re.fullmatch(r"\((?P<inside>.*)\)\s*(?P<unit>[uµμ]m)", plain)
    plain = bracket["inside"] if bracket else plain
    first, plus, rest = (p.strip() for p in plain.partition("+"))
    if not plus and (_GROWS.fullmatch(first) or _SLOPE.fullmatch(first)):
        return 0.0, _per(first, text, name)
    if plus:
        per = _per(rest, text, name)
        bare = re.fullmatch(NUMBER, first)  # "1.9 + L/300": the equation is one of numbers in um
        return quantity(f"{first} um" if bare else first, "length", name, example), per
    return quantity(f"{first} um" if bracket else first, "length", name, example), float("inf")


_CAPPED = re.compile(r"min\((?P<grows>[^,;]+)[,;](?P<cap>[^,;]+)\)|(?P<left>.+?)(?:<=|≤|<)(?P<right>.+)")


def with_cap(text: str) -> tuple[str, str]:
    """Split a limit and its cap into two texts; the cap is empty where there is none: "1.8 um + L/350 <= 4 um"."""
    capped = _CAPPED.fullmatch(text.strip().lstrip("±").strip())
    if capped is None:
        return text, ""
    return (capped["grows"] or capped["left"]).strip(), (capped["cap"] or capped["right"]).strip()


def _per(text: str, whole: str, name: str) -> float:
    grows, slope = _GROWS.fullmatch(text), _SLOPE.fullmatch(text)
    if not grows and not slope:
        raise UsageError(f'{name} = "{whole}" cannot be read: write {WAYS}')
    if grows:
        over, by = float(grows["slope"] or "1"), float(grows["per"])
    else:
        assert slope is not None
        over, by = float(slope["slope"]), 1000.0
    if not (over > 0 and by > 0):
        raise UsageError(f'{name} = "{whole}": a limit grows by more than nothing; write {WAYS}')
    if by / over < STEEPEST:
        hint = f"L/{1000 * by:g}, or {by:g} um/m" if by < 1 else f"L/{300:g}"
        raise UsageError(
            f'{name} = "{whole}" grows by {1000 * over / by:.4g} um per metre; usual are L/50 to L/1500 (0.7 to 20 um/m): is {hint} meant?'
        )
    return by / over


PRIORS: Mapping[str, str] = {
    "limit": "a machine may use all of every limit: the cautious choice",
    "uniform": "machines use any share of every limit, all shares alike",
    "typical": "machines use about half of every limit",
}
COARSEST = 0.2  # mm on the shortest length: measuring arms and the largest machines keep a few hundredths
POSITIONING = ("A", "E", "R", "B", "M")


@dataclass(frozen=True)
class LengthLimit:
    """A limit that may grow with the length: constant mm + length / per, cap mm at most, both sides (mm from mm)."""

    constant: float
    per: float = float("inf")
    cap: float = float("inf")

    def __call__(self, length: float) -> float:
        return min(self.constant + 1e-3 * length / self.per, self.cap)

    def at(self, lengths: Array) -> Array:
        """Return the limit (n,) mm for lengths (n,) mm."""
        return np.minimum(self.constant + 1e-3 * lengths / self.per, self.cap)

    @property
    def corner(self) -> float:
        """Length in mm at which the cap is reached; 0 where there is none."""
        return 1e3 * (self.cap - self.constant) * self.per if self.cap < float("inf") else 0.0

    def __str__(self) -> str:
        grows = f" + L/{self.per:g}" if self.per < float("inf") else ""
        cap = f" <= {self.cap * 1e3:g} um" if self.cap < float("inf") else ""
        return f"{self.constant * 1e3:g} um{grows}{cap}"


def length_limit(text: object, name: str, example: str = "1.9 um + L/300") -> LengthLimit:
    """Parse "1.9 um + L/300": L in mm gives um, as on certificates of ISO 10360-2 and on data sheets (vcmm.task.certification.mpe).
    UsageError: what is not understood or not positive."""
    if not isinstance(text, str):
        raise UsageError(
            f'{name} = {text} must be a text with its unit; write for example {name} = "{example}"'
        )
    grows, cap = with_cap(text)
    limit = LengthLimit(*parts_of(grows, name, example), cap=short_limit(cap, name) if cap else float("inf"))
    if not (limit.constant >= 0 and limit.per > 0) or (limit.constant == 0 and limit.per == float("inf")):
        raise UsageError(f'{name} = "{text}": a limit is positive; write for example {name} = "{example}"')
    if cap and (limit.per == float("inf") or limit.cap <= limit.constant):
        raise UsageError(
            f'{name} = "{text}": a cap bounds a limit that grows and begins below it; write for example {name} = "1.9 um + L/300 <= 4 um"'
        )
    return limit


def smallest_limit(e0: LengthLimit, form: float | None) -> float:
    """Return the limit in mm for the scatter where R0 is not stated: E0 of the shortest length (of 100 mm where E0 begins at
    zero), or the form of the test sphere where that is smaller."""
    shortest = e0.constant or e0(100.0)
    return shortest if form is None else min(shortest, form)


def short_limit(text: object, name: str) -> float:
    """Parse a limit that is one length, mm."""
    limit = length_limit(text, name, "1.9 um")
    if limit.per != float("inf"):
        raise UsageError(
            f'{name} = "{text}" does not grow with a length; write for example {name} = "1.8 um"'
        )
    return limit.constant


@dataclass(frozen=True)
class MachineCertificate:
    """Limits in mm; None where the certificate does not state one. positioning: (figure, axis or "") -> mm of ISO 230-2."""

    E0: LengthLimit | None = None
    E150: LengthLimit | None = None
    R0: float | None = None
    form: float | None = None
    size: float | None = None
    positioning: Mapping[tuple[str, str], float] = field(default_factory=dict)
    prior: str = "limit"
    findings: Findings = field(default_factory=Findings)

    def __post_init__(self) -> None:
        if self.prior not in PRIORS:
            raise UsageError(f'prior = "{self.prior}": no such prior.{choose_from(self.prior, PRIORS)}')
        if self.E0 is not None and self.E0(0.0) > COARSEST:
            raise UsageError(
                f"E0_MPE allows {self.E0(0.0):g} mm on the shortest length; no measuring machine is certified so coarsely: check the unit "
                "(um)"
            )
        if self.E0 is not None and COARSEST < self.E0.cap < float("inf"):
            raise UsageError(
                f"E0_MPE is capped at {self.E0.cap:g} mm; no measuring machine is certified so coarsely: check the unit (um)"
            )
        if self.E0 is None and not self.positioning:
            raise UsageError(
                "the certificate states neither E0_MPE nor iso230_2; without one of them machines can be as wrong as they like: "
                'write for example E0_MPE = "1.8 um + L/350"'
            )
        if self.E0 and self.R0 is not None and 2.0 * self.E0(1e4) < self.R0:
            raise UsageError(
                "R0_MPL is more than twice E0_MPE of 10 m: no machine that keeps E0 could use it; check the units"
            )
        if self.E0 and self.E150 and self.E150(0.0) < 0.5 * self.E0(0.0):
            raise UsageError(
                "E150_MPE is less than half of E0_MPE: an offset stylus measures no better; check the two limits"
            )

        over_the_limit(self.findings, self.E0, {"R0": self.R0, "P_Form": self.form, "P_Size": self.size})

    def positioning_limit(self, figure: str, axis: str) -> float | None:
        return self.positioning.get((figure, axis), self.positioning.get((figure, "")))

    def limits_accuracy(self, axis: str) -> bool:
        """Return whether A, E or M of an axis is limited."""
        return any(self.positioning_limit(figure, axis) is not None for figure in "AEM")

    def limits(self, test: str) -> dict[str, LengthLimit]:
        """Return the stated limits by the name of the figure, for a test such as "10360-2" or "230-2"."""
        if test == "10360-2":
            short = {"R0": self.R0, "P_Form_Sph_1x25": self.form, "P_Size_Sph_1x25": self.size}
            long = {"E0": self.E0, "E150": self.E150}
            return {n: x for n, x in long.items() if x} | {
                n: LengthLimit(x) for n, x in short.items() if x is not None
            }
        if test == "230-2":
            return {f"{f} {a}".strip(): LengthLimit(x) for (f, a), x in self.positioning.items()}
        return {}

    def words(self) -> str:
        """Describe the stated limits, as evidence of the Input."""
        parts = [f"{n} {x}" for n, x in (("E0", self.E0), ("E150", self.E150)) if x]
        parts += [
            f"{n} {x * 1e3:g} um"
            for n, x in (("R0", self.R0), ("P_Form", self.form), ("P_Size", self.size))
            if x is not None
        ]
        parts += [f"{f}{' ' + a if a else ''} {x * 1e3:g} um" for (f, a), x in self.positioning.items()]
        findings = self.findings.words()
        return f"certificate: {', '.join(parts)}; prior {self.prior}" + (
            f"; found {findings}" if findings else ""
        )
